//! Axisymmetric bodies on the z axis that hit each other, and a record of their runs.
#![allow(dead_code, reason = "every test uses some of it")]

use adaptive::AdaptiveError;
use adaptive::driver::{RunEnd, run};
use adaptive::model::RunModel;
use adaptive::record::{
    Continue, ImpactRecord, Observer, ObserverError, PhaseKind, PhaseRecord, RestartPoint, RunLayout, Sample,
    StressRecord, TransferRecord, TryRecord,
};
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

/// Everything that a run reports.
#[derive(Default)]
pub struct Trace {
    pub samples: Vec<Sample>,
    pub phases: Vec<PhaseRecord>,
    pub impacts: Vec<ImpactRecord>,
    pub tries: Vec<TryRecord>,
    pub transfers: Vec<TransferRecord>,
    pub stresses: Vec<StressRecord>,
    /// Restart points, and how many samples, phases, impacts, tries and transfers came before.
    pub restarts: Vec<(RestartPoint, [usize; 5])>,
    /// Asks to stop at the first step that ends at or after this time [s].
    pub stop_at: Option<f64>,
    /// Asks to stop while a model is built after so many tries.
    pub stop_after_tries: Option<usize>,
}

impl Observer for Trace {
    fn start(&mut self, _: &RunLayout) -> Result<(), ObserverError> {
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.samples.push(sample.clone());
        Ok(())
    }

    fn progress(&mut self, time: f64, _: f64, _: PhaseKind) -> Continue {
        if self.stop_at.is_some_and(|stop| time >= stop) { Continue::Interrupt } else { Continue::Yes }
    }

    fn is_interrupted(&mut self) -> bool {
        self.stop_after_tries.is_some_and(|n| self.tries.len() >= n)
    }

    fn phase(&mut self, record: &PhaseRecord) -> Result<(), ObserverError> {
        self.phases.push(*record);
        Ok(())
    }

    fn impact(&mut self, record: &ImpactRecord) -> Result<(), ObserverError> {
        self.impacts.push(*record);
        Ok(())
    }

    fn attempt(&mut self, record: &TryRecord) -> Result<(), ObserverError> {
        self.tries.push(record.clone());
        Ok(())
    }

    fn transfer(&mut self, record: &TransferRecord) -> Result<(), ObserverError> {
        self.transfers.push(record.clone());
        Ok(())
    }

    fn restart_point(&mut self, point: &RestartPoint) -> Result<(), ObserverError> {
        let before = self.counts();
        self.restarts.push((point.clone(), before));
        Ok(())
    }

    fn stress(&mut self, record: &StressRecord) -> Result<(), ObserverError> {
        self.stresses.push(record.clone());
        Ok(())
    }
}

impl Trace {
    /// Numbers of samples, phases, impacts, tries and transfers.
    pub fn counts(&self) -> [usize; 5] {
        let [samples, phases, impacts] = [self.samples.len(), self.phases.len(), self.impacts.len()];
        [samples, phases, impacts, self.tries.len(), self.transfers.len()]
    }

    /// Largest change of the total energy, relative to that at the start.
    pub fn energy_drift(&self) -> f64 {
        let start = self.samples[0].energies.total();
        self.samples.iter().map(|s| (s.energies.total() / start - 1.0).abs()).fold(0.0, f64::max)
    }

    /// Largest change of the momentum along z, relative to `scale` [kg m/s].
    pub fn momentum_change(&self, scale: f64) -> f64 {
        let start = self.samples[0].linear_momentum[2];
        let changes = self.samples.iter().map(|s| (s.linear_momentum[2] - start).abs());
        changes.fold(0.0, f64::max) / scale
    }

    /// Largest jump of energy of a hand-over, relative to the energy at the start.
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

/// A contact that the program refines, without any setting.
pub fn contact(name: &str, body: usize, target: Target) -> ContactSpec {
    ContactSpec { name: name.into(), body, target, law: ContactLaw::Surface(law()) }
}

/// The law of such a contact.
pub fn law() -> SurfaceLaw {
    SurfaceLaw {
        treatment: Treatment::Adaptive,
        penalty: None,
        search: PenaltySearch::CONVERGED,
        points: PointRule::Greville,
        method: Method::ActiveSet,
        friction: None,
        interval: IntervalSpec::default(),
        hand_over: HandOver::default(),
    }
}

/// A run with the defaults of scenario files.
pub fn spec(bodies: Vec<BodySpec>, contacts: Vec<ContactSpec>, end_time: f64) -> RunSpec {
    let phase =
        |method, tolerance, max_step| PhaseSettings { method, max_step, tolerance, velocity_floor: 1e-6 };
    RunSpec {
        bodies,
        joints: Vec::new(),
        loops: Vec::new(),
        loads: Vec::new(),
        contacts,
        points: Vec::new(),
        stress: Vec::new(),
        settings: RunSettings {
            end_time,
            gravity: Vector3::zeros(),
            static_start: false,
            free: phase(integration::Method::TrBdf2, 1e-6, 1e-4),
            impact: phase(integration::Method::DormandPrince, 1e-8, f64::INFINITY),
            quiet_time: None,
            free_interval: 0.01 * end_time,
            impact_interval: 0.0,
        },
    }
}

/// Builds and runs, reporting to `trace`.
pub fn try_run(spec: &RunSpec, trace: &mut Trace) -> Result<RunEnd, AdaptiveError> {
    run(&mut RunModel::build(spec)?, &spec.settings, trace)
}

/// A run that must succeed.
pub fn finished(spec: &RunSpec) -> Trace {
    let mut trace = Trace::default();
    try_run(spec, &mut trace).unwrap_or_else(|e| panic!("{e}"));
    trace
}
