//! The mean motion of a part of a body, and parts that move like rigid bodies, from quadrature
//! points on the part (docs/theory.md Eq. M.9, M.10; docs/decisions/0016-markers-with-extent.md).
//! Knows points, functions and unknowns, not what a body is made from.

use faer::Mat;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::kinematics::MarkerWeights;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Stiffness of a rigid part in units of that of an elastic body of its size: it deforms by this
/// share less than it would. The error of frequencies stays below 1e-5, and of sixteen digits of
/// the stiffness matrix eleven are left.
const RIGIDITY: f64 = 1e5;
/// Smallest moment of a part about its centre, as a share of the largest, that defines a rotation.
const FLATNESS: f64 = 1e-12;

/// Quadrature points of a part with the functions that are not zero there.
#[derive(Debug, Clone)]
pub struct PartPoints {
    motion: RigidMotion,
    n_functions: usize,
    /// Position in the model's components \[m\] and area or volume [m² or m³].
    points: Vec<([f64; 3], f64)>,
    starts: Vec<usize>,
    functions: Vec<(u32, f64)>,
}

/// Integrals of one function over a part.
#[derive(Debug, Clone, Copy)]
struct Share {
    number: u32,
    /// Mean of the function.
    mean: f64,
    /// Integral of the function times the arm from the centroid.
    lever: Vector3<f64>,
}

/// Integrals over a part.
struct Sums {
    total: f64,
    centroid: Vector3<f64>,
    /// `∫ |r|²` from the centroid.
    second: f64,
    /// From the moment of displacements about the centroid to the rotation; zero where a model does
    /// not turn.
    turns: Matrix3<f64>,
    shares: Vec<Share>,
}

impl PartPoints {
    /// A part without points of a body with `n_functions` functions.
    pub fn new(motion: RigidMotion, n_functions: usize) -> Self {
        Self { motion, n_functions, points: Vec::new(), starts: Vec::new(), functions: Vec::new() }
    }

    /// Adds a point at `place` \[m\] with the area or volume `weight` and the functions that are
    /// not zero there.
    pub fn push(&mut self, place: [f64; 3], weight: f64, functions: &[(u32, f64)]) {
        self.starts.push(self.functions.len());
        self.points.push((place, weight));
        self.functions.extend_from_slice(functions);
    }

    /// Calls `visit` with position, weight and functions of each point.
    fn visit(&self, mut visit: impl FnMut(&[f64; 3], f64, &[(u32, f64)])) {
        for (i, (point, weight)) in self.points.iter().enumerate() {
            let end = self.starts.get(i + 1).copied().unwrap_or(self.functions.len());
            visit(point, *weight, &self.functions[self.starts[i]..end]);
        }
    }

    fn sums(&self) -> Result<Sums, DataError> {
        let motion = self.motion;
        let at = |p: &[f64; 3]| match motion {
            RigidMotion::Axial => Vector3::new(0.0, 0.0, p[1]),
            _ => motion.in_space(p),
        };
        let total: f64 = self.points.iter().map(|p| p.1).sum();
        let centroid = self.points.iter().map(|(p, w)| at(p) * *w).sum::<Vector3<f64>>() / total;
        // Arms are small beside positions: what the round-off of the centroid leaves of their mean
        // would turn the part with them.
        let rest = self.points.iter().map(|(p, w)| (at(p) - centroid) * *w).sum::<Vector3<f64>>() / total;
        let arm = |p: &[f64; 3]| at(p) - centroid - rest;
        let (mut moment, mut second) = (Matrix3::zeros(), 0.0);
        for (p, w) in &self.points {
            let r = arm(p);
            moment += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * *w;
            let radius = if motion == RigidMotion::Axial { p[0] } else { 0.0 };
            second += (r.norm_squared() + radius * radius) * w;
        }
        let mut all = vec![(0.0, Vector3::zeros()); self.n_functions];
        self.visit(|p, weight, functions| {
            let r = arm(p);
            for &(number, value) in functions {
                let (sum, lever) = &mut all[number as usize];
                *sum += value * weight;
                *lever += r * (value * weight);
            }
        });
        let shares =
            all.into_iter().enumerate().filter(|(_, (sum, lever))| *sum != 0.0 || lever.norm() > 0.0);
        let shares = shares.map(|(n, (sum, lever))| Share { number: n as u32, mean: sum / total, lever });
        Ok(Sums { total, centroid, second, turns: turns(motion, moment)?, shares: shares.collect() })
    }

