//! Mass and stiffness of a joined system about a pose at rest (docs/theory.md Eq. M.55 to M.57, M.63).

mod loaded;

use faer::{Mat, MatRef};
use nalgebra::{Matrix6, Vector3, Vector6};

use super::dead_load::DeadLoad;
use crate::error::DynamicsError;
use crate::force::{BodyState, GeneralisedForce};
use crate::reduction::blocks::dense;
use crate::system::free_body::deformation::dot;
use crate::system::free_body::equations::RigidPart;
use crate::system::joints::TimeFunction;
use crate::system::joints::forces::joint_forces;
use crate::system::model::{MultibodyModel, TreeBody};
use crate::system::multibody::workspace::Workspace;
use crate::system::tree::kinematics::{JointKinematics, SpatialVector, frame_velocities, join, split};

/// Places and weights of differences of fourth order.
const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
/// Largest turn \[rad\] or displacement, as a share of the largest body, of the motions that
/// stiffness is found with: truncation is the fourth power, some 1e-13 of the forces per radian,
/// and round-off as much.
const MOTION: f64 = 1e-3;

/// Mobility left of a constraint, as a share of that of free bodies, below which it is redundant.
pub(super) const REDUNDANT: f64 = 1e-10;

/// Matrices of a system about a pose, in all rates of [`MultibodyModel::n_rates`]; prescribed
/// motions are held.
#[derive(Clone)]
pub(in crate::system) struct SmallMotion {
    /// Mass.
    pub mass: Mat<f64>,
    /// Modal stiffness; zero for joint coordinates.
    pub elastic: Vec<f64>,
    /// All other stiffness: weight, joint springs, loads, forces of loops. Symmetric where forces
    /// have a potential.
    pub stiffness: Mat<f64>,
    /// Accelerations with which the system leaves the pose, those of modes left out.
    pub accelerations: Vec<f64>,
    /// Rates of the loops' constraints by each rate, a row per constraint, each scaled to a free
    /// body's mobility.
    pub constraints: Mat<f64>,
    /// Motions of all bodies and inertia, for energies.
    inertia: Vec<BodyInertia>,
}

/// Motion of a system whose constraints are closed.
struct Closed {
    /// Lower Cholesky factor of the mass.
    factor: Mat<f64>,
    /// Accelerations, multiplied by the factor's transpose.
    whitened: Mat<f64>,
    /// Multipliers of the scaled constraints.
    scaled: Mat<f64>,
}

/// Inertia of one body where it is, in its axes.
#[derive(Clone)]
struct BodyInertia {
    rigid: [SpatialVector; 6],
    coupling: Vec<[f64; 6]>,
}

/// A system at rest that can be moved about, with the forces that keep it in the pose.
struct Movable {
    model: MultibodyModel,
    workspace: Workspace,
    t: f64,
    multipliers: Vec<f64>,
    dead: Vec<DeadLoad>,
    wrenches: Vec<SpatialVector>,
    modal: Vec<f64>,
}

impl SmallMotion {
    /// Of `model` at time `t` in the pose of `y`; velocities do not count.
    pub fn new(model: &MultibodyModel, t: f64, y: &[f64]) -> Result<Self, DynamicsError> {
        let (mut small, mut movable, steps) = Self::without_stiffness(model, t, y);
        let none = vec![0.0; small.n()];
        small.hold(&mut movable, y, &none)?;
        small.fill_stiffness(&mut movable, y, &steps);
        Ok(small)
    }

    /// Of the structure alone: mass, constraints, and the stiffness of modes and joint springs,
    /// which are all in [`Self::elastic`]; weight, stops and the forces of loops are left out.
    pub fn of_structure(model: &MultibodyModel, t: f64, y: &[f64]) -> Self {
        let (mut small, _, _) = Self::without_stiffness(model, t, y);
        for body in &model.bodies {
            let joint = &body.joint;
            if joint.coordinates.is_empty() {
                continue;
            }
            for (rate, k) in body.layout.rates_joint().zip(joint.free_velocities()) {
                small.elastic[rate] = joint.coordinates[k].stiffness;
            }
        }
        small
    }

    /// Keeps the coordinates `kept` alone, in their order; the others are held. Energies are not to
    /// be asked any more.
    pub fn keep(&mut self, kept: &[usize]) {
        let picked = |a: &Mat<f64>| Mat::from_fn(kept.len(), kept.len(), |i, j| a[(kept[i], kept[j])]);
        (self.mass, self.stiffness) = (picked(&self.mass), picked(&self.stiffness));
        let pick = |a: &[f64]| kept.iter().map(|i| a[*i]).collect::<Vec<_>>();
        (self.elastic, self.accelerations) = (pick(&self.elastic), pick(&self.accelerations));
        self.constraints =
            Mat::from_fn(self.constraints.nrows(), kept.len(), |k, j| self.constraints[(k, kept[j])]);
        self.inertia.clear();
    }

