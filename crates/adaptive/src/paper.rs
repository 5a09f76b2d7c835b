//! What \[A\] section 4.4 describes and a run does otherwise unless it is asked: fine models with
//! modes of their own, and the transfer of the state to them and back. Chosen by
//! [`crate::spec::TransferSpec`]; what asks for it stands in ARCHITECTURE.md. Knows bodies and
//! their fine models.

pub mod transfer;
pub mod fine_modes;
