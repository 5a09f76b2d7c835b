//! A half space whose points settle, and points on few unknowns.

use super::*;
use crate::quasistatic::Problem;
use crate::quasistatic::active_set::ActiveSet;
use faer::Mat;
use std::f64::consts::PI;

struct Normal(ActiveSet, Mat<f64>);

impl NormalSolver for Normal {
    fn solve_normal(
        &mut self,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        self.0.solve(&Problem { compliance: &self.1, springs, gaps }, forces)
    }

    fn solve_on_set(&mut self, rhs: &mut [f64]) -> bool {
        self.0.solve_on_set(rhs);
        true
    }
}

/// `N x N` points of a half space with unit shear modulus and unit spacing.
const N: usize = 9;

fn place(i: usize) -> [f64; 2] {
    [(i % N) as f64 - 4.1, (i / N) as f64 - 3.9]
}

/// Compliances of the half space (Johnson, Contact Mechanics, 3.2 and 3.6), under the points
/// that of a small disc.
fn half_space(poisson: f64) -> (Normal, StickSlip) {
    let n = N * N;
    let mut normal = Mat::zeros(n, n);
    let mut zone = StickSlip::new(Friction::new(0.0), n, 2, true);
    (0..n).for_each(|i| {
        zone.blocks.members.add(i);
    });
    for i in 0..n {
        for j in 0..n {
            let (p, q) = (place(i), place(j));
            let x = [p[0] - q[0], p[1] - q[1]];
            let r = if i == j { 0.3 } else { x[0].hypot(x[1]) };
            normal[(i, j)] = (1.0 - poisson) / (2.0 * PI * r);
            for a in 0..2 {
                let coupling = -(1.0 - 2.0 * poisson) * x[a] / (4.0 * PI * r * r);
                zone.blocks.set_coupling(i, a, j, coupling);
                for b in 0..2 {
                    let mut value = poisson * x[a] * x[b] / (r * r);
                    if a == b {
                        value += 1.0 - poisson + if i == j { 0.5 * poisson } else { 0.0 };
                    }
                    zone.blocks.set_tangential((i, a), (j, b), value / (2.0 * PI * r));
                }
            }
        }
    }
    zone.finish_blocks();
    (Normal(ActiveSet::new(n), normal), zone)
}

#[test]
fn turns_settle_from_sticking_to_sliding_at_any_coupling() {
    let n = N * N;
    let springs = vec![1e-3; n];
    let mut n_mixed = 0;
    for (poisson, coefficient) in [(0.3, 0.3), (0.3, 0.8), (0.0, 0.3), (0.0, 0.8)] {
        let (mut normal, mut zone) = half_space(poisson);
        zone.law.coefficient = coefficient;
        zone.set_springs(&springs);
        let mut forces = vec![0.0; n];
        // Slips from none to complete sliding and back, which crosses every state of the
        // annulus.
        for step in 0..80 {
            let slip = 0.5 * coefficient * (0.08 * f64::from(step)).sin();
            let gaps: Vec<f64> =
                (0..n).map(|i| 0.05 * (place(i)[0].powi(2) + place(i)[1].powi(2)) - 0.6).collect();
            let slips: Vec<f64> = (0..n).flat_map(|_| [slip, 0.3 * slip]).collect();
            let report = zone.solve(TOLERANCE, &mut normal, &springs, (&gaps, &slips), &mut forces);
            assert!(report.is_ok(), "{poisson} {coefficient} {step}: {report:?}");
            let states = zone.states();
            n_mixed += usize::from(states.contains(&PointState::Stick) && states.contains(&PointState::Slip));
            let tau = zone.forces().chunks_exact(2);
            for ((t, force), w) in tau.zip(&forces).zip(zone.increments().chunks_exact(2)) {
                let (size, slide) = (t[0].hypot(t[1]), w[0].hypot(w[1]));
                // Round-off of forces of order one, tolerance of the alternations.
                assert!(size <= coefficient * force + 1e-10);
                assert!(*force <= 0.0 || slide * (coefficient * force - size) <= 1e-9);
                assert!(*force <= 0.0 || (t[0] * w[0] + t[1] * w[1] + size * slide).abs() <= 1e-9);
            }
        }
    }
    assert!(n_mixed > 40, "{n_mixed}");
}

/// Points on hats of fewer nodes, which yield in all components.
struct Hats {
    n_t: usize,
    compliance: Mat<f64>,
    /// Three nodes of each point, with their values there.
    points: Vec<[(usize, f64); 3]>,
}

impl Hats {
    fn new(n_points: usize, n_nodes: usize, n_t: usize) -> Self {
        let size = (n_t + 1) * n_nodes;
        let near =
            |i: usize, j: usize| 0.1 * (1.3 * (i * size + j) as f64).sin() + f64::from(u8::from(i == j));
        let v = Mat::from_fn(size, size, near);
        let point = |i: usize| {
            let first = i * (n_nodes - 2) / n_points;
            let [a, b] = [0.1 + 0.2 * (i as f64).sin().abs(), 0.3 + 0.2 * (2.0 * i as f64).cos()];
            [(first, a), (first + 1, b), (first + 2, 1.0 - a - b)]
        };
        Self { n_t, compliance: &v * v.transpose(), points: (0..n_points).map(point).collect() }
    }

    /// Displacement of point `i` along `d` under a unit force on point `j` along `e`.
    fn answer(&self, (i, d): (usize, usize), (j, e): (usize, usize)) -> f64 {
        let mut sum = 0.0;
        self.row(i, d, &mut |a, x| self.row(j, e, &mut |b, y| sum += x * y * self.compliance[(a, b)]));
        sum
    }
}

impl Surfaces for Hats {
    fn n_unknowns(&self) -> usize {
        self.compliance.nrows()
    }

