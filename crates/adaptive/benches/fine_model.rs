//! The fine model of a ball of the double pendulums, stage by stage, from 8 to 32 contact elements across, and an evaluation of a
//! pair of them.
//!
//! With `FBIMPACT_PROCESSOR_TIME=N` a table of sizes and of the least processor seconds (of all threads) of `N` runs is printed
//! in place of the benchmarks: figures that other jobs of the machine disturb little.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up shall stop")]

use std::hint::black_box;

use adaptive::adaptivity::wanted_interval::WantedInterval;
use adaptive::body::field::Field;
use adaptive::body::field_body::FieldBody;
use adaptive::body::fine::refined::{FineMesh, FineSettings};
use adaptive::body::reduced::{Interface, ReducedBody};
use adaptive::body::splines::ElasticBody;
use adaptive::body::zone::ContactZone;
use adaptive::spec::{DiscretisationSpec, ElasticSpec, PointRule, ReductionSpec};
use contact_qs::quasistatic::Method;
use contact_qs::zone::points::{InterfaceCompliance, contact_submodel};
use contact_qs::{ActiveContact, Friction, SurfacePair, SurfacePairSettings, TargetFace, TargetSurface};
use cpu_time::ProcessTime;
use divan::Bencher;
use faer::Mat;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::problem::ElasticProblem;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere};
use iga_core::space::Space;
use iga_core::surface::BodySurface;

const RADIUS: f64 = 10e-3;
const WIDTH: f64 = 0.61e-3;
const N_MODES: usize = 20;
/// Penalty factor that the program ends with at the first impact of the pendulums [N/m³].
const PENALTY: f64 = 9.2e17;
/// Loads two thirds of the interval \[m\].
const APPROACH: f64 = 7e-6;
const ACROSS: [usize; 5] = [8, 12, 16, 24, 32];

/// A ball and its modes.
struct Coarse {
    body: ElasticBody,
    reduced: ReducedBody,
}

/// The fine model with an interval on one side of it.
struct Fine {
    mesh: FineMesh,
    zone: ContactZone,
}

impl Coarse {
    fn new() -> Self {
        let shape = sphere(RADIUS, SphereNet::for_degree(2)).unwrap();
        let degrees = shape.patches[0].knots().iter().map(|k| k.degree().max(2)).collect();
        let discretisation =
            DiscretisationSpec { degrees, elements: vec![8, 4, 4], knots: None, refine: Vec::new() };
        let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
        let reduction = ReductionSpec::CraigBampton { modes: N_MODES, fixed_interface_modes: None };
        let spec = ElasticSpec::new(shape, Model::Solid, steel, discretisation, reduction);
        let body = ElasticBody::build("ball", spec).unwrap();
        let reduced = body.reduce(&Interface::default()).unwrap();
        Self { body, reduced }
    }

    /// Refined where `x = side RADIUS`.
    fn mesh(&self, side: f64, across: usize) -> FineMesh {
        let patches = &self.body.shape.patches;
        let surface = BodySurface::new(patches, false);
        let at = surface.closest(patches, &[side * RADIUS, 0.0, 0.0]).unwrap();
        let wanted = WantedInterval { face: surface.faces()[at.face], centre: at.xi, widths: [WIDTH; 2] };
        let settings = FineSettings { elements: across, ..FineSettings::default() };
        FineMesh::build(&self.body, &[wanted], &settings).unwrap()
    }

    fn fine(&self, side: f64, across: usize) -> Fine {
        let mesh = self.mesh(side, across);
        let zone = mesh.zone(0, PointRule::Greville).unwrap();
        Fine { mesh, zone }
    }

    fn compliance(&self, fine: &Fine, problem: &ElasticProblem<'_>) -> Mat<f64> {
        let mut basis = self.reduced.basis.truncated(self.reduced.basis.n_low);
        basis.shapes = fine.mesh.prolong(&self.body.assembled, self.reduced.basis.shapes.as_ref());
        ResidualFlexibility::new(problem, &fine.zone.unknowns, &basis).unwrap().compliance().clone()
    }
}

