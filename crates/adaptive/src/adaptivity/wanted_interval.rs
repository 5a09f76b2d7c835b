//! A contact interval as it is asked for.

use iga_core::nurbs::Face;

/// A contact interval as it is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WantedInterval {
    /// Face that it lies on.
    pub face: Face,
    /// Parameters of its centre in the face's patch.
    pub centre: [f64; 3],
    /// Widths along the face's directions, rising; from the axis outwards where the centre lies on
    /// the axis of an axisymmetric model \[m\].
    pub widths: [f64; 2],
}
