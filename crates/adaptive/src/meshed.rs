//! Bodies of finite elements, reduced here.

use std::sync::Arc;

use faer::Mat;
use fe_mesh::Mesh;
use fe_mesh::fault::MeshFault;
use fe_mesh::jacobian::PointOf;
use fe_mesh::matrices::{Constants, Materials, assemble};
use fe_mesh::part::Part;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion, StandardInputData};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use ffr_dynamics::reduction::modal::{ReducedBasis, all_modes};
use ffr_dynamics::reduction::rigid::RigidModes;
use iga_core::elasticity::Material;
use nalgebra::{UnitQuaternion, Vector3};

use crate::elastic_body::{basis_from, damping, free_modes_answering, stored_basis};
use crate::error::AdaptiveError;
use crate::marker_loads::{MarkerLoads, answers_by_marker, load_columns};
use crate::part_motion::PartPoints;
use crate::spec::{Area, Extent, FrameSpec, MeshedSpec, Place, ReductionSpec};
use crate::store::{Bytes, ModelCache, ModelKey, meshed_definition};
use crate::unsupported::{MOST_RIGID_UNKNOWNS, Unsupported};

/// Displacement components of a node.
const N_COMPONENTS: usize = 3;

/// A body of finite elements, reduced.
#[derive(Debug, Clone)]
pub struct MeshedModel {
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// Eigenfrequencies of the free body, then those of static answers \[Hz\].
    pub frequencies: Vec<f64>,
    /// How many static answers there are to each joint's or load's forces; the last of the coordinates.
    pub answers: Vec<(String, usize)>,
    /// What it was built from.
    pub spec: MeshedSpec,
    /// Modes at the unknowns, in the frame in use.
    pub shapes: Mat<f64>,
}

/// The constants of a material.
pub fn constants(material: &Material) -> Constants {
    Constants { lambda: material.lame_lambda(), mu: material.shear_modulus(), density: material.density() }
}

/// Number of elastic modes that a mesh has.
pub fn n_elastic_modes(mesh: &Mesh) -> usize {
    (N_COMPONENTS * mesh.nodes().len()).saturating_sub(RigidMotion::Spatial.count())
}

impl MeshedSpec {
    /// Constants of every element.
    ///
    /// # Errors
    /// [`MeshFault`] for a group that does not exist, and for an element in none or several of them.
    pub fn materials(&self) -> Result<Materials, MeshFault> {
        let groups: Vec<(&str, Constants)> =
            self.groups.iter().map(|(name, material)| (name.as_str(), constants(material))).collect();
        let rest = self.material.as_ref().map(constants);
        Materials::by_group(&self.mesh, &groups, rest)
    }

    /// The material whose elastic constants a rigid part is compared with.
    fn first_material(&self) -> Option<&Material> {
        self.material.as_ref().or(self.groups.first().map(|(_, material)| material))
    }

    /// Stiffness and mass matrices, stiffened where parts of the body are rigid; `name` is that of the body.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`]; [`AdaptiveError::Unsupported`] for rigid parts with thousands of unknowns.
    pub fn assembled(&self, name: &str) -> Result<AssembledBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
        let materials = self.materials().map_err(fail)?;
        let matrices = assemble(&self.mesh, &materials, self.mass_rule).map_err(fail)?;
        let mut stiffness = matrices.stiffness;
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
        let nodes = self.mesh.nodes().to_vec();
        let node = |node: u32| (0..N_COMPONENTS as u8).map(move |component| Dof { node, component });
        Ok(AssembledBody {
            name: name.to_owned(),
            motion: RigidMotion::Spatial,
            stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            dofs: (0..nodes.len() as u32).flat_map(node).collect(),
            anchors: nodes.clone(),
            nodes,
        })
    }

    /// The quadrature points of a part.
    fn points(&self, area: &Area) -> Result<PartPoints, MeshFault> {
        let part: Part = match &area.extent {
            Extent::Face(name) => self.mesh.face_part(name)?,
            Extent::Around { point, radius } => self.mesh.around(point, *radius)?,
        };
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
                MarkerWeights::new(Vector3::from(*point), rotation, self.at(point).map_err(fail)?)
                    .map_err(wrong)
            }
            Place::Marker(marker) => {
                let known = self.mesh.face_names().collect::<Vec<_>>().join(", ");
                let what = Unsupported::UnknownMarker { holder: "mesh", marker: marker.clone(), known };
                Err(AdaptiveError::unsupported_body(name, what))
            }
        }
    }

    /// How a material point moves and turns, by half the curl of the displacement, with the unknowns.
    fn at(&self, point: &[f64; 3]) -> Result<Vec<(u32, [f64; 6])>, MeshFault> {
        let (e, xi) = self.mesh.locate(point)?;
        let element = self.mesh.elements().get(e);
        let (mut at, mut places) = (PointOf::default(), Vec::new());
        self.mesh.places(element.nodes, &mut places);
        at.evaluate(element.kind, &places, &xi);
        let mut entries = Vec::with_capacity(N_COMPONENTS * element.nodes.len());
        for ((&node, value), gradient) in element.nodes.iter().zip(&at.functions.values).zip(&at.gradients) {
            for c in 0..N_COMPONENTS {
                let direction = Vector3::ith(c, 1.0);
                let turn = 0.5 * Vector3::from(*gradient).cross(&direction);
                let moved = *value * direction;
                let w = [moved.x, moved.y, moved.z, turn.x, turn.y, turn.z];
                entries.extend(unknown(node, c).map(|n| (n as u32, w)));
            }
        }
        entries.sort_unstable_by_key(|e| e.0);
        Ok(entries)
    }
}

