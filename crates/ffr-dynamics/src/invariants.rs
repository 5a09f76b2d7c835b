//! Energy, momentum and angular momentum.
