//! A body's contact zone as dense data: points, areas, low-frequency shapes and compliance.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;

use crate::ContactError;

/// Rows with few entries: the shape functions of the points in terms of the interface freedoms, `N_b`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SparseRows {
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
    n_columns: usize,
}

impl SparseRows {
    /// No rows yet, `n_columns` columns.
    pub fn new(n_columns: usize) -> Self {
        Self { starts: vec![0], entries: Vec::new(), n_columns }
    }

    /// Adds a row of `(column, value)` pairs.
    ///
    /// # Panics
    /// If a column does not exist.
    pub fn push(&mut self, row: impl IntoIterator<Item = (usize, f64)>) {
        for (column, value) in row {
            assert!(column < self.n_columns, "column {column} of {}", self.n_columns);
            self.entries.push((column, value));
        }
        self.starts.push(self.entries.len());
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of columns.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Entries `(column, value)` of row `i`.
    pub fn row(&self, i: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }
}

/// Everything that contact needs from a reduced body.
///
/// Rows of `low` and rows and columns of `compliance` are ordered `n_components * point + component`, in the components of
/// the body model (`motion.direction(c)` gives each one's direction in space).
#[derive(Debug, Clone)]
pub struct ContactSubmodel {
    /// Rigid motions of the body model.
    pub motion: RigidMotion,
    /// Undeformed contact points in the body's frame, as points in space \[m\].
    pub points: Vec<[f64; 3]>,
    /// Tributary areas `w_i` \[m²\]; axisymmetric models carry `2πr`.
    pub areas: Vec<f64>,
    /// Shapes of the dynamic elastic coordinates at the points, `n_components n_points × n_q`.
    pub low: Mat<f64>,
    /// Quasistatic compliance `N_b G N_bᵀ` of the points [m/N]; zero-sized when all modes are dynamic.
    pub compliance: Mat<f64>,
    /// Shape functions `N_b` of the points in terms of the interface freedoms, in the order of `G`; without rows when
    /// all modes are dynamic.
    pub interface: SparseRows,
    /// Indices of the points that stand on the rim of the contact zone: contact there means that the zone is too small.
    pub rim: Vec<usize>,
}

impl ContactSubmodel {
    /// Number of contact points.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Whether the zone has a quasistatic compliance.
    pub fn is_quasistatic(&self) -> bool {
        self.compliance.nrows() > 0
    }

    /// Rows of `low`, one after the other.
    pub(crate) fn low_rows(&self) -> Vec<f64> {
        let (n_rows, n_q) = (self.low.nrows(), self.low.ncols());
        (0..n_rows * n_q).map(|k| self.low[(k / n_q, k % n_q)]).collect()
    }

    /// Whether each point stands on the rim.
    pub(crate) fn is_rim(&self) -> Vec<bool> {
        let mut is_rim = vec![false; self.n_points()];
        self.rim.iter().for_each(|&i| is_rim[i] = true);
        is_rim
    }

    /// Checks sizes and values.
    ///
    /// # Errors
    /// [`ContactError::Inconsistent`] with what does not fit.
    pub fn validate(&self) -> Result<(), ContactError> {
        let n = self.n_points();
        let n_rows = n * self.motion.n_components();
        let fail = |reason: String| Err(ContactError::Inconsistent { reason });
        if n == 0 {
            return fail("there is no contact point".into());
        }
        if self.areas.len() != n || self.low.nrows() != n_rows {
            return fail(format!(
                "{n} points need {n} areas and {n_rows} rows of shapes, there are {} and {}",
                self.areas.len(),
                self.low.nrows()
            ));
        }
        if self.is_quasistatic() && (self.compliance.nrows() != n_rows || self.compliance.ncols() != n_rows) {
            return fail(format!(
                "compliance is {} x {}, {n} points need {n_rows} x {n_rows}",
                self.compliance.nrows(),
                self.compliance.ncols()
            ));
        }
        if self.interface.n_rows() != 0 && self.interface.n_rows() != n_rows {
            return fail(format!("interface functions have {} rows, not {n_rows}", self.interface.n_rows()));
        }
        if let Some(i) = (0..n).find(|&i| !(self.areas[i] > 0.0 && self.areas[i].is_finite())) {
            return fail(format!("contact point {i} has an area of {:e} m^2", self.areas[i]));
        }
        if let Some(i) = self.rim.iter().find(|&&i| i >= n) {
            return fail(format!("rim point {i} of {n} points"));
        }
        if self.points.iter().flatten().any(|x| !x.is_finite())
            || !self.low.norm_max().is_finite()
            || (self.is_quasistatic() && !self.compliance.norm_max().is_finite())
        {
            return fail("a point, shape or compliance is not finite".into());
        }
        Ok(())
    }
}