    /// The marker that follows the mean motion of the part: displacement and rotation of `centre`
    /// (the model's components \[m\]) by the rigid motion nearest to the displacements of the part,
    /// every point with its area (theory Eq. M.9). `number`: the unknown of a function and
    /// component, if it is free.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the part defines no rotation.
    pub fn mean_motion(
        &self,
        centre: &[f64; 3],
        rotation: UnitQuaternion<f64>,
        number: impl Fn(u32, usize) -> Option<usize>,
    ) -> Result<MarkerWeights, DynamicsError> {
        let (sums, motion) = (self.sums()?, self.motion);
        let position = match motion {
            RigidMotion::Axial => Vector3::new(0.0, 0.0, centre[1]),
            _ => motion.in_space(centre),
        };
        let mut entries = Vec::with_capacity(sums.shares.len() * motion.n_components());
        for share in &sums.shares {
            for c in 0..motion.n_components() {
                let Some(unknown) = number(share.number, c) else { continue };
                if motion == RigidMotion::Axial && c == 0 {
                    continue; // around the circumference radial displacements have no mean
                }
                let direction = Vector3::ith(motion.direction(c), 1.0);
                let turn = sums.turns * share.lever.cross(&direction);
                let moved = direction * share.mean + turn.cross(&(position - sums.centroid));
                entries.push((unknown as u32, [moved.x, moved.y, moved.z, turn.x, turn.y, turn.z]));
            }
        }
        entries.sort_unstable_by_key(|e| e.0);
        MarkerWeights::new(position, rotation, entries)
    }

    /// Unknowns of the part as a rigid one, rising, and the lower triangle of its stiffness
    /// `α ∫ |u - u_rigid|² dA` with the rigid motion `u_rigid` nearest to `u` (theory Eq. M.10).
    /// Rigid motions of the body stay free of forces, masses stay as they are. `young`: modulus
    /// \[Pa\]; `thickness` of plane models \[m\].
    ///
    /// # Errors
    /// As [`PartPoints::mean_motion`].
    pub fn rigid_block(
        &self,
        young: f64,
        thickness: Option<f64>,
        number: impl Fn(u32, usize) -> Option<usize>,
        most_unknowns: usize,
    ) -> Result<Result<RigidBlock, usize>, DynamicsError> {
        let (sums, motion) = (self.sums()?, self.motion);
        // Share, component and number of every unknown.
        let components = |(i, share): (usize, &Share)| {
            let function = share.number;
            let number = &number;
            (0..motion.n_components())
                .filter_map(move |c| Some((i, c, number(function, c)?)))
                .collect::<Vec<_>>()
        };
        let mut unknowns: Vec<_> = sums.shares.iter().enumerate().flat_map(components).collect();
        unknowns.sort_unstable_by_key(|u| u.2);
        if unknowns.len() > most_unknowns {
            return Ok(Err(unknowns.len()));
        }
        let products = self.products(&sums.shares);
        // What the part is compared with has its mean diameter; of plane models, whose stiffness
        // does not depend on sizes in the plane, the thickness.
        let length = thickness.unwrap_or_else(|| 2.0 * (sums.second / sums.total).sqrt());
        let factor = RIGIDITY * young * length / sums.total;
        let block = Mat::from_fn(unknowns.len(), unknowns.len(), |i, j| {
            if i < j {
                return 0.0;
            }
            let ((a, c, _), (b, d, _)) = (unknowns[i], unknowns[j]);
            let (own, other) = (&sums.shares[a], &sums.shares[b]);
            let mut entry = 0.0;
            if c == d {
                // Axisymmetric rings have no rigid motion outwards.
                let is_free = motion != RigidMotion::Axial || c == 1;
                let mean = if is_free { sums.total * own.mean * other.mean } else { 0.0 };
                entry += products[(a.max(b), a.min(b))] - mean;
            }
            let arm = |share: &Share, c: usize| share.lever.cross(&Vector3::ith(motion.direction(c), 1.0));
            entry -= arm(own, c).dot(&(sums.turns * arm(other, d)));
            factor * entry
        });
        Ok(Ok(RigidBlock { unknowns: unknowns.into_iter().map(|u| u.2).collect(), block }))
    }