    /// Mass and constraints alone, with what the stiffness is found by.
    fn without_stiffness(model: &MultibodyModel, t: f64, y: &[f64]) -> (Self, Movable, Vec<f64>) {
        let mut movable = Movable::new(model, t, y);
        let mut elastic = vec![0.0; model.n_rates()];
        for body in &model.bodies {
            elastic[body.layout.rates_elastic()].copy_from_slice(&body.data.modal_stiffness);
        }
        let n = elastic.len();
        let mut small = Self {
            mass: Mat::zeros(n, n),
            stiffness: Mat::zeros(n, n),
            constraints: Mat::zeros(movable.multipliers.len(), n),
            accelerations: vec![0.0; n],
            inertia: movable.inertia(),
            elastic,
        };
        let steps = small.fill_mass(&mut movable);
        (small, movable, steps)
    }

    /// Changes of all rates that take the rates `open` of the constraints away with the least
    /// kinetic energy, by those joint coordinates alone for which `may_move` holds (Eq. M.24).
    pub fn closing_rates(
        model: &MultibodyModel,
        t: f64,
        y: &[f64],
        may_move: &[bool],
        open: &[f64],
    ) -> Result<Vec<f64>, DynamicsError> {
        let (small, movable, _) = Self::without_stiffness(model, t, y);
        let joints = model.bodies.iter().flat_map(|b| b.layout.rates_joint());
        let free: Vec<usize> = joints.filter(|&rate| may_move[rate]).collect();
        let mut change = vec![0.0; small.n()];
        if free.is_empty() {
            return Ok(change);
        }
        let loops = &movable.workspace.loops;
        let scaled = Mat::from_fn(open.len(), 1, |k, _| open[k] / loops.scale(k).sqrt());
        let none = Mat::zeros(free.len(), 1);
        let Closed { factor, mut whitened, .. } = small.closed(&free, none, scaled.as_ref())?;
        dense::solve_lower_transposed(factor.as_ref(), whitened.as_mut());
        free.iter().enumerate().for_each(|(i, rate)| change[*rate] = whitened[(i, 0)]);
        Ok(change)
    }

    /// What the forces `force` on the rates `free` do with the constraints closed, which open at
    /// the scaled rates `open` besides.
    fn closed(
        &self,
        free: &[usize],
        force: Mat<f64>,
        open: MatRef<'_, f64>,
    ) -> Result<Closed, DynamicsError> {
        let mass = Mat::from_fn(free.len(), free.len(), |i, j| self.mass[(free[i], free[j])]);
        let factor = dense::cholesky(mass, "mass matrix of the joints")?;
        let mut whitened = force;
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        let n_constraints = self.constraints.nrows();
        let mut scaled = Mat::zeros(n_constraints, 1);
        if n_constraints > 0 {
            let mut rows = Mat::from_fn(free.len(), n_constraints, |i, k| self.constraints[(k, free[i])]);
            dense::solve_lower(factor.as_ref(), rows.as_mut());
            let mobility = dense::product(rows.transpose(), rows.as_ref());
            let (values, vectors) = dense::symmetric_eigen(mobility.as_ref())?;
            let open = dense::product(rows.transpose(), whitened.as_ref()) + open;
            let mut parts = dense::product(vectors.transpose(), open.as_ref());
            for (k, value) in values.iter().enumerate() {
                parts[(k, 0)] *= if *value > REDUNDANT { -1.0 / value } else { 0.0 };
            }
            scaled = dense::product(vectors.as_ref(), parts.as_ref());
            dense::add_product(whitened.as_mut(), 1.0, rows.as_ref(), scaled.as_ref());
        }
        Ok(Closed { factor, whitened, scaled })
    }

