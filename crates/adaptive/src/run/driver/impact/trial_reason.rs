//! Why a trial is the result of its impact, or which contacts ask for another one.

use std::fmt;

use ffr_dynamics::error::EvaluationFailure;

use crate::adaptivity::overlap::Overlap;
use crate::uncertainty::accuracy::Remedy;

/// Why a trial is the result.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Acceptance {
    /// The observer asked to stop.
    Interrupted,
    /// No contact is refined.
    Given,
    /// Intervals and penalty factors are acceptable.
    Judged {
        /// Names of the contacts whose forces were too small to judge them by.
        minor: Vec<String>,
        /// Share of the largest force below which they are.
        share: f64,
        /// Contacts that used less of their intervals than asked for, since contact reached the end
        /// of narrower ones or these changed no force, and the least share that they used.
        little: Vec<(String, f64)>,
    },
}

impl fmt::Display for Acceptance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::Given => f.write_str("refinement and penalty are given"),
            Self::Judged { minor, share, little } => {
                f.write_str("utilisation and penalty factor are acceptable")?;
                for (contact, utilisation) in little {
                    let used = 100.0 * utilisation;
                    write!(
                        f,
                        "; {contact}: {used:.0} % used, narrower intervals do not hold the contact or change no force"
                    )?;
                }
                if minor.is_empty() {
                    return Ok(());
                }
                let names = minor.join(", ");
                write!(f, "; not judged, for their forces are below {share:.0e} of the largest: {names}")
            }
        }
    }
}

/// What a contact asks of the next trial.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Demand {
    /// Name of the contact.
    pub contact: String,
    pub change: Change,
}

impl fmt::Display for Demand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.contact, self.change)
    }
}

/// What is to be different in the next trial, and why.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Change {
    /// Contact reached an edge of the body: the whole surfaces take the place of the interval.
    WholeSurfaces,
    /// Contact reached an end of the interval, or used too little of it.
    Widths {
        /// Which of both.
        is_edge: bool,
        /// Share of the interval that was used, and the next width \[m\], for each direction.
        directions: Vec<(f64, f64)>,
    },
    /// Contact reached an end of the parts of the surfaces that are its zones: how far from the plane of
    /// the touch the next ones go on \[m\].
    Reach(f64),
    /// The bodies touched beside the zones: at how many places in all.
    Beside(usize),
    /// Contact moved along the interval.
    Finer {
        /// Elements in contact at one instant at most, as a share of those that intervals of the
        /// contact have.
        share: f64,
        /// How many times as many the next interval has.
        times: f64,
    },
    /// The band of the peak force is wider than it is wanted.
    Accuracy {
        /// The band, as a share of the peak force.
        band: f64,
        /// What it may be.
        wanted: f64,
        /// How many times as many elements the next interval has, and as stiff springs.
        next: Remedy,
    },
    /// Contact went on to the end of its zone: one about the present touch takes over.
    HandOver,
    /// The same where so many zones are to come that it goes on by Hertz's law.
    ByLaw(f64),
    /// The penalty search goes on.
    Penalty {
        /// Why.
        cause: PenaltyCause,
        /// Factor of the trial \[N/m³\].
        before: f64,
        /// Factor of the next one \[N/m³\].
        after: f64,
    },
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WholeSurfaces => f.write_str("contact reached an edge, next the whole surfaces"),
            Self::Widths { is_edge, directions } => {
                let used = |(utilisation, width): &(f64, f64)| {
                    format!("{:.0} % used, next width {width:.3e} m", 100.0 * utilisation)
                };
                let what = match is_edge {
                    true => "an edge element was in contact",
                    false => "too little of the interval was in contact",
                };
                write!(f, "{what} ({})", directions.iter().map(used).collect::<Vec<_>>().join(", "))
            }
            Self::Reach(reach) => {
                write!(f, "contact reached an end of the zone, which next reaches {reach:.3e} m far")
            }
            Self::Beside(n) => write!(f, "the bodies touched beside the zone, next zones at {n} places"),
            Self::Finer { share, times } => {
                let share = 100.0 * share;
                write!(
                    f,
                    "contact moved along the interval and had {share:.0} % of the elements of one at a time, next {times:.1} times as many elements"
                )
            }
            Self::Accuracy { band, wanted, next: Remedy { finer, stiffer } } => {
                let [band, wanted] = [band, wanted].map(|share| 100.0 * share);
                write!(f, "the band of the peak force is {band:.2} %, {wanted:.2} % are wanted")?;
                if *finer > 1.0 {
                    write!(f, ", next {finer:.0} times as many elements")?;
                }
                if *stiffer > 1.0 {
                    write!(f, ", next springs {stiffer:.1} times as stiff")?;
                }
                Ok(())
            }
            Self::HandOver => f.write_str("contact goes on beyond its zone, another one takes over"),
            Self::ByLaw(zones) => {
                write!(
                    f,
                    "contact goes on beyond its zone, by Hertz's law: {zones:.0} more zones are too many"
                )
            }
            Self::Penalty { cause, before, after } => {
                write!(f, "{cause} at {before:.3e} N/m^3, next {after:.3e} N/m^3")
            }
        }
    }
}

/// Why a penalty factor is not the last one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PenaltyCause {
    /// The steps of a trial that is stopped early have passed.
    TrialPassed,
    /// The contact solver found no forces.
    SolverFailed(EvaluationFailure),
    /// Too much of the approach of the bodies is penetration (theory Eq. A.36).
    TooSoft(Overlap),
    /// There is no peak force of another factor to compare with.
    NotCompared,
}

impl fmt::Display for PenaltyCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TrialPassed => f.write_str("trial passed"),
            Self::SolverFailed(failure) => {
                write!(f, "contact solver failed, {} ({failure})", failure.kind())
            }
            Self::TooSoft(overlap) => write!(
                f,
                "{:.1} % of the approach is penetration, {:.0} % are allowed,",
                100.0 * overlap.share,
                100.0 * overlap.most()
            ),
            Self::NotCompared => f.write_str("peak force not yet compared"),
        }
    }
}

/// The demands of several contacts in one line.
pub(crate) fn line(demands: &[Demand]) -> String {
    demands.iter().map(Demand::to_string).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_name_contacts_numbers_and_units() {
        let minor = vec!["a".to_owned(), "b".to_owned()];
        let little = vec![("c".to_owned(), 0.44)];
        assert_eq!(
            Acceptance::Judged { minor, share: 1e-4, little }.to_string(),
            "utilisation and penalty factor are acceptable; \
             c: 44 % used, narrower intervals do not hold the contact or change no force; \
             not judged, for their forces are below 1e-4 of the largest: a, b"
        );
        let widths = Change::Widths { is_edge: true, directions: vec![(1.0, 2e-3), (0.5, 1e-3)] };
        let accuracy =
            Change::Accuracy { band: 0.024, wanted: 0.01, next: Remedy { finer: 2.0, stiffer: 1.0 } };
        assert_eq!(
            accuracy.to_string(),
            "the band of the peak force is 2.40 %, 1.00 % are wanted, next 2 times as many elements"
        );
        let penalty = Change::Penalty { cause: PenaltyCause::TrialPassed, before: 1e12, after: 1e13 };
        let demands = [("c", widths), ("d", penalty)];
        assert_eq!(
            line(&demands.map(|(contact, change)| Demand { contact: contact.into(), change })),
            "c: an edge element was in contact (100 % used, next width 2.000e-3 m, 50 % used, next width 1.000e-3 m); \
             d: trial passed at 1.000e12 N/m^3, next 1.000e13 N/m^3"
        );
    }
}
