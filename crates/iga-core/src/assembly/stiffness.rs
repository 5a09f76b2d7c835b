//! Stiffness matrix.