/// Two balls, `A` on the left touching with its right side.
fn pair(coarse: &Coarse, sides: [&Fine; 2], compliances: [&Mat<f64>; 2]) -> SurfacePair {
    let shapes = sides.map(|s| s.mesh.prolong(&coarse.body.assembled, coarse.reduced.shapes()));
    let compliance =
        |i: usize| InterfaceCompliance { dofs: &sides[i].zone.unknowns, compliance: compliances[i].as_ref() };
    let [own, target] = sides.map(|s| &s.mesh);
    let points = contact_submodel(
        own.motion,
        &sides[0].zone.points,
        &own.lookup,
        shapes[0].as_ref(),
        Some(compliance(0)),
    );
    let interval = &target.intervals[0];
    let face = TargetFace { face: interval.parts[0].face, bounds: interval.parts[0].region };
    let surface = TargetSurface::flexible(
        target.motion,
        &target.space,
        &target.patches,
        &[face],
        &target.lookup,
        shapes[1].as_ref(),
        Some(compliance(1)),
    );
    let settings = SurfacePairSettings {
        contact_body: 0,
        target_body: Some(1),
        penalty: PENALTY,
        method: Method::ActiveSet,
    };
    SurfacePair::new(points.unwrap(), surface.unwrap(), settings).unwrap()
}

/// The bodies of a pair in a motion whose approach and slide go up and down a little, as the stages of a time step do.
struct Rubbing {
    pair: Active<SurfacePair>,
    bodies: Vec<BodyState>,
    forces: Vec<GeneralisedForce>,
    stage: u32,
    slide: f64,
}

impl Rubbing {
    fn new(pair: SurfacePair, slide: f64) -> Self {
        let mut bodies = vec![BodyState::at_rest(N_MODES); 2];
        bodies[0].velocity.z = slide * 5e4;
        let pair = Active::new(pair);
        Self { pair, bodies, forces: vec![GeneralisedForce::zeros(N_MODES); 2], stage: 0, slide }
    }

    fn evaluate(&mut self) -> f64 {
        self.stage += 1;
        self.bodies[0].position.z = self.slide * (0.05 * f64::from(self.stage)).sin();
        self.bodies[1].position.x = 2.0 * RADIUS - APPROACH - 5e-9 * f64::from(self.stage % 7);
        self.forces.iter_mut().for_each(GeneralisedForce::clear);
        self.pair.save();
        self.pair.evaluate(Motion::new(0.0, &self.bodies), &mut self.forces).unwrap();
        self.pair.report().normal_force
    }
}

/// A pair built once for all benchmarks of its size.
fn built(coarse: &Coarse, across: usize) -> SurfacePair {
    let sides = [coarse.fine(1.0, across), coarse.fine(-1.0, across)];
    let compliances = [0, 1].map(|i| {
        let assembled = sides[i].mesh.assemble(&coarse.body).unwrap();
        let problem = ElasticProblem::free(&assembled, &sides[i].zone.unknowns).unwrap();
        coarse.compliance(&sides[i], &problem)
    });
    pair(coarse, [&sides[0], &sides[1]], [&compliances[0], &compliances[1]])
}

#[divan::bench(args = ACROSS, sample_count = 3, sample_size = 1)]
fn mesh_and_points(bencher: Bencher<'_, '_>, across: usize) {
    let coarse = Coarse::new();
    bencher.bench_local(|| coarse.fine(1.0, across));
}

#[divan::bench(args = ACROSS, sample_count = 3, sample_size = 1)]
fn assembly(bencher: Bencher<'_, '_>, across: usize) {
    let coarse = Coarse::new();
    let fine = coarse.fine(1.0, across);
    bencher.bench_local(|| fine.mesh.assemble(&coarse.body).unwrap());
}

