//! Residual flexibility of the contact interface, by two routes.
