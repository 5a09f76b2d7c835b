//! What is written of scenarios: one as it was read, the JSON schema and the reference page of all.

pub mod reference;
pub(super) mod resolved;
pub mod schema;
