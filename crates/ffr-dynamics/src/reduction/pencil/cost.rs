//! What a body takes to be factorised, known before it is.

use std::sync::OnceLock;
use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use tracing::warn;

use super::Pencil;
use crate::memory::{gigabytes, most};

/// Bytes of an entry of a sparse matrix with its index.
const SPARSE_ENTRY: f64 = 12.0;
/// Matrices with the pattern of the stiffness that live at the same time: stiffness, mass, their
/// sum.
const MATRICES: f64 = 3.0;
/// Dense matrices of the size of the interface that live at the same time: flexibility, compliance,
/// the contact's own.
const DENSE: f64 = 3.0;
/// Time that a model takes over that of one factorisation at the speed of a dense product:
/// assembly, a second factorisation, solves, and what sparse matrices cost beside dense ones. An
/// order of magnitude: 2.5 for a ball with its contact zone, 4 for a block of 50,000 unknowns.
const BESIDE_THE_PRODUCT: f64 = 3.5;
/// Rows of the matrices whose product measures the machine: some milliseconds, and more than its
/// caches hold close by.
const PROBE: usize = 512;
/// Work that no machine does in a minute: with less nothing is measured.
const MUCH: f64 = 1e11;
/// Time and share of the memory beyond which a user wants to know before \[s\].
const LONG: f64 = 60.0;
const LARGE: f64 = 0.5;

/// Memory and work for the factor of a body and the compliance of its interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Memory for matrices, factor and compliance \[bytes\].
    pub bytes: f64,
    /// Multiplications and additions.
    pub work: f64,
}

impl Cost {
    /// Time on this machine with `threads` threads, roughly \[s\].
    pub fn seconds(&self, threads: usize) -> f64 {
        BESIDE_THE_PRODUCT * self.work / (products_per_second() * threads as f64)
    }
}

impl Pencil<'_> {
    /// What a factor takes, with the compliance of the `n` unknowns that are eliminated last.
    pub fn cost(&self, n: usize) -> Cost {
        let (entries, n) = (self.symbolic.n_entries() as f64, n as f64);
        let matrices = MATRICES * SPARSE_ENTRY * self.body.stiffness.compute_nnz() as f64;
        Cost {
            bytes: matrices + 8.0 * (entries + DENSE * n * n),
            // The compliance of the last unknowns is the inverse of their part of the factor.
            work: self.symbolic.work() + n.powi(3),
        }
    }

    /// Tells of a factor that takes more than a minute or half of the memory, and what makes it
    /// cheaper; `n` unknowns are eliminated last.
    pub(in crate::reduction) fn tell_cost(&self, n: usize) {
        let cost = self.cost(n);
        let is_large = most().is_some_and(|most| cost.bytes > LARGE * most as f64);
        if cost.work < MUCH && !is_large {
            return;
        }
        let seconds = cost.seconds(rayon::current_num_threads());
        if seconds > LONG || is_large {
            let zone = if n > 0 { format!(", {n} of them where it may be touched") } else { String::new() };
            warn!(
                "a model of body \"{}\" has {} unknowns{zone}: it takes some {seconds:.0} s and {} GB to be built; larger elements, or a narrower \
                 contacts.NAME.interval with fewer elements, make it cheaper, and \"fbimpact check --cost\" lists all models",
                self.body.name,
                self.body.n_unknowns(),
                gigabytes(1e-9 * cost.bytes),
            );
        }
    }
}

/// Multiplications and additions of a dense product on one thread of this machine in a second, the
/// best of a few.
fn products_per_second() -> f64 {
    static RATE: OnceLock<f64> = OnceLock::new();
    *RATE.get_or_init(|| {
        let a = Mat::from_fn(PROBE, PROBE, |i, j| (i + 2 * j) as f64);
        let mut c = Mat::<f64>::zeros(PROBE, PROBE);
        let time = (0..3).map(|_| {
            let begin = Instant::now();
            matmul(c.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0, Par::Seq);
            begin.elapsed().as_secs_f64()
        });
        (PROBE as f64).powi(3) / time.fold(f64::INFINITY, f64::min).max(f64::MIN_POSITIVE)
    })
}
