//! Impacts of two runs against each other.

use adaptive::run::recording::Recording;

/// What a user may count on: peaks, durations and rebounds.
pub const LIMIT: f64 = 1e-2;

/// Asserts that the impacts of two runs have the same peaks, durations, impulses and rebounds; prints the changes.
pub fn assert_same(what: &str, a: &Recording, b: &Recording) {
    assert_eq!(a.impacts.len(), b.impacts.len(), "{what}");
    for (i, (a, b)) in a.impacts.iter().zip(&b.impacts).enumerate() {
        let pairs = [
            ("peak", a.peak_force, b.peak_force),
            ("duration", a.end - a.start, b.end - b.start),
            ("impulse", a.impulse, b.impulse),
            ("rebound", a.separation_velocity, b.separation_velocity),
        ];
        for (name, x, y) in pairs {
            println!("{what}, impact {i}: {name} {x:.5e}, {y:.5e}, {:+.2} %", 100.0 * (x / y - 1.0));
            assert!((x / y - 1.0).abs() < LIMIT, "{what}, impact {i}: {name} {x:e} and {y:e}");
        }
    }
}
