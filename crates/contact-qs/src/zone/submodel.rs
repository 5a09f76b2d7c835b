//! A body's contact zone as dense data: points, areas, low-frequency shapes and compliance.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;

use crate::ContactError;
use crate::quasistatic::compliance::ZoneCompliance;
use crate::quasistatic::compliance::sparse_rows::SparseRows;

/// Everything that contact needs from a reduced body.
///
/// Rows of `low` and those of the points' compliance are ordered
/// `n_components * point + component`, in the components of the body model (`motion.direction(c)`
/// gives each one's direction in space).
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
    /// Quasistatic compliance `N_b G N_bᵀ` of the points [m/N].
    pub compliance: ZoneCompliance,
    /// Shape functions `N_b` of the points in terms of the interface degrees of freedom, in the
    /// order of `G`; without rows when all modes are dynamic.
    pub interface: SparseRows,
    /// Indices of the points that stand on the rim of the contact zone: contact there means that
    /// the zone is too small.
    pub rim: Vec<usize>,
    /// Outward normals of the faces that the points belong to, in the body's frame, for points that
    /// only surfaces can press that their faces are turned to (Eq. C.59); empty if every surface
    /// can press every point.
    pub facing: Vec<[f64; 3]>,
    /// Compliance of what the bodies' elements leave out of the indentation at each point, in series with its spring; empty if nothing
    /// (Eq. C.101) [m/N].
    pub left_out: Vec<f64>,
}

/// Cosine of the angle between the normal of a point's face and the opposite of the surface's
/// normal above which they are turned to each other: faces at less than 84 degrees. At an edge of
/// 90 degrees one of the two faces at least is always turned by less than 45.
const TURNED_TO: f64 = 0.1;

/// Whether a face with the outward unit normal `facing` is turned to a surface with the outward
/// normal `normal` (Eq. C.59).
pub(crate) fn is_turned_to(facing: &[f64; 3], normal: &[f64; 3]) -> bool {
    -(facing[0] * normal[0] + facing[1] * normal[1] + facing[2] * normal[2]) > TURNED_TO
}

impl ContactSubmodel {
    /// What is left out of the indentation at point `i` [m/N].
    pub fn left_out_at(&self, i: usize) -> f64 {
        self.left_out.get(i).copied().unwrap_or_default()
    }

    /// Number of contact points.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Whether the zone has a quasistatic compliance.
    pub fn is_quasistatic(&self) -> bool {
        self.compliance.is_some()
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
    /// [`ContactError::Data`] with what does not fit.
    pub fn validate(&self) -> Result<(), ContactError> {
        let n = self.n_points();
        let n_rows = n * self.motion.n_components();
        let count = |what: &str, found: usize, expected: usize| {
            let what = what.to_owned();
            if found == expected { Ok(()) } else { Err(DataError::Count { what, found, expected }) }
        };
        if n == 0 {
            return Err(ContactError::Nothing { what: "there is no contact point" });
        }
        count("areas of the contact points", self.areas.len(), n)?;
        count("rows of shapes at the contact points", self.low.nrows(), n_rows)?;
        if self.is_quasistatic() {
            self.compliance.check(&self.interface, n_rows)?;
        }
        if self.interface.n_rows() != 0 {
            count("rows of interface functions", self.interface.n_rows(), n_rows)?;
        }
        if !self.facing.is_empty() {
            count("normals of the contact points", self.facing.len(), n)?;
        }
        if let Some(i) = (0..n).find(|&i| !(self.areas[i] > 0.0 && self.areas[i].is_finite())) {
            let what = format!("the area of contact point {i} [m^2]");
            return Err(DataError::OutOfRange { what, value: self.areas[i], range: "> 0" }.into());
        }
        if let Some(&number) = self.rim.iter().find(|&&i| i >= n) {
            return Err(DataError::Index { what: "points of the rim".into(), number, count: n }.into());
        }
        if self.points.iter().flatten().any(|x| !x.is_finite()) || !self.low.norm_max().is_finite() {
            return Err(DataError::NotFinite { what: "a contact point or a shape there".into() }.into());
        }
        Ok(())
    }
}
