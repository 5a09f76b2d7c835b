//! How far a system at rest is from equilibrium, and the way there: what pushes it along the vibrations about
//! its pose, force elements included (docs/theory.md Eq. M.62 to M.65).

use std::ops::DerefMut;

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef};
use nalgebra::Vector3;

use crate::error::{DynamicsError, StaticStartFault};
use crate::force::active::ActiveForce;
use crate::integration::OdeSystem;
use crate::reduction::blocks::dense;
use crate::system::multibody::Multibody;
use crate::system::tree::kinematics::{frame_velocities, split, update};
use crate::system::vibration::Problem;
use crate::system::vibration::small_motion::SmallMotion;

/// Motion of surfaces that touch, as a share of what they yield by, that the stiffness of a force element is
/// found with: differences of a force like `x^(3/2)` are then right to some 1e-5, and those of light loads stay
/// above the round-off of gaps.
const REACH: f64 = 0.02;
/// Push along a direction, as a share of all that acts on the bodies, that counts as none: round-off.
const NO_PUSH: f64 = 1e-13;
/// Skew part of the stiffness between two vibrations, over the geometric mean of their own, that steps take account of.
const SKEW: f64 = 1e-3;
/// Halvings that find how far the stiffness is raised for a motion of a given size.
const HALVINGS: usize = 60;

/// A pose at rest under all forces: for each vibration about it how stiff it is and what pushes along it.
#[derive(Debug, Clone)]
pub struct Balance {
    n_rates: usize,
    /// The coordinates that move, by their rates.
    unknown: Vec<usize>,
    /// Their mass, those that are held free to move.
    mass: Mat<f64>,
    /// Squared frequencies, rising [1/s²].
    stiffness: Vec<f64>,
    /// Skew part of the stiffness between the vibrations, as of friction; none if it is small.
    skew: Option<Mat<f64>>,
    /// Vibrations, mass-orthonormal columns in the unknown coordinates.
    vibrations: Mat<f64>,
    /// Push along each of them [N/√kg].
    push: Vec<f64>,
    /// The same along the unknown coordinates, a column.
    force: Mat<f64>,
    /// What pushed at first on the way here [N/√kg].
    first: f64,
    /// All that acts on the bodies here [N/√kg].
    acting: f64,
    /// Mass of all bodies \[kg\].
    total: f64,
}

/// What a step towards equilibrium has left of the work of what pushes along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The share that is left: 0 after a whole step, 1 if nothing resisted it, negative if it went too far.
    pub left: f64,
    /// The share that the vibrations told of.
    pub expected: f64,
}

impl Balance {
    /// What is out of balance, as a share of all forces.
    pub fn residual(&self) -> f64 {
        let push = norm(&self.push);
        if push > 0.0 { push / self.first.max(self.acting) } else { 0.0 }
    }

    /// The vibration of the lowest squared frequency [1/s²], negative if the pose is not stable, and the change of all
    /// coordinates, by their rates, in it; none if nothing moves.
    pub fn softest(&self) -> Option<(f64, Vec<f64>)> {
        let lowest = *self.stiffness.first()?;
        Some((lowest, self.by_rates([1.0])))
    }

    /// Change of all coordinates, by their rates, towards equilibrium: Newton's step, shortened by a stiffness
    /// that is raised in all directions until the root of the bodies' mean square displacement is `radius`
    /// \[m\] at most (Eq. M.64). With it, whether it was shortened.
    pub fn change(&self, radius: f64) -> (Vec<f64>, bool) {
        let raised = self.raised(radius);
        (self.by_rates(self.along(raised)), raised > 0.0)
    }

    /// The step along each vibration with its stiffness `raised`.
    fn along(&self, raised: f64) -> Vec<f64> {
        let least = NO_PUSH * self.first.max(self.acting);
        let push = |m: usize| if self.push[m].abs() > least { self.push[m] } else { 0.0 };
        let stiffness = |m: usize| self.stiffness[m].abs() + raised;
        let Some(skew) = &self.skew else {
            let along = |m: usize| if push(m) == 0.0 { 0.0 } else { push(m) / stiffness(m) };
            return (0..self.push.len()).map(along).collect();
        };
        // Directions without push and stiffness stay as they are.
        let n = self.push.len();
        let own = |m: usize| if stiffness(m) > 0.0 { stiffness(m) } else { 1.0 };
        let matrix = Mat::from_fn(n, n, |i, j| skew[(i, j)] + if i == j { own(i) } else { 0.0 });
        let solved = matrix.partial_piv_lu().solve(Mat::from_fn(n, 1, |m, _| push(m)));
        (0..n)
            .map(|m| if stiffness(m) > 0.0 || push(m) == 0.0 { solved[(m, 0)] } else { f64::INFINITY })
            .collect()
    }

