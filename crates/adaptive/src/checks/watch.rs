//! A watch that no bodies go through each other, whatever bodies are made of and whatever makes the
//! force of a contact: how deep do the whole surfaces of a pair overlap, and does the contact know
//! of it (docs/theory.md Eq. P.12).

use contact_qs::{Detector, Sphere, Target};
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::error::AdaptiveError;
use crate::impact::AdaptiveContact;
use crate::touch::detection::{Clearance, Nearest, Search};

/// Share of the deepest overlap of a phase that a contact need not know of. Light touches at the
/// beginning of a phase and deepest places between contact points are far below it; an overlap
/// elsewhere, or without a contact, is above.
const UNKNOWN: f64 = 0.25;
/// Distance from the nearest point of the contact, in units of the distance of its points, within
/// which an overlap belongs to its touch.
const SAME_TOUCH: f64 = 2.0;
/// Ratio of the times of successive looks, from the start of an impact phase: seventy looks for a
/// million steps.
const LOOKS: f64 = 1.2;
/// An unknown overlap of so many times the limit ends the run at once, not at the end of the phase.
const AT_ONCE: f64 = 10.0;

/// Surfaces of a pair, or the spheres that stand for them under Hertz's law.
pub enum Shapes {
    /// The surfaces of the detection of the contact, which follow the modes that its bodies have at
    /// present.
    Refined,
    /// Surfaces of their own, the same for the whole run.
    Lasting(Box<Detector>),
    /// A sphere and what it meets.
    Spheres(Sphere, Target<Sphere>),
}

/// The overlap of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Depth of the deepest place \[m\].
    pub depth: f64,
    /// The deepest place, in space \[m\].
    pub place: Vector3<f64>,
    /// The same on the surfaces; none of spheres that stand for them.
    pub nearest: Option<Nearest>,
}

/// An overlap that the contact does not know of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unknown {
    /// When it was seen \[s\].
    pub time: f64,
    /// The overlap.
    pub overlap: Overlap,
    /// Overlap that the contact saw then, zero for none \[m\].
    pub known: f64,
}

/// What the watch keeps of a contact in the running phase.
pub struct WatchedPair {
    shapes: Shapes,
    search: Search,
    clearance: Clearance,
    /// Time from the start of the phase at which the next look is due \[s\].
    due: f64,
    deepest: f64,
    worst: Option<Unknown>,
    /// Whether the contact saw an overlap in the running phase.
    has_seen: bool,
}

/// How far a contact knows of the overlap of its bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// How deep it is; negative for a gap \[m\].
    pub depth: f64,
    /// Where, on the contact body in space; NaN for a contact that sees nothing \[m\].
    pub place: Vector3<f64>,
    /// Distance of its points from each other \[m\].
    pub spacing: f64,
}

impl WatchedPair {
    /// A pair before its first phase.
    pub fn new(shapes: Shapes, search: Search) -> Self {
        Self {
            shapes,
            search,
            clearance: Clearance::UNKNOWN,
            due: 0.0,
            deepest: 0.0,
            worst: None,
            has_seen: false,
        }
    }

    /// Begins another phase, or trial of one: what was seen before does not count.
    pub fn begin(&mut self) {
        self.search.forget();
        (self.clearance, self.due) = (Clearance::UNKNOWN, 0.0);
        (self.deepest, self.worst, self.has_seen) = (0.0, None, false);
    }

    /// Whether a look is due after the time `elapsed` of an impact phase; the next one then is
    /// later in proportion.
    pub fn is_due(&mut self, elapsed: f64) -> bool {
        let is_due = elapsed >= self.due;
        if is_due {
            self.due = LOOKS * elapsed;
        }
        is_due
    }

    /// Size of the smaller body, of which an overlap that says nothing is a share \[m\].
    pub fn size(&self, refinement: Option<&AdaptiveContact>) -> f64 {
        match (&self.shapes, refinement) {
            (Shapes::Spheres(own, other), _) => {
                own.radius.min(other.as_ref().body().map_or(f64::INFINITY, |o| o.radius))
            }
            (Shapes::Lasting(detector), _) => detector.least_size(),
            (Shapes::Refined, refinement) => refinement.map_or(0.0, |r| r.detector.least_size()),
        }
    }

