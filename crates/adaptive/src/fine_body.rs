//! The fine model of a body in a contact, of splines or of finite elements, or the body's own elements with its whole surface.

use std::borrow::Cow;

use contact_qs::points::DofLookup;
use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, RigidMotion};
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::{BodyTurn, FreeFlexibility, LowModes, ResidualFlexibility};
use iga_core::space::Space;
use nalgebra::Vector3;

use crate::body_model::FlexibleBody;
use crate::contact_zone::{ContactZone, PointsAbout};
use crate::elastic_body::{Discretised, ElasticBody};
use crate::error::AdaptiveError;
use crate::fine_elements::{FineElements, WantedZone, zone_definition as key_of_elements};
use crate::fine_model::{FineMesh, FineSettings, zone_definition as key_of_splines};
use crate::gauge::Gauge;
use crate::interval::IntervalGrid;
use crate::point_compliance::{ObservedPlace, PlaceFunctions, add_places};
use crate::record::TargetPlace;
use crate::spec::PointRule;
use crate::store::{ModelKey, matrix_values};
use crate::unsupported::Unsupported;
use crate::wanted_interval::WantedInterval;

/// A fine model before its matrices, with what was asked for.
pub enum FineBodyModel<'a> {
    /// Of splines.
    Splines {
        /// The refined mesh.
        mesh: Box<FineMesh>,
        /// The interval.
        wanted: WantedInterval,
        /// How levels were made.
        settings: FineSettings,
    },
    /// Of finite elements.
    Elements {
        /// The divided mesh.
        mesh: Box<FineElements>,
        /// The zone.
        wanted: WantedZone,
    },
    /// The body of splines itself: its zone is its whole surface (theory C.9), with points at a place on it if there is one.
    Whole(&'a ElasticBody, Option<PointsAbout>),
}

/// The elements of a fine model, without what they were made from.
pub enum ZoneMesh {
    /// Those of the body itself.
    Own,
    /// Splines.
    Splines(Box<FineMesh>),
    /// Finite elements.
    Elements(Box<FineElements>),
}

