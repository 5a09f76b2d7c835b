//! All tests of the crate, in one executable: a file that is not named here is not run (`scripts/check_layers.py` looks).
#![expect(clippy::unwrap_used, reason = "a failure there fails the test")]

#[expect(dead_code, reason = "tests of the program use the rest")]
mod balls;
mod blocks;
mod calculix;
mod decks;
mod matrices;
mod places;
mod plane;
mod readers;
mod refined;
mod spaces;
mod stress;
mod surfaces;
mod writers;
#[path = "../../../tests/support/damage.rs"]
mod damage;