/// Number of the unknown of a node along a direction.
fn unknown(node: u32, component: usize) -> Option<usize> {
    Some(N_COMPONENTS * node as usize + component)
}

impl MeshedModel {
    /// Reduces the body called `name` with static answers to `loads`; modes that `cache` has are not computed again.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] for places and groups that do not exist, [`AdaptiveError::Reduction`], [`AdaptiveError::Unsupported`].
    pub fn build(
        name: &str,
        spec: &MeshedSpec,
        loads: &[MarkerLoads],
        cache: &ModelCache,
    ) -> Result<Self, AdaptiveError> {
        let fail = |source: DynamicsError| AdaptiveError::Reduction { body: name.to_owned(), source };
        let assembled = spec.assembled(name)?;
        let at = |place: &Place| spec.marker_weights(name, place, UnitQuaternion::identity());
        let columns = load_columns(&assembled, loads, at, fail)?;
        let basis = modes(&assembled, spec, &columns, cache).map_err(fail)?;
        let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
        let mut data = StandardInputData::new(&assembled, basis.shapes.as_ref(), &stiffness).map_err(fail)?;
        data.modal_damping = damping(&spec.damping, &stiffness, basis.first_static()).map_err(fail)?;
        let mut shapes = basis.shapes;
        if let FrameSpec::Tangent(place) = &spec.frame {
            let support = at(place)?.marker("frame", shapes.as_ref()).map_err(fail)?;
            let tangent = support.tangent_frame(assembled.motion);
            shapes = tangent.shifted_shapes(&assembled, shapes.as_ref()).map_err(fail)?;
            data = data.in_tangent_frame(&tangent).map_err(fail)?;
        }
        let frequencies = basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect();
        let answers = answers_by_marker(loads, &basis.static_loads);
        Ok(Self { data, frequencies, answers, spec: spec.clone(), shapes })
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
            .marker(name, self.shapes.as_ref())
            .map_err(|source| AdaptiveError::Reduction { body: body.to_owned(), source })
    }
}

/// The modes of `body` with the static answers to `loads`, from `cache` if they are there.
fn modes(
    body: &AssembledBody,
    spec: &MeshedSpec,
    loads: &Mat<f64>,
    cache: &ModelCache,
) -> Result<ReducedBasis, DynamicsError> {
    let mut key = Bytes(meshed_definition(spec));
    match spec.reduction {
        ReductionSpec::All => key.add(&0),
        ReductionSpec::Modal { modes } | ReductionSpec::CraigBampton { modes, .. } => key.add(&(1, modes)),
    }
    key.sparse(loads);
    let key = ModelKey { kind: "modes of a mesh", definition: key.0 };
    let build = || match spec.reduction {
        ReductionSpec::All => all_modes(body),
        ReductionSpec::Modal { modes } | ReductionSpec::CraigBampton { modes, .. } => {
            free_modes_answering(body, modes, loads)
        }
    };
    // Rigid modes come from the matrices at no cost, and errors of theirs before those of the elastic ones.
    let rigid = Arc::new(RigidModes::new(body)?);
    cache.recent(key, |stored| basis_from(stored, body.dofs.len(), &rigid), build, stored_basis)
}