    /// Finds the accelerations with which the bodies, as stiff as they stand, leave the pose under the
    /// forces `added` besides, and the multipliers of loops; holds the bodies by both.
    fn hold(&mut self, movable: &mut Movable, y: &[f64], added: &[f64]) -> Result<(), DynamicsError> {
        let mut force = vec![0.0; self.n()];
        movable.forces(y, &mut force);
        force.iter_mut().zip(added).for_each(|(force, added)| *force += added);
        let free: Vec<usize> = movable.model.bodies.iter().flat_map(|b| b.layout.rates_joint()).collect();
        if free.is_empty() {
            return Ok(());
        }
        let forces = Mat::from_fn(free.len(), 1, |i, _| force[free[i]]);
        let open = Mat::zeros(self.constraints.nrows(), 1);
        let Closed { factor, mut whitened, scaled } = self.closed(&free, forces, open.as_ref())?;
        for (k, multiplier) in movable.multipliers.iter_mut().enumerate() {
            *multiplier = scaled[(k, 0)] / movable.workspace.loops.scale(k).sqrt();
        }
        dense::solve_lower_transposed(factor.as_ref(), whitened.as_mut());
        free.iter().enumerate().for_each(|(i, rate)| self.accelerations[*rate] = whitened[(i, 0)]);
        movable.place(y);
        movable.hold(&self.accelerations);
        Ok(())
    }

    /// Number of coordinates.
    pub fn n(&self) -> usize {
        self.elastic.len()
    }

    /// Columns of mass and constraints; returns steps for differences along each coordinate.
    fn fill_mass(&mut self, movable: &mut Movable) -> Vec<f64> {
        let n = self.n();
        let (mut rates, mut column) = (vec![0.0; n], vec![0.0; n]);
        let mut frames = vec![[0.0; 6]; self.inertia.len()];
        let length = movable.length();
        let mut steps = Vec::with_capacity(n);
        for j in 0..n {
            rates.fill(0.0);
            rates[j] = 1.0;
            frame_velocities(&movable.model, &movable.workspace.edges, &rates, &mut frames);
            self.momenta(&movable.model, &frames, &rates, &mut movable.wrenches, &mut movable.modal);
            movable.write_coordinates(&mut column);
            column.iter().enumerate().for_each(|(i, m)| self.mass[(i, j)] = *m);
            let loops = &movable.workspace.loops;
            for k in 0..self.constraints.nrows() {
                let scale = loops.scale(k).sqrt();
                self.constraints[(k, j)] = loops.rate(&movable.model, k, &frames, &rates) / scale;
            }
            let moved = movable.largest_motion(&frames, j, length);
            // A coordinate that moves no frame and no marker changes forces in proportion: any step
            // does.
            steps.push(MOTION / moved.max(f64::MIN_POSITIVE.sqrt()).max(1e-3 / length));
        }
        steps
    }

    /// Columns of the stiffness by differences of the forces.
    fn fill_stiffness(&mut self, movable: &mut Movable, y: &[f64], steps: &[f64]) {
        let mut force = vec![0.0; self.n()];
        let mut moved = y.to_vec();
        for (j, step) in steps.iter().enumerate() {
            for (at, weight) in STENCIL {
                moved.copy_from_slice(y);
                displace(&movable.model, &mut moved, j, at * step);
                movable.forces(&moved, &mut force);
                for (i, f) in force.iter().enumerate() {
                    self.stiffness[(i, j)] -= f * weight / step;
                }
            }
        }
    }

    /// Momenta of all bodies moving with `frames` and elastic rates.
    fn momenta(
        &self,
        model: &MultibodyModel,
        frames: &[SpatialVector],
        rates: &[f64],
        rigid: &mut [SpatialVector],
        modal: &mut [f64],
    ) {
        for (i, (body, inertia)) in model.bodies.iter().zip(&self.inertia).enumerate() {
            let elastic = &rates[body.layout.rates_elastic()];
            rigid[i] = inertia.rigid.map(|row| dot(&row, &frames[i]));
            let out = &mut modal[body.layout.rates_elastic()];
            for (j, (row, rate)) in inertia.coupling.iter().zip(elastic).enumerate() {
                rigid[i].iter_mut().zip(row).for_each(|(p, c)| *p += c * rate);
                let own: f64 =
                    elastic.iter().enumerate().map(|(k, r)| body.data.modal_mass.entry(j, k) * r).sum();
                out[j] = dot(row, &frames[i]) + own;
            }
        }
    }

    /// Momenta of all bodies moving with `frames` and elastic rates, and those along the modes.
    pub fn momenta_of(
        &self,
        model: &MultibodyModel,
        frames: &[SpatialVector],
        rates: &[f64],
    ) -> (Vec<SpatialVector>, Vec<f64>) {
        let (mut rigid, mut modal) = (vec![[0.0; 6]; frames.len()], vec![0.0; rates.len()]);
        self.momenta(model, frames, rates, &mut rigid, &mut modal);
        (rigid, modal)
    }

    /// The rigid motion that carries the momenta of body `i`, `rigid` in its axes, as it stands (Eq. Q.2).
    pub fn carrying(&self, i: usize, rigid: &SpatialVector) -> SpatialVector {
        let inertia = Matrix6::from_fn(|r, c| self.inertia[i].rigid[r][c]);
        // Of plane bodies some directions have none.
        let least = f64::EPSILON * inertia.amax();
        let inverse = inertia.pseudo_inverse(least).unwrap_or_else(|_| Matrix6::zeros());
        (inverse * Vector6::from_row_slice(rigid)).into()
    }

