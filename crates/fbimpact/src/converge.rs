//! How far a result depends on its resolution: the scenario as it is beside variants with more
//! modes, finer meshes, finer contact zones, a tighter integration and higher penalty factors.
//!
//! [`plan`] says what is varied and [`execute`] runs it in processes of this program; [`result_files::converge`] reads what came out,
//! compares, judges and shows it. `docs/is_it_right.md` is the page for users.

pub mod plan;
mod job;
pub mod execute;
pub mod sizes;
