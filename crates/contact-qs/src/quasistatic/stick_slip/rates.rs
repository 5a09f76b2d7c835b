//! Rates of the point forces on the sets of the last solution, and the work of sliding that they tell (docs/theory.md Eqs. F.9 to
//! F.12).

use ffr_dynamics::error::EvaluationFailure;

use super::{MAX_ALTERNATIONS, NormalSolver, StickSlip, TOLERANCE, not_converged};
use crate::law::sliding_work::SlidingWork;
use crate::quasistatic::tangential::{PointState, TangentialProblem};

/// Tolerance of the rates that make up a stiffness: its other errors are larger.
const OF_STIFFNESS: f64 = 1e-7;

/// Replaces `rates` by those of the normal forces on the last active set when gaps change at `gap_rates` [m/s], `springs` being the
/// compliances of the penalty springs; without a `zone` the points that `forces` press are springs alone \[N/s\]. False where the
/// solver does not tell.
fn normal_rates<Z: NormalSolver>(
    zone: Option<&mut Z>,
    (springs, forces): (&[f64], &[f64]),
    gap_rates: impl Iterator<Item = f64>,
    rates: &mut [f64],
) -> bool {
    rates.iter_mut().zip(gap_rates).for_each(|(rate, gap)| *rate = -gap);
    let Some(zone) = zone else {
        for ((rate, spring), force) in rates.iter_mut().zip(springs).zip(forces) {
            *rate = if *force > 0.0 { *rate / spring } else { 0.0 };
        }
        return true;
    };
    zone.solve_on_set(rates)
}

/// Replaces `normal` and `tangential` by the rates of the forces on the sets of the last solution, as exact as a stiffness needs them;
/// arguments as of [`StickSlip::find_rates`]. False where the solver does not tell.
pub(crate) fn force_rates<Z: NormalSolver>(
    friction: Option<&mut StickSlip>,
    zone: Option<&mut Z>,
    pressed: (&[f64], &[f64]),
    [gap_rates, slip_rates]: [&[f64]; 2],
    [normal, tangential]: [&mut [f64]; 2],
) -> bool {
    let Some(friction) = friction else {
        return normal_rates(zone, pressed, gap_rates.iter().copied(), normal);
    };
    let outcome = friction.find_rates(OF_STIFFNESS, zone, pressed, gap_rates, slip_rates);
    normal.copy_from_slice(&friction.normal_rates);
    tangential.copy_from_slice(&friction.rates);
    outcome.is_ok()
}

impl StickSlip {
    /// Work of sliding at the last solution (Eqs. F.9 to F.12, F.15); arguments as of [`StickSlip::find_rates`].
    ///
    /// # Errors
    /// If the alternations don't converge.
    pub fn sliding_work(
        &mut self,
        zone: Option<&mut impl NormalSolver>,
        pressed: (&[f64], &[f64]),
        gap_rates: &[f64],
        slip_rates: &[f64],
    ) -> Result<SlidingWork, EvaluationFailure> {
        if !self.solver.states().contains(&PointState::Slip) {
            return Ok(SlidingWork::default());
        }
        self.find_rates(TOLERANCE, zone, pressed, gap_rates, slip_rates)?;
        // The rates of the bounds are left in `shifted`.
        let sliding = (0..self.n_points).filter(|&i| self.solver.states()[i] == PointState::Slip);
        Ok(sliding.map(|i| self.work_of_point(i)).fold(SlidingWork::default(), SlidingWork::plus))
    }

    /// Work of sliding of point `i`, whose bound changes at `shifted`.
    fn work_of_point(&self, i: usize) -> SlidingWork {
        let (mut power, mut work, mut size) = (0.0, 0.0, 0.0_f64);
        for k in self.n_t * i..self.n_t * (i + 1) {
            let increment = self.solver.increments()[k];
            power -= self.forces[k] * self.slip_rates[k];
            work -= self.forces[k] * increment;
            size = size.hypot(increment);
        }
        if self.solver.saved_states()[i] == PointState::Open {
            // The point was open when the step began and has slipped since: its power begins at
            // zero, the rate of its bound does not.
            return SlidingWork { power, ..SlidingWork::default() };
        }
        SlidingWork { power, slid: work, slid_rate: power + size * self.shifted[i] }
    }

