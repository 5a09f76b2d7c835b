//! Damping ratios of bodies that joints hold: those of the modes of the joined system
//! (docs/theory.md Eq. F.29 to F.33).
//!
//! A ratio that is set for the modes of the free body is lost where rigid motion carries a mode.
//! Here each body's damping matrix is found from the modes of the system about a pose: it acts on
//! the body's elastic rates alone, so that momenta stay exact, and it is positive semidefinite in
//! any pose.

use std::ops::DerefMut;

use faer::{Mat, MatRef};

use super::Problem;
use super::small_motion::SmallMotion;
use crate::body::{DampingLaw, ModalDamping};
use crate::error::DynamicsError;
use crate::force::active::ActiveForce;
use crate::reduction::blocks::dense;
use crate::system::model::MultibodyModel;
use crate::system::multibody::Multibody;
use crate::system::multibody::free_vibration::vibrates_alone;

/// Rounds in which the shares of the modes are fitted to their ratios.
const ROUNDS: usize = 300;
/// Deviation of a ratio, as a share of it, that ends them: far below what anybody knows of damping.
const FITTED: f64 = 1e-6;
/// Share of a mode's elastic energy in the damped bodies from which on it has their ratios in full,
/// in a body from which on the mode counts in the body's list of them.
const OWN: f64 = 0.5;

/// The damping ratios of a body by its own law.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnDamping {
    /// Damping ratios.
    pub law: DampingLaw,
    /// Frequency of the last of its own modes, above which ratios are critical at most [rad/s].
    pub highest: f64,
    /// Coefficients of its modes while nothing holds it [1/s].
    pub free: Vec<f64>,
    /// Further coefficients, which are as they are [1/s].
    pub added: Vec<f64>,
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Gives the bodies for which `own` has one the damping whose ratios hold for the system as it
    /// is joined in the pose of `y` at time `t`, undeformed; bodies that nothing holds have that of
    /// their free modes. Others keep theirs.
    ///
    /// # Errors
    /// [`DynamicsError`] if the mass matrix is not positive definite or an eigenproblem cannot be solved.
    pub fn set_held_damping(
        &mut self,
        (t, y): (f64, &[f64]),
        own: &[Option<OwnDamping>],
    ) -> Result<(), DynamicsError> {
        let is_alone: Vec<bool> = (0..own.len()).map(|i| vibrates_alone(&self.model, i)).collect();
        let held: Vec<Held<'_>> = own
            .iter()
            .enumerate()
            .filter(|(i, _)| !is_alone[*i])
            .filter_map(|(body, own)| Some(Held { body, own: own.as_ref()? }))
            .filter(|held| held.own.law.is_any())
            .collect();
        if held.is_empty() {
            return Ok(());
        }
        let mut undeformed = y[..self.model.n_states()].to_vec();
        for body in &self.model.bodies {
            undeformed[body.layout.elastic()].fill(0.0);
        }
        let structure = Structure::new(&self.model, t, &undeformed, &is_alone)?;
        let found = structure.damping(&held)?;
        for (held, mut matrix) in held.iter().zip(found) {
            held.own.added.iter().enumerate().for_each(|(j, d)| matrix[(j, j)] += d);
            self.replace_damping(held.body, ModalDamping::Full(matrix))?;
        }
        Ok(())
    }
}

/// A body that joints hold.
struct Held<'a> {
    body: usize,
    own: &'a OwnDamping,
}

/// The system as joined in a pose, with the stiffness of its modes and joint springs.
struct Structure {
    small: SmallMotion,
    /// Coordinates of the elastic motion of each body; empty of those that vibrate for themselves.
    elastic: Vec<std::ops::Range<usize>>,
}

/// Vibrations of a structure.
struct Vibrations {
    /// Angular frequencies [rad/s].
    frequencies: Vec<f64>,
    /// Columns `v = K^(1/2) z / ω`, orthonormal: their squares are the shares of the elastic energy
    /// (Eq. F.29).
    parts: Mat<f64>,
}