impl FineBodyModel<'_> {
    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Splines { mesh, .. } => mesh.motion,
            Self::Elements { .. } => RigidMotion::Spatial,
            Self::Whole(body, _) => body.assembled.motion,
        }
    }

    /// Numbers of the unknowns.
    pub fn lookup(&self) -> &DofLookup {
        match self {
            Self::Splines { mesh, .. } => &mesh.lookup,
            Self::Elements { mesh, .. } => &mesh.lookup,
            Self::Whole(body, _) => &body.lookup,
        }
    }

    /// The spline space; none of finite elements.
    pub fn splines(&self) -> Option<Discretised<'_>> {
        match self {
            Self::Splines { mesh, .. } => Some(mesh.discretised()),
            Self::Elements { .. } => None,
            Self::Whole(body, _) => Some(body.discretised()),
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        match self {
            Self::Splines { mesh, .. } => mesh.n_unknowns(),
            Self::Elements { mesh, .. } => mesh.n_unknowns(),
            Self::Whole(body, _) => body.assembled.n_unknowns(),
        }
    }

    /// Number of elements.
    pub fn n_elements(&self) -> usize {
        match self {
            Self::Splines { mesh, .. } => mesh.space.n_elements(),
            Self::Elements { mesh, .. } => mesh.n_elements(),
            Self::Whole(body, _) => body.space.n_elements(),
        }
    }

    /// Contact points, by `rule` on splines, and interface; `contact` is the contact's name.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if no point lies in the zone, [`AdaptiveError::Mesh`] for a side without area.
    pub fn zone(&self, rule: PointRule, contact: &str) -> Result<ContactZone, AdaptiveError> {
        let fail = |source| AdaptiveError::Contact { contact: contact.to_owned(), source };
        match self {
            Self::Splines { mesh, .. } => mesh.zone(0, rule).map_err(fail),
            Self::Elements { mesh, .. } => mesh.zone(),
            Self::Whole(body, about) => ContactZone::whole(&body.discretised(), about.as_ref()).map_err(fail),
        }
    }

    /// Outward normal of the smooth surface that the zone lies on in place of the sides of the mesh; none if it lies on the surface of the body.
    pub fn outward(&self) -> Option<Vector3<f64>> {
        match self {
            Self::Splines { .. } | Self::Whole(..) => None,
            Self::Elements { mesh, .. } => mesh.outward(),
        }
    }

    /// The rows by which the use of the zone is judged; a whole surface has none.
    pub fn grid(&self) -> IntervalGrid {
        match self {
            Self::Splines { mesh, .. } => mesh.intervals[0].grid(),
            Self::Elements { mesh, .. } => mesh.grid(),
            Self::Whole(body, _) => {
                IntervalGrid { widths: [body.size(), 0.0], ends: Vec::new(), n_elements: [1; 2] }
            }
        }
    }

    /// The row of each point of `zone`, per direction.
    pub fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        match self {
            Self::Splines { mesh, .. } => mesh.contact_elements(0, zone),
            Self::Elements { mesh, .. } => mesh.contact_elements(zone),
            Self::Whole(..) => vec![[0; 2]; zone.points.len()],
        }
    }

    /// What the place `place` of the body shows of the unknowns, `coarse` being the body.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn shown_at(
        &self,
        place: &ObservedPlace,
        coarse: &FlexibleBody<'_>,
    ) -> Result<PlaceFunctions, AdaptiveError> {
        if let Self::Elements { mesh, .. } = self {
            return PlaceFunctions::new(place, |x| mesh.functions_at(x), |x| mesh.gauge(x));
        }
        let (Some(mesh), Some(body)) = (self.splines(), coarse.spline_body()) else {
            return Err(other_kind(coarse));
        };
        let gauge = |x: &[f64; 3]| Gauge::of_splines(&mesh, &body.spec.material, x);
        PlaceFunctions::new(place, |x| mesh.functions_at(x), gauge)
    }

    /// What the zone meets of the target at one place, if that has an edge or a corner there.
    pub fn meets(&self) -> Option<&TargetPlace> {
        let Self::Whole(_, Some(about)) = self else { return None };
        about.meets.as_ref()
    }

    /// The rotation by which the model is turned after its matrices are made; none of most.
    pub fn turn(&self, coarse: &FlexibleBody<'_>) -> Option<BodyTurn> {
        match (self, coarse.spline_body()) {
            (Self::Splines { mesh, .. }, Some(body)) => mesh.turn(body),
            _ => None,
        }
    }

    /// Stiffness and mass before the model is turned, `coarse` being the body.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the body's name.
    pub fn assemble(&self, coarse: &FlexibleBody<'_>) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        match (self, coarse.spline_body()) {
            (Self::Splines { mesh, .. }, Some(body)) => mesh.assemble_unturned(body).map(Cow::Owned),
            (Self::Elements { mesh, .. }, None) => mesh.assemble().map(Cow::Owned),
            (Self::Whole(body, _), _) => Ok(Cow::Borrowed(&body.assembled)),
            _ => Err(other_kind(coarse)),
        }
    }

    /// Modes of `coarse` in use at the unknowns.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if `coarse` is of the other kind.
    pub fn shapes(&self, coarse: &FlexibleBody<'_>) -> Result<Mat<f64>, AdaptiveError> {
        self.prolong(coarse, coarse.reduced.shapes())
    }

    /// Free modes of `coarse` that are dynamic, at the unknowns.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if `coarse` is of the other kind.
    pub fn low_modes(&self, coarse: &FlexibleBody<'_>) -> Result<LowModes, AdaptiveError> {
        let LowModes { shapes, omega } = coarse.reduced.basis.low_modes();
        Ok(LowModes { shapes: self.prolong(coarse, shapes.as_ref())?, omega })
    }

    fn prolong(&self, coarse: &FlexibleBody<'_>, shapes: MatRef<'_, f64>) -> Result<Mat<f64>, AdaptiveError> {
        match (self, coarse.spline_body()) {
            (Self::Splines { mesh, .. }, Some(body)) => Ok(mesh.prolong(&body.assembled, shapes)),
            (Self::Elements { mesh, .. }, None) => Ok(mesh.prolong(shapes)),
            (Self::Whole(..), Some(_)) => Ok(shapes.to_owned()),
            _ => Err(other_kind(coarse)),
        }
    }

    /// Flexibility of the interface `unknowns` of `assembled`, the matrices of the body `coarse` before the model is turned.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn flexibility(
        &self,
        assembled: &AssembledBody,
        coarse: &FlexibleBody<'_>,
        unknowns: &[usize],
    ) -> Result<FreeFlexibility, AdaptiveError> {
        let problem = ElasticProblem::free(assembled, unknowns);
        let flexibility = problem.and_then(|problem| FreeFlexibility::new(&problem, unknowns));
        flexibility.map_err(|source| reduction(coarse, source))
    }

    /// What the modes of `coarse`, prolonged, leave of `flexibility` (theory Eq. A.6).
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn residual(
        &self,
        flexibility: FreeFlexibility,
        coarse: &FlexibleBody<'_>,
        low: LowModes,
    ) -> Result<ResidualFlexibility, AdaptiveError> {
        flexibility.without(low, self.turn(coarse)).map_err(|source| reduction(coarse, source))
    }

    /// Key of what is kept of the flexibility of the interface `unknowns` and, if `has_modes`, without the modes of `coarse` and with what `points` show
    /// of it, of the model as it is turned.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if `coarse` is of the other kind.
    pub fn compliance_key(
        &self,
        coarse: &FlexibleBody<'_>,
        (unknowns, points): (&[usize], &[ObservedPlace]),
        has_modes: bool,
    ) -> Result<ModelKey, AdaptiveError> {
        let turn = self.turn(coarse);
        let mut key = match (self, coarse.spline_body(), coarse.mesh()) {
            (Self::Splines { mesh, wanted, settings }, Some(body), _) => {
                let unturned = mesh.rotated.as_ref().filter(|_| turn.is_some());
                let wanted = unturned.map_or(*wanted, |rotated| rotated.net.turn.wanted);
                key_of_splines(body, Some((&wanted, settings)))
            }
            (Self::Whole(body, _), ..) => key_of_splines(body, None),
            (Self::Elements { wanted, .. }, _, Some(spec)) => key_of_elements(spec, wanted),
            _ => return Err(other_kind(coarse)),
        };
        key.add(&has_modes);
        if has_modes {
            let basis = &coarse.reduced.basis;
            key.add(&(basis.n_low, &basis.omega, basis.shapes.nrows(), matrix_values(&basis.shapes)));
            key.add(&turn.map(|turn| (turn.rotation, turn.n_components)));
        }
        // They say as well by which points the contact is watched.
        add_places(&mut key, unknowns, points);
        Ok(ModelKey { kind: "compliance", definition: key.0 })
    }

    /// Its elements.
    pub fn into_mesh(self) -> ZoneMesh {
        match self {
            Self::Splines { mesh, .. } => ZoneMesh::Splines(mesh),
            Self::Elements { mesh, .. } => ZoneMesh::Elements(mesh),
            Self::Whole(..) => ZoneMesh::Own,
        }
    }
}

/// What a reduction of `body` says.
fn reduction(body: &FlexibleBody<'_>, source: DynamicsError) -> AdaptiveError {
    AdaptiveError::Reduction { body: body.name.to_owned(), source }
}

/// A fine model that is not one of `body`.
fn other_kind(body: &FlexibleBody<'_>) -> AdaptiveError {
    AdaptiveError::unsupported_body(body.name, Unsupported::FineModelOfOtherKind)
}
