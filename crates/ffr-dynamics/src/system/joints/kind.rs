//! Relative motion of two markers (docs/theory.md Eq. M.12, M.13).
//!
//! Axes are those of the markers: a hinge turns about `z`, a slider moves along `z`, a plane has
//! the normal `z`. At zero coordinates the markers coincide. Coordinates are displacements along
//! the parent's axes, then rotations.

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

use crate::body::RigidMotion;
use crate::rotation::{quaternion_rate, rotation_from_slice};

/// Kind of a joint. Coordinates in the order given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// No relative motion.
    Fixed,
    /// Angle about `z`.
    Revolute,
    /// Displacement along `z`.
    Prismatic,
    /// Displacement along `z` and angle about it.
    Cylindrical,
    /// Angle about the parent's `x`, then angle about the child's `y`.
    Universal,
    /// Quaternion `w x y z` from the child to the parent; velocities: angular velocity in the
    /// child's frame.
    Spherical,
    /// Displacements along `x` and `y`, angle about `z`.
    Planar,
    /// Displacement in the parent's frame and quaternion; velocities: rates of the displacement,
    /// angular velocity in the child's frame.
    Free,
    /// Displacement along `z`, for axisymmetric bodies.
    Axial,
    /// Displacements along some of the parent's axes and rotations about some: of one about that
    /// axis, of two about the first axis of the parent, then about the second of the child, of
    /// three by a quaternion.
    Generic(FreeDirections),
}

/// The directions in which a joint lets its child move: displacements along `x`, `y`, `z` of the
/// parent's marker, rotations about them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FreeDirections(pub [bool; 6]);

impl FreeDirections {
    /// Names of the directions, displacements first.
    pub const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

    const fn of(directions: &[usize]) -> Self {
        let mut free = [false; 6];
        let mut i = 0;
        while i < directions.len() {
            free[directions[i]] = true;
            i += 1;
        }
        Self(free)
    }

    /// Axes of the free displacements.
    fn displacements(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |&axis| self.0[axis])
    }

    /// Axes of the free rotations.
    fn rotations(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |&axis| self.0[3 + axis])
    }
}

/// One velocity of a joint: a translation, a rotation, or both.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointColumn {
    /// Velocity of the child marker [m/s per unit].
    pub translation: Vector3<f64>,
    /// Angular velocity of the child marker's frame [rad/s per unit].
    pub rotation: Vector3<f64>,
}

/// Pose and motion of the child marker relative to the parent marker, in the parent marker's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointMotion {
    /// Displacement of the child marker \[m\].
    pub displacement: Vector3<f64>,
    /// Rotation from the child marker's frame to the parent marker's frame.
    pub rotation: UnitQuaternion<f64>,
    /// What each velocity does; as many as the joint has.
    pub columns: [JointColumn; 6],
    /// Relative velocity [m/s].
    pub velocity: Vector3<f64>,
    /// Relative angular velocity [rad/s].
    pub angular_velocity: Vector3<f64>,
    /// Rate of the angular velocity when all velocities are constant [rad/s²]; that of the velocity
    /// is zero.
    pub bias: Vector3<f64>,
}

