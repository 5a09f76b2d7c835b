//! The displacement field of a body, coarse or fine, of whatever elements: its points, markers and
//! parts, strain and stress.

use contact_qs::zone::points::DofLookup;
use faer::sparse::SparseColMat;
use faer::{Mat, MatRef};
use ffr_dynamics::body::{AssembledBody, Dof, RigidMotion};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use iga_core::SplineError;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::elasticity::{Material, MaterialField, Model};
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::space::Space;
use nalgebra::{UnitQuaternion, Vector3};

use crate::body::gauge::Gauge;
use crate::body::loads::{StaticLoads, load_columns};
use crate::body::part_motion::PartPoints;
use crate::error::AdaptiveError;
use crate::spec::body::rigid_motion;
use crate::spec::{Area, Place};

/// Unknowns on a rigid part beyond which the block that couples all of them is refused: 1e7
/// entries.
const MOST_RIGID_UNKNOWNS: usize = 4500;
/// Share of the largest weight below which an unknown does not count for a marker: round-off of
/// basis functions that vanish there.
const ROUND_OFF: f64 = 1e-12;

/// Values of functions that vanish at a point on a side of their element: round-off of its
/// parameters.
const VANISHES: f64 = 16.0 * f64::EPSILON;

/// Displacements of a body on a space of its own, with materials and numbered unknowns. What a new
/// kind of elements has to say is required; what follows from it is provided.
pub trait Field: Send + Sync {
    /// Name of the body.
    fn name(&self) -> &str;

    /// Functions.
    fn space(&self) -> &dyn Space;

    /// Kinematics.
    fn model(&self) -> &Model;

    /// Materials of the elements.
    fn materials(&self) -> &dyn MaterialField;

    /// The unknowns, sorted by node, then component.
    fn dofs(&self) -> &[Dof];

    /// The number of the unknown of each function and component.
    fn lookup(&self) -> &DofLookup;

    /// Element and parameters of a point of the undeformed body, in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] if the point is not in the body.
    fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError>;

