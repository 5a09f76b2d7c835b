//! Eigenfrequencies of a joined system about a pose at rest (docs/theory.md Eq. M.55 to M.59).

mod dead_load;
pub(super) mod small_motion;
pub mod held_damping;
pub mod pressed;

use std::ops::DerefMut;

use faer::{Mat, MatRef};

use super::model::MultibodyModel;
use super::multibody::Multibody;
use super::multibody::workspace::Workspace;
use super::tree::kinematics::update;
use crate::error::DynamicsError;
use crate::force::active::ActiveForce;
use crate::reduction::blocks::dense;
use small_motion::{REDUNDANT, SmallMotion};

/// Share of the stiffness other than that of the modes that differences leave undecided: a hundred
/// times their round-off.
const UNDECIDED: f64 = 1e-11;
/// Share of the highest squared frequency below which round-off of the eigenvectors shows.
const ROUND_OFF: f64 = 1e-18;
/// Part of the highest squared frequency up to which modes are computed again among themselves:
/// eigenvalues are right to round-off of the largest one, eigenvectors so much that nothing of the
/// high modes is left in the second computation.
const LOW: f64 = 1e-5;

/// Small vibrations of a system about a pose.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SystemModes {
    /// Modes with rising squared frequency: unstable ones, rigid ones, vibrations.
    pub modes: Vec<SystemMode>,
    /// Coordinates of joints and modes, prescribed ones left out.
    pub n_coordinates: usize,
    /// Independent constraints of loop-closing joints.
    pub n_constraints: usize,
    /// Acceleration with which the bodies, were they rigid, would leave the pose, root mean square
    /// over their mass [m/s²]; zero in equilibrium.
    pub acceleration: f64,
    /// Part of the stiffness without a potential, that of following loads and moments, as a share
    /// of the stiffness of the modes that it couples (Eq. M.60). It is left out.
    pub asymmetry: f64,
}

/// A mode of a system.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemMode {
    /// Squared angular eigenfrequency [rad²/s²]; zero for a rigid motion, negative for an unstable
    /// one.
    pub squared_frequency: f64,
    /// Share of each body in the kinetic energy.
    pub shares: Vec<f64>,
    /// What the dampers of bodies and joints take from the mode, `zᵀ D z` of the mass-orthonormal
    /// mode `z` (Eq. M.61) [1/s].
    pub damping: f64,
}

impl SystemMode {
    /// Eigenfrequency \[Hz\]; zero if the mode does not vibrate.
    pub fn frequency(&self) -> f64 {
        self.squared_frequency.max(0.0).sqrt() / std::f64::consts::TAU
    }

    /// Damping ratio, 1 being critical; none of a mode that does not vibrate. Between modes that
    /// dampers couple it holds to first order.
    pub fn damping_ratio(&self) -> Option<f64> {
        (self.squared_frequency > 0.0).then(|| 0.5 * self.damping / self.squared_frequency.sqrt())
    }

    /// Rate at which an unstable mode grows, `e^(rate t)` \[1/s\]; zero for others.
    pub fn growth_rate(&self) -> f64 {
        (-self.squared_frequency).max(0.0).sqrt()
    }
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Undamped vibrations about the pose of `y` at time `t`: velocities zero, prescribed motions
    /// held, force elements left out (contacts open), joint springs, drives and loads as they are,
    /// with the stiffness of weight and of the forces in loops.
    ///
    /// Where the pose is no equilibrium of joints, inertia forces hold it, fixed in space at every
    /// material point; where it is none of modes, constant forces along them do (Eq. M.56).
    ///
    /// # Errors
    /// [`DynamicsError`] if the mass matrix is not positive definite or an eigenproblem cannot be solved.
    pub fn small_vibrations(&self, t: f64, y: &[f64]) -> Result<SystemModes, DynamicsError> {
        let model = &self.model;
        if model.n_rates() == 0 {
            return Ok(SystemModes::default());
        }
        let mut still = y[..model.n_states()].to_vec();
        for body in &model.bodies {
            still[body.layout.velocities()].fill(0.0);
            still[body.layout.elastic_rates()].fill(0.0);
        }
        let small = SmallMotion::new(model, t, &still)?;
        let problem = Problem::new(&small)?;
        let (values, vectors) = problem.modes()?;
        let mut workspace = Workspace::new(model);
        update(model, t, &still, &mut workspace.states, &mut workspace.edges);
        let n = vectors.nrows();
        let mass: f64 = model.bodies.iter().map(|b| b.data.mass).sum();
        let left = small.energies(model, &workspace.edges, &small.accelerations).iter().sum::<f64>() / mass;
        let modes = values.iter().enumerate().map(|(m, value)| {
            let rates: Vec<f64> = (0..n).map(|i| vectors[(i, m)]).collect();
            let energies = small.energies(model, &workspace.edges, &rates);
            let sum: f64 = energies.iter().sum();
            SystemMode {
                squared_frequency: *value,
                shares: energies.iter().map(|e| e / sum).collect(),
                damping: power(model, &workspace, &rates),
            }
        });
        Ok(SystemModes {
            modes: modes.collect(),
            n_coordinates: n,
            n_constraints: n - values.len(),
            acceleration: if left > 0.0 { left.sqrt() } else { 0.0 },
            asymmetry: problem.asymmetry(&values, &problem.skew(&vectors)),
        })
    }
}