impl Structure {
    fn new(model: &MultibodyModel, t: f64, y: &[f64], is_alone: &[bool]) -> Result<Self, DynamicsError> {
        let mut small = SmallMotion::of_structure(model, t, y);
        let mut kept = Vec::new();
        let mut elastic = Vec::new();
        for (body, is_alone) in model.bodies.iter().zip(is_alone) {
            let start = kept.len();
            if !is_alone {
                kept.extend(body.layout.rates_elastic());
            }
            elastic.push(start..kept.len());
            kept.extend(body.layout.rates_joint());
        }
        small.keep(&kept);
        Ok(Self { small, elastic })
    }

    fn vibrations(&self, small: &SmallMotion) -> Result<Vibrations, DynamicsError> {
        let (values, modes) = Problem::new(small)?.modes()?;
        let first = values.iter().take_while(|v| **v <= 0.0).count();
        let frequencies: Vec<f64> = values[first..].iter().map(|v| v.sqrt()).collect();
        let parts = Mat::from_fn(small.n(), frequencies.len(), |i, m| {
            small.elastic[i].sqrt() * modes[(i, first + m)] / frequencies[m]
        });
        Ok(Vibrations { frequencies, parts })
    }

    /// Damping matrices of the bodies `held`.
    fn damping(&self, held: &[Held<'_>]) -> Result<Vec<Mat<f64>>, DynamicsError> {
        let all = self.vibrations(&self.small)?;
        let blocks: Vec<MatRef<'_, f64>> = held
            .iter()
            .map(|h| all.parts.as_ref().subrows(self.elastic[h.body].start, self.elastic[h.body].len()))
            .collect();
        let mut weights = Vec::with_capacity(held.len());
        for (h, part) in held.iter().zip(&blocks) {
            weights.push(self.weights(h, &all, *part)?);
        }
        let mut found = self.unreachable(held, &all);
        let shares = fitted_shares(&blocks, &weights, &found);
        for ((h, part), (weights, matrix)) in held.iter().zip(&blocks).zip(weights.iter().zip(&mut found)) {
            let scaled = Mat::from_fn(part.nrows(), part.ncols(), |i, m| {
                part[(i, m)] * (shares[m] * weights[m]).sqrt()
            });
            dense::add_product(matrix.as_mut(), 1.0, scaled.as_ref(), scaled.transpose());
            let root = |i: usize| self.small.elastic[self.elastic[h.body].start + i].sqrt();
            let whole =
                Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| root(i) * matrix[(i, j)] * root(j));
            *matrix = whole;
            dense::symmetrise(matrix);
        }
        Ok(found)
    }

    /// `2 ζ/ω` of each mode of the system by what body `held` loses, whose part of the modes is
    /// `part` (Eq. F.30).
    fn weights(
        &self,
        held: &Held<'_>,
        all: &Vibrations,
        part: MatRef<'_, f64>,
    ) -> Result<Vec<f64>, DynamicsError> {
        let OwnDamping { law, highest, .. } = held.own;
        let listed = match law {
            DampingLaw::Ratios(ratios) if ratios.iter().any(|r| r.total_cmp(&ratios[0]).is_ne()) => {
                Some(self.listed(held.body, ratios, part)?)
            }
            _ => None,
        };
        let weight = |(m, w): (usize, &f64)| {
            let ratio = listed.as_ref().map_or_else(|| law.ratio(0, *w), |listed| listed[m]);
            2.0 * if *w > *highest { ratio.min(1.0) } else { ratio } / w
        };
        Ok(all.frequencies.iter().enumerate().map(weight).collect())
    }

    /// Ratios of the modes of the system by a list for those of body `body` among bodies as rigid
    /// as they stand, each mode of the system having the mean over its elastic energy in them.
    fn listed(&self, body: usize, ratios: &[f64], part: MatRef<'_, f64>) -> Result<Vec<f64>, DynamicsError> {
        let own = self.elastic[body].clone();
        let is_other = |i: &usize| self.elastic.iter().any(|e| e.contains(i)) && !own.contains(i);
        let kept: Vec<usize> = (0..self.small.n()).filter(|i| !is_other(i)).collect();
        let first = kept.iter().take_while(|i| **i < own.start).count();
        let mut small = self.small.clone();
        small.keep(&kept);
        let Vibrations { frequencies, parts } = self.vibrations(&small)?;
        let modes = parts.as_ref().subrows(first, own.len());
        let mut number = 0;
        let of_mode: Vec<f64> = (0..frequencies.len())
            .map(|j| {
                let ratio = ratios[number.min(ratios.len() - 1)];
                number += usize::from(modes.col(j).squared_norm_l2() >= OWN);
                ratio
            })
            .collect();
        let shares = dense::product(modes.transpose(), part);
        let mean = |m: usize| {
            let (mut sum, mut whole) = (0.0, f64::MIN_POSITIVE);
            for (j, ratio) in of_mode.iter().enumerate() {
                sum += ratio * shares[(j, m)].powi(2);
                whole += shares[(j, m)].powi(2);
            }
            sum / whole
        };
        Ok((0..part.ncols()).map(mean).collect())
    }

