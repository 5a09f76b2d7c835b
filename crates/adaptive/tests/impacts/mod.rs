//! Axisymmetric bodies on the z axis that hit each other, and a record of their runs.

use std::f64::consts::PI;
use std::ops::{Deref, DerefMut};

use adaptive::AdaptiveError;
use adaptive::model::RunModel;
use adaptive::record::{PhaseKind, Sample};
use adaptive::run::driver::{RunEnd, run};
use adaptive::run::recording::Recording;
use adaptive::spec::{
    Accuracy, BodyKind, BodySpec, ContactLaw, ContactSpec, DiscretisationSpec, ElasticSpec, InitialMotion,
    IntervalSpec, PenaltySearch, PhaseSettings, PointRule, ReductionSpec, Resolution, RunSettings, RunSpec,
    SurfaceLaw, Target, TransferSpec, Treatment,
};
use contact_qs::law::penalty::DEFAULT_STIFFNESS_RATIO;
use contact_qs::quasistatic::Method;
use ffr_dynamics::integration;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere as solid_sphere};
use iga_core::nurbs::primitives::{axisymmetric, plane};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Everything that a run reports.
#[derive(Default)]
pub struct Trace(pub Recording);

impl Deref for Trace {
    type Target = Recording;

    fn deref(&self) -> &Recording {
        &self.0
    }
}

impl DerefMut for Trace {
    fn deref_mut(&mut self) -> &mut Recording {
        &mut self.0
    }
}

impl Trace {
    /// Largest change of the momentum along z, relative to `scale` [kg m/s].
    pub fn momentum_change(&self, scale: f64) -> f64 {
        let start = self.samples[0].linear_momentum[2];
        let changes = self.samples.iter().map(|s| (s.linear_momentum[2] - start).abs());
        changes.fold(0.0, f64::max) / scale
    }

    /// Largest jump of energy of a transfer, relative to the energy at the start.
    pub fn largest_jump(&self) -> f64 {
        let start = self.samples[0].energies.total();
        let jumps = self.transfers.iter().map(|t| (t.energy_after - t.energy_before).abs() / start);
        jumps.fold(0.0, f64::max)
    }

    pub fn kinds(&self) -> Vec<PhaseKind> {
        self.phases.iter().map(|p| p.kind).collect()
    }

    pub fn last(&self) -> &Sample {
        self.samples.last().expect("a sample")
    }
}

/// Numbers that look random, the same in every run (Steele, Lea & Flood 2014, SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// A number between `low` and `high`, every order of magnitude equally likely.
    pub fn of_any_size(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// A rotation, all equally likely (Shoemake 1992).
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let (u, a, b) = (self.next(), self.between(0.0, 2.0 * PI), self.between(0.0, 2.0 * PI));
        let (p, q) = ((1.0 - u).sqrt(), u.sqrt());
        UnitQuaternion::new_normalize(Quaternion::new(q * b.cos(), p * a.sin(), p * a.cos(), q * b.sin()))
    }
}

/// Elastic constants and density.
#[derive(Debug, Clone, Copy)]
pub struct Solid {
    pub youngs: f64,
    pub poisson: f64,
    pub density: f64,
}

pub const STEEL: Solid = Solid { youngs: 210e9, poisson: 0.3, density: 7850.0 };
pub const ALUMINIUM: Solid = Solid { youngs: 72.8e9, poisson: 0.33, density: 2789.0 };

/// An axisymmetric body whose frame starts at height `z` with speed `v`.
pub fn body(
    name: &str,
    shape: Shape,
    solid: Solid,
    elements: [usize; 2],
    modes: usize,
    (z, v): (f64, f64),
) -> BodySpec {
    let material = Material::new(solid.youngs, solid.poisson, solid.density).expect("a material");
    let discretisation = DiscretisationSpec {
        degrees: vec![3, 3],
        elements: elements.to_vec(),
        knots: None,
        refine: Vec::new(),
    };
    let reduction = ReductionSpec::CraigBampton { modes, fixed_interface_modes: None };
    let elastic = ElasticSpec::new(shape, Model::Axisymmetric, material, discretisation, reduction);
    let motion = InitialMotion {
        position: Vector3::new(0.0, 0.0, z),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::new(0.0, 0.0, v),
        angular_velocity: Vector3::zeros(),
    };
    BodySpec { name: name.into(), kind: BodyKind::Elastic(Box::new(elastic)), motion }
}

/// A sphere of 8 by 8 cubic elements with 10 modes.
pub fn sphere(name: &str, radius: f64, solid: Solid, place: (f64, f64)) -> BodySpec {
    body(name, axisymmetric::sphere(radius).expect("a sphere"), solid, [8, 8], 10, place)
}

/// A disc of 8 by 8 cubic elements with 10 modes, in plane strain or plane stress.
pub fn disc(
    name: &str,
    radius: f64,
    thickness: f64,
    is_strain: bool,
    solid: Solid,
    motion: InitialMotion,
) -> BodySpec {
    let shape = plane::disc(radius).expect("a disc");
    let material = Material::new(solid.youngs, solid.poisson, solid.density).expect("a material");
    let discretisation =
        DiscretisationSpec { degrees: vec![3, 3], elements: vec![8, 8], knots: None, refine: Vec::new() };
    let reduction = ReductionSpec::CraigBampton { modes: 10, fixed_interface_modes: None };
    let model = if is_strain { Model::PlaneStrain { thickness } } else { Model::PlaneStress { thickness } };
    let elastic = ElasticSpec::new(shape, model, material, discretisation, reduction);
    BodySpec { name: name.into(), kind: BodyKind::Elastic(Box::new(elastic)), motion }
}

