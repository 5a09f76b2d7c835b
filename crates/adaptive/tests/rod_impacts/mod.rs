//! Impacts of [A] section 5: bodies, contacts, settings, and what a run reports.
#![allow(dead_code, reason = "every test uses some of them")]

#[path = "../impacts/mod.rs"]
mod impacts;

use adaptive::driver::run;
use adaptive::model::RunModel;
use adaptive::spec::{
    BodyKind, BodySpec, ContactLaw, ContactSpec, DiscretisationSpec, ElasticSpec, HandOver, InitialMotion,
    IntervalSpec, PenaltySearch, PhaseSettings, PointRule, ReductionSpec, RunSettings, RunSpec, SurfaceLaw,
    Target, Treatment,
};
use contact_qs::quasistatic::Method;
use ffr_dynamics::integration;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::axisymmetric;
use nalgebra::{UnitQuaternion, Vector3};

pub const RADIUS: f64 = 10e-3; // m
pub const LENGTH: f64 = 1.0; // m
pub const SPEED: f64 = 0.1; // m/s
pub const GAP: f64 = 1e-6; // m

pub use impacts::Trace;

pub fn body(
    name: &str,
    shape: Shape,
    steel: bool,
    elements: [usize; 2],
    modes: usize,
    z: f64,
    v: f64,
) -> BodySpec {
    let material =
        if steel { Material::new(210e9, 0.3, 7850.0) } else { Material::new(72.8e9, 0.33, 2789.0) };
    let elastic = ElasticSpec::new(
        shape,
        Model::Axisymmetric,
        material.expect("a material"),
        DiscretisationSpec {
            degrees: vec![3, 3],
            elements: elements.to_vec(),
            knots: None,
            refine: Vec::new(),
        },
        ReductionSpec::CraigBampton { modes, fixed_interface_modes: None },
    );
    let motion = InitialMotion {
        position: Vector3::new(0.0, 0.0, z),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::new(0.0, 0.0, v),
        angular_velocity: Vector3::zeros(),
    };
    BodySpec { name: name.into(), kind: BodyKind::Elastic(Box::new(elastic)), motion }
}

pub fn contact(name: &str, body: usize, target: usize, search: PenaltySearch, method: Method) -> ContactSpec {
    let law = SurfaceLaw {
        treatment: Treatment::Adaptive,
        penalty: None,
        search,
        points: PointRule::Greville,
        method,
        friction: None,
        interval: IntervalSpec::default(),
        hand_over: HandOver::default(),
    };
    ContactSpec { name: name.into(), body, target: Target::Body(target), law: ContactLaw::Surface(law) }
}

pub fn settings(end_time: f64) -> RunSettings {
    let phase = |max_step| PhaseSettings {
        method: integration::Method::DormandPrince,
        max_step,
        tolerance: 1e-8,
        velocity_floor: 1e-6,
    };
    RunSettings {
        end_time,
        gravity: Vector3::zeros(),
        static_start: false,
        free: phase(1e-4),
        impact: phase(f64::INFINITY),
        quiet_time: None,
        free_interval: 1e-5,
        impact_interval: 0.0,
    }
}

fn impact(bodies: Vec<BodySpec>, contacts: Vec<ContactSpec>, end_time: f64) -> RunSpec {
    RunSpec {
        bodies,
        joints: Vec::new(),
        loops: Vec::new(),
        loads: Vec::new(),
        contacts,
        points: Vec::new(),
        stress: Vec::new(),
        settings: settings(end_time),
    }
}

pub fn sphere() -> Shape {
    axisymmetric::sphere(RADIUS).expect("a sphere")
}

/// Sphere, rod, gap, sphere, as in [A] section 5.
pub fn sphere_rod_sphere(search: PenaltySearch) -> RunSpec {
    let rod = axisymmetric::rod(RADIUS, LENGTH).expect("a rod");
    let bodies = vec![
        body("left", sphere(), true, [8, 8], 10, -RADIUS, SPEED),
        body("rod", rod, false, [4, 200], 20, 0.0, 0.0),
        body("right", sphere(), true, [8, 8], 10, LENGTH + RADIUS + GAP, 0.0),
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
        body("left", sphere(), true, [4, 4], 10, -RADIUS, 20.0 * SPEED),
        body("right", sphere(), true, [4, 4], 10, RADIUS, 0.0),
    ];
    impact(bodies, vec![contact("pair", 0, 1, PenaltySearch::CONVERGED, Method::ActiveSet)], end_time)
}

pub fn finished(spec: &RunSpec) -> Trace {
    let mut trace = Trace::default();
    let mut model = RunModel::build(spec).unwrap_or_else(|e| panic!("{e}"));
    run(&mut model, &spec.settings, &mut trace).unwrap_or_else(|e| panic!("{e}"));
    trace
}
