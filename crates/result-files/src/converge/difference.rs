//! What a variant changes: impacts matched by contact and order, motions at the end body by body,
//! largest values place by place.

use super::motion::length;
use super::outcome::{Impact, Motion, Outcome};
use super::peaks::{Peak, PeakKind};

/// Displacement, over the size of the largest body, below which a point is at rest: a million times
/// the round-off of its position.
const LEAST_DISPLACEMENT: f64 = 1e-9;
/// Stress below which a place has none \[Pa\]: above the round-off of a stiff body's strain, 1e-16 of
/// some 1e11 Pa.
const LEAST_STRESS: f64 = 1e-3;

/// What is compared of an impact, of a body, or of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time of the first contact.
    Start,
    /// Largest normal force.
    PeakForce,
    /// Time between first and last contact.
    Duration,
    /// Normal force over time.
    Impulse,
    /// Velocity of a body at the end.
    Velocity,
    /// Largest displacement of a point since the start.
    Displacement,
    /// Largest von Mises stress at a place.
    Stress,
    /// Number of impacts of a contact.
    Count,
}

impl Quantity {
    /// Quantities of an impact.
    pub const OF_IMPACT: [Self; 4] = [Self::Start, Self::PeakForce, Self::Duration, Self::Impulse];

    /// Name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::PeakForce => "peak_force",
            Self::Duration => "duration",
            Self::Impulse => "impulse",
            Self::Velocity => "final_velocity",
            Self::Displacement => "peak_displacement",
            Self::Stress => "peak_von_mises",
            Self::Count => "impacts",
        }
    }

    /// Name in sentences.
    pub fn words(self) -> &'static str {
        match self {
            Self::Start => "time",
            Self::PeakForce => "peak force",
            Self::Duration => "duration",
            Self::Impulse => "impulse",
            Self::Velocity => "final velocity",
            Self::Displacement => "largest displacement",
            Self::Stress => "largest stress",
            Self::Count => "number",
        }
    }

    /// Its value.
    pub fn of(self, impact: &Impact) -> f64 {
        match self {
            Self::Start => impact.start,
            Self::PeakForce => impact.peak_force,
            Self::Duration => impact.duration,
            Self::Impulse => impact.impulse,
            Self::Velocity | Self::Displacement | Self::Stress | Self::Count => f64::NAN,
        }
    }

    /// What a change of it is related to: the value itself, but for times at the very start, which
    /// have no size of their own.
    fn scale(self, impact: &Impact) -> f64 {
        match self {
            Self::Start => impact.start.max(impact.duration),
            _ => self.of(impact).abs(),
        }
    }
}

impl From<PeakKind> for Quantity {
    fn from(kind: PeakKind) -> Self {
        match kind {
            PeakKind::Displacement => Self::Displacement,
            PeakKind::Stress => Self::Stress,
        }
    }
}

/// A change of one quantity of an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Quantity.
    pub quantity: Quantity,
    /// Value in the variant.
    pub value: f64,
    /// Change relative to the base run.
    pub relative: f64,
}

/// What a variant changes of an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactChange {
    /// Number among all impacts of the base run, from 1.
    pub number: usize,
    /// Name of the contact.
    pub contact: String,
    /// Changes, in the order of [`Quantity::OF_IMPACT`].
    pub changes: [Change; 4],
}

/// Another number of impacts of a contact.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CountChange {
    /// Name of the contact.
    pub contact: String,
    /// Impacts in the base run.
    pub base: usize,
    /// Impacts in the variant.
    pub variant: usize,
}

/// What a variant changes of a body's motion at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityChange {
    /// Name of the body.
    pub body: String,
    /// Velocity at the end in the variant [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity at the end in the variant [rad/s].
    pub angular_velocity: [f64; 3],
    /// Change of either, as a share of the largest speed in the base run.
    pub relative: f64,
}

/// What a variant changes of the largest value at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct PeakChange {
    /// The value in the variant.
    pub peak: Peak,
    /// Its change as a share of the largest value of its quantity in the base run, or of what counts
    /// as none.
    pub relative: f64,
}

