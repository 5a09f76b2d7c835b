//! Search for the penalty factor (\[A\] section 4.1, Fig. 3; theory section A.4).
//!
//! A state machine that is fed with the outcomes of simulated impacts and answers with what to do next. It knows neither
//! models nor time: the driver runs, stops and resumes impacts.

use std::fmt;

use ffr_dynamics::error::FailureKind;

/// `c_p = multiplier × 10^exponent` (\[A\] Eq. (8)).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PenaltyFactor {
    /// Multiplier, 1 to 9.
    pub multiplier: u8,
    /// Exponent.
    pub exponent: i32,
}

impl PenaltyFactor {
    /// The nearest factor with an integer multiplier; `None` unless `value` is positive and finite.
    pub fn from_value(value: f64) -> Option<Self> {
        if !(value > 0.0 && value.is_finite()) {
            return None;
        }
        let exponent = value.log10().floor() as i32;
        let multiplier = (value / 10f64.powi(exponent)).round() as u8;
        Some(if multiplier >= 10 {
            Self { multiplier: 1, exponent: exponent + 1 }
        } else {
            Self { multiplier: multiplier.max(1), exponent }
        })
    }

    /// Its value [N/m³].
    pub fn value(self) -> f64 {
        f64::from(self.multiplier) * 10f64.powi(self.exponent)
    }

    /// The exponent raised by one.
    pub fn raised(self) -> Self {
        Self { exponent: self.exponent + 1, ..self }
    }

    /// The multiplier lowered by one; below `1 × 10^e` follows `9 × 10^(e-1)`.
    pub fn lowered(self) -> Self {
        if self.multiplier > 1 {
            Self { multiplier: self.multiplier - 1, ..self }
        } else {
            Self { multiplier: 9, exponent: self.exponent - 1 }
        }
    }
}

/// How the penalty factor is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenaltyStrategy {
    /// The given factor, as it is.
    Fixed,
    /// As printed (Fig. 3): trials of `trial_steps` steps with contact raise the exponent until the contact solver fails,
    /// then the multiplier goes down and the impact goes on from the failing step.
    ErrorDriven {
        /// Steps with contact of a trial.
        trial_steps: usize,
    },
    /// Raised by `factor` until the peak force changes by less than `tolerance`, relative.
    UntilConverged {
        /// Factor between two trials, > 1.
        factor: f64,
        /// Permitted change of the peak force, relative.
        tolerance: f64,
    },
    /// Raised as long as too much of the approach of the bodies is penetration (theory section A.9). For flat faces and edges, whose peak force
    /// does not converge with the factor because it excites the highest modes that are kept.
    UntilStiff,
}

/// What yields beside the penalty springs while two bodies approach each other (theory section A.9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pressing {
    /// Waves between flat faces, which say how large the force is and how long it lasts: [`MOST_OVERLAP_OF_WAVES`] of the approach, and what is
    /// missing is added, for stiffer springs than the modes follow ring.
    Waves,
    /// A body as a whole, through which waves have run to and fro [`TRIPS`] times: its stiffness says how fast the force rises. Also what
    /// yields at a smooth touch or an edge. [`MOST_OVERLAP`], and ten times the factor.
    Body,
}

impl Pressing {
    /// How bodies are pressed by flat faces `time` \[s\] after these have met, if a wave takes `round_trip` \[s\] to and fro through the one of them
    /// that is crossed sooner.
    pub fn of_flat_faces(time: f64, round_trip: f64) -> Self {
        if time > TRIPS * round_trip { Self::Body } else { Self::Waves }
    }

    /// Share of the approach that may be penetration.
    fn most_overlap(self) -> f64 {
        match self {
            Self::Waves => MOST_OVERLAP_OF_WAVES,
            Self::Body => MOST_OVERLAP,
        }
    }
}

/// How much of the approach of two bodies was penetration and not deformation, at the instant of the largest approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Penetration over approach.
    pub share: f64,
    /// What yielded meanwhile.
    pub pressing: Pressing,
}

