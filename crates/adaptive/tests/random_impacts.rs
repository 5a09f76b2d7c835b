//! Impacts of two spheres drawn at random, simulated without any setting, beside Hertz's theory.

use std::f64::consts::PI;
use std::time::Instant;

use crate::impacts::{ALUMINIUM, Numbers, STEEL, Solid, Trace, contact, spec, sphere, try_run};
use adaptive::spec::{BodyKind, ContactLaw, RunSpec, Target};
use rayon::prelude::*;

impl Numbers {
    fn coin(&mut self) -> bool {
        self.next() < 0.5
    }

    fn known_or_any_solid(&mut self) -> Solid {
        match (4.0 * self.next()) as usize {
            0 => STEEL,
            1 => ALUMINIUM,
            _ => Solid {
                youngs: self.of_any_size(1e9, 400e9),
                poisson: self.between(0.0, 0.45),
                density: self.of_any_size(1e3, 20e3),
            },
        }
    }
}

/// Two spheres about to meet; the first flies towards the second along +z.
#[derive(Debug, Clone)]
struct Case {
    number: u64,
    radii: [f64; 2],
    solids: [Solid; 2],
    velocities: [f64; 2],
    gap: f64,
    /// Whether the body listed first is the upper one, and whether the contact body is the second in the list.
    swaps: [bool; 2],
}

/// Hertz's impact of two spheres (Johnson, Contact Mechanics, chapter 11).
#[derive(Debug)]
struct Hertz {
    peak: f64,
    duration: f64,
    approach: f64,
    /// Contact radius over the smaller sphere's.
    ratio: f64,
    /// Contact radius over the relative one `r1 r2 / (r1 + r2)`, the small number of Hertz's theory (Johnson 1985, 4.2).
    relative_ratio: f64,
}

impl Case {
    fn draw(number: u64) -> Self {
        let mut random = Numbers(20_240_518 + number);
        let radii = [random.of_any_size(1e-3, 50e-3), random.of_any_size(1e-3, 50e-3)];
        let solids = [random.known_or_any_solid(), random.known_or_any_solid()];
        let closing = random.of_any_size(1e-3, 2.0);
        // One at rest, the other at rest, or both in motion.
        let second = match (3.0 * random.next()) as usize {
            0 => 0.0,
            1 => -closing,
            _ => closing * random.between(-1.5, 1.5),
        };
        let gap = if random.next() < 0.2 { 0.0 } else { random.of_any_size(1e-9, 1e-3) };
        let swaps = [random.coin(), random.coin()];
        Self { number, radii, solids, velocities: [second + closing, second], gap, swaps }
    }

    fn closing(&self) -> f64 {
        self.velocities[0] - self.velocities[1]
    }

    fn masses(&self) -> [f64; 2] {
        std::array::from_fn(|i| 4.0 / 3.0 * PI * self.radii[i].powi(3) * self.solids[i].density)
    }

    fn hertz(&self) -> Hertz {
        let [m1, m2] = self.masses();
        let [r1, r2] = self.radii;
        let compliance: f64 = self.solids.iter().map(|s| (1.0 - s.poisson.powi(2)) / s.youngs).sum();
        let (mass, radius) = (m1 * m2 / (m1 + m2), r1 * r2 / (r1 + r2));
        let stiffness = 4.0 / 3.0 / compliance * radius.sqrt();
        let speed = self.closing();
        let approach = (1.25 * mass * speed * speed / stiffness).powf(0.4);
        Hertz {
            peak: stiffness * approach.powf(1.5),
            duration: 2.943 * approach / speed,
            approach,
            ratio: (radius * approach).sqrt() / r1.min(r2),
            relative_ratio: (approach / radius).sqrt(),
        }
    }

    /// Relative rise of Hertz's peak force because the spheres end: an estimate, to first order, which some pairs
    /// of very unequal spheres exceed.
    ///
    /// Hertz's half spaces give way down to infinity. Boussinesq's displacement below a force F at the depth R of a centre,
    /// `F (1 + ν)(3 - 2ν)/(2π E R)`, is missing in the approach `δ = c F^(2/3)`. With
    /// `δ = c F^(2/3) - b F` the energy `∫F dδ` falls by `5/4 ε`, `ε = b F/δ`, and the peak at given energy rises by `3/4 ε`.
    fn finite_size(&self) -> f64 {
        let below: f64 = self
            .solids
            .iter()
            .zip(self.radii)
            .map(|(s, r)| (1.0 + s.poisson) * (3.0 - 2.0 * s.poisson) / (2.0 * PI * s.youngs * r))
            .sum();
        let hertz = self.hertz();
        0.75 * below * hertz.peak / hertz.approach
    }

