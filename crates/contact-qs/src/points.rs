//! Contact points on a surface: Greville or Gauss, with tributary areas.
