//! Boxes of parameters.

/// A box of parameters of a patch, or of a face with equal ends in the fixed direction; entries
/// beyond the dimension are ignored. In a direction with a seam it may reach beyond the ends of the
/// patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterBox {
    /// Lower corner.
    pub lower: [f64; 3],
    /// Upper corner.
    pub upper: [f64; 3],
}

impl ParameterBox {
    /// Whether `xi` lies in the box grown by `slack`, as far as the directions `directions` tell.
    pub fn contains(
        &self,
        xi: &[f64; 3],
        slack: &[f64; 3],
        mut directions: impl Iterator<Item = usize>,
    ) -> bool {
        directions.all(|d| xi[d] >= self.lower[d] - slack[d] && xi[d] <= self.upper[d] + slack[d])
    }
}
