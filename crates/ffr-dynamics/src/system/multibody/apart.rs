//! Which force elements are left out because their bodies are too far apart to act on each other.
//!
//! Elements that know their clearance ([`crate::force::ForceElement::clearance`]) are sorted once; those with more than a
//! skin of it find nothing as long as no frame has moved by half of the least clearance among them. So a right-hand
//! side costs one distance a body and the elements near each other, and its results are those of all elements, to the
//! last bit.

use nalgebra::Vector3;

use crate::force::BodyState;

/// Uses of one sorting below which the skin is doubled, and above which it is halved: a wide one lasts longer and leaves
/// out fewer.
const FEW: u32 = 16;
const MANY: u32 = 256;
/// Part of the half clearance by which frames may move: round-off is far below the rest.
const SURE: f64 = 0.999;

/// The elements to be evaluated.
#[derive(Debug, Default)]
pub struct Apart {
    /// Origins of the frames when the elements were sorted.
    origins: Vec<Vector3<f64>>,
    /// Elements that may act, in order.
    near: Vec<usize>,
    /// Least clearance of the elements left out; negative if nothing is known \[m\].
    least: f64,
    skin: f64,
    n_uses: u32,
}

impl Apart {
    /// Nothing is known of `n_elements` elements and `n_bodies` bodies.
    pub fn new(n_elements: usize, n_bodies: usize) -> Self {
        let (near, origins) = (Vec::with_capacity(n_elements), Vec::with_capacity(n_bodies));
        Self { origins, near, least: -1.0, skin: 0.0, n_uses: 0 }
    }

    /// Forgets what is known: elements have changed.
    pub fn forget(&mut self) {
        self.least = -1.0;
    }

    /// The elements that may have less than the clearance `margin` in the motions `states`, if that is known; none if all
    /// are to be looked at, and sorted.
    pub fn near(&mut self, states: &[BodyState], margin: f64) -> Option<&[usize]> {
        let reach = 0.5 * (SURE * self.least - margin);
        // A motion that is not a number is nowhere near.
        let is_near = |(state, origin): (&BodyState, &Vector3<f64>)| {
            (state.position - origin).norm_squared() <= reach * reach
        };
        let is_known = reach >= 0.0 && states.iter().zip(&self.origins).all(is_near);
        self.n_uses += u32::from(is_known);
        is_known.then_some(self.near.as_slice())
    }

    /// Which of `n_elements` elements may have found anything in the last evaluation; the others found what they do at the start:
    /// no energy, no force.
    pub fn found(&self, n_elements: usize) -> impl Iterator<Item = usize> {
        let near = (self.least >= 0.0).then_some(&self.near);
        (0..near.map_or(n_elements, Vec::len)).map(move |k| near.map_or(k, |near| near[k]))
    }

    /// Sorts `n_elements` elements in the motions `states`; `clearance` tells how far each is from acting, or nothing of one
    /// that is never left out. Does not allocate.
    pub fn sort(
        &mut self,
        n_elements: usize,
        states: &[BodyState],
        mut clearance: impl FnMut(usize) -> Option<f64>,
    ) {
        if self.least >= 0.0 {
            self.skin *= if self.n_uses < FEW {
                2.0
            } else if self.n_uses > MANY {
                0.5
            } else {
                1.0
            };
        }
        self.origins.clear();
        self.origins.extend(states.iter().map(|state| state.position));
        self.near.clear();
        let mut least = f64::INFINITY;
        for i in 0..n_elements {
            match clearance(i).filter(|clearance| *clearance > self.skin) {
                Some(clearance) => least = least.min(clearance),
                None => self.near.push(i),
            }
        }
        let is_any = self.near.len() < n_elements;
        self.least = if is_any { least } else { -1.0 };
        (self.skin, self.n_uses) = (if is_any { self.skin.max(1e-3 * least) } else { 0.5 * self.skin }, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_keeps_the_margin_however_bodies_move() {
        let at = |x: f64| BodyState { position: Vector3::new(x, 0.0, 0.0), ..BodyState::at_rest(0) };
        let places = [0.0, 1.0, 3.0];
        let sorted = places.map(at);
        let mut apart = Apart::new(3, 3);
        assert_eq!(apart.near(&sorted, 0.0), None, "nothing is known");
        // Pairs of bodies of no size: clearances 1, 3 and 2. The third element is never left out.
        apart.sort(3, &sorted, |i| [Some(1.0), Some(3.0), None][i]);
        assert_eq!(apart.near(&sorted, 0.0), Some(&[2][..]));
        // Two bodies that close by `way` each leave 1 - 2 way to the first pair.
        for (way, margin, is_known) in [
            (0.4, 0.1, true),
            (0.4, 0.3, false),
            (0.49, 0.0, true),
            (0.51, 0.0, false),
            (f64::NAN, 0.0, false),
        ] {
            let moved = [at(way), at(1.0 - way), at(3.0)];
            assert_eq!(apart.near(&moved, margin).is_some(), is_known, "{way}, {margin}");
        }
        apart.forget();
        assert_eq!(apart.near(&sorted, 0.0), None);
    }
}
