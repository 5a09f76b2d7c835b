//! Bodies of finite elements, reduced here.

use contact_qs::points::DofLookup;
use faer::sparse::SparseColMat;
use fe_mesh::fault::MeshFault;
use fe_mesh::part::Part;
use fe_mesh::{Mesh, MeshSpace};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use iga_core::SplineError;
use iga_core::assembly::assemble;
use iga_core::elasticity::{ElementMaterials, Material, Model};
use iga_core::recovery::RecoveryWorkspace;
use iga_core::space::Space;
use nalgebra::{UnitQuaternion, Vector3};

use crate::elastic_body::{Interface, ReducedBody, ReductionInput, modes_key};
use crate::error::AdaptiveError;
use crate::gauge::Gauge;
use crate::marker_loads::load_columns;
use crate::part_motion::PartPoints;
use crate::spec::{Area, Extent, FrameSpec, MeshedSpec, Place};
use crate::store::{ModelCache, ModelKey, meshed_definition};
use crate::unsupported::{MOST_RIGID_UNKNOWNS, Unsupported};

/// Displacement components of a node.
const N_COMPONENTS: usize = 3;

/// A body of finite elements, reduced.
pub struct MeshedModel {
    /// What it was built from.
    pub spec: MeshedSpec,
    /// The reduced model.
    pub reduced: ReducedBody,
    /// The interface that it was reduced for.
    pub interface: Interface,
    /// Numbers of the unknowns.
    pub lookup: DofLookup,
}

/// Number of elastic modes that a mesh has.
pub fn n_elastic_modes(mesh: &Mesh) -> usize {
    (N_COMPONENTS * mesh.nodes().len()).saturating_sub(RigidMotion::Spatial.count())
}

