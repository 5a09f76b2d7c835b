//! Rigid-body modes of a discretised body.