    fn row(&self, i: usize, d: usize, entry: &mut dyn FnMut(usize, f64)) {
        self.points[i].iter().for_each(|(node, value)| entry((self.n_t + 1) * node + d, *value));
    }

    fn compliance(&self, i: usize, j: usize) -> f64 {
        self.compliance[(i, j)]
    }
}

#[test]
fn forces_in_the_unknowns_of_surfaces_are_those_of_the_points() {
    let (n, n_nodes, springs) = (60, 9, vec![1e-3; 60]);
    let (mut n_mixed, mut most) = (0, 0);
    for (n_t, coefficient) in [(1, 0.3), (2, 0.3), (2, 0.8)] {
        let hats = Hats::new(n, n_nodes, n_t);
        let [mut points, mut unknowns] =
            [(); 2].map(|()| StickSlip::new(Friction::new(coefficient), n, n_t, true));
        (0..n).for_each(|i| {
            points.blocks.members.add(i);
        });
        for ((i, j), d) in (0..n * n).map(|k| (k / n, k % n)).flat_map(|p| (1..=n_t).map(move |d| (p, d))) {
            points.blocks.set_coupling(i, d - 1, j, hats.answer((i, d), (j, 0)));
            for e in 1..=n_t {
                points.blocks.set_tangential((i, d - 1), (j, e - 1), hats.answer((i, d), (j, e)));
            }
        }
        points.finish_blocks();
        let mut normal = Normal(ActiveSet::new(n), Mat::from_fn(n, n, |i, j| hats.answer((i, 0), (j, 0))));
        [&mut points, &mut unknowns].into_iter().for_each(|zone| zone.set_springs(&springs));
        let [mut expected, mut found] = [(); 2].map(|()| vec![0.0; n]);
        for step in 0..60 {
            let (slip, open) = (0.3 * (0.1 * f64::from(step)).sin(), step as usize % 7);
            let along = |i: usize| (i as f64 - 30.0 + f64::from(step) * 0.1) / 30.0;
            let gaps: Vec<f64> =
                (0..n).map(|i| if i % 9 == open { 1.0 } else { along(i).powi(2) - 0.5 }).collect();
            let slips: Vec<f64> =
                (0..n * n_t).map(|k| slip * if k % n_t == 0 { 1.0 } else { 0.4 * along(k) }).collect();
            let given = (gaps.as_slice(), slips.as_slice());
            points.solve(TOLERANCE, &mut normal, &springs, given, &mut expected).unwrap();
            let is_member: Vec<bool> = gaps.iter().map(|gap| *gap < 0.4).collect();
            assert!(unknowns.take(&hats, |i| is_member[i], &springs));
            let report = unknowns.solve_taken(TOLERANCE, &springs, given, &mut found).unwrap();
            most = most.max(report.iterations);
            let largest = expected.iter().copied().fold(0.0, f64::max);
            let off = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off(&found, &expected) < 1e-9 * largest, "{n_t} {coefficient} {step}");
            assert!(off(unknowns.forces(), points.forces()) < 1e-9 * largest, "{n_t} {coefficient} {step}");
            // A point that is about to slide may stand on either side.
            let apart = |(i, (a, b)): (usize, (&PointState, &PointState))| {
                let force = points.forces()[n_t * i..n_t * (i + 1)].iter().fold(0.0_f64, |s, f| s.hypot(*f));
                a != b && (force - points.bounds()[i]).abs() > 1e-9 * largest
            };
            assert!(!unknowns.states().iter().zip(points.states()).enumerate().any(apart));
            let states = points.states().to_vec();
            let is_mixed = states.contains(&PointState::Stick) && states.contains(&PointState::Slip);
            n_mixed += usize::from(is_mixed);
            if unknowns.states() != states.as_slice() || !is_mixed {
                continue;
            }
            // Slips of order one.
            assert!(increments_differ(&points, &unknowns, n_t) < 1e-9);
            let gap_rates: Vec<f64> = (0..n).map(|i| -1.0 + along(i)).collect();
            let pressed = |forces| (springs.as_slice(), forces);
            points.find_rates(TOLERANCE, Some(&mut normal), pressed(&*expected), &gap_rates, &slips).unwrap();
            unknowns.find_rates(TOLERANCE, Some(&mut normal), pressed(&*found), &gap_rates, &slips).unwrap();
            let largest = points.normal_rates.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
            let rates = |zone: &StickSlip| [zone.normal_rates.clone(), zone.rates.clone()];
            for (a, b) in rates(&unknowns).iter().zip(&rates(&points)) {
                // Turns of the forces to 1e-8 in the one, 1e-12 in the other.
                assert!(off(a, b) < 1e-6 * largest, "{n_t} {coefficient} {step}: {}", off(a, b) / largest);
            }
            let loaded = |k: usize| states[k / n_t] != PointState::Open;
            let slip_rates = unknowns.slip_rates.iter().zip(&points.slip_rates).enumerate();
            let off =
                slip_rates.filter(|(k, _)| loaded(*k)).fold(0.0_f64, |m, (_, (a, b))| m.max((a - b).abs()));
            // Rates of order one.
            assert!(off < 1e-6, "{off}");
        }
    }
    assert!(n_mixed > 60 && most <= 30, "{n_mixed} {most}");
}

/// Largest difference of the slip increments of loaded points.
fn increments_differ(a: &StickSlip, b: &StickSlip, n_t: usize) -> f64 {
    let increments = a.increments().iter().zip(b.increments()).enumerate();
    let loaded = increments.filter(|(k, _)| a.states()[k / n_t] != PointState::Open);
    loaded.fold(0.0, |m, (_, (a, b))| m.max((a - b).abs()))
}