impl MeshedSpec {
    /// Displacements of the mesh.
    pub fn space(&self) -> MeshSpace<'_> {
        MeshSpace::new(&self.mesh, self.mass_rule)
    }

    /// Materials of the elements.
    ///
    /// # Errors
    /// [`MeshFault`] for a group that does not exist, and for an element in none or several of them.
    pub fn materials(&self) -> Result<ElementMaterials, MeshFault> {
        let groups: Vec<_> = self.groups.iter().map(|(name, material)| (name.as_str(), *material)).collect();
        self.mesh.materials(&groups, self.material)
    }

    /// The material whose elastic constants a rigid part is compared with.
    fn first_material(&self) -> Option<&Material> {
        self.material.as_ref().or(self.groups.first().map(|(_, material)| material))
    }

    /// Stiffness and mass matrices, stiffened where parts of the body are rigid; `name` is that of the body.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`], [`AdaptiveError::Geometry`]; [`AdaptiveError::Unsupported`] for rigid parts with thousands of unknowns.
    pub fn assembled(&self, name: &str) -> Result<AssembledBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let materials = self.materials().map_err(fail)?;
        let matrices = assemble(&self.space(), &Model::Solid, &materials).map_err(|e| geometry(name, e))?;
        let stiffness = self.stiffened(name, matrices.stiffness)?;
        Ok(assembled_body(name, self.mesh.nodes(), stiffness, matrices.mass))
    }

    /// The matrix `stiffness` of the body `name`, stiffened where parts of the body are rigid; nodes of the mesh have the first unknowns.
    ///
    /// # Errors
    /// As [`MeshedSpec::assembled`].
    pub fn stiffened(
        &self,
        name: &str,
        mut stiffness: SparseColMat<u32, f64>,
    ) -> Result<SparseColMat<u32, f64>, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        for area in &self.rigid_areas {
            let young = self.first_material().map_or(0.0, Material::youngs_modulus);
            let block = self
                .points(area)
                .map_err(fail)?
                .rigid_block(young, None, unknown, MOST_RIGID_UNKNOWNS)
                .map_err(|source| AdaptiveError::Reduction { body: name.to_owned(), source })?;
            let block = block.map_err(|unknowns| {
                let part = area.extent.name();
                let what = Unsupported::RigidPart { part, unknowns, most: MOST_RIGID_UNKNOWNS };
                AdaptiveError::unsupported_body(name, what)
            })?;
            stiffness = block.added_to(&stiffness);
        }
        Ok(stiffness)
    }

    /// Nodes that move with the rigid parts of the body `name`.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] for a part that does not exist.
    pub fn rigid_nodes(&self, name: &str) -> Result<Vec<u32>, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let parts = self.rigid_areas.iter().map(|area| self.part(area).map_err(fail));
        let parts = parts.collect::<Result<Vec<Part>, AdaptiveError>>()?;
        let points = parts.iter().flat_map(|part| (0..part.len()).map(|i| part.point(i).2));
        Ok(points.flatten().map(|(node, _)| *node).collect())
    }

    fn part(&self, area: &Area) -> Result<Part, MeshFault> {
        match &area.extent {
            Extent::Face(name) => self.mesh.face_part(name),
            Extent::Around { point, radius } => self.mesh.around(point, *radius),
        }
    }

    /// Side of the longest element at a disc or ball \[m\]; none of a face, or if there is no such part.
    pub fn longest_element(&self, area: &Area) -> Option<f64> {
        if matches!(area.extent, Extent::Face(_)) {
            return None;
        }
        let part = self.part(area).ok()?;
        let place = |node: u32| Vector3::from(self.mesh.nodes()[node as usize]);
        let side = |i: usize| {
            let (_, _, functions) = part.point(i);
            let pairs = functions
                .iter()
                .enumerate()
                .flat_map(|(k, a)| functions[..k].iter().map(move |b| (a.0, b.0)));
            let across = pairs.map(|(a, b)| (place(a) - place(b)).norm()).fold(0.0, f64::max);
            // The diagonal of a square; a triangle has none.
            if matches!(functions.len(), 3 | 6) { across } else { across * std::f64::consts::FRAC_1_SQRT_2 }
        };
        Some((0..part.len()).map(side).fold(0.0, f64::max))
    }

    /// The quadrature points of a part.
    fn points(&self, area: &Area) -> Result<PartPoints, MeshFault> {
        let part = self.part(area)?;
        let mut points = PartPoints::new(RigidMotion::Spatial, self.mesh.nodes().len());
        for i in 0..part.len() {
            let (place, weight, functions) = part.point(i);
            points.push(place, weight, functions);
        }
        Ok(points)
    }

    /// The marker at `place` with axes turned by `rotation`, in terms of the unknowns: the mean motion of a part; a single point without its rotation.
    fn marker_weights(
        &self,
        name: &str,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let wrong = |source| AdaptiveError::Reduction { body: name.to_owned(), source };
        match place {
            Place::Area(area) => {
                let points = self.points(area).map_err(fail)?;
                points.mean_motion(&area.centre, rotation, unknown).map_err(wrong)
            }
            Place::Point(point) => {
                MarkerWeights::new(Vector3::from(*point), rotation, self.at(name, point)?).map_err(wrong)
            }
            Place::Marker(marker) => {
                let known = self.mesh.face_names().collect::<Vec<_>>().join(", ");
                let what = Unsupported::UnknownMarker { holder: "mesh", marker: marker.clone(), known };
                Err(AdaptiveError::unsupported_body(name, what))
            }
        }
    }

    /// The softest material of the body, by the speed of its waves.
    pub fn slowest_material(&self) -> Option<&Material> {
        let speed = |m: &&Material| m.youngs_modulus() / m.density();
        let all = self.material.iter().chain(self.groups.iter().map(|(_, material)| material));
        all.min_by(|a, b| speed(a).total_cmp(&speed(b)))
    }

    /// Functions that are not zero at a point of the undeformed body \[m\], with their values; `name` is that of the body.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] if the point is not in the body.
    pub fn functions_at(&self, name: &str, place: &[f64; 3]) -> Result<Vec<(u32, f64)>, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let (e, xi) = self.mesh.locate(place).map_err(fail)?;
        Ok(self.space().functions_at(e, &xi))
    }

    /// Strain and stress at a point of the undeformed body \[m\] by its unknowns; `name` is that of the body.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] if the point is not in the body, [`AdaptiveError::Geometry`] if an element about it is folded.
    pub fn gauge(&self, name: &str, place: &[f64; 3]) -> Result<Gauge, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let (e, xi) = self.mesh.locate(place).map_err(fail)?;
        let materials = self.materials().map_err(fail)?;
        Gauge::of_elements(&self.space(), &materials, (e, &xi)).map_err(|e| geometry(name, e))
    }

    /// How a material point of the body `name` moves and turns, by half the curl of the displacement, with the unknowns.
    fn at(&self, name: &str, point: &[f64; 3]) -> Result<Vec<(u32, [f64; 6])>, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let (e, xi) = self.mesh.locate(point).map_err(fail)?;
        let functions = RecoveryWorkspace::default().functions(&self.space(), e, &xi);
        let mut entries = Vec::new();
        for function in functions.map_err(|e| geometry(name, e))? {
            for c in 0..N_COMPONENTS {
                let direction = Vector3::ith(c, 1.0);
                let turn = 0.5 * Vector3::from(function.gradient).cross(&direction);
                let moved = function.value * direction;
                let w = [moved.x, moved.y, moved.z, turn.x, turn.y, turn.z];
                entries.extend(unknown(function.number, c).map(|n| (n as u32, w)));
            }
        }
        entries.sort_unstable_by_key(|e| e.0);
        Ok(entries)
    }
}