/// What a variant changes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Difference {
    /// Impacts that both have.
    pub impacts: Vec<ImpactChange>,
    /// Contacts with more or fewer impacts.
    pub counts: Vec<CountChange>,
    /// Motions at the end.
    pub velocities: Vec<VelocityChange>,
    /// Largest values at the places that the scenario asks for.
    pub peaks: Vec<PeakChange>,
}

/// The largest change of a variant.
#[derive(Debug, Clone, PartialEq)]
pub struct Largest {
    /// What changes.
    pub quantity: Quantity,
    /// Relative change; infinite for another number of impacts.
    pub relative: f64,
    /// The impact with its contact, the contact, the body, or the place.
    pub place: String,
}

/// The size of a body by name, by which angular velocities become velocities \[m\].
pub type Size<'a> = dyn Fn(&str) -> f64 + 'a;

impl Difference {
    /// What `variant` changes of `base`, both complete.
    pub fn new(base: &Outcome, variant: &Outcome, size: &Size<'_>) -> Self {
        let matching = |impact: &Impact| {
            variant.impacts.iter().find(|i| i.contact == impact.contact && i.order == impact.order)
        };
        let both = base.impacts.iter().enumerate().filter_map(|(i, b)| Some((i + 1, b, matching(b)?)));
        Self {
            impacts: both.map(|(number, b, v)| impact_change(number, b, v)).collect(),
            counts: counts(&base.impacts, &variant.impacts),
            velocities: velocities(&base.motions, &variant.motions, size),
            peaks: peaks(base, &variant.peaks, size),
        }
    }

    /// The largest change, if anything can be compared. Another number of impacts is more than any
    /// other change.
    pub fn largest(&self) -> Option<Largest> {
        let counts = self.counts.iter().map(|c| Largest {
            quantity: Quantity::Count,
            relative: f64::INFINITY,
            place: format!("of impacts of contact \"{}\"", c.contact),
        });
        let impacts = self.impacts.iter().flat_map(|i| {
            i.changes.iter().map(|c| Largest {
                quantity: c.quantity,
                relative: c.relative.abs(),
                place: format!("of impact {} (contact \"{}\")", i.number, i.contact),
            })
        });
        let velocities = self.velocities.iter().map(|v| Largest {
            quantity: Quantity::Velocity,
            relative: v.relative,
            place: format!("of body \"{}\"", v.body),
        });
        let peaks = self.peaks.iter().map(|p| Largest {
            quantity: p.peak.kind.into(),
            relative: p.relative.abs(),
            place: format!("at {}", p.peak.place),
        });
        // The first of equal ones.
        counts
            .chain(impacts)
            .chain(velocities)
            .chain(peaks)
            .reduce(|a, b| if b.relative > a.relative { b } else { a })
    }
}

fn impact_change(number: usize, base: &Impact, variant: &Impact) -> ImpactChange {
    let changes = Quantity::OF_IMPACT.map(|quantity| {
        let (value, before) = (quantity.of(variant), quantity.of(base));
        Change { quantity, value, relative: relative(value - before, quantity.scale(base)) }
    });
    ImpactChange { number, contact: base.contact.clone(), changes }
}

/// `change` as a share of `scale`; anything is infinitely much of nothing, and so is what is no
/// number.
fn relative(change: f64, scale: f64) -> f64 {
    if change.abs() <= 0.0 {
        return 0.0;
    }
    let share = change / scale;
    if share.is_nan() { f64::INFINITY } else { share }
}

fn counts(base: &[Impact], variant: &[Impact]) -> Vec<CountChange> {
    let mut contacts: Vec<&str> = base.iter().chain(variant).map(|i| i.contact.as_str()).collect();
    contacts.sort_unstable();
    contacts.dedup();
    let count = |impacts: &[Impact], contact: &str| impacts.iter().filter(|i| i.contact == contact).count();
    let change = |contact: &str| CountChange {
        contact: contact.to_owned(),
        base: count(base, contact),
        variant: count(variant, contact),
    };
    contacts.into_iter().map(change).filter(|c| c.base != c.variant).collect()
}

