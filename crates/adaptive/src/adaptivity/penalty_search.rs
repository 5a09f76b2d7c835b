//! Search for the penalty factor (\[A\] section 4.1, Fig. 3; theory section A.4).
//!
//! A state machine that is fed with the outcomes of simulated impacts and answers with what to do
//! next. It knows neither models nor time: the driver runs, stops and resumes impacts.

use std::fmt;

use super::overlap::{Overlap, Pressing};

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
    /// As printed (Fig. 3): trials of `trial_steps` steps with contact raise the exponent until the
    /// contact solver fails, then the multiplier goes down and the impact goes on from the failing
    /// step.
    ErrorDriven {
        /// Steps with contact of a trial.
        trial_steps: usize,
    },
    /// Raised by `factor` until the peak force changes by less than `tolerance`, relative: by comparison with the trial before, or by
    /// the bound that the share of penetration tells (theory Eq. A.44), which needs no other trial.
    UntilConverged {
        /// Factor between two trials, > 1.
        factor: f64,
        /// Permitted change of the peak force, relative.
        tolerance: f64,
    },
    /// Raised as long as too much of the approach of the bodies is penetration (theory
    /// section A.9). For flat faces and edges, whose peak force does not converge with the factor
    /// because it excites the highest modes that are kept.
    UntilStiff,
}

/// Factor by which the penalty factor is raised at most, and the margin above what springs in
/// series need, since the force changes as well.
const MOST_RISE: f64 = 10.0;
const RISE_MARGIN: f64 = 1.1;
/// How far above theory Eq. A.25 the factors of whole surfaces begin: under edges and corners springs take up to 3 % of the approach by that, and a
/// tenth of it so.
const START_OF_WHOLE: f64 = 10.0;
/// Number of steps in a factor of ten to which a rise is rounded up: what is measured of an overlap is
/// right to a per cent, and equal bodies are to get equal springs.
const STEPS: f64 = 10.0;

/// The factor by which penalty springs must be stiffer for no more overlap than is allowed: springs
/// in series with the bodies, under the same force (theory Eq. A.37).
fn missing_stiffness(overlap: Overlap) -> f64 {
    let odds = |share: f64| share / (1.0 - share).max(f64::MIN_POSITIVE);
    let needed = (RISE_MARGIN * odds(overlap.share) / odds(overlap.most())).clamp(RISE_MARGIN, MOST_RISE);
    10_f64.powf((STEPS * needed.log10() - 1e-9).ceil() / STEPS)
}

/// Relative change of the peak force that counts as none: a fifth of a percent, less than
/// discretisation errors.
pub const PEAK_TOLERANCE: f64 = 2e-3;

impl PenaltyStrategy {
    /// The default: a further factor of ten changes the peak force by less than [`PEAK_TOLERANCE`].
    pub const CONVERGED: Self = Self::UntilConverged { factor: 10.0, tolerance: PEAK_TOLERANCE };

    /// Factor by which a predicted factor begins above that of theory Eq. A.25: as stiff springs as a second trial would have had cost a
    /// quasistatic contact no steps.
    pub fn start(self) -> f64 {
        match self {
            Self::UntilConverged { factor, .. } => factor,
            Self::UntilStiff => START_OF_WHOLE,
            Self::Fixed | Self::ErrorDriven { .. } => 1.0,
        }
    }
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
    /// From the stiffness of a soft rubber foundation to ten decades above that of steel on
    /// elements of a micrometre.
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
    SolverError,
}

/// Why the search ended without a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenaltyFailure {
    /// The contact solver failed down to the lowest factor.
    TooLow {
        /// Lowest factor tried, infinite where no penetration is allowed [N/m³].
        penalty: f64,
    },
    /// Up to the highest factor the solver did not fail, and the peak force did not converge.
    TooHigh {
        /// Highest factor tried [N/m³].
        penalty: f64,
        /// Last relative change of the peak force, if there was one.
        change: Option<f64>,
    },
    /// Penetration is still too large a share of the approach with the highest factor at which the contact solver finds
    /// forces, or with the highest that is tried.
    TooSoft {
        /// That factor [N/m³].
        penalty: f64,
        /// How much of their approach is penetration.
        overlap: Overlap,
    },
}