    /// What damps the deformations that loops do not leave in this pose: the free bodies' damping
    /// (Eq. F.33), over the roots of the stiffness.
    fn unreachable(&self, held: &[Held<'_>], all: &Vibrations) -> Vec<Mat<f64>> {
        let stiff: Vec<usize> = (0..self.small.n()).filter(|i| self.small.elastic[*i] > 0.0).collect();
        let zeros = |h: &Held<'_>| Mat::zeros(self.elastic[h.body].len(), self.elastic[h.body].len());
        let mut found: Vec<Mat<f64>> = held.iter().map(zeros).collect();
        if all.frequencies.len() >= stiff.len() {
            return found;
        }
        let reached = dense::product(all.parts.as_ref(), all.parts.transpose());
        let rest = |i: usize, j: usize| f64::from(u8::from(i == j)) - reached[(i, j)];
        for (h, to) in held.iter().zip(&mut found) {
            let own = self.elastic[h.body].clone();
            for other in held {
                let place = self.elastic[other.body].clone();
                let free = |k: usize| (other.own.free[k] / self.small.elastic[place.start + k]).sqrt();
                let half = Mat::from_fn(own.len(), place.len(), |i, k| {
                    rest(own.start + i, place.start + k) * free(k)
                });
                dense::add_product(to.as_mut(), 1.0, half.as_ref(), half.transpose());
            }
        }
        found
    }
}

/// Shares `d` of the modes by which the bodies' damping, without what couples them, gives each mode
/// its ratio (Eq. F.32): multiplied by what is asked over what is found, round by round, so that
/// they stay positive. One body alone has ones.
fn fitted_shares(blocks: &[MatRef<'_, f64>], weights: &[Vec<f64>], given: &[Mat<f64>]) -> Vec<f64> {
    let n = blocks.first().map_or(0, |b| b.ncols());
    let mut coupling = Mat::<f64>::zeros(n, n);
    let (mut asked, mut constant) = (vec![0.0; n], vec![0.0; n]);
    let mut in_bodies = vec![0.0; n];
    for part in blocks {
        in_bodies.iter_mut().zip(part.col_iter()).for_each(|(e, column)| *e += column.squared_norm_l2());
    }
    for ((part, weights), given) in blocks.iter().zip(weights).zip(given) {
        let dots = dense::product(part.transpose(), *part);
        let by_given = dense::product(given.as_ref(), *part);
        for j in 0..n {
            for i in 0..n {
                coupling[(i, j)] += dots[(i, j)].powi(2) * weights[j];
            }
            asked[j] += dots[(j, j)] * weights[j];
            constant[j] += part.col(j).transpose() * by_given.col(j);
        }
    }
    // A mode that strains springs of joints, or other bodies, more than these asks for less: slow
    // motion would ask of them what high modes do not bear.
    let part = |i: usize| (in_bodies[i] / OWN).min(1.0);
    let mut shares = Mat::<f64>::from_fn(n, 1, |i, _| part(i));
    asked.iter_mut().enumerate().for_each(|(i, asked)| *asked *= part(i));
    for _ in 0..ROUNDS {
        let found = dense::product(coupling.as_ref(), shares.as_ref());
        let mut largest = 0.0_f64;
        for i in 0..n {
            let found = found[(i, 0)] + constant[i];
            if found > 0.0 && asked[i] > 0.0 {
                largest = largest.max((found / asked[i] - 1.0).abs());
                shares[(i, 0)] *= asked[i] / found;
            }
        }
        if largest < FITTED {
            break;
        }
    }
    (0..n).map(|i| shares[(i, 0)]).collect()
}
