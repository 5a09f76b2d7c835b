//! Many runs of one scenario, in processes of this program: what is varied, and how they are made.
//!
//! [`plan`] varies the resolution for `fbimpact converge`, which [`result_files::converge`] compares and judges
//! (`docs/is_it_right.md`); [`orientations`] turns a part for `fbimpact drop`. [`execute`] makes the runs, whatever they are for.

mod job;
pub mod execute;
pub mod plan;
pub mod sizes;
pub mod orientations;