impl fmt::Display for PenaltyFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLow { penalty } if penalty.is_infinite() => {
                f.write_str("the contact solver fails where no penetration is allowed")
            }
            Self::TooLow { penalty } => {
                write!(f, "the contact solver still fails at the lowest penalty factor {penalty:.3e} N/m^3")
            }
            Self::TooHigh { penalty, change: Some(change) } => write!(
                f,
                "the peak force still changes by {:.3} % at the highest penalty factor {penalty:.3e} N/m^3; loosen penalty.tolerance or refine the interval",
                100.0 * change
            ),
            Self::TooSoft { penalty, overlap } => write!(
                f,
                "{:.0} % of the approach of the bodies is penetration at the penalty factor {penalty:.3e} N/m^3, the highest with which the contact solver finds forces, and {:.0} % are allowed; refine the mesh at the touch, or keep the factor (penalty.initial) by penalty.search = \"fixed\"",
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

    /// A search whose factor an earlier impact of the same pair has found: the first completed run
    /// is accepted. Errors of the solver lower it.
    pub fn from_accepted(strategy: PenaltyStrategy, penalty: f64) -> Self {
        Self { state: State::Known, ..Self::new(strategy, penalty) }
    }

    /// The search that accepts a factor `times` as large in the first completed run; none of a factor that is given, and where none so large is
    /// permitted.
    pub fn raised_by(&self, times: f64) -> Option<Self> {
        let penalty = self.penalty * times;
        let may_rise = self.strategy != PenaltyStrategy::Fixed && penalty <= self.range.upper;
        may_rise.then(|| Self { range: self.range, ..Self::from_accepted(self.strategy, penalty) })
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

    /// Whether an error of the solver lowers the factor in the running impact, which goes on from
    /// the failing step, instead of ending the trial: always as printed, and where nothing higher
    /// is looked for.
    pub fn is_resuming(&self) -> bool {
        let is_printed = matches!(self.strategy, PenaltyStrategy::ErrorDriven { .. });
        let is_known = matches!(self.state, State::Lowering | State::Known);
        is_printed || (is_known && self.strategy != PenaltyStrategy::Fixed)
    }

    /// Whether an error of the solver counts at once, as printed; otherwise only where no step is
    /// short enough to avoid it.
    pub fn stops_at_errors(&self) -> bool {
        matches!(self.strategy, PenaltyStrategy::ErrorDriven { .. })
    }

    /// The search once its factor is found: one more run is made with it.
    #[must_use]
    pub fn accepted(&self) -> Self {
        Self { state: State::Known, ..self.clone() }
    }

    /// Starts the current run from its beginning: the first one, or once more after the model has
    /// changed. A changed model has other forces, so that they are not compared with those of
    /// earlier runs.
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
            (_, RunOutcome::SolverError) => self.after_error(),
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
        let most = run.overlap.as_ref().and_then(Overlap::peak_change);
        if [change, most].into_iter().flatten().any(|change| change < tolerance) {
            return self.accept(true);
        }
        self.state = State::Raising { last: Some(run) };
        self.raise(self.penalty * factor, change)
    }

    /// The next step after a run in which penetration was too large a share of the approach, even
    /// if the force has converged; none where the user gives the factor, and in trials of Fig. 3,
    /// which raise it anyway.
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
        Some(match self.raise(penalty * factor, None) {
            PenaltyAction::Fail(_) => PenaltyAction::Fail(PenaltyFailure::TooSoft { penalty, overlap }),
            action => action,
        })
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

    fn after_error(&mut self) -> PenaltyAction {
        match (self.strategy, self.state) {
            // A completed run is at hand, and nothing higher can be solved: that is the best there
            // is.
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
                return PenaltyAction::Fail(PenaltyFailure::TooLow { penalty: self.penalty });
            }
            _ => self.state = State::Lowering,
        }
        let lowered = PenaltyFactor::from_value(self.penalty).map_or(f64::NAN, |p| p.lowered().value());
        if lowered.is_nan() || lowered < self.range.lower {
            return PenaltyAction::Fail(PenaltyFailure::TooLow { penalty: self.penalty });
        }
        self.penalty = lowered;
        PenaltyAction::Resume { penalty: lowered }
    }

    fn accept(&self, is_last_run: bool) -> PenaltyAction {
        PenaltyAction::Accept { penalty: self.penalty, is_last_run }
    }
}

#[cfg(test)]
mod tests;
