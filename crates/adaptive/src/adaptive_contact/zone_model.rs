//! Fine models that are built again to look at them.

use faer::Mat;
use ffr_dynamics::reduction::ResidualFlexibility;

use crate::body_model::FlexibleBody;
use crate::contact_zone::ContactZone;
use crate::error::AdaptiveError;
use crate::fine_model::FineMesh;
use crate::gauge::Gauge;
use crate::point_compliance::{ObservedPlace, PlaceFunctions, PointCompliance, of_body};
use crate::simulation::ObservedPoint;

/// A fine model of a body, built again to look at it.
pub struct ZoneModel {
    /// The mesh; none if it is that of the body itself.
    pub mesh: Option<FineMesh>,
    /// Contact points and interface.
    pub zone: ContactZone,
    /// Low-frequency modes at its unknowns, in the frame in use.
    pub shapes: Mat<f64>,
    /// Flexibility of what they leave out.
    pub residual: ResidualFlexibility,
}

impl ZoneModel {
    /// How forces at its interface displace those of the points `all` that are on its body, whose number and view are given, and strain it
    /// there (theory Eqs. A.33, M.52).
    ///
    /// # Errors
    /// [`AdaptiveError`] if a point is not in the body.
    pub fn compliances(
        &self,
        all: &[ObservedPoint],
        (index, body): (usize, &FlexibleBody<'_>),
    ) -> Result<Vec<PointCompliance>, AdaptiveError> {
        let lookup = self.mesh.as_ref().map_or(body.lookup, |mesh| &mesh.lookup);
        let show = |place: &ObservedPlace| {
            let (Some(mesh), Some(splines)) = (&self.mesh, body.spline_body()) else {
                return body.shown_at(place);
            };
            let (mesh, material) = (mesh.discretised(), &splines.spec.material);
            PlaceFunctions::new(place, |x| mesh.functions_at(x), |x| Gauge::of_splines(&mesh, material, x))
        };
        of_body(all, (index, body.motion, lookup), show, &self.residual)
    }
}
