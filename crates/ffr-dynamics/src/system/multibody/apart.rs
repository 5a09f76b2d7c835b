//! Which force elements are left out because their bodies are too far apart to act on each other.
//!
//! Elements that know their clearance ([`crate::force::ForceElement::clearance`]) are sorted once; those with more than a
//! skin of it find nothing as long as no frame has moved by half of the least clearance among them. So a right-hand
//! side costs one distance a body and the elements near each other, and its results are those of all elements, to the
//! last bit.

use std::ops::DerefMut;

use nalgebra::Vector3;

use crate::force::BodyState;
use crate::force::active::ActiveForce;

/// Uses of one sorting below which the skin is doubled, and above which it is halved: a wide one lasts longer and leaves
/// out fewer.
const FEW: u32 = 16;
const MANY: u32 = 256;
/// Part of the half clearance by which frames may move: round-off is far below the rest.
const SURE: f64 = 0.999;

/// The elements to be evaluated.
#[derive(Debug, Default)]
pub(super) struct Apart {
    /// Origins of the frames when the elements were sorted.
    origins: Vec<Vector3<f64>>,
    /// Elements that may act, in order.
    near: Vec<usize>,
    /// By how much each frame may have moved since; negative if nothing is known \[m\].
    reach: f64,
    skin: f64,
    n_uses: u32,
}

impl Apart {
    /// Nothing is known of `n_elements` elements and `n_bodies` bodies.
    pub fn new(n_elements: usize, n_bodies: usize) -> Self {
        let (near, origins) = (Vec::with_capacity(n_elements), Vec::with_capacity(n_bodies));
        Self { origins, near, reach: -1.0, skin: 0.0, n_uses: 0 }
    }

    /// Forgets what is known: elements have changed.
    pub fn forget(&mut self) {
        self.reach = -1.0;
    }

    /// The elements that may act in the motions `states`, if that is known; none if all are to be evaluated, and
    /// sorted.
    pub fn near(&mut self, states: &[BodyState]) -> Option<&[usize]> {
        // A motion that is not a number is nowhere near.
        let is_near = |(state, origin): (&BodyState, &Vector3<f64>)| {
            (state.position - origin).norm_squared() <= self.reach * self.reach
        };
        let is_known = self.reach >= 0.0 && states.iter().zip(&self.origins).all(is_near);
        self.n_uses += u32::from(is_known);
        is_known.then_some(self.near.as_slice())
    }

    /// Which of `n_elements` elements may have found anything in the last evaluation; the others found what they do at the start:
    /// no energy, no force.
    pub fn found(&self, n_elements: usize) -> impl Iterator<Item = usize> {
        let near = (self.reach >= 0.0).then_some(&self.near);
        (0..near.map_or(n_elements, Vec::len)).map(move |k| near.map_or(k, |near| near[k]))
    }

    /// Sorts `forces`, which have just been evaluated in the motions `states`. Does not allocate.
    pub fn sort<F: DerefMut<Target: ActiveForce>>(&mut self, forces: &[F], states: &[BodyState]) {
        if self.reach >= 0.0 {
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
        for (i, force) in forces.iter().enumerate() {
            let clearance = force.clearance(states).filter(|_| !force.notes_motions());
            match clearance.filter(|clearance| *clearance > self.skin) {
                Some(clearance) => least = least.min(clearance),
                None => self.near.push(i),
            }
        }
        let is_any = self.near.len() < forces.len();
        self.reach = if is_any { 0.5 * SURE * least } else { -1.0 };
        (self.skin, self.n_uses) = (if is_any { self.skin.max(1e-3 * least) } else { 0.5 * self.skin }, 0);
    }
}