    /// Finds the rates of the forces, and of the slip increments, on the sets of the last solution. `gap_rates` and `slip_rates`:
    /// rates of the points along normal and tangents without those of the forces [m/s]; `springs` and `forces`: compliances of the
    /// normal springs [m/N] and normal forces of that solution \[N\]; `tolerance`: last change of the rates, over the largest.
    ///
    /// # Errors
    /// If the alternations don't converge.
    pub(super) fn find_rates<Z: NormalSolver>(
        &mut self,
        tolerance: f64,
        zone: Option<&mut Z>,
        (springs, forces): (&[f64], &[f64]),
        gap_rates: &[f64],
        slip_rates: &[f64],
    ) -> Result<(), EvaluationFailure> {
        let Some(zone) = zone else {
            normal_rates::<Z>(None, (springs, forces), gap_rates.iter().copied(), &mut self.normal_rates);
            self.bound_rates();
            let found = (&mut *self.rates, &mut *self.slip_rates);
            self.solver.rates_of_points(&self.springs, &self.bounds, (slip_rates, &self.shifted), found);
            return Ok(());
        };
        if let Some(newton) = self.newton.as_mut().filter(|_| self.is_taken) {
            for rates in [&mut self.normal_rates, &mut self.rates, &mut self.slip_rates] {
                rates.fill(0.0);
            }
            let (n_t, states) = (self.n_t, self.solver.states());
            newton.rates((gap_rates, slip_rates), tolerance, |i, forces, moved| {
                self.normal_rates[i] = forces[0];
                for a in 0..n_t {
                    self.rates[n_t * i + a] = forces[a + 1];
                    if states[i] == PointState::Slip {
                        self.slip_rates[n_t * i + a] = moved[a + 1] + self.springs[i] * forces[a + 1];
                    }
                }
            });
            self.bound_rates();
            return Ok(());
        }
        if !self.has_rates {
            let Self { blocks, springs, bounds, solver, .. } = self;
            let problem = TangentialProblem { compliance: blocks, springs, slips: slip_rates, bounds };
            solver.prepare_rates(&problem)?;
            self.has_rates = true;
        }
        self.rates.fill(0.0);
        self.relaxation[1].restart();
        for _ in 0..MAX_ALTERNATIONS {
            self.shifted.copy_from_slice(gap_rates);
            self.blocks.add_to_gaps(&self.rates, &mut self.shifted);
            let gap_rates = self.shifted.iter().copied();
            if !normal_rates(Some(&mut *zone), (springs, forces), gap_rates, &mut self.normal_rates) {
                break;
            }
            self.offsets.copy_from_slice(slip_rates);
            self.blocks.add_to_slips(&self.normal_rates, &mut self.offsets);
            self.bound_rates();
            let problem = TangentialProblem {
                compliance: &self.blocks,
                springs: &self.springs,
                slips: slip_rates,
                bounds: &self.bounds,
            };
            self.solver.rates(&problem, &self.shifted, &self.offsets, &mut self.next, &mut self.slip_rates);
            let largest = self.next.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if self.relaxation[1].step(&mut self.rates, &self.next, tolerance * largest) {
                return Ok(());
            }
        }
        Err(not_converged(self.law.coefficient))
    }

    /// Leaves the rates of the bounds that belong to those of the normal forces in `shifted`.
    fn bound_rates(&mut self) {
        let points = self.shifted.iter_mut().zip(&self.normal_rates).zip(&self.lengths);
        points.for_each(|((bound, rate), length)| *bound = self.law.coefficient * rate / length);
    }
}