    fn spec(&self) -> RunSpec {
        let place = |i: usize| [-self.radii[0], self.gap + self.radii[1]][i];
        let body = |i: usize| {
            sphere(["lower", "upper"][i], self.radii[i], self.solids[i], (place(i), self.velocities[i]))
        };
        let bodies = if self.swaps[0] { vec![body(1), body(0)] } else { vec![body(0), body(1)] };
        let (first, second) = if self.swaps[1] { (1, 0) } else { (0, 1) };
        let end = self.gap / self.closing() + 3.0 * self.hertz().duration;
        spec(bodies, vec![contact("impact", first, Target::Body(second))], end)
    }
}

/// What came out of a case.
struct Outcome {
    case: Case,
    hertz: Hertz,
    trace: Trace,
    seconds: f64,
}

impl Outcome {
    fn of(case: Case) -> Self {
        let (mut trace, started) = (Trace::default(), Instant::now());
        try_run(&case.spec(), &mut trace).unwrap_or_else(|e| panic!("{case:?}: {e}"));
        Self { hertz: case.hertz(), case, trace, seconds: started.elapsed().as_secs_f64() }
    }

    fn peak_deviation(&self) -> f64 {
        self.trace.impacts[0].peak_force / self.hertz.peak - 1.0
    }

    fn restitution(&self) -> f64 {
        self.trace.impacts[0].restitution
    }

    fn momentum_change(&self) -> f64 {
        let [m1, m2] = self.case.masses();
        let scale = (m1 * self.case.velocities[0]).abs() + (m2 * self.case.velocities[1]).abs();
        self.trace.momentum_change(scale)
    }

    fn line(&self) -> String {
        let c = &self.case;
        format!(
            "{:3} a/r {:.4} peak {:+.4} (finite size {:+.4}) restitution {:.5} momentum {:.0e} energy {:.0e} trials {} \
             steps {} {:.2} s; radii {:.2} {:.2} mm, E {:.1} {:.1} GPa, nu {:.2} {:.2}, {:.4} m/s, gap {:.0e} m",
            c.number,
            self.hertz.ratio,
            self.peak_deviation(),
            c.finite_size(),
            self.restitution(),
            self.momentum_change(),
            self.trace.energy_drift(),
            self.trace.trials.len(),
            self.trace.phases.iter().map(|p| p.steps).sum::<u64>(),
            self.seconds,
            1e3 * c.radii[0],
            1e3 * c.radii[1],
            1e-9 * c.solids[0].youngs,
            1e-9 * c.solids[1].youngs,
            c.solids[0].poisson,
            c.solids[1].poisson,
            c.closing(),
            c.gap,
        )
    }

    fn check(&self) {
        let line = self.line();
        assert_eq!(self.trace.impacts.len(), 1, "{line}");
        assert!(self.momentum_change() < MOMENTUM, "{line}");
        assert!(self.trace.energy_drift() < DRIFT, "{line}");
        assert!(!self.trace.transfers.is_empty() && self.trace.largest_jump() < JUMP, "{line}");
        // It fits the width, and the share of penetration shows that the penalty factor is high enough.
        assert_eq!(self.trace.trials.len(), 1, "{line}");
        assert!(self.trace.trials.iter().all(|t| (0.5..0.95).contains(&t.utilisation[0])), "{line}");
        if self.hertz.ratio < HERTZ_APPLIES {
            assert!((self.restitution() - 1.0).abs() < HERTZ, "{line}");
            let stiffer = self.case.finite_size().max(HERTZ);
            assert!((-HERTZ..stiffer).contains(&self.peak_deviation()), "{line}");
        }
        if self.hertz.relative_ratio < HERTZ_APPLIES {
            assert!(self.peak_deviation().abs() < HERTZ, "{line}");
        }
    }
}

/// Permitted change of the momentum: forces are equal and opposite to round-off (claim 3 of docs/verification.md).
const MOMENTUM: f64 = 1e-12;
/// Permitted drift of the energy (claim 1 of docs/verification.md).
const DRIFT: f64 = 1e-5;
/// Permitted jump of the energy at a transfer (claim 2 of docs/verification.md).
const JUMP: f64 = 1e-5;
/// Contact radius over the smaller sphere's, or over the relative radius, up to which the half spaces of Hertz's theory stand for
/// spheres.
const HERTZ_APPLIES: f64 = 0.05;
/// Permitted deviation of peak force and restitution there (claim 5 of docs/verification.md); more only where the finite size of the
/// spheres accounts for it.
const HERTZ: f64 = 2e-2;