/// Power that dampers of bodies and joints take from the motion `rates` \[W\]. Friction and
/// bearings are not among them: they are no part of small motions.
fn power(model: &MultibodyModel, workspace: &Workspace, rates: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (body, edge) in model.bodies.iter().zip(&workspace.edges) {
        let joint = &body.joint;
        if !joint.coordinates.is_empty() {
            for (rate, k) in rates[body.layout.rates_joint()].iter().zip(joint.free_velocities()) {
                let compressed = joint.coordinates[k].stop.as_ref();
                let at_stop =
                    compressed.map_or(0.0, |stop| stop.tangent(edge.coordinates.positions[k], 0.0)[1]);
                sum += (joint.coordinates[k].damping + at_stop) * rate * rate;
            }
        }
        let elastic = &rates[body.layout.rates_elastic()];
        sum += body.data.modal_damping.apply(elastic, &mut vec![0.0; elastic.len()]);
    }
    sum
}

/// The eigenproblem in coordinates in which the mass matrix is the identity and the constraints
/// hold.
pub(super) struct Problem<'a> {
    small: &'a SmallMotion,
    /// Symmetric part of the stiffness other than that of modes.
    stiffness: Mat<f64>,
    /// Squared frequency below which a mode counts as rigid, without the part of the modal
    /// stiffness.
    undecided: f64,
    /// Lower Cholesky factor of the mass matrix.
    factor: Mat<f64>,
    /// Motions that the constraints leave, orthonormal in whitened coordinates.
    free: Mat<f64>,
}

impl<'a> Problem<'a> {
    pub fn new(small: &'a SmallMotion) -> Result<Self, DynamicsError> {
        let mut mass = small.mass.clone();
        dense::symmetrise(&mut mass);
        let factor = dense::cholesky(mass, "mass matrix of the system")?;
        let mut stiffness = small.stiffness.clone();
        dense::symmetrise(&mut stiffness);
        let undecided = UNDECIDED * whitened(&factor, stiffness.as_ref()).norm_l2();
        let free = free_motions(&factor, &small.constraints)?;
        Ok(Self { small, stiffness, undecided, factor, free })
    }

    /// Largest entry of the skew part of the stiffness between two of the modes, as a share of the
    /// geometric mean of their squared frequencies `values`, of the larger one if the other mode is
    /// rigid (Eq. M.60).
    ///
    /// Not of the skew matrix by the symmetric one: where forces do not depend on the pose at all,
    /// both are round-off.
    pub fn asymmetry(&self, values: &[f64], skew: &Mat<f64>) -> f64 {
        let mut largest = 0.0_f64;
        for (i, j) in (0..values.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let (a, b) = (values[i].abs(), values[j].abs());
            let stiffness = if a.min(b) > 0.0 { (a * b).sqrt() } else { a.max(b) };
            if stiffness > 0.0 {
                largest = largest.max(skew[(i, j)].abs() / stiffness);
            }
        }
        largest
    }

    /// Skew part of the stiffness between the modes `vectors`.
    pub fn skew(&self, vectors: &Mat<f64>) -> Mat<f64> {
        let product = dense::product(self.small.stiffness.as_ref(), vectors.as_ref());
        let modal = dense::product(vectors.transpose(), product.as_ref());
        Mat::from_fn(modal.nrows(), modal.ncols(), |i, j| 0.5 * (modal[(i, j)] - modal[(j, i)]))
    }

