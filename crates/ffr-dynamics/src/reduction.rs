//! From thousands of unknowns to a few: eigenmodes, Craig-Bampton, interface compliance.
//!
//! Everything here works on an [`AssembledBody`](crate::body::AssembledBody) alone. A [`Pencil`]
//! holds `K`, `M` and one symbolic factorisation; [`ElasticProblem`] is the elastic part of it,
//! free or clamped; on that stand the eigensolver ([`eigen`]), modal truncation ([`modal`]),
//! Craig-Bampton ([`mod@craig_bampton`]) and the residual flexibility ([`compliance`]) with the
//! modes that it stands for ([`compliance::residual_modes`]), and the static answers to loads
//! ([`static_answers`]). Equations: docs/theory.md R.1 to R.31.

pub mod ordering;
pub mod factor;
pub mod blocks;
pub mod pencil;
pub mod rigid;
pub mod problem;
pub mod eigen;
pub mod modal;
pub mod compliance;
pub mod static_answers;
pub mod craig_bampton;

pub use compliance::residual_modes::ResidualModes;
pub use compliance::{BodyTurn, FreeFlexibility, ResidualFlexibility};
pub use craig_bampton::{CraigBampton, FixedInterfaceModes, craig_bampton};
pub use eigen::modes::{EigenModes, neighbouring_counts};
pub use eigen::neighbours::Neighbours;
pub use factor::{CholeskyFactor, SymbolicFactor};
pub use modal::{LowModes, ReducedBasis, all_modes};
pub use pencil::cost::Cost;
pub use pencil::inertia::Inertia;
pub use pencil::{Digits, Pencil};
pub use problem::ElasticProblem;
pub use rigid::{MassProperties, RigidModes};
pub use static_answers::{TakenLoads, with_static_answers};
