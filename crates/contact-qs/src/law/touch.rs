//! The force of two smooth bodies that touch at a point or, as plane models, along a line (docs/theory.md Eqs. C.82, C.104).

use std::f64::consts::PI;

use super::{HertzEllipse, LineLaw, Solid};

/// Force as a function of the approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TouchLaw {
    /// At a point, over an ellipse.
    Point(HertzEllipse),
    /// Along a line, over a strip as wide as the models are thick.
    Line(LineLaw),
}

impl TouchLaw {
    /// Force at `approach` \[N\], the energy stored by then \[J\] and the slope of the force [N/m]; `approach` is not
    /// negative \[m\].
    pub fn at(&self, approach: f64) -> (f64, f64, f64) {
        match self {
            Self::Point(law) => {
                let rise = law.stiffness() * approach.sqrt();
                (rise * approach, 0.4 * rise * approach * approach, 1.5 * rise)
            }
            Self::Line(law) => law.at(approach),
        }
    }

    /// Semi-axes of the contact under the force `force`, larger first \[m\]; none along a line, where the
    /// bodies end.
    pub fn semi_axes(&self, force: f64) -> [f64; 2] {
        match self {
            Self::Point(law) => law.semi_axes(force),
            Self::Line(law) => [0.0, law.half_width(force)],
        }
    }

    /// Area of the contact under the force `force` \[m²\].
    pub fn area(&self, force: f64) -> f64 {
        match self {
            Self::Point(law) => law.semi_axes(force).iter().product::<f64>() * PI,
            Self::Line(law) => law.area(force),
        }
    }

    /// Mean square of the distance from the middle at which the pressure acts, over that of the rim (Eqs. C.83,
    /// C.106).
    pub fn mean_square(&self) -> f64 {
        match self {
            Self::Point(_) => 0.2,
            Self::Line(_) => 0.25,
        }
    }

    /// Tangential stiffness over the normal one along the larger and the smaller axis, without
    /// slip, of partners of `solids` (Eq. C.86); half planes yield alike in both directions.
    pub fn tangential_ratios(&self, solids: &[Solid; 2]) -> [f64; 2] {
        match self {
            Self::Point(law) => law.tangential_ratios(solids),
            Self::Line(_) => [1.0; 2],
        }
    }
}
