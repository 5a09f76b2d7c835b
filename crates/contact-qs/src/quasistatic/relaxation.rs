//! Fixed points by relaxed iteration.

/// Iterations without a smaller change after which steps are shortened.
const IDLE: usize = 10;

/// Fixed-point iteration with Aitken's relaxation (Irons & Tuck 1969) as long as that gains; then
/// steps of half the length, and half that again (Krasnoselskii 1955), which no cycle of states
/// survives.
pub(super) struct Relaxation {
    residual: Vec<f64>,
    factor: f64,
    is_first: bool,
    /// Smallest change so far, and iterations since then.
    least: f64,
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
            n_idle: 0,
            damped: None,
        }
    }

    /// Forgets what earlier iterations showed.
    pub fn restart(&mut self) {
        (self.factor, self.is_first, self.damped) = (1.0, true, None);
        (self.least, self.n_idle) = (f64::INFINITY, 0);
    }

    /// Moves `x` towards its image `image`; whether they differ by `tolerance` at most, where `x`
    /// becomes the image.
    pub fn step(&mut self, x: &mut [f64], image: &[f64], tolerance: f64) -> bool {
        let (mut largest, mut product, mut square) = (0.0_f64, 0.0, 0.0);
        for ((old, a), b) in self.residual.iter_mut().zip(&*x).zip(image) {
            let new = b - a;
            largest = largest.max(new.abs());
            product += *old * (new - *old);
            square += (new - *old) * (new - *old);
            *old = new;
        }
        if largest <= tolerance {
            x.copy_from_slice(image);
            return true;
        }
        self.n_idle = if largest < self.least { 0 } else { self.n_idle + 1 };
        self.least = self.least.min(largest);
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
