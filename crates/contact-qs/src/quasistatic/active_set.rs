//! Primal active-set solver.