impl Overlap {
    /// Share that is allowed.
    pub fn most(&self) -> f64 {
        self.pressing.most_overlap()
    }

    /// Whether the springs were too soft.
    pub fn is_too_much(&self) -> bool {
        self.share > self.most()
    }
}

/// The largest share of the approach of two bodies that may be penetration and not deformation (theory Eq. A.36). The approach at which a force is
/// reached, and with it the stiffness of the contact, is off by no more than this share; of a body between two flat faces by twice as much.
pub const MOST_OVERLAP: f64 = 0.03;

/// The largest share of penetration in the approach between flat faces while waves say how large the force is. The impact then lasts longer by half
/// of this share; springs that are three times as stiff ring by a quarter of the force and more.
pub const MOST_OVERLAP_OF_WAVES: f64 = 0.1;

/// Round trips of waves after which the stress along a body is even and it yields like a spring: the criterion of Davies and Hunter (1963) for
/// specimens in the split Hopkinson bar.
pub const TRIPS: f64 = std::f64::consts::PI;

/// Factor by which the penalty factor is raised at most, and the margin above what springs in series need, since the force changes as well.
const MOST_RISE: f64 = 10.0;
const RISE_MARGIN: f64 = 1.1;

/// The factor by which penalty springs must be stiffer for no more overlap than is allowed: springs in series with the bodies, under the same
/// force (theory Eq. A.37).
fn missing_stiffness(overlap: Overlap) -> f64 {
    let odds = |share: f64| share / (1.0 - share).max(f64::MIN_POSITIVE);
    (RISE_MARGIN * odds(overlap.share) / odds(overlap.most())).clamp(RISE_MARGIN, MOST_RISE)
}

/// Relative change of the peak force that counts as none: a fifth of a percent, less than discretisation errors.
pub const PEAK_TOLERANCE: f64 = 2e-3;

impl PenaltyStrategy {
    /// The default: a further factor of ten changes the peak force by less than [`PEAK_TOLERANCE`].
    pub const CONVERGED: Self = Self::UntilConverged { factor: 10.0, tolerance: PEAK_TOLERANCE };
}

/// Range in which a penalty factor is looked for [N/m³].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PenaltyRange {
    /// Lowest factor.
    pub lower: f64,
    /// Highest factor.
    pub upper: f64,
}

impl Default for PenaltyRange {
    /// From the stiffness of a soft rubber foundation to ten decades above that of steel on elements of a micrometre.
    fn default() -> Self {
        Self { lower: 1e6, upper: 1e28 }
    }
}

/// The outcome of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RunOutcome {
    /// The trial's steps passed without an error of the contact solver.
    TrialPassed,
    /// The impact was simulated to its end; largest contact force \[N\].
    Completed {
        /// Largest contact force \[N\].
        peak_force: f64,
        /// How much of the approach was penetration; none where nothing approached.
        overlap: Option<Overlap>,
    },
    /// The contact solver failed.
    SolverError {
        /// What went wrong.
        failure: FailureKind,
    },
}

/// Why the search ended without a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenaltyFailure {
    /// The contact solver failed down to the lowest factor.
    TooLow {
        /// Lowest factor tried [N/m³].
        penalty: f64,
        /// Last error of the contact solver.
        failure: FailureKind,
    },
    /// Up to the highest factor the solver did not fail, and the peak force did not converge.
    TooHigh {
        /// Highest factor tried [N/m³].
        penalty: f64,
        /// Last relative change of the peak force, if there was one.
        change: Option<f64>,
    },
    /// With the highest factor at which the contact solver finds forces, penetration is still too large a share of the approach.
    TooSoft {
        /// The highest factor that could be solved [N/m³].
        penalty: f64,
        /// How much of their approach is penetration.
        overlap: Overlap,
    },
}

