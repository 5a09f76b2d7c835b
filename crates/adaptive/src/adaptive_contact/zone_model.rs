//! Fine models that are built again to look at them.

use contact_qs::points::DofLookup;
use faer::Mat;
use ffr_dynamics::reduction::ResidualFlexibility;

use crate::body_model::FlexibleBody;
use crate::contact_zone::ContactZone;
use crate::error::AdaptiveError;
use crate::fine_body::ZoneMesh;
use crate::gauge::Gauge;
use crate::point_compliance::{Functions, ObservedPlace, PlaceFunctions, PointCompliance, of_body};
use crate::simulation::ObservedPoint;

/// A fine model of a body, built again to look at it.
pub struct ZoneModel {
    /// Its elements.
    pub mesh: ZoneMesh,
    /// Contact points and interface.
    pub zone: ContactZone,
    /// Low-frequency modes at its unknowns, in the frame in use.
    pub shapes: Mat<f64>,
    /// Flexibility of what they leave out.
    pub residual: ResidualFlexibility,
}

impl ZoneModel {
    /// Numbers of its unknowns, `body` being its body.
    pub fn lookup<'a>(&'a self, body: &FlexibleBody<'a>) -> &'a DofLookup {
        match &self.mesh {
            ZoneMesh::Own => body.lookup,
            ZoneMesh::Splines(mesh) => &mesh.lookup,
            ZoneMesh::Elements(mesh) => &mesh.lookup,
        }
    }

    /// Strain and stress at the point `x` of `body`, its body, in the components of that's model \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn gauge_at(&self, x: &[f64; 3], body: &FlexibleBody<'_>) -> Result<Gauge, AdaptiveError> {
        match (&self.mesh, body.spline_body()) {
            (ZoneMesh::Splines(mesh), Some(splines)) => {
                Gauge::of_splines(&mesh.discretised(), &splines.spec.material, x)
            }
            (ZoneMesh::Elements(mesh), _) => mesh.gauge(x),
            _ => body.gauge_at(x),
        }
    }

    /// The field of its unknowns `u` as it is drawn: control values of splines, values at all nodes of a mesh, those behind the free ones tied to them.
    pub fn field(&self, u: &[f64], body: &FlexibleBody<'_>) -> Vec<f64> {
        match &self.mesh {
            ZoneMesh::Own => body.field(u),
            ZoneMesh::Splines(mesh) => mesh.discretised().control_values(u),
            ZoneMesh::Elements(mesh) => mesh.at_nodes(u),
        }
    }

    /// Functions that are not zero at the point `x` of `body`, its body, with their values.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn functions_at(&self, x: &[f64; 3], body: &FlexibleBody<'_>) -> Result<Functions, AdaptiveError> {
        match &self.mesh {
            ZoneMesh::Own => body.functions_at(x),
            ZoneMesh::Splines(mesh) => mesh.discretised().functions_at(x),
            ZoneMesh::Elements(mesh) => mesh.functions_at(x),
        }
    }

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
        let show = |place: &ObservedPlace| {
            PlaceFunctions::new(place, |x| self.functions_at(x, body), |x| self.gauge_at(x, body))
        };
        of_body(all, (index, body.motion, self.lookup(body)), show, &self.residual)
    }
}