    /// How the bodies lie in each other at time `time` in the motions `states`; nothing if they do
    /// not.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`], with the name `contact`, if the motions are not finite.
    pub fn overlap(
        &mut self,
        contact: &str,
        refinement: Option<&AdaptiveContact>,
        (time, states): (f64, &[BodyState]),
    ) -> Result<Option<Overlap>, AdaptiveError> {
        let detector = match (&self.shapes, refinement) {
            (Shapes::Spheres(own, other), _) => {
                let overlap = own.nearest(other.as_ref(), states).filter(|(gap, ..)| *gap < 0.0);
                return Ok(overlap.map(|(gap, _, [place, _])| Overlap { depth: -gap, place, nearest: None }));
            }
            (Shapes::Lasting(detector), _) => detector,
            (Shapes::Refined, Some(refinement)) => &refinement.detector,
            (Shapes::Refined, None) => return Ok(None),
        };
        if self.clearance.go_on(detector, (time, states), 0.0) {
            return Ok(None);
        }
        let nearest = self
            .search
            .nearest(detector, states)
            .map_err(|source| AdaptiveError::Contact { contact: contact.to_owned(), source })?;
        self.clearance.gap = nearest.gap.max(0.0);
        let overlap = Overlap { depth: -nearest.gap, place: nearest.contact.point, nearest: Some(nearest) };
        Ok((nearest.gap < 0.0).then_some(overlap))
    }

    /// Notes `overlap` at time `time`, of which the contact sees `seen`, and that overlaps below
    /// `least` say nothing; what is to be told at once: a place that is none of the contact's. One
    /// between its points, which may touch later, waits for the end of the phase.
    pub fn note(&mut self, (time, least): (f64, f64), overlap: Overlap, seen: Seen) -> Option<Unknown> {
        self.deepest = self.deepest.max(overlap.depth);
        self.has_seen |= seen.depth > 0.0;
        let found = Unknown { time, overlap, known: seen.depth.max(0.0) };
        if (overlap.place - seen.place).norm() <= SAME_TOUCH * seen.spacing {
            return None;
        }
        if found.missing() > least && self.worst.is_none_or(|worst| worst.missing() < found.missing()) {
            self.worst = Some(found);
        }
        (found.missing() > AT_ONCE * least && found.missing() > UNKNOWN * self.deepest).then_some(found)
    }

    /// What the contact did not know of in the phase that ends, if it is more than its points leave
    /// between each other; `last` is the overlap at its end, which a contact that never saw one
    /// does not know of, wherever it is.
    pub fn unknown(&self, last: Option<Unknown>) -> Option<Unknown> {
        self.worst
            .filter(|worst| worst.missing() > UNKNOWN * self.deepest)
            .or(last.filter(|_| !self.has_seen))
    }
}

impl Unknown {
    fn missing(&self) -> f64 {
        self.overlap.depth - self.known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> WatchedPair {
        WatchedPair::new(Shapes::Refined, Search::new())
    }

    fn overlap(depth: f64) -> Overlap {
        Overlap { depth, place: Vector3::zeros(), nearest: None }
    }

    fn seen(depth: f64, distance: f64) -> Seen {
        Seen { depth, place: Vector3::x() * distance, spacing: 1e-4 }
    }

    #[test]
    fn what_points_leave_between_each_other_is_no_fault() {
        let mut watched = pair();
        // The first point, a distance of points beside the deepest place, touches 1 um late; the
        // bodies come nearer by 20 um and part.
        for (t, depth) in [(0.0, 5e-7), (1.0, 5e-6), (2.0, 20e-6), (3.0, 4e-6)] {
            assert_eq!(watched.note((t, 1e-8), overlap(depth), seen(depth - 1e-6, 1e-4)), None);
        }
        let last = Unknown { time: 3.0, overlap: overlap(4e-6), known: 3e-6 };
        assert_eq!(watched.unknown(Some(last)), None);
    }

    #[test]
    fn an_overlap_without_contact_is_told() {
        // No contact at all: a little late, at the end of the phase.
        let nothing = Seen { depth: f64::NEG_INFINITY, place: Vector3::repeat(f64::NAN), spacing: 0.0 };
        let mut watched = pair();
        assert_eq!(watched.note((1.0, 1e-7), overlap(5e-7), nothing), None);
        let unknown = watched.unknown(None).expect("a fault");
        assert_eq!((unknown.time, unknown.known, unknown.overlap.depth), (1.0, 0.0, 5e-7));
        // At once if it is deep; a contact that presses elsewhere does not hide it.
        let told = watched.note((2.0, 1e-7), overlap(8e-6), seen(2e-6, 1e-3)).expect("a fault");
        assert_eq!((told.time, told.known), (2.0, 2e-6));
        // Points beside it that never touch.
        let mut watched = pair();
        assert_eq!(watched.note((1.0, 1e-7), overlap(5e-6), seen(-1e-7, 1e-4)), None);
        let last = Unknown { time: 1.0, overlap: overlap(5e-6), known: 0.0 };
        assert_eq!(watched.unknown(Some(last)), Some(last));
        // Another phase begins anew.
        watched.begin();
        assert_eq!(watched.unknown(None), None);
    }

    #[test]
    fn looks_become_rarer_in_proportion_to_the_time() {
        let mut watched = pair();
        let steps = 1_000_000;
        let looks = (0..steps).filter(|k| watched.is_due(f64::from(*k) * 1e-7)).count();
        assert!((60..=100).contains(&looks), "{looks}");
        watched.begin();
        assert!(watched.is_due(0.0));
    }
}
