//! Block Lanczos with shift-invert, checked by an inertia count.
