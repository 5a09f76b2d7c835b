//! Joints, what acts along their coordinates, and loads.

use ffr_dynamics::system::joints::JointKind;

use super::Place;

/// A joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the scenario.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Place on the body nearer to ground.
    pub parent: Attachment,
    /// Place on the body that hangs on the joint.
    pub child: Attachment,
    /// Rotation from the joint's axes to space with all joint coordinates at zero, unit quaternion `w x y z`. A joint turns
    /// about and moves along its `z` axis; a universal joint turns about its `x` and `y` axes.
    pub axes: [f64; 4],
    /// Whether the joint is a constraint between bodies that hang on other joints.
    pub closes_loop: bool,
    /// Coordinates at the start, in the order of the kind, a rotation as a quaternion; none for loop-closing joints.
    pub positions: Vec<f64>,
    /// Velocities at the start.
    pub velocities: Vec<f64>,
    /// What acts along the velocities, one entry each; none for loop-closing joints.
    pub coordinates: Vec<JointCoordinate>,
}

/// One side of a joint, or the place of a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Attachment {
    /// Index of the body; `None` is ground.
    pub body: Option<usize>,
    /// Where on it.
    pub at: Place,
}

/// What acts along one velocity of a joint; N and m, or N m and rad.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointCoordinate {
    /// Spring stiffness.
    pub stiffness: f64,
    /// Coordinate at which the spring is relaxed.
    pub rest: f64,
    /// Damping.
    pub damping: f64,
    /// Force of a drive.
    pub drive: Option<Curve>,
    /// Prescribed motion.
    pub motion: Option<Curve>,
}

/// A force and a moment on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Name in the scenario.
    pub name: String,
    /// Where it acts.
    pub at: Attachment,
    /// Force along x, y, z \[N\], then moment about them \[N m\].
    pub components: [Option<Curve>; 6],
    /// Whether the axes are those of the body.
    pub is_following: bool,
}

/// A quantity over time.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// `Σ_k c_k t^k`.
    Polynomial {
        /// Coefficients, the constant first.
        coefficients: Vec<f64>,
    },
    /// `offset + amplitude sin(2π f t + phase)`.
    Harmonic {
        /// Amplitude.
        amplitude: f64,
        /// Frequency \[Hz\].
        frequency: f64,
        /// Phase \[rad\].
        phase: f64,
        /// Mean value.
        offset: f64,
    },
    /// From rest to a constant rate.
    SpinUp {
        /// Final rate [1/s].
        rate: f64,
        /// Time at which it is reached \[s\].
        duration: f64,
    },
    /// Natural cubic spline through points.
    Table {
        /// Rising times, two at least \[s\].
        times: Vec<f64>,
        /// Values, one a time.
        values: Vec<f64>,
    },
}
