//! The fine model of a body in a contact, of splines or of finite elements, or the body's own elements with its whole surface.

use std::borrow::Cow;

use contact_qs::points::DofLookup;
use faer::Mat;
use ffr_dynamics::body::{AssembledBody, RigidMotion};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::problem::ElasticProblem;
use iga_core::space::Space;
use nalgebra::Vector3;

use crate::body_model::FlexibleBody;
use crate::contact_zone::ContactZone;
use crate::elastic_body::{Discretised, ElasticBody};
use crate::error::AdaptiveError;
use crate::fine_elements::{FineElements, WantedZone, compliance_key as key_of_elements};
use crate::fine_model::{FineMesh, FineSettings, compliance_key as key_of_splines};
use crate::gauge::Gauge;
use crate::interval::IntervalGrid;
use crate::point_compliance::{ObservedPlace, PlaceFunctions};
use crate::spec::{LowModes, PointRule};
use crate::store::ModelKey;
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
    /// The body of splines itself: its zone is its whole surface (theory C.9).
    Whole(&'a ElasticBody),
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
            Self::Whole(body) => body.assembled.motion,
        }
    }

    /// Numbers of the unknowns.
    pub fn lookup(&self) -> &DofLookup {
        match self {
            Self::Splines { mesh, .. } => &mesh.lookup,
            Self::Elements { mesh, .. } => &mesh.lookup,
            Self::Whole(body) => &body.lookup,
        }
    }

    /// The spline space; none of finite elements.
    pub fn splines(&self) -> Option<Discretised<'_>> {
        match self {
            Self::Splines { mesh, .. } => Some(mesh.discretised()),
            Self::Elements { .. } => None,
            Self::Whole(body) => Some(body.discretised()),
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        match self {
            Self::Splines { mesh, .. } => mesh.n_unknowns(),
            Self::Elements { mesh, .. } => mesh.n_unknowns(),
            Self::Whole(body) => body.assembled.n_unknowns(),
        }
    }

    /// Number of elements.
    pub fn n_elements(&self) -> usize {
        match self {
            Self::Splines { mesh, .. } => mesh.space.n_elements(),
            Self::Elements { mesh, .. } => mesh.n_elements(),
            Self::Whole(body) => body.space.n_elements(),
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
            Self::Whole(body) => ContactZone::whole(&body.discretised()).map_err(fail),
        }
    }

    /// Outward normal of the smooth surface that the zone lies on in place of the sides of the mesh; none if it lies on the surface of the body.
    pub fn outward(&self) -> Option<Vector3<f64>> {
        match self {
            Self::Splines { .. } | Self::Whole(_) => None,
            Self::Elements { mesh, .. } => mesh.outward(),
        }
    }

    /// The rows by which the use of the zone is judged; a whole surface has none.
    pub fn grid(&self) -> IntervalGrid {
        match self {
            Self::Splines { mesh, .. } => mesh.intervals[0].grid(),
            Self::Elements { mesh, .. } => mesh.grid(),
            Self::Whole(body) => {
                IntervalGrid { widths: [body.size(), 0.0], ends: Vec::new(), n_elements: [1; 2] }
            }
        }
    }

    /// The row of each point of `zone`, a direction.
    pub fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        match self {
            Self::Splines { mesh, .. } => mesh.contact_elements(0, zone),
            Self::Elements { mesh, .. } => mesh.contact_elements(zone),
            Self::Whole(_) => vec![[0; 2]; zone.points.len()],
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

    /// Stiffness and mass, `coarse` being the body.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the body's name.
    pub fn assemble(&self, coarse: &FlexibleBody<'_>) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        match (self, coarse.spline_body()) {
            (Self::Splines { mesh, .. }, Some(body)) => mesh.assemble(body).map(Cow::Owned),
            (Self::Elements { mesh, .. }, None) => mesh.assemble().map(Cow::Owned),
            (Self::Whole(body), _) => Ok(Cow::Borrowed(&body.assembled)),
            _ => Err(other_kind(coarse)),
        }
    }

    /// Modes of `coarse` in use at the unknowns.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if `coarse` is of the other kind.
    pub fn shapes(&self, coarse: &FlexibleBody<'_>) -> Result<Mat<f64>, AdaptiveError> {
        match (self, coarse.spline_body()) {
            (Self::Splines { mesh, .. }, Some(body)) => {
                Ok(mesh.prolong(&body.assembled, coarse.reduced.shapes()))
            }
            (Self::Elements { mesh, .. }, None) => Ok(mesh.prolong(coarse.reduced.shapes())),
            (Self::Whole(_), Some(_)) => Ok(coarse.reduced.shapes().to_owned()),
            _ => Err(other_kind(coarse)),
        }
    }

    /// What the modes of `coarse`, prolonged, leave of the flexibility of the interface `unknowns` of `assembled` (theory Eq. A.6).
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn residual(
        &self,
        assembled: &AssembledBody,
        coarse: &FlexibleBody<'_>,
        unknowns: &[usize],
    ) -> Result<ResidualFlexibility, AdaptiveError> {
        let reduced = &coarse.reduced.basis;
        let fail = |source| AdaptiveError::Reduction { body: coarse.name.to_owned(), source };
        let problem = || ElasticProblem::free(assembled, unknowns).map_err(fail);
        match (self, coarse.spline_body()) {
            (Self::Splines { mesh, .. }, Some(body)) => {
                let reduced = mesh.reduce(assembled, (body, coarse.reduced), unknowns, LowModes::Prolonged);
                reduced.map(|(_, residual)| residual)
            }
            (Self::Elements { mesh, .. }, None) => {
                let problem = problem()?;
                let rigid = problem.free_rigid().map_err(fail)?;
                let basis = reduced.prolonged(mesh.prolong(reduced.shapes.as_ref()), rigid);
                ResidualFlexibility::new(&problem, unknowns, &basis).map_err(fail)
            }
            (Self::Whole(_), Some(_)) => {
                ResidualFlexibility::new(&problem()?, unknowns, reduced).map_err(fail)
            }
            _ => Err(other_kind(coarse)),
        }
    }

    /// Key of the compliance at the interface `unknowns` and to `points`; none if `coarse` is of the other kind.
    pub fn compliance_key(
        &self,
        coarse: &FlexibleBody<'_>,
        at: (&[usize], &[ObservedPlace]),
    ) -> Result<ModelKey, AdaptiveError> {
        match (self, coarse.spline_body(), coarse.mesh()) {
            (Self::Splines { wanted, settings, .. }, Some(body), _) => {
                Ok(key_of_splines((body, coarse.reduced), Some((wanted, settings)), at))
            }
            (Self::Whole(body), ..) => Ok(key_of_splines((body, coarse.reduced), None, at)),
            (Self::Elements { wanted, .. }, _, Some(spec)) => {
                Ok(key_of_elements((spec, coarse.reduced), wanted, at))
            }
            _ => Err(other_kind(coarse)),
        }
    }

    /// Its elements.
    pub fn into_mesh(self) -> ZoneMesh {
        match self {
            Self::Splines { mesh, .. } => ZoneMesh::Splines(mesh),
            Self::Elements { mesh, .. } => ZoneMesh::Elements(mesh),
            Self::Whole(_) => ZoneMesh::Own,
        }
    }
}

/// A fine model that is not one of `body`.
fn other_kind(body: &FlexibleBody<'_>) -> AdaptiveError {
    AdaptiveError::unsupported_body(body.name, Unsupported::FineModelOfOtherKind)
}
