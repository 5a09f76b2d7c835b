//! Algorithm 1 of [A]: Newton with Broyden updates.
