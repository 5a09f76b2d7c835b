//! How state components move each other, and the derivatives of a right-hand side in the unknowns
//! (docs/theory.md Eq. T.20 to T.22).

/// How a group of state components changes with others. Numbers are indices into the state vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KinematicBlock {
    /// `len` positions from `position` on whose rates are the components from `velocity` on.
    Vector {
        /// First position.
        position: usize,
        /// First velocity.
        velocity: usize,
        /// Number of positions, and of velocities.
        len: usize,
    },
    /// A quaternion `w x y z` with the rate (D.1) from an angular velocity in the turning frame.
    Rotation {
        /// First of four components.
        quaternion: usize,
        /// First of three angular velocities.
        velocity: usize,
    },
    /// `len` components from `start` on whose rates depend on anything, and that move no position
    /// directly.
    Plain {
        /// First component.
        start: usize,
        /// Number of components.
        len: usize,
    },
}

impl KinematicBlock {
    /// First unknown and number of unknowns.
    pub(super) fn unknowns(&self) -> (usize, usize) {
        match *self {
            Self::Vector { velocity, len, .. } => (velocity, len),
            Self::Rotation { velocity, .. } => (velocity, 3),
            Self::Plain { start, len } => (start, len),
        }
    }

    /// First position and number of positions.
    pub(super) fn positions(&self) -> (usize, usize) {
        match *self {
            Self::Vector { position, len, .. } => (position, len),
            Self::Rotation { quaternion, .. } => (quaternion, 4),
            Self::Plain { start, .. } => (start, 0),
        }
    }
}

/// Derivatives of the rates of all unknowns: with respect to motion along each unknown's position,
/// and to each unknown itself.
///
/// Unknowns count in the order of the system's blocks: velocities of vectors, angular velocities,
/// plain components.
#[derive(Debug, Clone)]
pub struct Linearisation {
    n: usize,
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
    is_known: Vec<[bool; 2]>,
}

impl Linearisation {
    /// For `n` unknowns, all derivatives unknown.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            by_position: vec![0.0; n * n],
            by_velocity: vec![0.0; n * n],
            is_known: vec![[false; 2]; n],
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.n
    }

    /// Change of all rates with the position that unknown `unknown` moves, per unit; for a rotation
    /// about a body axis, per radian. To be written; what is in it is undefined.
    pub fn position_column_mut(&mut self, unknown: usize) -> &mut [f64] {
        self.is_known[unknown][0] = true;
        &mut self.by_position[unknown * self.n..(unknown + 1) * self.n]
    }

    /// Change of all rates with the unknown `unknown` itself. To be written; what is in it is
    /// undefined.
    pub fn velocity_column_mut(&mut self, unknown: usize) -> &mut [f64] {
        self.is_known[unknown][1] = true;
        &mut self.by_velocity[unknown * self.n..(unknown + 1) * self.n]
    }

    /// The column written by [`Linearisation::position_column_mut`].
    pub fn position_column(&self, unknown: usize) -> &[f64] {
        &self.by_position[unknown * self.n..(unknown + 1) * self.n]
    }

    /// The column written by [`Linearisation::velocity_column_mut`].
    pub fn velocity_column(&self, unknown: usize) -> &[f64] {
        &self.by_velocity[unknown * self.n..(unknown + 1) * self.n]
    }

    /// Whether the derivative with the position, or with the unknown itself, has been written: one
    /// entry per unknown.
    pub(super) fn is_known(&self) -> &[[bool; 2]] {
        &self.is_known
    }

    /// Forgets all columns, save that plain components have no positions.
    pub(super) fn reset(&mut self, blocks: &[KinematicBlock]) {
        self.is_known.fill([false; 2]);
        let mut first = 0;
        for block in blocks {
            let (_, len) = block.unknowns();
            if matches!(block, KinematicBlock::Plain { .. }) {
                (first..first + len).for_each(|j| self.position_column_mut(j).fill(0.0));
            }
            first += len;
        }
    }
}
