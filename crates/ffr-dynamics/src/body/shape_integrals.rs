//! Inertia integrals from the consistent mass matrix.
