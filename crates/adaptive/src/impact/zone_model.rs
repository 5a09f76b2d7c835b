//! Fine models of contacts, built again to look at them.

use faer::Mat;
use ffr_dynamics::reduction::ResidualFlexibility;

use crate::body::fine::FineModel;
use crate::body::point_compliance::{PointCompliance, of_body};
use crate::body::zone::ContactZone;
use crate::error::AdaptiveError;
use crate::state::simulation::ObservedPoint;

/// A fine model of a body, built again to look at it.
pub struct ZoneModel {
    /// Its elements.
    pub model: Box<dyn FineModel>,
    /// Contact points and interface.
    pub zone: ContactZone,
    /// Low-frequency modes at its unknowns, in the frame in use.
    pub shapes: Mat<f64>,
    /// Flexibility of what they leave out.
    pub residual: ResidualFlexibility,
}

impl ZoneModel {
    /// How forces at its interface displace those of the points `all` that are on its body, whose
    /// number is `body`, and strain it there (theory Eqs. Q.5, Q.8).
    ///
    /// # Errors
    /// [`AdaptiveError`] if a point is not in the body.
    pub fn compliances(
        &self,
        all: &[ObservedPoint],
        body: usize,
    ) -> Result<Vec<PointCompliance>, AdaptiveError> {
        of_body(all, (body, self.model.field()), &self.residual)
    }
}