    /// Twice the kinetic energy of each body for `rates`.
    pub fn energies(&self, model: &MultibodyModel, edges: &[JointKinematics], rates: &[f64]) -> Vec<f64> {
        let mut frames = vec![[0.0; 6]; self.inertia.len()];
        frame_velocities(model, edges, rates, &mut frames);
        let (rigid, modal) = self.momenta_of(model, &frames, rates);
        let of = |(i, body): (usize, &TreeBody)| {
            let elastic = body.layout.rates_elastic();
            dot(&rigid[i], &frames[i]) + dot(&modal[elastic.clone()], &rates[elastic])
        };
        model.bodies.iter().enumerate().map(of).collect()
    }
}

impl Movable {
    /// At time `t` in the pose of `y`, under weight alone.
    fn new(model: &MultibodyModel, t: f64, y: &[f64]) -> Self {
        let mut model = model.clone();
        for body in &mut model.bodies {
            for motion in body.joint.coordinates.iter_mut().filter_map(|c| c.motion.as_mut()) {
                *motion = TimeFunction::constant(motion.at(t)[0]);
            }
        }
        let workspace = Workspace::new(&model);
        let (wrenches, modal) = (vec![[0.0; 6]; model.bodies.len()], vec![0.0; model.n_rates()]);
        let multipliers = vec![0.0; workspace.loops.n_constraints()];
        let mut movable = Self { workspace, t, multipliers, dead: Vec::new(), wrenches, modal, model };
        movable.place(y);
        movable.hold(&vec![0.0; movable.model.n_rates()]);
        movable
    }

    /// Moves the bodies to the pose of `y`.
    fn place(&mut self, y: &[f64]) {
        let Self { model, workspace, t, .. } = self;
        workspace.place(model, *t, y);
        workspace.loops.evaluate(model, &workspace.states, &workspace.edges);
    }

    /// Takes the inertia forces of `accelerations` in the present pose, and weight, as dead loads.
    fn hold(&mut self, accelerations: &[f64]) {
        let Self { model, workspace, .. } = self;
        let mut frames = vec![[0.0; 6]; model.bodies.len()];
        frame_velocities(model, &workspace.edges, accelerations, &mut frames);
        let bodies = model.bodies.iter().zip(&workspace.states).zip(&mut frames);
        let dead = bodies.map(|((body, state), frame)| {
            let gravity = state.rotation.inverse_transform_vector(&model.gravity);
            frame.iter_mut().zip(gravity.iter()).for_each(|(a, g)| *a -= g);
            DeadLoad::new(&body.data, state, frame)
        });
        self.dead = dead.collect();
    }

    /// Inertia of the bodies where they stand.
    fn inertia(&mut self) -> Vec<BodyInertia> {
        let Workspace { bodies, states, sums, .. } = &mut self.workspace;
        let bodies = bodies.iter_mut().zip(&self.model.bodies).zip(states.iter().zip(sums.iter()));
        let inertia = bodies.map(|((workspace, body), (state, sum))| {
            let (RigidPart { inertia, .. }, _) =
                workspace.assemble((&body.data, &body.deformation), state, sum);
            let rigid = std::array::from_fn(|i: usize| std::array::from_fn(|j| inertia[i.max(j)][i.min(j)]));
            BodyInertia { rigid, coupling: workspace.elastic_part().0.to_vec() }
        });
        inertia.collect()
    }

    /// Forces along all coordinates at rest in the pose of `y`, modal stiffness left out
    /// (Eq. M.56).
    fn forces(&mut self, y: &[f64], out: &mut [f64]) {
        self.place(y);
        let Self { model, workspace, multipliers, dead, wrenches, modal, .. } = self;
        workspace.add_loads(model);
        let Workspace { states, sums, loops, .. } = workspace;
        loops.load_response(model, multipliers);
        for (i, body) in model.bodies.iter().enumerate() {
            let places = body.layout.rates_elastic();
            let elastic = &mut modal[places.clone()];
            let by_loops = &loops.response.forces[places];
            for (to, (load, by_loop)) in elastic.iter_mut().zip(sums[i].elastic.iter().zip(by_loops)) {
                *to = load + by_loop;
            }
            let load = wrench(&states[i], &sums[i]);
            let held = dead[i].apply(&states[i], elastic);
            wrenches[i] = std::array::from_fn(|r| load[r] + held[r] + loops.response.frame_forces[i][r]);
        }
        self.write_coordinates(out);
        for body in &self.model.bodies {
            let places = body.layout.rates_joint();
            let by_gears = &self.workspace.loops.response.forces[places.clone()];
            out[places].iter_mut().zip(by_gears).for_each(|(to, force)| *to += force);
        }
        for (i, body) in self.model.bodies.iter().enumerate().filter(|(_, b)| !b.joint.coordinates.is_empty())
        {
            let joint = &body.joint;
            let positions = &self.workspace.edges[i].coordinates.positions;
            let forces = joint_forces(joint.kind, &joint.coordinates, self.t, positions, &[0.0; 6]);
            let places = body.layout.rates_joint();
            for (to, k) in out[places].iter_mut().zip(joint.free_velocities()) {
                *to += forces.passive[k] + forces.drive[k];
            }
        }
    }

