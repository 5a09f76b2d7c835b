//! Standard input data of a flexible body.