    /// `∫ R_A R_B dA` of the functions in `shares`, lower triangle.
    fn products(&self, shares: &[Share]) -> Mat<f64> {
        let mut index = vec![u32::MAX; self.n_functions];
        for (i, share) in shares.iter().enumerate() {
            index[share.number as usize] = i as u32;
        }
        let mut products = Mat::zeros(shares.len(), shares.len());
        self.visit(|_, weight, functions| {
            for &(a, value) in functions {
                for &(b, other) in functions {
                    let (i, j) = (index[a as usize] as usize, index[b as usize] as usize);
                    if j <= i && i < shares.len() {
                        products[(i, j)] += weight * value * other;
                    }
                }
            }
        });
        products
    }
}

fn turns(motion: RigidMotion, moment: Matrix3<f64>) -> Result<Matrix3<f64>, DataError> {
    let inverse = match motion {
        RigidMotion::Axial => Some(Matrix3::zeros()),
        RigidMotion::Planar => (moment[(2, 2)] > 0.0)
            .then(|| Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1.0 / moment[(2, 2)]))),
        RigidMotion::Spatial => {
            let eigen = moment.symmetric_eigenvalues();
            (eigen.min() > FLATNESS * eigen.max()).then(|| moment.try_inverse()).flatten()
        }
    };
    inverse.ok_or(DataError::NoRotation { marker: "the points of a marker", remedy: "name a wider part" })
}

/// Stiffness of a part that moves like a rigid body.
#[derive(Debug, Clone)]
pub struct RigidBlock {
    /// Unknowns, rising.
    pub unknowns: Vec<usize>,
    /// Lower triangle [N/m].
    pub block: Mat<f64>,
}

impl RigidBlock {
    /// The sparse lower triangle `matrix` with this block added.
    pub fn added_to(&self, matrix: &SparseColMat<u32, f64>) -> SparseColMat<u32, f64> {
        let Self { unknowns, block } = self;
        let n = matrix.ncols();
        let (starts, all_rows) = (matrix.symbolic().col_ptr(), matrix.row_idx());
        let mut columns = Vec::with_capacity(n + 1);
        let (mut rows, mut values) = (Vec::with_capacity(all_rows.len()), Vec::with_capacity(all_rows.len()));
        let mut next = 0;
        columns.push(0u32);
        for j in 0..n {
            let own = starts[j] as usize..starts[j + 1] as usize;
            let added: &[usize] = if unknowns.get(next) == Some(&j) { &unknowns[next..] } else { &[] };
            let mut added =
                added.iter().enumerate().map(|(k, row)| (*row as u32, block[(next + k, next)])).peekable();
            for (row, value) in own.clone().map(|k| (all_rows[k], matrix.val()[k])) {
                while let Some((before, entry)) = added.next_if(|(r, _)| *r < row) {
                    rows.push(before);
                    values.push(entry);
                }
                let more = added.next_if(|(r, _)| *r == row).map_or(0.0, |(_, entry)| entry);
                rows.push(row);
                values.push(value + more);
            }
            for (row, entry) in added {
                rows.push(row);
                values.push(entry);
            }
            next += usize::from(unknowns.get(next) == Some(&j));
            columns.push(rows.len() as u32);
        }
        SparseColMat::new(SymbolicSparseColMat::new_checked(n, n, columns, None, rows), values)
    }
}
