//! Whether meshes are fine enough where they are touched, from the contact radius that Hertz's theory predicts (docs/theory.md Eq. P.11).

use ffr_dynamics::system::force::BodyState;

use crate::mesh_surface::{MeshSurface, SideSite};
use crate::sizing::zone::predicted_zone;
use crate::spec::{BodyKind, ContactLaw, ContactSpec, MeshedSpec, RunSpec, Target};
use crate::touch_sites::TouchSite;
use crate::warning::{Warning, WarningKind};

/// Sides of quadratic elements on the contact radius that make the force right to half a per cent: with one the force of a ball is off by 0.7 %, with
/// two by 0.2 % (Eq. P.11).
pub const QUADRATIC: f64 = 2.0;
/// The same of linear elements: with three the force is off by 3 %, which falls with the square of their length.
pub const LINEAR: f64 = 8.0;
/// Growth of elements per length away from the touch in a field of sizes.
pub const GROWTH: f64 = 0.35;

/// A place where a body of finite elements is going to be touched.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshTouch {
    /// Name of the contact.
    pub contact: String,
    /// Index of the body.
    pub body: usize,
    /// Name of the body.
    pub name: String,
    /// Where \[m\].
    pub point: [f64; 3],
    /// Predicted radius of the contact, of an ellipse the larger one \[m\].
    pub radius: f64,
    /// Predicted force \[N\].
    pub force: f64,
    /// Longest edge of the sides there \[m\].
    pub length: f64,
    /// Longest edge that resolves the contact \[m\].
    pub wanted: f64,
}

impl MeshTouch {
    /// Whether the sides there are too long.
    pub fn is_coarse(&self) -> bool {
        self.length > self.wanted
    }

    /// The warning of a touch with sides that are too long.
    pub fn warning(&self) -> Warning {
        let Self { contact, name, length, wanted, radius, force, .. } = self;
        Warning {
            kind: WarningKind::CoarseTouch,
            subject: format!("body \"{name}\""),
            time: 0.0,
            value: *length,
            limit: *wanted,
            message: format!(
                "contact \"{contact}\" touches it with a radius of {radius:.3e} m at {force:.3e} N by Hertz's theory, where the sides of its \
                 elements are {length:.3e} m long; {wanted:.3e} m at most make the force right"
            ),
            remedy:
                "mesh it finer at the touch: fbimpact mesh-size SCENARIO -o sizes.geo writes sizes for Gmsh"
                    .into(),
        }
    }
}

/// The touches of `contact` on bodies of finite elements, as far as Hertz's theory predicts them, `poses` being the motions at the start.
pub fn touches(spec: &RunSpec, poses: &[BodyState], contact: &ContactSpec) -> Vec<MeshTouch> {
    let on_mesh = |body: usize| match &spec.bodies[body].kind {
        BodyKind::Meshed(meshed) => Some(meshed.as_ref()),
        BodyKind::Elastic(_) | BodyKind::Rigid(_) | BodyKind::Imported(_) => None,
    };
    let other = if let Target::Body(other) = contact.target { Some(other) } else { None };
    let bodies = [Some(contact.body), other];
    let has_mesh = bodies.iter().flatten().any(|b| on_mesh(*b).is_some());
    if !(has_mesh && matches!(contact.law, ContactLaw::Surface(_))) {
        return Vec::new();
    }
    let Some(zone) = predicted_zone(spec, poses, contact) else { return Vec::new() };
    let touch = |(body, site): (usize, TouchSite)| {
        let (mesh, TouchSite::Side(site)) = (on_mesh(body)?, site) else { return None };
        let (length, wanted) = lengths(mesh, &site, zone.half_width);
        Some(MeshTouch {
            contact: contact.name.clone(),
            body,
            name: spec.bodies[body].name.clone(),
            point: site.point,
            radius: zone.half_width,
            force: zone.force,
            length,
            wanted,
        })
    };
    let sites = bodies.into_iter().zip(zone.sites).filter_map(|(body, site)| Some((body?, site?)));
    sites.filter_map(touch).collect()
}

/// Longest edge at `site`, and the longest that resolves a contact of the given radius \[m\].
fn lengths(body: &MeshedSpec, site: &SideSite, radius: f64) -> (f64, f64) {
    let is_quadratic = body.mesh.elements().iter().next().is_some_and(|e| e.kind.is_quadratic());
    let sides = if is_quadratic { QUADRATIC } else { LINEAR };
    (MeshSurface::of(&body.mesh).length_at(site), radius / sides)
}

/// Mean length of the longest edges of the sides that are not near `touches` \[m\]; of all if there is no other.
pub fn usual_length(body: &MeshedSpec, touches: &[MeshTouch]) -> f64 {
    let all: Vec<([f64; 3], f64)> = MeshSurface::of(&body.mesh).lengths().collect();
    let is_far = |point: &[f64; 3]| {
        let distance = |t: &MeshTouch| {
            t.point.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / t.radius
        };
        // Beyond ten radii pressure of contact is no matter for the mesh.
        touches.iter().all(|t| distance(t) > 10.0)
    };
    let far: Vec<f64> = all.iter().filter(|(point, _)| is_far(point)).map(|(_, length)| *length).collect();
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    if far.is_empty() { mean(&all.iter().map(|(_, length)| *length).collect::<Vec<_>>()) } else { mean(&far) }
}