    /// Squared frequencies, rising, and modes in the system's coordinates, mass-orthonormal.
    pub fn modes(&self) -> Result<(Vec<f64>, Mat<f64>), DynamicsError> {
        let n = self.small.n();
        if self.free.ncols() == 0 {
            return Ok((Vec::new(), Mat::zeros(n, 0)));
        }
        let whole = Mat::from_fn(n, n, |i, j| {
            self.stiffness[(i, j)] + if i == j { self.small.elastic[i] } else { 0.0 }
        });
        let reduced = dense::product(whitened(&self.factor, whole.as_ref()).as_ref(), self.free.as_ref());
        let mut reduced = dense::product(self.free.transpose(), reduced.as_ref());
        dense::symmetrise(&mut reduced);
        let (mut values, vectors) = dense::symmetric_eigen(reduced.as_ref())?;
        let mut modes = dense::product(self.free.as_ref(), vectors.as_ref());
        dense::solve_lower_transposed(self.factor.as_ref(), modes.as_mut());
        let highest = values.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let mut range = 0..values.len();
        loop {
            let largest = values[range.clone()].iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            let is_low = |v: &f64| v.abs() <= LOW * largest;
            let start = values.iter().take_while(|v| !is_low(v)).count();
            let end = start + values[start..].iter().take_while(|v| is_low(v)).count();
            if start == end || (start..end) == range {
                break;
            }
            range = start..end;
            self.repeat(range.clone(), &mut values, &mut modes)?;
        }
        let limit = self.undecided + ROUND_OFF * highest;
        values.iter_mut().filter(|v| v.abs() <= limit).for_each(|v| *v = 0.0);
        Ok((values, modes))
    }

    /// Computes the modes `range` again in the space that they span, where high frequencies do not
    /// disturb them.
    fn repeat(
        &self,
        range: std::ops::Range<usize>,
        values: &mut [f64],
        modes: &mut Mat<f64>,
    ) -> Result<(), DynamicsError> {
        let low = modes.subcols(range.start, range.len()).to_owned();
        let elastic = &self.small.elastic;
        let mut stiffness = dense::product(self.stiffness.as_ref(), low.as_ref());
        for (i, j) in (0..low.nrows()).flat_map(|i| (0..low.ncols()).map(move |j| (i, j))) {
            stiffness[(i, j)] += elastic[i] * low[(i, j)];
        }
        let stiffness = dense::product(low.transpose(), stiffness.as_ref());
        let mass = dense::product(self.small.mass.as_ref(), low.as_ref());
        let mut mass = dense::product(low.transpose(), mass.as_ref());
        dense::symmetrise(&mut mass);
        let factor = dense::cholesky(mass, "mass matrix of low modes")?;
        let mut reduced = whitened(&factor, stiffness.as_ref());
        dense::symmetrise(&mut reduced);
        let (found, mut vectors) = dense::symmetric_eigen(reduced.as_ref())?;
        dense::solve_lower_transposed(factor.as_ref(), vectors.as_mut());
        let again = dense::product(low.as_ref(), vectors.as_ref());
        values[range.clone()].copy_from_slice(&found);
        modes.subcols_mut(range.start, range.len()).copy_from(&again);
        Ok(())
    }
}

/// `L⁻¹ A L⁻ᵀ`.
fn whitened(factor: &Mat<f64>, a: MatRef<'_, f64>) -> Mat<f64> {
    let mut half = a.to_owned();
    dense::solve_lower(factor.as_ref(), half.as_mut());
    let mut half = half.transpose().to_owned();
    dense::solve_lower(factor.as_ref(), half.as_mut());
    half.transpose().to_owned()
}

/// Orthonormal basis of the whitened motions that keep the constraints.
fn free_motions(factor: &Mat<f64>, constraints: &Mat<f64>) -> Result<Mat<f64>, DynamicsError> {
    let n = factor.nrows();
    if constraints.nrows() == 0 {
        return Ok(Mat::identity(n, n));
    }
    let mut rows = constraints.transpose().to_owned();
    dense::solve_lower(factor.as_ref(), rows.as_mut());
    let mobility = dense::product(rows.transpose(), rows.as_ref());
    let (values, vectors) = dense::symmetric_eigen(mobility.as_ref())?;
    let held: Vec<usize> = (0..values.len()).filter(|k| values[*k] > REDUNDANT).collect();
    let picked = Mat::from_fn(values.len(), held.len(), |i, k| vectors[(i, held[k])]);
    Ok(dense::orthogonal_complement(dense::product(rows.as_ref(), picked.as_ref()).as_ref()))
}