#[divan::bench(args = ACROSS, sample_count = 3, sample_size = 1)]
fn factorisation(bencher: Bencher<'_, '_>, across: usize) {
    let coarse = Coarse::new();
    let fine = coarse.fine(1.0, across);
    let assembled = fine.mesh.assemble(&coarse.body).unwrap();
    bencher.bench_local(|| {
        black_box(ElasticProblem::free(&assembled, &fine.zone.unknowns).unwrap());
    });
}

#[divan::bench(args = ACROSS, sample_count = 3, sample_size = 1)]
fn compliance(bencher: Bencher<'_, '_>, across: usize) {
    let coarse = Coarse::new();
    let fine = coarse.fine(1.0, across);
    let assembled = fine.mesh.assemble(&coarse.body).unwrap();
    let problem = ElasticProblem::free(&assembled, &fine.zone.unknowns).unwrap();
    bencher.bench_local(|| coarse.compliance(&fine, &problem));
}

#[divan::bench(args = ACROSS, sample_count = 50)]
fn evaluation(bencher: Bencher<'_, '_>, across: usize) {
    let mut motion = Rubbing::new(built(&Coarse::new(), across), 0.0);
    bencher.bench_local(|| motion.evaluate());
}

#[divan::bench(args = ACROSS, sample_count = 50)]
fn evaluation_with_friction(bencher: Bencher<'_, '_>, across: usize) {
    let pair = built(&Coarse::new(), across).with_friction(Friction::new(0.3)).unwrap();
    let mut motion = Rubbing::new(pair, 2e-6);
    bencher.bench_local(|| motion.evaluate());
}

/// Least processor seconds of `times` runs, and the last result.
fn least<T>(times: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let start = ProcessTime::now();
        let result = run();
        (start.elapsed().as_secs_f64(), result)
    };
    let first = once();
    (1..times).fold(first, |(seconds, _), _| {
        let (again, result) = once();
        (seconds.min(again), result)
    })
}

/// Evaluations of the table: 100, 10 times.
fn milliseconds(pair: SurfacePair, slide: f64) -> f64 {
    let mut motion = Rubbing::new(pair, slide);
    motion.evaluate();
    let (seconds, _) = least(10, || (0..100).map(|_| motion.evaluate()).sum::<f64>());
    10.0 * seconds
}

fn print_table(times: usize) {
    let coarse = Coarse::new();
    eprintln!(
        "across elements unknowns interface points active | mesh assembly factorisation compliance pair [s] | evaluation, rubbing [ms]"
    );
    for across in ACROSS {
        let (meshing, own) = least(times, || coarse.fine(1.0, across));
        let other = coarse.fine(-1.0, across);
        let (assembling, assembled) = least(times, || own.mesh.assemble(&coarse.body).unwrap());
        let (factorising, problem) =
            least(times, || ElasticProblem::free(&assembled, &own.zone.unknowns).unwrap());
        let (reducing, g) = least(times, || coarse.compliance(&own, &problem));
        let opposite: AssembledBody = other.mesh.assemble(&coarse.body).unwrap();
        let h = coarse.compliance(&other, &ElasticProblem::free(&opposite, &other.zone.unknowns).unwrap());
        let both = || pair(&coarse, [&own, &other], [&g, &h]);
        let (pairing, _) = least(times, both);
        let mut motion = Rubbing::new(both(), 0.0);
        motion.evaluate();
        let n_active = motion.pair.report().n_active;
        eprintln!(
            "{across} {} {} {} {} {n_active} | {meshing:.3} {assembling:.3} {factorising:.3} {reducing:.3} {pairing:.3} | {:.3} {:.3}",
            own.mesh.space.n_elements(),
            own.mesh.n_unknowns(),
            own.zone.unknowns.len(),
            own.zone.points.len(),
            milliseconds(both(), 0.0),
            milliseconds(both().with_friction(Friction::new(0.3)).unwrap(), 2e-6),
        );
    }
}

fn main() {
    match std::env::var("FBIMPACT_PROCESSOR_TIME").ok().and_then(|n| n.parse().ok()) {
        Some(times) => print_table(times),
        None => divan::main(),
    }
}
