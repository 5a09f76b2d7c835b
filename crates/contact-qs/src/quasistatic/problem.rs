//! The strictly convex problem for the point forces.
