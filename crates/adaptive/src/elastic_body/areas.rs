//! Markers with an extent: the mean motion of a part of a body, and parts that move like rigid bodies (docs/theory.md Eq. M.44, M.45;
//! docs/decisions/0016-markers-with-extent.md).

use faer::Mat;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::kinematics::MarkerWeights;
use iga_core::elasticity::Material;
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::nurbs::patch::PointBasis;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::discretised::Discretised;
use crate::error::AdaptiveError;
use crate::spec::Area;
use crate::unsupported::Unsupported;

/// Stiffness of a rigid part in units of that of an elastic body of its size: it deforms by this share less than it would.
/// The error of frequencies stays below 1e-5, and of sixteen digits of the stiffness matrix eleven are left.
const RIGIDITY: f64 = 1e5;
/// Smallest moment of a part about its centre, as a share of the largest, that defines a rotation.
const FLATNESS: f64 = 1e-12;
/// Unknowns on a rigid part beyond which the block that couples all of them is refused: 1e7 entries.
const MOST_UNKNOWNS: usize = 4500;

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
    motion: RigidMotion,
    total: f64,
    centroid: Vector3<f64>,
    /// `∫ |r|²` from the centroid.
    second: f64,
    /// From the moment of displacements about the centroid to the rotation; zero where a model does not turn.
    turns: Matrix3<f64>,
    shares: Vec<Share>,
}

