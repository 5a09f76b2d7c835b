//! What a variant changes: impacts matched by contact and order, motions at the end body by body.

use super::motion::length;
use super::outcome::{Impact, Motion, Outcome};

/// What is compared of an impact, or of a body.
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
            Self::Velocity | Self::Count => f64::NAN,
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

/// What a variant changes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Difference {
    /// Impacts that both have.
    pub impacts: Vec<ImpactChange>,
    /// Contacts with more or fewer impacts.
    pub counts: Vec<CountChange>,
    /// Motions at the end.
    pub velocities: Vec<VelocityChange>,
}

/// The largest change of a variant.
#[derive(Debug, Clone, PartialEq)]
pub struct Largest {
    /// What changes.
    pub quantity: Quantity,
    /// Relative change; infinite for another number of impacts.
    pub relative: f64,
    /// The impact with its contact, the contact, or the body.
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
        // The first of equal ones.
        counts.chain(impacts).chain(velocities).reduce(|a, b| if b.relative > a.relative { b } else { a })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn impact(contact: &str, order: usize, [start, peak_force, duration, impulse]: [f64; 4]) -> Impact {
        Impact { contact: contact.to_owned(), order, start, duration, peak_force, impulse }
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
}