impl fmt::Display for PenaltyFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLow { penalty, failure } => write!(
                f,
                "the contact solver still fails ({failure}) at the lowest penalty factor {penalty:.3e} N/m^3; refine the interval or use the active-set solver"
            ),
            Self::TooHigh { penalty, change: Some(change) } => write!(
                f,
                "the peak force still changes by {:.3} % at the highest penalty factor {penalty:.3e} N/m^3; loosen penalty.tolerance or refine the interval",
                100.0 * change
            ),
            Self::TooSoft { penalty, overlap } => write!(
                f,
                "{:.0} % of the approach of the bodies is penetration at the penalty factor {penalty:.3e} N/m^3, the highest with which the contact solver finds forces, and {:.0} % are allowed; refine the mesh at the touch, or take the active-set solver",
                100.0 * overlap.share,
                100.0 * overlap.most()
            ),
            Self::TooHigh { penalty, change: None } => write!(
                f,
                "no error of the contact solver up to the highest penalty factor {penalty:.3e} N/m^3; search until convergence instead of until an error"
            ),
        }
    }
}

/// The next step of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenaltyAction {
    /// Simulate the impact from its start.
    Run {
        /// Penalty factor [N/m³].
        penalty: f64,
        /// Steps with contact after which to stop; `None`: to the end.
        contact_steps: Option<usize>,
    },
    /// Go on from the failing step, to the end of the impact.
    Resume {
        /// Penalty factor [N/m³].
        penalty: f64,
    },
    /// The factor is found.
    Accept {
        /// Penalty factor [N/m³].
        penalty: f64,
        /// Whether the last run is the result; otherwise the last one that was completed before it.
        is_last_run: bool,
    },
    /// The search ended without a factor.
    Fail(PenaltyFailure),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// The factor is being raised, in trials or in full runs; `last`: the last completed run.
    Raising { last: Option<Completed> },
    /// An error occurred, the factor goes down.
    Lowering,
    /// The factor is known from an earlier impact: one run.
    Known,
}

/// A run to the end of the impact.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Completed {
    penalty: f64,
    peak_force: f64,
    overlap: Option<Overlap>,
}

/// The search itself.
#[derive(Debug, Clone, PartialEq)]
pub struct PenaltySearch {
    strategy: PenaltyStrategy,
    range: PenaltyRange,
    penalty: f64,
    state: State,
}

impl PenaltySearch {
    /// A search that starts from `penalty` [N/m³].
    pub fn new(strategy: PenaltyStrategy, penalty: f64) -> Self {
        Self { strategy, range: PenaltyRange::default(), penalty, state: State::Raising { last: None } }
    }

    /// A search whose factor an earlier impact of the same pair has found: the first completed run is accepted. Errors
    /// of the solver lower it.
    pub fn from_accepted(strategy: PenaltyStrategy, penalty: f64) -> Self {
        Self { state: State::Known, ..Self::new(strategy, penalty) }
    }

    /// This search with the factors limited to `range`.
    #[must_use]
    pub fn within(self, range: PenaltyRange) -> Self {
        Self { range, ..self }
    }

    /// Factor of the current run [N/m³].
    pub fn penalty(&self) -> f64 {
        self.penalty
    }

    /// Whether an error of the solver lowers the factor in the running impact, which goes on from the failing step, instead
    /// of ending the trial: always as printed, and where nothing higher is looked for.
    pub fn is_resuming(&self) -> bool {
        let is_printed = matches!(self.strategy, PenaltyStrategy::ErrorDriven { .. });
        let is_known = matches!(self.state, State::Lowering | State::Known);
        is_printed || (is_known && self.strategy != PenaltyStrategy::Fixed)
    }

    /// Whether an error of the solver counts at once, as printed; otherwise only where no step is short enough to avoid it.
    pub fn stops_at_errors(&self) -> bool {
        matches!(self.strategy, PenaltyStrategy::ErrorDriven { .. })
    }

    /// The search once its factor is found: one more run is made with it.
    #[must_use]
    pub fn accepted(&self) -> Self {
        Self { state: State::Known, ..self.clone() }
    }

