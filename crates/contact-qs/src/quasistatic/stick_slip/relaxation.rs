//! Fixed points by relaxed iteration.

/// Iterations without a smaller change after which steps are shortened.
const IDLE: usize = 10;
/// Change, as a share of the largest number, that is round-off where it does not fall any more:
/// forces on points that are dependent but for their springs err by eps times the stiffness of these
/// against the surface, `1e3` to `1e5`.
const ROUND_OFF: f64 = 1e-10;

/// Fixed-point iteration with Aitken's relaxation (Irons & Tuck 1969) as long as that gains; then
/// steps of half the length, and half that again (Krasnoselskii 1955), which no cycle of states
/// survives.
pub(super) struct Relaxation {
    residual: Vec<f64>,
    factor: f64,
    is_first: bool,
    /// Smallest change so far, and iterations since then.
    least: f64,
    last: f64,
    n_idle: usize,
    /// Longest step, once Aitken's no longer gain.
    damped: Option<f64>,
}

impl Relaxation {
    /// For `n` numbers.
    pub fn new(n: usize) -> Self {
        Self {
            residual: vec![0.0; n],
            factor: 1.0,
            is_first: true,
            least: f64::INFINITY,
            last: f64::INFINITY,
            n_idle: 0,
            damped: None,
        }
    }

    /// Forgets what earlier iterations showed.
    pub fn restart(&mut self) {
        (self.factor, self.is_first, self.damped) = (1.0, true, None);
        (self.least, self.n_idle) = (f64::INFINITY, 0);
    }

    /// Largest change that the last iteration asked for.
    pub fn change(&self) -> f64 {
        self.last
    }

    /// Moves `x` towards its image `image`; whether they differ by `tolerance` at most, or by round-off,
    /// where `x` becomes the image.
    pub fn step(&mut self, x: &mut [f64], image: &[f64], tolerance: f64) -> bool {
        let (mut largest, mut product, mut square) = (0.0_f64, 0.0, 0.0);
        for ((old, a), b) in self.residual.iter_mut().zip(&*x).zip(image) {
            let new = b - a;
            largest = largest.max(new.abs());
            product += *old * (new - *old);
            square += (new - *old) * (new - *old);
            *old = new;
        }
        self.n_idle = if largest < self.least { 0 } else { self.n_idle + 1 };
        (self.least, self.last) = (self.least.min(largest), largest);
        let size = image.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if largest <= tolerance || (self.n_idle >= IDLE && largest <= ROUND_OFF * size) {
            x.copy_from_slice(image);
            return true;
        }
        if self.n_idle >= IDLE {
            self.damped = Some(0.5 * self.damped.unwrap_or(1.0));
            self.n_idle = 0;
        }
        if let Some(factor) = self.damped {
            self.factor = factor;
        } else if !self.is_first && square > 0.0 {
            self.factor = (-self.factor * product / square).clamp(0.1, 2.0);
        }
        self.is_first = false;
        x.iter_mut().zip(&self.residual).for_each(|(x, r)| *x += self.factor * r);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iterations_end_at_round_off() {
        // The image is off by 1e-12 to and fro, the tolerance is finer.
        let (mut relaxation, mut x) = (Relaxation::new(1), [0.0]);
        relaxation.restart();
        let mut sign = 1.0;
        let is_done = (0..60).any(|_| {
            sign = -sign;
            let image = [1.0 + 0.1 * (x[0] - 1.0) + 1e-12 * sign];
            relaxation.step(&mut x, &image, 1e-14)
        });
        assert!(is_done && (x[0] - 1.0).abs() < 1e-11, "{x:?}");
        // What still swings by more than that has not converged.
        relaxation.restart();
        assert!(!(0..60).any(|_| relaxation.step(&mut [1.0], &[1.0 + 1e-6], 1e-14)));
    }
}