impl JointKind {
    /// Name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Prismatic => "prismatic",
            Self::Cylindrical => "cylindrical",
            Self::Universal => "universal",
            Self::Spherical => "spherical",
            Self::Planar => "planar",
            Self::Free => "free",
            Self::Axial => "axial",
            Self::Generic(_) => "generic",
        }
    }

    /// The joint that lets a body with `motion` move as it can.
    pub fn freest(motion: RigidMotion) -> Self {
        match motion {
            RigidMotion::Spatial => Self::Free,
            RigidMotion::Planar => Self::Planar,
            RigidMotion::Axial => Self::Axial,
        }
    }

    /// Directions in which the child may move.
    pub fn free_directions(self) -> FreeDirections {
        match self {
            Self::Fixed => const { FreeDirections::of(&[]) },
            Self::Revolute => const { FreeDirections::of(&[5]) },
            Self::Prismatic | Self::Axial => const { FreeDirections::of(&[2]) },
            Self::Cylindrical => const { FreeDirections::of(&[2, 5]) },
            Self::Universal => const { FreeDirections::of(&[3, 4]) },
            Self::Spherical => const { FreeDirections::of(&[3, 4, 5]) },
            Self::Planar => const { FreeDirections::of(&[0, 1, 5]) },
            Self::Free => const { FreeDirections::of(&[0, 1, 2, 3, 4, 5]) },
            Self::Generic(free) => free,
        }
    }

    /// Number of velocities.
    pub fn n_velocities(self) -> usize {
        self.free_directions().0.iter().filter(|free| **free).count()
    }

    /// Number of position coordinates.
    pub fn n_positions(self) -> usize {
        self.n_velocities() + usize::from(self.quaternion().is_some())
    }

    /// Number of displacements among the coordinates; they come first.
    fn n_displacements(self) -> usize {
        self.free_directions().displacements().count()
    }

    /// Index of the quaternion among the position coordinates, and of the angular velocity among
    /// the velocities.
    pub fn quaternion(self) -> Option<usize> {
        (self.free_directions().rotations().count() == 3).then(|| self.n_displacements())
    }

    /// Whether velocity `k` is an angular one.
    pub fn is_angle(self, k: usize) -> bool {
        (self.n_displacements()..self.n_velocities()).contains(&k)
    }

    /// Directions in which the joint holds the child marker: displacements along the parent's axes.
    pub fn held_directions(self) -> &'static [usize] {
        let [x, y, z, ..] = self.free_directions().0;
        match (x, y, z) {
            (false, false, false) => &[0, 1, 2],
            (true, false, false) => &[1, 2],
            (false, true, false) => &[0, 2],
            (false, false, true) => &[0, 1],
            (true, true, false) => &[2],
            (true, false, true) => &[1],
            (false, true, true) => &[0],
            (true, true, true) => &[],
        }
    }

    /// Pairs of axes (parent's, child's) that the joint keeps perpendicular.
    pub fn perpendicular_axes(self) -> &'static [(usize, usize)] {
        let [_, _, _, x, y, z] = self.free_directions().0;
        match (x, y, z) {
            (false, false, false) => &[(0, 1), (1, 2), (2, 0)],
            (true, false, false) => &[(1, 0), (2, 0)],
            (false, true, false) => &[(2, 1), (0, 1)],
            (false, false, true) => &[(0, 2), (1, 2)],
            (true, true, false) => &[(0, 1)],
            (true, false, true) => &[(0, 2)],
            (false, true, true) => &[(1, 2)],
            (true, true, true) => &[],
        }
    }

    /// Position coordinates where the markers coincide.
    pub fn zero(self) -> [f64; 7] {
        let mut positions = [0.0; 7];
        if let Some(w) = self.quaternion() {
            positions[w] = 1.0;
        }
        positions
    }

    /// Relative motion at `positions` and `velocities` (Eq. M.12).
    ///
    /// # Panics
    /// If there are fewer numbers than the joint has coordinates.
    pub fn motion(self, positions: &[f64], velocities: &[f64]) -> JointMotion {
        let mut motion = JointMotion {
            displacement: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            columns: [JointColumn::default(); 6],
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            bias: Vector3::zeros(),
        };
        let free = self.free_directions();
        let mut k = 0;
        for axis in free.displacements() {
            motion.slide(k, Vector3::ith(axis, 1.0), positions[k]);
            k += 1;
        }
        if self.quaternion().is_some() {
            motion.swivel(k, &positions[k..k + 4]);
        } else {
            // Two at most: three are a quaternion.
            let mut first: Option<(Vector3<f64>, f64)> = None;
            for axis in free.rotations() {
                let along = motion.rotation * Vector3::ith(axis, 1.0);
                motion.turn(k, axis, along, positions[k]);
                if let Some((before, rate)) = first {
                    motion.bias = before.cross(&along) * (rate * velocities[k]);
                }
                first = Some((along, velocities[k]));
                k += 1;
            }
        }
        for (column, u) in motion.columns.iter().zip(velocities).take(self.n_velocities()) {
            motion.velocity += column.translation * *u;
            motion.angular_velocity += column.rotation * *u;
        }
        motion
    }

    /// Rates of the position coordinates (Eq. M.13).
    ///
    /// # Panics
    /// If the slices do not have the joint's numbers of coordinates.
    pub fn position_rates(self, positions: &[f64], velocities: &[f64], rates: &mut [f64]) {
        match self.quaternion() {
            None => rates.copy_from_slice(velocities),
            Some(w) => {
                rates[..w].copy_from_slice(&velocities[..w]);
                let spin = Vector3::from_column_slice(&velocities[w..w + 3]);
                quaternion_rate(&positions[w..w + 4], &spin, &mut rates[w..w + 4]);
            }
        }
    }

    /// Moves position coordinates by a small `change`, which counts like velocities over a unit of
    /// time.
    pub fn displace(self, positions: &mut [f64], change: &[f64]) {
        let n_plain = self.quaternion().unwrap_or(positions.len());
        for (p, c) in positions[..n_plain].iter_mut().zip(change) {
            *p += c;
        }
        if let Some(w) = self.quaternion() {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from_column_slice(&change[w..w + 3]));
            let q = &mut positions[w..w + 4];
            let moved = Quaternion::new(q[0], q[1], q[2], q[3]) * turn.into_inner();
            q.copy_from_slice(&[moved.w, moved.i, moved.j, moved.k]);
        }
    }
}