    /// Starts the current run from its beginning: the first one, or once more after the model has changed. A changed model has other
    /// forces, so that they are not compared with those of earlier runs.
    pub fn restart(&mut self) -> PenaltyAction {
        if let State::Raising { last } = &mut self.state {
            *last = None;
        }
        self.run()
    }

    fn run(&self) -> PenaltyAction {
        let contact_steps = match (self.strategy, self.state) {
            (PenaltyStrategy::ErrorDriven { trial_steps }, State::Raising { .. }) => Some(trial_steps),
            _ => None,
        };
        PenaltyAction::Run { penalty: self.penalty, contact_steps }
    }

    /// The next step after the current run has ended with `outcome`.
    pub fn next(&mut self, outcome: RunOutcome) -> PenaltyAction {
        if let RunOutcome::Completed { peak_force, overlap: Some(overlap) } = outcome
            && overlap.is_too_much()
            && let Some(stiffer) = self.stiffer(peak_force, overlap)
        {
            return stiffer;
        }
        match (self.strategy, outcome) {
            (_, RunOutcome::SolverError { failure }) => self.after_error(failure),
            (PenaltyStrategy::ErrorDriven { .. }, _) if matches!(self.state, State::Raising { .. }) => {
                // An impact that ends within the steps of a trial has passed it as well.
                self.raise(self.next_decade(), None)
            }
            (_, RunOutcome::TrialPassed) => self.run(),
            (
                PenaltyStrategy::UntilConverged { factor, tolerance },
                RunOutcome::Completed { peak_force, overlap },
            ) => self.after_run(factor, tolerance, Completed { penalty: self.penalty, peak_force, overlap }),
            (_, RunOutcome::Completed { .. }) => self.accept(true),
        }
    }

    fn after_run(&mut self, factor: f64, tolerance: f64, run: Completed) -> PenaltyAction {
        let State::Raising { last } = self.state else { return self.accept(true) };
        let peak = run.peak_force;
        let change = last.map(|last| (peak - last.peak_force).abs() / peak.abs().max(f64::MIN_POSITIVE));
        if change.is_some_and(|c| c < tolerance) {
            return self.accept(true);
        }
        self.state = State::Raising { last: Some(run) };
        self.raise(self.penalty * factor, change)
    }

    /// The next step after a run in which penetration was too large a share of the approach, even if the force has converged; none where the user
    /// gives the factor, and in trials of Fig. 3, which raise it anyway.
    fn stiffer(&mut self, peak_force: f64, overlap: Overlap) -> Option<PenaltyAction> {
        let penalty = self.penalty;
        let factor = match (self.strategy, self.state) {
            (PenaltyStrategy::Fixed, _) | (PenaltyStrategy::ErrorDriven { .. }, State::Raising { .. }) => {
                return None;
            }
            (_, State::Lowering) => {
                return Some(PenaltyAction::Fail(PenaltyFailure::TooSoft { penalty, overlap }));
            }
            (PenaltyStrategy::UntilConverged { factor, .. }, _) => factor,
            (PenaltyStrategy::UntilStiff | PenaltyStrategy::ErrorDriven { .. }, _) => {
                match overlap.pressing {
                    Pressing::Waves => missing_stiffness(overlap),
                    Pressing::Body => MOST_RISE,
                }
            }
        };
        self.state = State::Raising { last: Some(Completed { penalty, peak_force, overlap: Some(overlap) }) };
        Some(self.raise(self.penalty * factor, None))
    }

    fn raise(&mut self, penalty: f64, change: Option<f64>) -> PenaltyAction {
        if penalty.is_nan() || penalty > self.range.upper {
            return PenaltyAction::Fail(PenaltyFailure::TooHigh { penalty: self.penalty, change });
        }
        self.penalty = penalty;
        self.run()
    }

    fn next_decade(&self) -> f64 {
        PenaltyFactor::from_value(self.penalty).map_or(f64::NAN, |p| p.raised().value())
    }