fn check_all(numbers: std::ops::Range<u64>) {
    let outcomes: Vec<Outcome> = numbers.into_par_iter().map(|n| Outcome::of(Case::draw(n))).collect();
    let applies = |o: &&Outcome| o.hertz.ratio < HERTZ_APPLIES;
    let most = |f: &dyn Fn(&Outcome) -> f64| {
        let worst = outcomes.iter().filter(applies).max_by(|a, b| f(a).total_cmp(&f(b)));
        println!("{}", worst.map(Outcome::line).unwrap_or_default());
    };
    println!("{} of {} within Hertz's reach", outcomes.iter().filter(applies).count(), outcomes.len());
    most(&|o| o.peak_deviation().abs());
    let strictly = outcomes.iter().filter(|o| o.hertz.relative_ratio < HERTZ_APPLIES);
    let (n, worst) = strictly.fold((0, 0.0_f64), |(n, w), o| (n + 1, w.max(o.peak_deviation().abs())));
    println!("{n} by the relative radius, peaks within {worst:e}");
    most(&|o| 1.0 - o.restitution());
    most(&|o| o.momentum_change());
    most(&|o| o.trace.energy_drift());
    most(&|o| o.seconds);
    let far = |o: &&Outcome| applies(o) && o.peak_deviation().abs() > HERTZ;
    outcomes.iter().filter(far).for_each(|o| println!("beyond the limit: {}", o.line()));
    outcomes.iter().for_each(Outcome::check);
}

#[test]
fn spheres_drawn_at_random_hit_each_other_as_hertz_says() {
    check_all(0..8);
}

#[test]
#[ignore = "second tier: two minutes"]
fn two_hundred_pairs_of_spheres_hit_each_other_as_hertz_says() {
    check_all(0..200);
}

#[test]
fn deviation_from_hertz_vanishes_with_the_contact_radius() {
    // The pair of the largest deviation where Hertz's law applies, ever slower.
    let case = Case { gap: 0.0, ..Case::draw(197) };
    let slower = |factor: f64| Case { velocities: case.velocities.map(|v| v * factor), ..case.clone() };
    // a/r goes with the speed to the power of 2/5.
    let outcomes: Vec<Outcome> = [1.0, 0.5_f64.powf(2.5), 0.25_f64.powf(2.5)]
        .into_par_iter()
        .map(|f| Outcome::of(slower(f)))
        .collect();
    let slopes: Vec<f64> = outcomes.iter().map(|o| o.peak_deviation() / o.hertz.ratio).collect();
    println!("{slopes:?}");
    assert!((outcomes[0].hertz.ratio / outcomes[2].hertz.ratio - 4.0).abs() < 1e-12);
    // Proportional to a/r: a property of the spheres, not an error of a mesh that is fitted to the contact. Terms of higher
    // order, a logarithm among them, bend it.
    assert!(slopes.iter().all(|s| (s / slopes[0] - 1.0).abs() < 0.2), "{slopes:?}");
}

#[test]
fn deviation_from_hertz_is_no_error_of_the_mesh() {
    // The pair of the largest deviation again, 2.16 %, with twice the elements in every direction.
    let case = Case::draw(197);
    let mut finer = case.spec();
    for body in &mut finer.bodies {
        let BodyKind::Elastic(elastic) = &mut body.kind else { panic!("an elastic body") };
        elastic.discretisation.elements.iter_mut().for_each(|n| *n *= 2);
    }
    for contact in &mut finer.contacts {
        let ContactLaw::Surface(law) = &mut contact.law else { panic!("a contact of surfaces") };
        law.interval.elements = Some(32);
    }
    let mut trace = Trace::default();
    try_run(&finer, &mut trace).unwrap_or_else(|e| panic!("{e}"));
    let peak = trace.impacts[0].peak_force / case.hertz().peak - 1.0;
    let plain = Outcome::of(case).peak_deviation();
    println!("{plain} {peak}");
    // 2.16 % and 2.29 %: the finer mesh is no nearer to Hertz. A tenth of what is to be explained. The other pair beyond 2 %
    // is number 151: a/r 0.0473, 2.01 %; 2.7 % are what the finite size may make in both.
    assert!((peak - plain).abs() < 2e-3, "{plain} {peak}");
}
