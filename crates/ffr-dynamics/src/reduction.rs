//! From thousands of unknowns to a few: eigenmodes, Craig-Bampton, interface compliance.
//!
//! Everything here works on an [`AssembledBody`](crate::body::AssembledBody) alone. A [`Pencil`]
//! holds `K`, `M` and one symbolic factorisation; [`ElasticProblem`] is the elastic part of it,
//! free or clamped; on that stand the eigensolver ([`eigen`]), modal truncation ([`modal`]),
//! Craig-Bampton ([`mod@craig_bampton`]) and the residual flexibility ([`compliance`]) with the
//! modes that it stands for ([`residual_modes`]), and the static answers to loads
//! ([`static_answers`]). Equations: docs/theory.md R.1 to R.31.

pub mod dense;
pub mod product;
pub mod ordering;
mod random;
mod separator;
mod quotient;
mod supernodes;
mod layout;
mod entry;
mod entry_positions;
mod numeric;
mod panel_solve;
mod tree_solve;
pub mod memory;
pub mod factor;
mod single_precision;
pub mod inertia;
pub mod pencil;
pub mod rigid;
pub mod problem;
mod point_support;
pub mod lanczos;
mod search;
pub mod neighbours;
pub mod eigen;
pub mod eigen_modes;
pub mod modal;
pub mod craig_bampton;
pub mod compliance;
pub mod residual_modes;
pub mod static_answers;

pub use compliance::{BodyTurn, FreeFlexibility, ResidualFlexibility};
pub use craig_bampton::{CraigBampton, FixedInterfaceModes, craig_bampton};
pub use eigen_modes::{EigenModes, neighbouring_counts};
pub use factor::{CholeskyFactor, SymbolicFactor};
pub use inertia::Inertia;
pub use modal::{LowModes, ReducedBasis, all_modes};
pub use neighbours::Neighbours;
pub use pencil::Pencil;
pub use problem::ElasticProblem;
pub use residual_modes::ResidualModes;
pub use rigid::{MassProperties, RigidModes};
pub use static_answers::{TakenLoads, with_static_answers};