impl Discretised<'_> {
    fn extent_points(&self, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError> {
        let points = extent.points(self.shape, self.space, self.model);
        let mut points =
            points.map_err(|source| AdaptiveError::Geometry { body: self.name.to_owned(), source })?;
        // Where the functions put a point, not where the search wanted it to the last digits but one: rigid motions are then followed to
        // round-off.
        let mut places = Vec::with_capacity(points.len());
        self.visit(&points, |_, functions| {
            let mut place = [0.0; 3];
            for &(number, value) in functions {
                let control_point = self.space.control_points()[number as usize];
                place.iter_mut().zip(control_point).for_each(|(sum, p)| *sum += value * p);
            }
            places.push(place);
        });
        points.iter_mut().zip(places).for_each(|(point, place)| point.point = place);
        Ok(points)
    }

    /// Calls `visit` with each point and the functions that are not zero there, each with its value.
    fn visit(&self, points: &[ExtentPoint], mut visit: impl FnMut(&ExtentPoint, &[(u32, f64)])) {
        let (mut basis, mut active, mut found) = (PointBasis::default(), Vec::new(), Vec::new());
        for point in points {
            self.space.evaluate(point.element, &point.xi, 0, &mut basis);
            self.space.active_functions(point.element, &mut active);
            found.clear();
            let values = active.iter().copied().zip(basis.values.iter().copied());
            found.extend(values.filter(|(_, value)| value.abs() > 0.0));
            visit(point, &found);
        }
    }

    fn sums(&self, points: &[ExtentPoint]) -> Result<Sums, AdaptiveError> {
        let motion = self.motion();
        let at = |p: &ExtentPoint| match motion {
            RigidMotion::Axial => Vector3::new(0.0, 0.0, p.point[1]),
            _ => motion.in_space(&p.point),
        };
        let total: f64 = points.iter().map(|p| p.weight).sum();
        let centroid = points.iter().map(|p| at(p) * p.weight).sum::<Vector3<f64>>() / total;
        // Arms are small beside positions: what the round-off of the centroid leaves of their mean would turn the part with them.
        let rest = points.iter().map(|p| (at(p) - centroid) * p.weight).sum::<Vector3<f64>>() / total;
        let arm = |p: &ExtentPoint| at(p) - centroid - rest;
        let (mut moment, mut second) = (Matrix3::zeros(), 0.0);
        for p in points {
            let r = arm(p);
            moment += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * p.weight;
            let radius = if motion == RigidMotion::Axial { p.point[0] } else { 0.0 };
            second += (r.norm_squared() + radius * radius) * p.weight;
        }
        let mut all = vec![(0.0, Vector3::zeros()); self.space.n_functions()];
        self.visit(points, |p, functions| {
            let r = arm(p);
            for &(number, value) in functions {
                let (sum, lever) = &mut all[number as usize];
                *sum += value * p.weight;
                *lever += r * (value * p.weight);
            }
        });
        let shares =
            all.into_iter().enumerate().filter(|(_, (sum, lever))| *sum != 0.0 || lever.norm() > 0.0);
        let shares = shares.map(|(n, (sum, lever))| Share { number: n as u32, mean: sum / total, lever });
        let turns = self.turns(motion, moment)?;
        Ok(Sums { motion, total, centroid, second, turns, shares: shares.collect() })
    }

    fn turns(&self, motion: RigidMotion, moment: Matrix3<f64>) -> Result<Matrix3<f64>, AdaptiveError> {
        let inverse = match motion {
            RigidMotion::Axial => Some(Matrix3::zeros()),
            RigidMotion::Planar => (moment[(2, 2)] > 0.0)
                .then(|| Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1.0 / moment[(2, 2)]))),
            RigidMotion::Spatial => {
                let eigen = moment.symmetric_eigenvalues();
                (eigen.min() > FLATNESS * eigen.max()).then(|| moment.try_inverse()).flatten()
            }
        };
        inverse.ok_or_else(|| {
            let source =
                DataError::NoRotation { marker: "the points of a marker", remedy: "name a wider part" };
            AdaptiveError::Reduction { body: self.name.to_owned(), source: source.into() }
        })
    }

    /// The marker that follows the mean motion of `area`: displacement and rotation of its centre by the rigid motion nearest to
    /// the displacements of the part, every point with its area (theory Eq. M.44).
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if there is no such part, [`AdaptiveError::Reduction`] if it defines no rotation.
    pub fn mean_motion(
        &self,
        area: &Area,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        let sums = self.sums(&self.extent_points(&area.extent)?)?;
        let motion = sums.motion;
        let position = match motion {
            RigidMotion::Axial => Vector3::new(0.0, 0.0, area.centre[1]),
            _ => motion.in_space(&area.centre),
        };
        let mut entries = Vec::with_capacity(sums.shares.len() * motion.n_components());
        for share in &sums.shares {
            for c in 0..motion.n_components() {
                let Some(unknown) = self.lookup.number(share.number, c) else { continue };
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
            .map_err(|source| AdaptiveError::Reduction { body: self.name.to_owned(), source })
    }

    /// The lower triangle `stiffness` with that of the rigid parts `areas` added: `α ∫ |u - u_rigid|² dA` with the rigid motion
    /// `u_rigid` nearest to `u` (theory Eq. M.45). Rigid motions of the body stay free of forces, masses stay as they are.
    ///
    /// # Errors
    /// As [`Discretised::mean_motion`]; [`AdaptiveError::Unsupported`] for parts with thousands of unknowns.
    pub fn stiffened(
        &self,
        stiffness: SparseColMat<u32, f64>,
        areas: &[Area],
        material: &Material,
    ) -> Result<SparseColMat<u32, f64>, AdaptiveError> {
        areas.iter().try_fold(stiffness, |sum, area| {
            let (unknowns, block) = self.rigid_block(area, material)?;
            Ok(with_block(&sum, &unknowns, &block))
        })
    }

    /// Unknowns of a rigid part, rising, and the lower triangle of its stiffness.
    fn rigid_block(&self, area: &Area, material: &Material) -> Result<(Vec<usize>, Mat<f64>), AdaptiveError> {
        let points = self.extent_points(&area.extent)?;
        let sums = self.sums(&points)?;
        let motion = sums.motion;
        // Share, component and number of every unknown.
        let components = |(i, share): (usize, &Share)| {
            let number = share.number;
            (0..motion.n_components()).filter_map(move |c| Some((i, c, self.lookup.number(number, c)?)))
        };
        let mut unknowns: Vec<_> = sums.shares.iter().enumerate().flat_map(components).collect();
        unknowns.sort_unstable_by_key(|u| u.2);
        if unknowns.len() > MOST_UNKNOWNS {
            let (part, unknowns) = (area.extent.name().to_string(), unknowns.len());
            let what = Unsupported::RigidPart { part, unknowns, most: MOST_UNKNOWNS };
            return Err(AdaptiveError::unsupported_body(self.name, what));
        }
        let products = self.products(&points, &sums.shares);
        let factor = RIGIDITY * material.youngs_modulus() * self.length(&sums) / sums.total;
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
        Ok((unknowns.into_iter().map(|u| u.2).collect(), block))
    }

    /// Length of the elastic body that a rigid part is compared with: its mean diameter; the thickness of plane models, whose
    /// stiffness does not depend on sizes in the plane \[m\].
    fn length(&self, sums: &Sums) -> f64 {
        self.model.thickness().unwrap_or_else(|| 2.0 * (sums.second / sums.total).sqrt())
    }

    /// `∫ R_A R_B dA` of the functions in `shares`, lower triangle.
    fn products(&self, points: &[ExtentPoint], shares: &[Share]) -> Mat<f64> {
        let mut index = vec![u32::MAX; self.space.n_functions()];
        for (i, share) in shares.iter().enumerate() {
            index[share.number as usize] = i as u32;
        }
        let mut products = Mat::zeros(shares.len(), shares.len());
        self.visit(points, |p, functions| {
            for &(a, value) in functions {
                for &(b, other) in functions {
                    let (i, j) = (index[a as usize] as usize, index[b as usize] as usize);
                    if j <= i && i < shares.len() {
                        products[(i, j)] += p.weight * value * other;
                    }
                }
            }
        });
        products
    }
}

/// The sum of a sparse lower triangle and of the lower triangle of a block at `unknowns`, which rise.
fn with_block(
    matrix: &SparseColMat<u32, f64>,
    unknowns: &[usize],
    block: &Mat<f64>,
) -> SparseColMat<u32, f64> {
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