    /// How far stiffness is raised for a step of `radius`.
    fn raised(&self, radius: f64) -> f64 {
        let size = |raised: f64| norm(&self.along(raised));
        let most = radius * self.total.sqrt();
        if size(0.0) <= most {
            return 0.0;
        }
        let mut raised = norm(&self.push) / most;
        let mut lower = 0.5 * raised;
        while size(lower) <= most {
            (raised, lower) = (lower, 0.5 * lower);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (lower + raised);
            if size(middle) <= most { raised = middle } else { lower = middle }
        }
        raised
    }

    /// The change of all coordinates, by their rates, of a motion by so much in each vibration.
    fn by_rates(&self, along: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut change = vec![0.0; self.n_rates];
        for (m, d) in along.into_iter().enumerate() {
            for (i, rate) in self.unknown.iter().enumerate() {
                change[*rate] += self.vibrations[(i, m)] * d;
            }
        }
        change
    }

    /// What a step by `change`, no longer than `radius`, has left of its work where the system has the `accelerations`.
    pub fn outcome(&self, (change, radius): (&[f64], f64), accelerations: &[f64]) -> Outcome {
        let work = self.work(change);
        // What raises the stiffness is left by the vibrations themselves.
        let raised = self.raised(radius) * self.with_mass(change, change);
        Outcome { left: self.with_mass(change, accelerations) / work, expected: raised / work }
    }

    /// Takes the first push of `other`, in an earlier pose, as that of the way here: what is left is a share of it.
    pub fn remember(&mut self, other: &Self) {
        self.first = other.first;
    }

    /// The same vibrations in another pose near by, where the system has its last evaluation.
    pub fn refresh<F: DerefMut<Target: ActiveForce>>(&mut self, system: &Multibody<F>) {
        self.acting = system.acting(self.total);
        self.see(&system.workspace.accelerations.rates);
    }

    /// Takes what gives the `accelerations` as the push.
    fn see(&mut self, accelerations: &[f64]) {
        self.force = dense::product(self.mass.as_ref(), self.column(accelerations).as_ref());
        let push = dense::product(self.vibrations.transpose(), self.force.as_ref());
        self.push = (0..self.stiffness.len()).map(|m| push[(m, 0)]).collect();
    }

    /// Work of the present push along `change` \[J\].
    pub fn work(&self, change: &[f64]) -> f64 {
        dense::product(self.column(change).transpose(), self.force.as_ref())[(0, 0)]
    }

    /// Root of the bodies' mean square displacement by `change` \[m\].
    pub fn displacement(&self, change: &[f64]) -> f64 {
        (self.with_mass(change, change) / self.total).max(0.0).sqrt()
    }

    /// Scalar product of two changes of the coordinates with the mass.
    fn with_mass(&self, a: &[f64], b: &[f64]) -> f64 {
        let b = dense::product(self.mass.as_ref(), self.column(b).as_ref());
        dense::product(self.column(a).transpose(), b.as_ref())[(0, 0)]
    }

