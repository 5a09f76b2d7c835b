//! Files damaged at random, for readers.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Has `check` try random bytes, the same cases every time: a failure stays one. `FBIMPACT_FUZZ=100` tries a hundred times as many,
/// others each time.
pub fn cases(n: u32, check: impl Fn(&[u8])) {
    let factor: Option<u32> = std::env::var("FBIMPACT_FUZZ").ok().and_then(|text| text.parse().ok());
    let n = n * factor.unwrap_or(1);
    let config = Config { cases: n, failure_persistence: None, max_shrink_time: 5000, ..Config::default() };
    let mut runner = match factor {
        Some(_) => TestRunner::new(config),
        None => TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha)),
    };
    let bytes = prop::collection::vec(any::<u8>(), 0..400);
    let outcome = runner.run(&bytes, |bytes| {
        check(&bytes);
        Ok(())
    });
    outcome.unwrap_or_else(|e| panic!("{e}"));
}

/// Overwrites, cuts and doubles pieces of `text` as the bytes say; `letters` are some that the format knows.
pub fn mutated(text: &[u8], bytes: &[u8], letters: &[u8]) -> Vec<u8> {
    let mut out = text.to_vec();
    let mut bytes = bytes.iter().copied().cycle();
    let mut next = move || usize::from(bytes.next().unwrap_or(0));
    for _ in 0..=next() % 6 {
        if out.is_empty() {
            break;
        }
        let (at, n) = ((next() * 256 + next()) % out.len(), next() % 24);
        let end = (at + n).min(out.len());
        match next() % 4 {
            0 => out[at..end].iter_mut().for_each(|b| *b = next() as u8),
            1 => drop(out.drain(at..end)),
            2 => {
                let piece = out[at..end].to_vec();
                let to = next() % out.len();
                out.splice(to..to, piece);
            }
            _ => out[at] = letters[next() % letters.len()],
        }
    }
    out
}