/// A solid sphere without symmetry in its model, with 18 modes.
pub fn ball(name: &str, radius: f64, solid: Solid, motion: InitialMotion) -> BodySpec {
    let shape = solid_sphere(radius, SphereNet::Spindle).expect("a ball");
    let material = Material::new(solid.youngs, solid.poisson, solid.density).expect("a material");
    let discretisation = DiscretisationSpec {
        degrees: vec![2, 2, 3],
        elements: vec![8, 4, 4],
        knots: None,
        refine: Vec::new(),
    };
    let reduction = ReductionSpec::CraigBampton { modes: 18, fixed_interface_modes: None };
    let elastic = ElasticSpec::new(shape, Model::Solid, material, discretisation, reduction);
    BodySpec { name: name.into(), kind: BodyKind::Elastic(Box::new(elastic)), motion }
}

/// A contact that the program refines, without any setting.
pub fn contact(name: &str, body: usize, target: Target) -> ContactSpec {
    ContactSpec {
        name: name.into(),
        body,
        target,
        law: ContactLaw::Surface(law()),
        damping: 0.0,
        initial_overlap: 0.0,
    }
}

/// The law of such a contact, with a first penalty factor so low that another trial follows.
pub fn soft_law() -> SurfaceLaw {
    SurfaceLaw { stiffness_ratio: 0.1 * DEFAULT_STIFFNESS_RATIO, ..law() }
}

/// `spec` with that law for all contacts.
pub fn softened(mut spec: RunSpec) -> RunSpec {
    spec.contacts.iter_mut().for_each(|contact| contact.law = ContactLaw::Surface(soft_law()));
    spec
}

/// The law of such a contact.
pub fn law() -> SurfaceLaw {
    SurfaceLaw {
        treatment: Treatment::Adaptive,
        penalty: None,
        stiffness_ratio: DEFAULT_STIFFNESS_RATIO,
        search: PenaltySearch::CONVERGED,
        points: PointRule::Greville,
        method: Method::ActiveSet,
        friction: None,
        interval: IntervalSpec::default(),
        transfer: TransferSpec::default(),
    }
}

/// A run with the defaults of scenario files.
pub fn spec(bodies: Vec<BodySpec>, contacts: Vec<ContactSpec>, end_time: f64) -> RunSpec {
    let phase = |method, tolerance, max_step| PhaseSettings {
        method: Some(method),
        max_step,
        tolerance: Some(tolerance),
        tolerance_factor: 1.0,
        velocity_floor: 1e-6,
    };
    RunSpec {
        accuracy: Accuracy::Normal,
        bodies,
        joints: Vec::new(),
        loops: Vec::new(),
        gears: Vec::new(),
        loads: Vec::new(),
        contacts,
        points: Vec::new(),
        stress: Vec::new(),
        settings: RunSettings {
            end_time,
            gravity: Vector3::zeros(),
            start: adaptive::spec::Start::Given,
            free: phase(integration::Method::TrBdf2, 1e-6, 1e-4),
            impact: phase(integration::Method::DormandPrince, 1e-8, f64::INFINITY),
            lasting: phase(integration::Method::Gauss, 1e-5, f64::INFINITY),
            step_share: 0.5,
            quiet_time: None,
            stop_after_impacts: None,
            stop_at_rest: None,
            energy_tolerance: 1e-3,
            free_interval: Some(0.01 * end_time),
            impact_interval: 0.0,
            phase_share: 0.0,
            free_share: 0.0,
            pressure: true,
            uncertainty: true,
            accuracy: None,
        },
        resolution: Resolution::default(),
        frequency_errors: Vec::new(),
    }
}

/// Settings of runs that are integrated explicitly throughout.
pub fn explicit(end_time: f64) -> RunSettings {
    let phase = |max_step| PhaseSettings {
        method: Some(integration::Method::DormandPrince),
        max_step,
        tolerance: Some(1e-8),
        tolerance_factor: 1.0,
        velocity_floor: 1e-6,
    };
    RunSettings {
        end_time,
        gravity: Vector3::zeros(),
        start: adaptive::spec::Start::Given,
        free: phase(1e-4),
        impact: phase(f64::INFINITY),
        lasting: phase(f64::INFINITY),
        step_share: 0.5,
        quiet_time: None,
        stop_after_impacts: None,
        stop_at_rest: None,
        energy_tolerance: 1e-3,
        free_interval: Some(1e-5),
        impact_interval: 0.0,
        phase_share: 0.0,
        free_share: 0.0,
        pressure: true,
        uncertainty: true,
        accuracy: None,
    }
}

/// Builds and runs, reporting to `trace`.
pub fn try_run(spec: &RunSpec, trace: &mut Trace) -> Result<RunEnd, AdaptiveError> {
    run(&mut RunModel::build(spec)?, &spec.settings, &mut trace.0)
}

/// A run that must succeed.
pub fn finished(spec: &RunSpec) -> Trace {
    let mut trace = Trace::default();
    try_run(spec, &mut trace).unwrap_or_else(|e| panic!("{e}"));
    trace
}
