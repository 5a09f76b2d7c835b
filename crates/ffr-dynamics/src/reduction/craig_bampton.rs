//! Fixed-interface (Craig-Bampton) reduction.