    /// Forces (or momenta) along the coordinates from those on frames and modes, from the leaves to
    /// ground; uses them up.
    fn write_coordinates(&mut self, out: &mut [f64]) {
        let Self { model, workspace, wrenches, modal, .. } = self;
        for &i in model.order.iter().rev() {
            let (TreeBody { joint, layout, .. }, edge) = (&model.bodies[i], &workspace.edges[i]);
            let wrench = wrenches[i];
            for (to, column) in out[layout.rates_joint()].iter_mut().zip(&edge.columns) {
                *to = dot(column, &wrench);
            }
            let to = &mut out[layout.rates_elastic()];
            to.copy_from_slice(&modal[layout.rates_elastic()]);
            to.iter_mut().zip(&edge.elastic_columns).for_each(|(to, column)| *to += dot(column, &wrench));
            if let Some(p) = joint.parent.body {
                let (force, moment) = split(&wrench);
                let (force, moment) = (edge.turn.tr_mul(&force), edge.turn.tr_mul(&moment));
                let at_marker = join(&force, &(moment + edge.lever.cross(&force)));
                let elastic = model.bodies[p].layout.rates_elastic();
                edge.add_at_parent(&at_marker, &mut wrenches[p], &mut modal[elastic]);
            }
        }
    }

    /// Size of the largest body: its radius of gyration about its frame; 1 m if all are points.
    fn length(&self) -> f64 {
        let squared = |b: &TreeBody| b.data.second_moment.trace() / b.data.mass;
        let largest = self.model.bodies.iter().map(squared).fold(0.0, f64::max).sqrt();
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// Largest turn, or displacement over `length`, of frames and markers by a unit of coordinate
    /// `j`.
    fn largest_motion(&self, frames: &[SpatialVector], j: usize, length: f64) -> f64 {
        let size = |v: &Vector3<f64>, w: &Vector3<f64>| w.norm().max(v.norm() / length);
        let frames = frames.iter().map(|vector| {
            let (v, w) = split(vector);
            size(&v, &w)
        });
        let mut largest = frames.fold(0.0, f64::max);
        let owner = self.model.bodies.iter().enumerate().find(|(_, b)| b.layout.rates_elastic().contains(&j));
        let Some((i, body)) = owner else { return largest };
        let mode = j - body.layout.rates_elastic().start;
        let sites = self.model.loops.iter().flat_map(|l| [&l.parent, &l.child]);
        let sites = sites.filter(|site| site.body == Some(i)).map(|site| &site.marker);
        let loads = self.model.loads.iter().filter(|load| load.body == i).map(|load| &load.marker);
        let children = self.model.bodies.iter().map(|b| &b.joint.parent).filter(|p| p.body == Some(i));
        let own = [&body.joint.child].into_iter().chain(children.map(|site| &site.marker));
        for marker in sites.chain(loads).chain(own).filter(|m| m.n_modes() > 0) {
            let column = |row: fn(&crate::kinematics::Marker, usize) -> &[f64]| {
                Vector3::from_fn(|c, _| row(marker, c)[mode])
            };
            let moved = column(crate::kinematics::Marker::displacement_row);
            largest = largest.max(size(&moved, &column(crate::kinematics::Marker::rotation_row)));
        }
        largest
    }
}

/// A force in the axes of the body.
pub(super) fn wrench(state: &BodyState, sum: &GeneralisedForce) -> SpatialVector {
    join(&state.rotation.inverse_transform_vector(&sum.force), &sum.torque_in_body)
}

/// Moves coordinate `j` of the state `y`.
fn displace(model: &MultibodyModel, y: &mut [f64], j: usize, by: f64) {
    let mut change = vec![0.0; model.n_rates()];
    change[j] = by;
    model.displace(y, &change);
}
