//! Whether meshes are fine enough where they are touched, from the contact radius that Hertz's
//! theory predicts (docs/theory.md Eq. P.10).

use iga_core::nurbs::jet::{difference, norm};

use crate::record::warning::{Warning, WarningKind};
use crate::sizing::zone::{PredictedZone, predicted_zone};
use crate::spec::{ContactSpec, MeshedSpec};
use crate::surface::smooth_fit::SmoothFit;
use crate::surface::{MeshSurface, Surface, SurfacePlace};
use crate::touch::first::FirstTouches;

/// Sides of quadratic elements on the contact radius that make the force right to half a per cent:
/// with one the force of a ball is off by 0.7 %, with two by 0.2 % (Eq. P.10).
pub const QUADRATIC: f64 = 2.0;
/// Linear elements over the contact radius: with three the force is off by 3 %, which falls with
/// the square of their length.
pub const LINEAR: f64 = 8.0;
/// Growth of elements per length away from the touch in a field of sizes.
pub const GROWTH: f64 = 0.35;

/// Error of the force by the shape of sides beyond which a warning names the body.
const SHAPE_ERROR: f64 = 1e-2;

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
    /// Whether the program divides the elements there when the bodies touch.
    pub is_refined: bool,
    /// Error of the force that the shape of the sides may cause, as a share of it (Eq. C.73).
    pub shape_error: f64,
}

impl MeshTouch {
    /// Whether the sides there are too long, and stay so.
    pub fn is_coarse(&self) -> bool {
        self.length > self.wanted && !self.is_refined
    }

    /// The warnings about it.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> + '_ {
        let is_crude = self.is_refined && self.shape_error > SHAPE_ERROR;
        let coarse = self.is_coarse().then(|| self.warning());
        coarse.into_iter().chain(is_crude.then(|| self.warning_of_shape()))
    }

    /// The warning of sides whose shape follows the part too roughly.
    fn warning_of_shape(&self) -> Warning {
        let Self { contact, name, length, radius, shape_error, .. } = self;
        let share = 100.0 * shape_error;
        let off = if share < 100.0 { format!("{share:.1} %") } else { "as much as itself".to_owned() };
        Warning {
            kind: WarningKind::CoarseShape,
            subject: format!("body \"{name}\""),
            time: 0.0,
            value: *shape_error,
            limit: SHAPE_ERROR,
            message: format!(
                "contact \"{contact}\" touches it with a radius of {radius:.3e} m, where normals of its sides of {length:.3e} m change at their edges; \
                 the force may be off by {off} for that"
            ),
            remedy: "mesh it with shorter or quadratic sides there, whose middle nodes lie on the part (gmsh -order 2): sides half as long err a \
                     quarter to an eighth of that"
                .into(),
        }
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

/// The touches of `contact` on bodies of finite elements, as far as Hertz's theory predicts them.
pub fn touches(first: &FirstTouches<'_>, contact: &ContactSpec) -> Vec<MeshTouch> {
    let spec = first.spec;
    let on_mesh = |body: usize| spec.bodies[body].kind.meshed();
    let has_mesh = contact.bodies().any(|body| on_mesh(body).is_some());
    let Some(law) = contact.law.surface().filter(|_| has_mesh) else { return Vec::new() };
    let is_refined = law.treatment.is_searched();
    let Some(zone) = predicted_zone(first, contact) else { return Vec::new() };
    let touch = |(body, site): (usize, SurfacePlace)| {
        let mesh = on_mesh(body)?;
        let surface = MeshSurface::of(&mesh.mesh);
        let (length, wanted) = (surface.length_at(&site), wanted_length(mesh, zone.half_width));
        Some(MeshTouch {
            contact: contact.name.clone(),
            body,
            name: spec.bodies[body].name.clone(),
            point: site.point,
            radius: zone.half_width,
            force: zone.force,
            length,
            wanted,
            is_refined,
            shape_error: shape_error(&surface, &site, &zone),
        })
    };
    let sites = contact.bodies().zip(zone.sites).filter_map(|(body, site)| Some((body, site?)));
    sites.filter_map(touch).collect()
}

/// Longest edge that resolves a contact of the given radius \[m\].
fn wanted_length(body: &MeshedSpec, radius: f64) -> f64 {
    let is_quadratic = body.mesh.elements().iter().next().is_some_and(|e| e.kind.is_quadratic());
    let sides = if is_quadratic { QUADRATIC } else { LINEAR };
    radius / sides
}

/// Error of the force that the change of normals at edges may cause, as a share of it (Eq. C.73);
/// none where a smooth surface takes their place.
fn shape_error(surface: &MeshSurface, site: &SurfacePlace, zone: &PredictedZone) -> f64 {
    let PredictedZone { half_width, approach, .. } = zone;
    // Of spheres a²/δ.
    let radius = half_width * half_width / approach;
    let is_within = |x: &[f64; 3]| norm(&difference(x, &site.point)) <= *half_width;
    let smooth =
        surface.shape_at(site).and_then(|s| SmoothFit::new(surface, (site, &s), *half_width, is_within));
    if smooth.is_some() {
        return 0.0;
    }
    let [around, inside] = surface.turns_at(site, *half_width);
    radius * (around / surface.length_at(site)).max(0.25 * inside / half_width)
}

/// Mean length of the longest edges of the sides that are not near `touches` \[m\]; of all if there
/// is no other.
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
