//! How far a result depends on its resolution: the scenario as it is beside variants with more modes, finer meshes, finer contact
//! zones, a tighter integration and higher penalty factors.
//!
//! [`plan`] says what is varied, [`execute`] runs it in processes of this program, [`outcome`] reads what came out, [`difference`]
//! compares, [`verdict`] judges and [`report`] shows it. `docs/is_it_right.md` is the page for users.

pub mod plan;
pub mod outcome;
mod motion;
mod job;
pub mod execute;
pub mod difference;
pub mod verdict;
pub mod report;
pub mod sizes;