    fn after_error(&mut self, failure: FailureKind) -> PenaltyAction {
        match (self.strategy, self.state) {
            // A completed run is at hand, and nothing higher can be solved: that is the best there is.
            (
                PenaltyStrategy::UntilConverged { .. } | PenaltyStrategy::UntilStiff,
                State::Raising { last: Some(Completed { penalty, overlap, .. }) },
            ) => {
                if let Some(overlap) = overlap.filter(Overlap::is_too_much) {
                    return PenaltyAction::Fail(PenaltyFailure::TooSoft { penalty, overlap });
                }
                self.penalty = penalty;
                return self.accept(false);
            }
            (PenaltyStrategy::Fixed, _) => {
                return PenaltyAction::Fail(PenaltyFailure::TooLow { penalty: self.penalty, failure });
            }
            _ => self.state = State::Lowering,
        }
        let lowered = PenaltyFactor::from_value(self.penalty).map_or(f64::NAN, |p| p.lowered().value());
        if lowered.is_nan() || lowered < self.range.lower {
            return PenaltyAction::Fail(PenaltyFailure::TooLow { penalty: self.penalty, failure });
        }
        self.penalty = lowered;
        PenaltyAction::Resume { penalty: lowered }
    }

    fn accept(&self, is_last_run: bool) -> PenaltyAction {
        PenaltyAction::Accept { penalty: self.penalty, is_last_run }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As printed in \[A\] section 4.1: trials of 30 contact steps.
    const PRINTED: PenaltyStrategy = PenaltyStrategy::ErrorDriven { trial_steps: 30 };
    use approx::assert_relative_eq;

    /// Runs a search on a solver that fails above `limit` and gives a peak force `force(c_p)`.
    fn run(search: &mut PenaltySearch, limit: f64, force: impl Fn(f64) -> f64) -> (PenaltyAction, Vec<f64>) {
        let (mut action, mut log) = (search.restart(), Vec::new());
        for _ in 0..100 {
            let (penalty, trial) = match action {
                PenaltyAction::Run { penalty, contact_steps } => (penalty, contact_steps.is_some()),
                PenaltyAction::Resume { penalty } => (penalty, false),
                done => return (done, log),
            };
            log.push(penalty);
            let outcome = match (penalty > limit, trial) {
                (true, _) => RunOutcome::SolverError { failure: FailureKind::Singular },
                (false, true) => RunOutcome::TrialPassed,
                (false, false) => RunOutcome::Completed { peak_force: force(penalty), overlap: None },
            };
            action = search.next(outcome);
        }
        (action, log)
    }

    fn accepted(action: PenaltyAction) -> f64 {
        match action {
            PenaltyAction::Accept { penalty, .. } => penalty,
            other => panic!("not accepted: {other:?}"),
        }
    }

    #[test]
    fn the_printed_search_raises_by_ten_and_lowers_the_multiplier() {
        let mut search = PenaltySearch::new(PRINTED, 1e15);
        assert_eq!(search.restart(), PenaltyAction::Run { penalty: 1e15, contact_steps: Some(30) });
        let (action, log) = run(&mut search, 5.5e16, |_| 70.0);
        assert_relative_eq!(accepted(action), 5e16, max_relative = 1e-14);
        let expected = [1e15, 1e16, 1e17, 9e16, 8e16, 7e16, 6e16, 5e16];
        assert_eq!(log.len(), expected.len());
        for (found, wanted) in log.iter().zip(expected) {
            assert_relative_eq!(*found, wanted, max_relative = 1e-14);
        }
    }

    #[test]
    fn after_an_error_the_impact_goes_on_and_may_fail_again() {
        let mut search = PenaltySearch::new(PRINTED, 2e17);
        search.restart();
        let first = search.next(RunOutcome::SolverError { failure: FailureKind::NotFinite });
        assert_eq!(first, PenaltyAction::Resume { penalty: 1e17 });
        let PenaltyAction::Resume { penalty } =
            search.next(RunOutcome::SolverError { failure: FailureKind::Singular })
        else {
            panic!("the impact must go on")
        };
        assert_relative_eq!(penalty, 9e16, max_relative = 1e-14);
        let done = search.next(RunOutcome::Completed { peak_force: 3.0, overlap: None });
        assert!(matches!(done, PenaltyAction::Accept { is_last_run: true, .. }));
    }

    #[test]
    fn a_converged_force_is_accepted_in_two_runs() {
        let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e17);
        let (action, log) = run(&mut search, f64::INFINITY, |c| 70.0 * (1.0 - 1e14 / c));
        assert_eq!(log.len(), 2);
        assert_relative_eq!(accepted(action), 1e18, max_relative = 1e-14);
    }

