//! Small differential equations for tests of the integrators, and measures of their solutions.

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::integration::{KinematicBlock, OdeSystem, Oscillator, Oscillators};

pub fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Slope of `log error` over `log step`, least squares.
pub fn slope(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (x, y): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(h, e)| (h.ln(), e.ln())).unzip();
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(a, b)| (a - mx) * (b - my)).sum();
    covariance / x.iter().map(|a| (a - mx).powi(2)).sum::<f64>()
}

/// A force over time, on the oscillator of a number.
pub type Force = fn(f64, usize) -> f64;

/// Equations given by a function, with the Euclidean norm over a tolerance.
pub struct Given<F> {
    dimension: usize,
    pub tolerance: f64,
    pub blocks: Vec<KinematicBlock>,
    pub oscillators: Vec<Oscillator>,
    pub dissipated: Option<usize>,
    /// Place of the quadrature of the power supplied, and the force over time on each oscillator.
    pub supply: Option<(usize, Force)>,
    rate: F,
}

impl<F: FnMut(f64, &[f64], &mut [f64])> Given<F> {
    pub fn new(dimension: usize, tolerance: f64, rate: F) -> Self {
        let (blocks, oscillators, dissipated, supply) = Default::default();
        Self { dimension, tolerance, blocks, oscillators, dissipated, supply, rate }
    }
}

impl<F: FnMut(f64, &[f64], &mut [f64])> OdeSystem for Given<F> {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        (self.rate)(t, y, dydt);
        Ok(())
    }

    fn error_norm(&mut self, _y0: &[f64], _y1: &[f64], error: &[f64]) -> f64 {
        norm(error) / self.tolerance
    }

    fn oscillators(&self) -> Oscillators<'_> {
        Oscillators { list: &self.oscillators, dissipated: self.dissipated }
    }

    fn supply(&mut self, t: f64, _y: &[f64], forces: &mut [f64]) -> Option<usize> {
        let (place, force) = self.supply?;
        forces.iter_mut().enumerate().for_each(|(i, slot)| *slot = force(t, i));
        Some(place)
    }

    fn kinematics(&self) -> Vec<KinematicBlock> {
        self.blocks.clone()
    }
}

/// Eccentric Kepler orbit, `e = 0.3`, period 2π: smooth, nonlinear, closed form at full periods, two invariants.
pub const ECCENTRICITY: f64 = 0.3;
pub const PERIHELION: [f64; 4] = [1.0 - ECCENTRICITY, 0.0, 0.0, 1.362_770_287_738_494_3]; // sqrt((1 + e) / (1 - e))

pub fn kepler_rate(_t: f64, y: &[f64], dydt: &mut [f64]) {
    let cubed = (y[0] * y[0] + y[1] * y[1]).powf(1.5);
    dydt.copy_from_slice(&[y[2], y[3], -y[0] / cubed, -y[1] / cubed]);
}