fn velocities(base: &[Motion], variant: &[Motion], size: &Size<'_>) -> Vec<VelocityChange> {
    // The speed of the far end of a body that turns counts as well as that of its origin.
    let fastest = |m: &Motion| m.fastest.max(m.fastest_turn * size(&m.body));
    let scale = base.iter().map(fastest).fold(0.0, f64::max);
    let between = |a: &[f64; 3], b: &[f64; 3]| length(&std::array::from_fn(|k| a[k] - b[k]));
    let change = |b: &Motion| {
        let v = variant.iter().find(|v| v.body == b.body)?;
        let moved = between(&v.velocity, &b.velocity);
        let turned = between(&v.angular_velocity, &b.angular_velocity) * size(&b.body);
        Some(VelocityChange {
            body: b.body.clone(),
            velocity: v.velocity,
            angular_velocity: v.angular_velocity,
            relative: relative(moved.max(turned), scale),
        })
    };
    base.iter().filter_map(change).collect()
}

fn peaks(base: &Outcome, variant: &[Peak], size: &Size<'_>) -> Vec<PeakChange> {
    let largest = base.motions.iter().map(|m| size(&m.body)).fold(0.0, f64::max);
    let base = &base.peaks;
    let change = |b: &Peak| {
        let least = if b.kind == PeakKind::Stress { LEAST_STRESS } else { LEAST_DISPLACEMENT * largest };
        let alike = base.iter().filter(|p| p.kind == b.kind);
        let scale = alike.map(|p| p.value).fold(least, f64::max);
        let peak = variant.iter().find(|v| v.kind == b.kind && v.place == b.place)?.clone();
        let relative = relative(peak.value - b.value, scale);
        Some(PeakChange { peak, relative })
    };
    base.iter().filter_map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn impact(contact: &str, order: usize, [start, peak_force, duration, impulse]: [f64; 4]) -> Impact {
        Impact {
            contact: contact.to_owned(),
            order,
            start,
            duration,
            peak_force,
            impulse,
            bands: [f64::NAN; 3],
        }
    }

    fn motion(body: &str, speed: f64, turn: f64, fastest: f64) -> Motion {
        Motion {
            body: body.to_owned(),
            velocity: [0.0, 0.0, speed],
            angular_velocity: [turn, 0.0, 0.0],
            fastest,
            fastest_turn: turn.abs(),
        }
    }

    fn outcome(impacts: Vec<Impact>, motions: Vec<Motion>) -> Outcome {
        Outcome { is_complete: true, impacts, motions, ..Outcome::default() }
    }

    #[test]
    fn impacts_are_matched_by_contact_and_order_however_they_are_mixed() {
        let base = outcome(
            vec![
                impact("a", 1, [1.0, 10.0, 0.1, 2.0]),
                impact("b", 1, [1.5, 20.0, 0.1, 2.0]),
                impact("a", 2, [2.0, 30.0, 0.1, 2.0]),
            ],
            vec![],
        );
        let variant = outcome(
            vec![
                impact("b", 1, [1.5, 22.0, 0.1, 2.0]),
                impact("a", 1, [1.0, 10.0, 0.1, 2.0]),
                impact("a", 2, [2.02, 30.0, 0.1, 2.0]),
            ],
            vec![],
        );
        let difference = Difference::new(&base, &variant, &|_| 1.0);
        assert_eq!(difference.impacts.iter().map(|i| i.number).collect::<Vec<_>>(), [1, 2, 3]);
        let relative = |i: usize, k: usize| difference.impacts[i].changes[k].relative;
        // Round-off of a difference of numbers of order 1.
        assert!((relative(1, 1) - 0.1).abs() < 1e-14 && (relative(2, 0) - 0.01).abs() < 1e-14);
        assert!(relative(0, 0).abs() <= 0.0 && relative(0, 3).abs() <= 0.0);
        let largest = difference.largest().expect("something is compared");
        assert_eq!(largest.quantity, Quantity::PeakForce);
        assert_eq!(largest.place, "of impact 2 (contact \"b\")");
    }

    #[test]
    fn another_number_of_impacts_is_told_and_outweighs_everything() {
        let first = impact("a", 1, [1.0, 10.0, 0.1, 2.0]);
        let second = impact("a", 2, [2.0, 10.0, 0.1, 2.0]);
        let base = outcome(vec![first.clone(), second], vec![motion("ball", 1.0, 0.0, 1.0)]);
        let variant = outcome(vec![first], vec![motion("ball", -1.0, 0.0, 1.0)]);
        let difference = Difference::new(&base, &variant, &|_| 1.0);
        assert_eq!(difference.impacts.len(), 1);
        assert_eq!(difference.counts, [CountChange { contact: "a".into(), base: 2, variant: 1 }]);
        let largest = difference.largest().expect("something is compared");
        assert_eq!((largest.quantity, largest.relative), (Quantity::Count, f64::INFINITY));
    }

    #[test]
    fn a_touch_at_the_very_start_is_judged_by_its_duration() {
        let base = outcome(vec![impact("a", 1, [0.0, 10.0, 1e-4, 2.0])], vec![]);
        let variant = outcome(vec![impact("a", 1, [1e-7, 10.0, 1e-4, 2.0])], vec![]);
        let start = Difference::new(&base, &variant, &|_| 1.0).impacts[0].changes[0];
        assert!((start.relative - 1e-3).abs() < 1e-15, "{}", start.relative);
    }

    #[test]
    fn motions_are_shares_of_the_largest_speed_and_turns_count_by_the_size() {
        // The ball that comes to rest changes by 0.01 m/s; the other was as fast as 2 m/s.
        let base = outcome(vec![], vec![motion("rests", 0.0, 0.0, 1.0), motion("flies", 1.0, 0.0, 2.0)]);
        let variant = outcome(vec![], vec![motion("rests", 0.01, 0.0, 1.0), motion("flies", 1.0, 0.1, 2.0)]);
        let changes = Difference::new(&base, &variant, &|_| 0.5).velocities;
        assert!((changes[0].relative - 0.005).abs() < 1e-15);
        assert!((changes[1].relative - 0.1 * 0.5 / 2.0).abs() < 1e-15, "0.1 rad/s at 0.5 m of 2 m/s");
        // At rest from beginning to end.
        let still = outcome(vec![], vec![motion("rests", 0.0, 0.0, 0.0)]);
        assert!(Difference::new(&still, &still, &|_| 1.0).velocities[0].relative.abs() <= 0.0);
    }

    #[test]
    fn largest_values_are_shares_of_the_largest_of_their_kind() {
        let peak = |kind, place: &str, value| Peak { kind, place: place.to_owned(), value };
        let run = |stress: f64, little: f64| Outcome {
            peaks: vec![
                peak(PeakKind::Displacement, "point \"tip\"", 1e-3),
                peak(PeakKind::Stress, "point \"root\"", stress),
                peak(PeakKind::Stress, "point \"tip\"", little),
            ],
            ..outcome(vec![], vec![])
        };
        let difference = Difference::new(&run(4e6, 10.0), &run(4.2e6, 20.0), &|_| 1.0);
        let relative: Vec<f64> = difference.peaks.iter().map(|p| p.relative).collect();
        // The tip's stress doubles, which is nothing beside that of the root; round-off of a quotient.
        let expected = [0.0, 0.05, 10.0 / 4e6];
        assert!(relative.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{relative:?}");
        let largest = difference.largest().expect("something is compared");
        assert_eq!((largest.quantity, largest.place.as_str()), (Quantity::Stress, "at point \"root\""));
        // Of a point at rest and a body without stress it is round-off that changes.
        let rest = |round_off: f64| Outcome {
            peaks: vec![
                peak(PeakKind::Displacement, "point \"tip\"", round_off),
                peak(PeakKind::Stress, "point \"tip\"", 1e12 * round_off),
            ],
            ..outcome(vec![], vec![motion("rod", 0.0, 0.0, 0.0)])
        };
        let difference = Difference::new(&rest(1e-17), &rest(2e-17), &|_| 0.1);
        assert!(difference.peaks.iter().all(|p| p.relative < 0.02), "{:?}", difference.peaks);
    }
}
