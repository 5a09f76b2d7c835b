//! Gauss-Legendre quadrature.
