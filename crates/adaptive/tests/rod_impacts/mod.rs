//! Impacts of [A] section 5: bodies, contacts, settings, and what a run reports.

use crate::impacts;
pub use crate::impacts::finished;
use crate::impacts::{ALUMINIUM, STEEL, body};
use adaptive::spec::{BodySpec, ContactLaw, ContactSpec, PenaltySearch, RunSpec, SurfaceLaw, Target};
use contact_qs::quasistatic::Method;
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::axisymmetric;

pub const RADIUS: f64 = 10e-3; // m
pub const LENGTH: f64 = 1.0; // m
pub const SPEED: f64 = 0.1; // m/s
pub const GAP: f64 = 1e-6; // m

pub fn contact(name: &str, body: usize, target: usize, search: PenaltySearch, method: Method) -> ContactSpec {
    let law = SurfaceLaw { search, method, ..impacts::law() };
    ContactSpec {
        name: name.into(),
        body,
        target: Target::Body(target),
        law: ContactLaw::Surface(law),
        damping: 0.0,
        initial_overlap: 0.0,
    }
}

fn impact(bodies: Vec<BodySpec>, contacts: Vec<ContactSpec>, end_time: f64) -> RunSpec {
    RunSpec { settings: impacts::explicit(end_time), ..impacts::spec(bodies, contacts, end_time) }
}

pub fn sphere() -> Shape {
    axisymmetric::sphere(RADIUS).expect("a sphere")
}

/// Sphere, rod, gap, sphere, as in [A] section 5.
pub fn sphere_rod_sphere(search: PenaltySearch) -> RunSpec {
    let rod = axisymmetric::rod(RADIUS, LENGTH).expect("a rod");
    let bodies = vec![
        body("left", sphere(), STEEL, [8, 8], 10, (-RADIUS, SPEED)),
        body("rod", rod, ALUMINIUM, [4, 200], 20, (0.0, 0.0)),
        body("right", sphere(), STEEL, [8, 8], 10, (LENGTH + RADIUS + GAP, 0.0)),
    ];
    let contacts = vec![
        contact("first", 0, 1, search, Method::ActiveSet),
        contact("second", 2, 1, search, Method::ActiveSet),
    ];
    impact(bodies, contacts, 8e-4)
}

/// Two steel spheres, which touch at the start; the first one moves at 2 m/s, so that the contact grows to 0.4 mm and is over
/// after few periods of the modes of its zone.
pub fn two_spheres(end_time: f64) -> RunSpec {
    let bodies = vec![
        body("left", sphere(), STEEL, [4, 4], 10, (-RADIUS, 20.0 * SPEED)),
        body("right", sphere(), STEEL, [4, 4], 10, (RADIUS, 0.0)),
    ];
    impact(bodies, vec![contact("pair", 0, 1, PenaltySearch::CONVERGED, Method::ActiveSet)], end_time)
}