impl JointMotion {
    fn slide(&mut self, k: usize, axis: Vector3<f64>, distance: f64) {
        self.displacement += axis * distance;
        self.columns[k].translation = axis;
    }

    /// Turns the child about its present axis number `axis`, which points `along` in the parent
    /// marker's frame.
    fn turn(&mut self, k: usize, axis: usize, along: Vector3<f64>, angle: f64) {
        self.rotation *=
            UnitQuaternion::from_axis_angle(&Unit::new_unchecked(Vector3::ith(axis, 1.0)), angle);
        self.columns[k].rotation = along;
    }

    fn swivel(&mut self, k: usize, quaternion: &[f64]) {
        self.rotation = rotation_from_slice(quaternion);
        let matrix = self.rotation.to_rotation_matrix();
        for c in 0..3 {
            self.columns[k + c].rotation = matrix.matrix().column(c).into_owned();
        }
    }
}

/// A joint's motion in other axes than those of the parent's marker.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct JointPoint {
    /// Displacement of the child marker \[m\].
    pub displacement: Vector3<f64>,
    /// What each velocity does.
    pub columns: [JointColumn; 6],
    /// Relative velocity [m/s].
    pub velocity: Vector3<f64>,
    /// Relative angular velocity [rad/s].
    pub angular_velocity: Vector3<f64>,
    /// Rate of the angular velocity when all velocities are constant [rad/s²].
    pub bias: Vector3<f64>,
}

impl JointPoint {
    /// The motion of a joint with `n` velocities in the axes into which `rotation` turns the parent
    /// marker's axes.
    pub(crate) fn new(motion: &JointMotion, rotation: &UnitQuaternion<f64>, n: usize) -> Self {
        let matrix = rotation.to_rotation_matrix();
        let mut columns = [JointColumn::default(); 6];
        for (column, local) in columns.iter_mut().zip(&motion.columns).take(n) {
            column.translation = matrix * local.translation;
            column.rotation = matrix * local.rotation;
        }
        Self {
            displacement: matrix * motion.displacement,
            columns,
            velocity: matrix * motion.velocity,
            angular_velocity: matrix * motion.angular_velocity,
            bias: matrix * motion.bias,
        }
    }
}