    #[test]
    fn a_force_that_still_changes_asks_for_more() {
        let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
        let (action, log) = run(&mut search, f64::INFINITY, |c| 70.0 * (1.0 - 1e14 / c));
        assert_eq!(log.len(), 4); // changes 9 %, 0.9 %, 0.09 %
        assert_relative_eq!(accepted(action), 1e18, max_relative = 1e-14);
    }

    #[test]
    fn an_error_on_the_way_up_returns_to_the_completed_run() {
        let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
        let (action, _) = run(&mut search, 2e15, |c| 70.0 * (1.0 - 1e14 / c));
        assert_eq!(action, PenaltyAction::Accept { penalty: 1e15, is_last_run: false });
    }

    #[test]
    fn errors_are_answered_in_the_running_impact_as_printed() {
        let given = PenaltySearch::new(PenaltyStrategy::Fixed, 1e18);
        let printed = PenaltySearch::new(PRINTED, 1e18);
        let converged = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e18);
        assert!(printed.is_resuming(), "from the first error on");
        assert!(!given.is_resuming() && !given.accepted().is_resuming());
        // A run on the way up is compared with the one before, so that it keeps its factor.
        assert!(!converged.is_resuming() && converged.accepted().is_resuming());
    }

    #[test]
    fn an_accepted_factor_takes_one_run() {
        let mut search = PenaltySearch::from_accepted(PenaltyStrategy::CONVERGED, 1e18);
        let (action, log) = run(&mut search, f64::INFINITY, |_| 10.0);
        assert_eq!(log.len(), 1);
        assert_relative_eq!(accepted(action), 1e18);
        let mut printed = PenaltySearch::from_accepted(PRINTED, 1e18);
        assert_eq!(printed.restart(), PenaltyAction::Run { penalty: 1e18, contact_steps: None });
        assert_relative_eq!(accepted(run(&mut printed, 8.5e17, |_| 10.0).0), 8e17);
    }

    #[test]
    fn a_fixed_factor_is_run_once_and_never_changed() {
        let mut search = PenaltySearch::new(PenaltyStrategy::Fixed, 3.3e16);
        assert_relative_eq!(accepted(run(&mut search, f64::INFINITY, |_| 1.0).0), 3.3e16);
        let mut failing = PenaltySearch::new(PenaltyStrategy::Fixed, 3.3e16);
        assert!(matches!(run(&mut failing, 1.0, |_| 1.0).0, PenaltyAction::Fail(_)));
    }

    #[test]
    fn searches_that_cannot_end_fail_with_their_numbers() {
        let mut endless = PenaltySearch::new(PRINTED, 1e15);
        let (action, _) = run(&mut endless, f64::INFINITY, |_| 1.0);
        let PenaltyAction::Fail(failure) = action else { panic!("must fail: {action:?}") };
        assert!(failure.to_string().contains("1.000e28"), "{failure}");
        let mut hopeless = PenaltySearch::new(PRINTED, 1e15);
        let (action, _) = run(&mut hopeless, 0.0, |_| 1.0);
        assert!(
            matches!(
                action,
                PenaltyAction::Fail(PenaltyFailure::TooLow { failure: FailureKind::Singular, .. })
            ),
            "{action:?}"
        );
        let mut drifting = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
        let (action, _) = run(&mut drifting, f64::INFINITY, |c| c);
        let PenaltyAction::Fail(failure) = action else { panic!("must fail: {action:?}") };
        assert!(failure.to_string().contains("90.000 %"), "{failure}");
    }

    #[test]
    fn a_changed_model_restarts_the_comparison() {
        let mut search = PenaltySearch::new(PenaltyStrategy::CONVERGED, 1e15);
        search.restart();
        search.next(RunOutcome::Completed { peak_force: 10.0, overlap: None });
        assert!(matches!(search.restart(), PenaltyAction::Run { .. }));
        let next = search.next(RunOutcome::Completed { peak_force: 10.0, overlap: None });
        assert!(matches!(next, PenaltyAction::Run { .. }), "a run on another model is no evidence: {next:?}");
    }

    #[test]
    fn bodies_that_lie_in_each_other_are_no_result() {
        let error = RunOutcome::SolverError { failure: FailureKind::Singular };
        let completed = |share, pressing| RunOutcome::Completed {
            peak_force: 1.0,
            overlap: Some(Overlap { share, pressing }),
        };
        // Springs in series: of 20 % penetration 80 % is deformation, which stays.
        let missing = 1.1 * (0.2 / 0.8) / (0.1 / 0.9);
        for (strategy, pressing, rise) in [
            (PenaltyStrategy::CONVERGED, Pressing::Body, 10.0),
            (PenaltyStrategy::UntilStiff, Pressing::Body, 10.0),
            (PenaltyStrategy::UntilStiff, Pressing::Waves, missing),
        ] {
            let soft = completed(2.0 * MOST_OVERLAP_OF_WAVES, pressing);
            let stiff = completed(0.9 * pressing.most_overlap(), pressing);
            // The force is the same each time: only the overlap asks for more.
            let mut search = PenaltySearch::new(strategy, 1e13);
            search.restart();
            for penalty in [rise * 1e13, rise * rise * 1e13] {
                let next = search.next(soft);
                assert!(
                    matches!(next, PenaltyAction::Run { penalty: p, .. } if (p / penalty - 1.0).abs() < 1e-12),
                    "{next:?}"
                );
            }
            let done = search.next(stiff);
            assert!(matches!(done, PenaltyAction::Accept { is_last_run: true, .. }), "{done:?}");
            // A factor that an earlier impact found.
            let mut known = PenaltySearch::from_accepted(strategy, 1e13);
            known.restart();
            assert!(matches!(known.next(soft), PenaltyAction::Run { .. }));
            // Nothing higher can be solved.
            let failed = known.next(error);
            assert!(matches!(failed, PenaltyAction::Fail(PenaltyFailure::TooSoft { .. })), "{failed:?}");
        }
        let soft = completed(2.0 * MOST_OVERLAP_OF_WAVES, Pressing::Waves);
        // Lowered until the solver found forces.
        let mut lowered = PenaltySearch::new(PRINTED, 1e13);
        lowered.restart();
        lowered.next(error);
        assert!(matches!(lowered.next(soft), PenaltyAction::Fail(PenaltyFailure::TooSoft { .. })));
        // The user's own factor.
        let mut given = PenaltySearch::new(PenaltyStrategy::Fixed, 1e13);
        assert!(matches!(given.next(soft), PenaltyAction::Accept { .. }));
    }

    #[test]
    fn factors_round_to_integer_multipliers() {
        let factor = |v| PenaltyFactor::from_value(v);
        assert_eq!(factor(5e16), Some(PenaltyFactor { multiplier: 5, exponent: 16 }));
        assert_eq!(factor(9.7e16), Some(PenaltyFactor { multiplier: 1, exponent: 17 }));
        assert_eq!((factor(0.0), factor(f64::NAN), factor(f64::INFINITY)), (None, None, None));
    }
}