    fn column(&self, all: &[f64]) -> Mat<f64> {
        Mat::from_fn(self.unknown.len(), 1, |i, _| all[self.unknown[i]])
    }
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// How far the system is from equilibrium at time `t` in the state `y`, whose elastic rates are zero.
    /// Coordinates whose rate `is_held` stay as they are and keep their velocity; those of bodies in motion
    /// are to be among them. The elastic ones of such bodies are in equilibrium when they do not accelerate
    /// beside them.
    ///
    /// # Errors
    /// [`DynamicsError::StaticStart`] if a force element refuses or has coordinates of its own, or if
    /// coordinates are held in a system with loops or gears.
    pub fn balance(&mut self, t: f64, y: &[f64], is_held: &[bool]) -> Result<Balance, DynamicsError> {
        let fail = |fault| Err(DynamicsError::StaticStart(fault));
        let (held, unknown): (Vec<usize>, Vec<usize>) =
            (0..self.model.n_rates()).partition(|rate| is_held[*rate]);
        if !held.is_empty() && self.model.has_constraints() {
            return fail(StaticStartFault::LoopClosing);
        }
        if self.forces().iter().any(|force| force.n_coordinates() > 0) {
            return fail(StaticStartFault::Vibrating);
        }
        if let Err(refusal) = self.evaluate_accelerations(t, y) {
            return fail(refusal.into());
        }
        let accelerations = self.workspace.accelerations.rates.clone();
        let pressed: Vec<usize> = (0..self.forces().len()).filter(|i| !self.forces()[*i].is_idle()).collect();
        let yielded = |i: &usize| {
            let (force, energies) = (self.forces()[*i].resultant().norm(), self.forces()[*i].energies());
            2.0 * (energies.elastic_high + energies.penalty) / force
        };
        let reach = REACH * pressed.iter().map(yielded).filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min);
        let (model, forces) = self.parts();
        let mut small = SmallMotion::loaded(model, (t, y), (&pressed, reach), forces)?;
        // What the elements found belongs to the pose again.
        if let Err(refusal) = self.evaluate_accelerations(t, y) {
            return fail(refusal.into());
        }
        let mass = free_mass(small.mass.as_ref(), &unknown, &held)?;
        small.keep(&unknown);
        small.mass.clone_from(&mass);
        let problem = Problem::new(&small)?;
        let (stiffness, vibrations) = problem.modes()?;
        let skew = problem.skew(&vibrations);
        let skew = (problem.asymmetry(&stiffness, &skew) > SKEW).then_some(skew);
        let total = self.model.bodies.iter().map(|b| b.data.mass).filter(|m| m.is_finite()).sum();
        let n_rates = self.model.n_rates();
        let (push, force, acting) = (Vec::new(), Mat::new(), self.acting(total));
        let mut balance = Balance {
            n_rates,
            unknown,
            mass,
            stiffness,
            skew,
            vibrations,
            push,
            force,
            first: 0.0,
            acting,
            total,
        };
        balance.see(&accelerations);
        balance.first = norm(&balance.push);
        Ok(balance)
    }

    /// Weight and the force elements of the last evaluation, each over the root of the mass it acts on, root of the
    /// sum of squares [N/√kg].
    fn acting(&self, total: f64) -> f64 {
        let elements = self.forces().iter().map(|force| force.resultant().norm_squared() / total);
        (elements.sum::<f64>() + total * self.model.gravity.norm_squared()).sqrt()
    }

    /// The state `y` with its coordinates moved by `change`, by their rates, and loops closed again.
    pub fn displaced(&mut self, t: f64, y: &[f64], change: &[f64]) -> Vec<f64> {
        let mut moved = y.to_vec();
        self.model.displace(&mut moved, change);
        self.project(t, &mut moved);
        moved
    }

    /// Accelerations of all coordinates at the last evaluation.
    pub fn accelerations(&self) -> &[f64] {
        &self.workspace.accelerations.rates
    }

    /// The body that moves most with a small `change` of the coordinates, by the energy of rigid motion, and how:
    /// displacement of its frame in the inertial frame \[m\], turn in its axes \[rad\].
    pub fn most_moved(
        &mut self,
        t: f64,
        y: &[f64],
        change: &[f64],
    ) -> Option<(usize, Vector3<f64>, Vector3<f64>)> {
        let mut frames = vec![[0.0; 6]; self.model.bodies.len()];
        update(&self.model, t, y, &mut self.workspace.states, &mut self.workspace.edges);
        frame_velocities(&self.model, &self.workspace.edges, change, &mut frames);
        let bodies = self.model.bodies.iter().zip(&frames).enumerate();
        let energies = bodies.map(|(i, (body, frame))| {
            let (moved, turned) = split(frame);
            let arm = body.data.second_moment.trace().sqrt();
            (i, body.data.mass * moved.norm_squared() + (arm * turned.norm()).powi(2))
        });
        let (i, _) = energies.filter(|(_, e)| *e > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (moved, turned) = split(&frames[i]);
        Some((i, self.workspace.states[i].rotation * moved, turned))
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Mass of the coordinates `unknown` with the others, `held`, free to accelerate (Eq. M.62).
fn free_mass(mass: MatRef<'_, f64>, unknown: &[usize], held: &[usize]) -> Result<Mat<f64>, DynamicsError> {
    let block = |rows: &[usize], columns: &[usize]| {
        Mat::from_fn(rows.len(), columns.len(), |i, j| mass[(rows[i], columns[j])])
    };
    let mut own = block(unknown, unknown);
    if !held.is_empty() {
        let factor = dense::cholesky(block(held, held), "mass matrix of the joints")?;
        let mut coupling = block(held, unknown);
        dense::solve_lower(factor.as_ref(), coupling.as_mut());
        dense::add_product(own.as_mut(), -1.0, coupling.transpose(), coupling.as_ref());
    }
    Ok(own)
}