    /// Quadrature points of a part of the body.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] if there is no such part.
    fn points_of(&self, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError>;

    /// The place that the body calls `marker`, in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if there is none.
    fn named_place(&self, marker: &str) -> Result<[f64; 3], AdaptiveError>;

    /// Strain and stress at the parameters `xi` of element `e` by a unit of the displacement of
    /// every function that they depend on, a component at a time [1/m].
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the elements are folded.
    fn unit_states(&self, e: usize, xi: &[f64; 3]) -> Result<Vec<(u32, Vec<PointState>)>, SplineError> {
        RecoveryWorkspace::default().unit_states(self.space(), self.model(), self.materials().on(e), e, xi)
    }

    /// The field of the unknowns `u` as it is drawn: a displacement for every control point or
    /// node, node-major; zeros where a component is held.
    fn drawn_values(&self, u: &[f64]) -> Vec<f64> {
        self.control_values(u)
    }

    /// Rigid motions of the model.
    fn motion(&self) -> RigidMotion {
        rigid_motion(self.model())
    }

    /// Number of unknowns.
    fn n_unknowns(&self) -> usize {
        self.dofs().len()
    }

    /// An error of the geometry of this body.
    fn geometry_fault(&self, source: SplineError) -> AdaptiveError {
        AdaptiveError::Geometry { body: self.name().to_owned(), source }
    }

    /// Displacements of the unknowns as node-major control values, with zeros where a component is
    /// held.
    fn control_values(&self, u: &[f64]) -> Vec<f64> {
        let n_components = self.motion().n_components();
        let mut values = vec![0.0; self.space().n_functions() * n_components];
        for (dof, u) in self.dofs().iter().zip(u) {
            values[dof.node as usize * n_components + dof.component as usize] = *u;
        }
        values
    }

    /// Functions that are not zero at a point of the undeformed body (the model's components,
    /// \[m\]), with their values.
    ///
    /// # Errors
    /// As [`Field::locate`].
    fn functions_at(&self, place: &[f64; 3]) -> Result<Vec<(u32, f64)>, AdaptiveError> {
        let (e, xi) = self.locate(place)?;
        Ok(self.space().functions_at(e, &xi))
    }

    /// Strain and stress at a point of the undeformed body, in the model's components \[m\].
    ///
    /// # Errors
    /// As [`Field::locate`]; [`AdaptiveError::Geometry`] if an element about it is folded.
    fn gauge_at(&self, place: &[f64; 3]) -> Result<Gauge, AdaptiveError> {
        let (e, xi) = self.locate(place)?;
        self.unit_states(e, &xi).map(Gauge::of).map_err(|source| self.geometry_fault(source))
    }

    /// Coordinates of a place in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if the body has no marker of that name.
    fn coordinates(&self, place: &Place) -> Result<[f64; 3], AdaptiveError> {
        match place {
            Place::Point(point) | Place::Area(Area { centre: point, .. }) => Ok(*point),
            Place::Marker(name) => self.named_place(name),
        }
    }

    /// The material point at `place`, moving with the modes `shapes`; of a part of the body its
    /// mean motion.
    ///
    /// # Errors
    /// As [`Field::locate`], [`Field::part`] and [`Field::named_place`] if there is no such place.
    fn flexible_point(&self, place: &Place, shapes: MatRef<'_, f64>) -> Result<FlexiblePoint, AdaptiveError> {
        if matches!(place, Place::Area(_)) {
            return Ok(self.marker("point", place, UnitQuaternion::identity(), shapes)?.point());
        }
        let place = self.coordinates(place)?;
        let functions = self.functions_at(&place)?;
        let (motion, lookup) = (self.motion(), self.lookup());
        let row = |c: usize, j: usize| -> f64 {
            let terms =
                functions.iter().filter_map(|&(node, v)| Some(v * shapes[(lookup.number(node, c)?, j)]));
            terms.sum()
        };
        let rows = Mat::from_fn(motion.n_components(), shapes.ncols(), row);
        Ok(FlexiblePoint::from_rows(motion, motion.in_space(&place), rows.as_ref(), 0))
    }

    /// The marker `name` at `place` with axes turned by `rotation` from the body's, moving with the
    /// modes `shapes`. At a point it turns with half the curl of the displacement, on a part of the
    /// body it has its mean motion (theory Eq. M.9).
    ///
    /// # Errors
    /// As [`Field::flexible_point`]; [`AdaptiveError::Reduction`] if a mode is not finite there.
    fn marker(
        &self,
        name: &str,
        place: &Place,
        rotation: UnitQuaternion<f64>,
        shapes: MatRef<'_, f64>,
    ) -> Result<Marker, AdaptiveError> {
        let marker = self.marker_weights(place, rotation)?.marker(name, shapes);
        marker.map_err(|source| AdaptiveError::Reduction { body: self.name().to_owned(), source })
    }

    /// The marker at `place` with axes turned by `rotation`, in terms of the unknowns.
    ///
    /// # Errors
    /// As [`Field::flexible_point`]; [`AdaptiveError::Reduction`] if a function is not finite
    /// there.
    fn marker_weights(
        &self,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        match place {
            Place::Area(area) => self.mean_motion(area, rotation),
            Place::Point(_) | Place::Marker(_) => self.turning_point(&self.coordinates(place)?, rotation),
        }
    }

    /// The marker that moves with the material point at `place` and turns by half the curl of the
    /// displacement there (theory Eq. M.8), with the orientation `rotation`.
    ///
    /// # Errors
    /// As [`Field::locate`]; [`AdaptiveError::Reduction`] if its orientation is not finite.
    fn turning_point(
        &self,
        place: &[f64; 3],
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        let (e, xi) = self.locate(place)?;
        let functions = RecoveryWorkspace::default().functions(self.space(), e, &xi);
        let motion = self.motion();
        let mut entries = Vec::new();
        for f in functions.map_err(|source| self.geometry_fault(source))? {
            let gradient = Vector3::from(f.gradient);
            for c in 0..motion.n_components() {
                let Some(unknown) = self.lookup().number(f.number, c) else { continue };
                let direction = Vector3::ith(motion.direction(c), 1.0);
                let mut w = [0.0; 6];
                if motion != RigidMotion::Axial {
                    w[3..].copy_from_slice((0.5 * gradient.cross(&direction)).as_slice());
                } else if c == 0 {
                    continue; // around the circumference radial displacements have no mean
                }
                w[..3].copy_from_slice((f.value * direction).as_slice());
                entries.push((unknown as u32, w));
            }
        }
        drop_round_off(&mut entries);
        self.weights(place, rotation, entries)
    }

    /// The material point at `place` in terms of the unknowns, without its rotation.
    ///
    /// # Errors
    /// As [`Field::locate`]; [`AdaptiveError::Reduction`] if it is not finite.
    fn point_weights(&self, place: &[f64; 3]) -> Result<MarkerWeights, AdaptiveError> {
        let motion = self.motion();
        let mut entries = Vec::new();
        for (node, value) in self.functions_at(place)? {
            for c in 0..motion.n_components() {
                let mut w = [0.0; 6];
                w[motion.direction(c)] = value;
                entries.extend(self.lookup().number(node, c).map(|unknown| (unknown as u32, w)));
            }
        }
        self.weights(place, UnitQuaternion::identity(), entries)
    }

    /// The marker of the unknowns `entries` at `place`.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] if it is not finite.
    fn weights(
        &self,
        place: &[f64; 3],
        rotation: UnitQuaternion<f64>,
        mut entries: Vec<(u32, [f64; 6])>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        entries.sort_unstable_by_key(|(unknown, _)| *unknown);
        MarkerWeights::new(self.motion().in_space(place), rotation, entries)
            .map_err(|source| AdaptiveError::Reduction { body: self.name().to_owned(), source })
    }

    /// The part `extent` with the functions at its points.
    ///
    /// # Errors
    /// As [`Field::points_of`].
    fn part(&self, extent: &Extent) -> Result<PartPoints, AdaptiveError> {
        let space = self.space();
        let mut part = PartPoints::new(self.motion(), space.n_functions());
        for point in self.points_of(extent)? {
            let mut found = space.functions_at(point.element, &point.xi);
            found.retain(|(_, value)| value.abs() > VANISHES);
            // Where the functions put a point, not where the search wanted it to the last digits
            // but one: rigid motions are then followed to round-off.
            let mut place = [0.0; 3];
            for &(number, value) in &found {
                let control_point = space.control_points()[number as usize];
                place.iter_mut().zip(control_point).for_each(|(sum, p)| *sum += value * p);
            }
            part.push(place, point.weight, &found);
        }
        Ok(part)
    }

    /// The marker that follows the mean motion of `area`: displacement and rotation of its centre
    /// by the rigid motion nearest to the displacements of the part, every point with its area
    /// (theory Eq. M.9).
    ///
    /// # Errors
    /// As [`Field::part`]; [`AdaptiveError::Reduction`] if it defines no rotation.
    fn mean_motion(
        &self,
        area: &Area,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        let number = |function, c| self.lookup().number(function, c);
        self.part(&area.extent)?
            .mean_motion(&area.centre, rotation, number)
            .map_err(|source| AdaptiveError::Reduction { body: self.name().to_owned(), source })
    }

    /// The lower triangle `stiffness` with that of the rigid parts `areas` of `material` added:
    /// `α ∫ |u - u_rigid|² dA` with the rigid motion `u_rigid` nearest to `u` (theory Eq. M.10).
    /// Rigid motions of the body stay free of forces, masses stay as they are.
    ///
    /// # Errors
    /// As [`Field::mean_motion`]; [`AdaptiveError::Unsupported`] for parts with thousands of
    /// unknowns.
    fn stiffened(
        &self,
        stiffness: SparseColMat<u32, f64>,
        areas: &[Area],
        material: &Material,
    ) -> Result<SparseColMat<u32, f64>, AdaptiveError> {
        areas.iter().try_fold(stiffness, |sum, area| {
            let number = |function, c| self.lookup().number(function, c);
            let (young, thickness) = (material.youngs_modulus(), self.model().thickness());
            let block =
                self.part(&area.extent)?
                    .rigid_block(young, thickness, number, MOST_RIGID_UNKNOWNS)
                    .map_err(|source| AdaptiveError::Reduction { body: self.name().to_owned(), source })?;
            let block = block.map_err(|unknowns| {
                let part = area.extent.name();
                let what = format!(
                    "the rigid coupling of {part} holds {unknowns} unknowns, {MOST_RIGID_UNKNOWNS} are possible; choose coupling = \
                     \"average\" or fewer elements"
                );
                AdaptiveError::unsupported_body(self.name(), what)
            })?;
            Ok(block.added_to(&sum))
        })
    }

    /// Forces on the unknowns of `assembled`, the matrices of this field, under `loads`, a column
    /// each, see [`load_columns`].
    ///
    /// # Errors
    /// As [`Field::marker_weights`].
    fn load_columns(
        &self,
        assembled: &AssembledBody,
        loads: &StaticLoads,
    ) -> Result<Mat<f64>, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name().to_owned(), source };
        load_columns(assembled, loads, |place| self.marker_weights(place, UnitQuaternion::identity()), fail)
    }
}

/// Leaves out unknowns that move and turn the marker by round-off only.
fn drop_round_off(entries: &mut Vec<(u32, [f64; 6])>) {
    let largest = |part: std::ops::Range<usize>| {
        entries.iter().flat_map(|(_, w)| &w[part.clone()]).fold(0.0f64, |m, v| m.max(v.abs()))
    };
    let limits = [largest(0..3), largest(3..6)].map(|m| ROUND_OFF * m);
    entries.retain(|(_, w)| w.iter().enumerate().any(|(i, v)| v.abs() > limits[i / 3]));
}