/// An error of the geometry of the body `name`.
pub fn geometry(name: &str, source: SplineError) -> AdaptiveError {
    AdaptiveError::Geometry { body: name.to_owned(), source }
}

/// A body with the matrices given, three unknowns a node of `nodes`.
pub fn assembled_body(
    name: &str,
    nodes: &[[f64; 3]],
    stiffness: SparseColMat<u32, f64>,
    mass: SparseColMat<u32, f64>,
) -> AssembledBody {
    AssembledBody {
        name: name.to_owned(),
        motion: RigidMotion::Spatial,
        stiffness,
        mass: MassMatrix::PerComponent(mass),
        dofs: dofs_of(nodes.len()),
        anchors: nodes.to_vec(),
        nodes: nodes.to_vec(),
    }
}

/// The unknowns of `n` nodes, three each.
pub fn dofs_of(n: usize) -> Vec<Dof> {
    let node = |node: u32| (0..N_COMPONENTS as u8).map(move |component| Dof { node, component });
    (0..n as u32).flat_map(node).collect()
}

/// Number of the unknown of a node along a direction.
fn unknown(node: u32, component: usize) -> Option<usize> {
    Some(N_COMPONENTS * node as usize + component)
}

impl MeshedModel {
    /// Reduces the body called `name` for `interface`; modes that `cache` has are not computed again.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] for places and groups that do not exist, [`AdaptiveError::Reduction`], [`AdaptiveError::Unsupported`].
    pub fn build(
        name: &str,
        spec: &MeshedSpec,
        interface: Interface,
        cache: &ModelCache,
    ) -> Result<Self, AdaptiveError> {
        let fail = |source: DynamicsError| AdaptiveError::Reduction { body: name.to_owned(), source };
        let assembled = spec.assembled(name)?;
        let at = |place: &Place| spec.marker_weights(name, place, UnitQuaternion::identity());
        let columns = load_columns(&assembled, &interface.loads, at, fail)?;
        let key = modes_key(&meshed_definition(spec), spec.reduction, &interface, &columns);
        let key = ModelKey { kind: "modes of a mesh", ..key };
        let (reduction, damping) = (spec.reduction, &spec.damping);
        let input = ReductionInput { body: &assembled, reduction, damping, key };
        let mut reduced = input.reduce(&interface, &columns, cache).map_err(fail)?;
        if let FrameSpec::Tangent(place) = &spec.frame {
            let support = at(place)?.marker("frame", reduced.basis.shapes.as_ref()).map_err(fail)?;
            let tangent = support.tangent_frame(assembled.motion);
            let shapes = tangent.shifted_shapes(&assembled, reduced.basis.shapes.as_ref()).map_err(fail)?;
            reduced.framed = Some(shapes);
            reduced.data = reduced.data.in_tangent_frame(&tangent).map_err(fail)?;
        }
        let lookup = DofLookup::new(&assembled.dofs);
        Ok(Self { spec: spec.clone(), reduced, interface, lookup })
    }

    /// Number of unknowns of the full model.
    pub fn n_unknowns(&self) -> usize {
        N_COMPONENTS * self.spec.mesh.nodes().len()
    }

    /// The material point at `place`, of a part its mean motion; `body` is the body's name.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] if there is no such place.
    pub fn point(&self, body: &str, place: &Place) -> Result<FlexiblePoint, AdaptiveError> {
        Ok(self.marker(body, "point", place, UnitQuaternion::identity())?.point())
    }

    /// The marker `name` at `place` with axes turned by `rotation` from those of the body called `body`.
    ///
    /// # Errors
    /// As [`MeshedModel::point`].
    pub fn marker(
        &self,
        body: &str,
        name: &str,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<Marker, AdaptiveError> {
        self.spec
            .marker_weights(body, place, rotation)?
            .marker(name, self.reduced.shapes())
            .map_err(|source| AdaptiveError::Reduction { body: body.to_owned(), source })
    }
}
