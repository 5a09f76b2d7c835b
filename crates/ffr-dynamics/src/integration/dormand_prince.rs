//! Dormand-Prince 5(4) with dense output.
