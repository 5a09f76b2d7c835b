//! Why a joint cannot be, with the numbers.

use thiserror::Error;

/// What is wrong with a gear. Texts are fragments that read after "gear ...: ".
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GearFault {
    /// A joint that is none of the tree's.
    #[error("there is no joint \"{joint}\" with coordinates; joints that close loops have none")]
    UnknownJoint {
        /// Name of the joint.
        joint: String,
    },
    /// A coordinate that the joint does not have.
    #[error(
        "joint \"{joint}\" has no coordinate {coordinate} for a gear: a {kind} joint has {coordinates} displacements and angles, counted from 0"
    )]
    NoCoordinate {
        /// Name of the joint.
        joint: String,
        /// Its kind.
        kind: &'static str,
        /// Number of the coordinate, from 0.
        coordinate: usize,
        /// Number of coordinates; rotations about a point have none.
        coordinates: usize,
    },
    /// A ratio that is no ratio.
    #[error("ratio {ratio} must be finite and not zero")]
    Ratio {
        /// Ratio given.
        ratio: f64,
    },
    /// An offset that is none.
    #[error("offset {offset} must be finite")]
    Offset {
        /// Offset given.
        offset: f64,
    },
    /// A chain of gears that can only stand still.
    #[error(
        "ratio {given} contradicts the other gears, by which it is {found}: the chain would lock; leave one gear out or correct a ratio"
    )]
    Contradiction {
        /// Ratio given.
        given: f64,
        /// Ratio by the other gears.
        found: f64,
    },
    /// A gear of a coordinate with itself.
    #[error(
        "both sides are the same coordinate, which has no ratio to itself; name another joint or coordinate for one of them"
    )]
    Itself,
    /// A gear that follows from others.
    #[error("the other gears between these coordinates say the same already; leave one out")]
    Repeated,
    /// Two prescribed motions in one chain.
    #[error("it joins two coordinates whose motions are both prescribed; prescribe one, the other follows")]
    Prescribed,
    /// Velocities at the start that contradict the gear.
    #[error(
        "velocities given at the start slip by {rate:.3e} m/s or rad/s; leave out those that follow from others, or correct them"
    )]
    StartSpeed {
        /// Slip at the second coordinate [m/s or rad/s].
        rate: f64,
    },
    /// Coordinates that do not come together.
    #[error(
        "the coordinates stay apart by {gap:.3e} m or rad, limit 1e-11; start nearer to a position that fits"
    )]
    Apart {
        /// Largest residual [m or rad].
        gap: f64,
    },
}

/// What is wrong with a joint, its coordinates or its attachment. Texts are fragments that read
/// after "joint ...: ".
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JointFault {
    /// The marker belongs to modes that its body does not have.
    #[error("marker \"{marker}\" has {found} elastic coordinates, its body \"{body}\" {expected}")]
    MarkerModes {
        /// Name of the marker.
        marker: String,
        /// Elastic coordinates of the marker.
        found: usize,
        /// Name of the body.
        body: String,
        /// Elastic coordinates of the body.
        expected: usize,
    },
    /// Ground is the child.
    #[error("its child is ground; exchange parent and child")]
    ChildIsGround,
    /// The joint leads out of the plane of a plane model, or off the axis of an axisymmetric one.
    #[error("a {kind} joint moves in direction {direction}, which the {model} model lacks")]
    OffModel {
        /// Kind of the joint.
        kind: &'static str,
        /// Direction of the marker's axes.
        direction: &'static str,
        /// Kind of the body's model.
        model: &'static str,
    },
    /// Bodies of flat models whose planes or axes do not agree.
    #[error(
        "{model} bodies can only be joined to ground or to each other with parallel z axes (\"{parent}\", \"{child}\")"
    )]
    NotParallel {
        /// Kind of the bodies' models.
        model: &'static str,
        /// Name of the parent.
        parent: String,
        /// Name of the child.
        child: String,
    },
    /// A free joint as a loop.
    #[error("a free joint closes no loop")]
    FreeLoop,
    /// A loop within one body.
    #[error("both markers are on the same body")]
    SameBody,
    /// A loop with forces along its coordinates.
    #[error("a loop-closing joint has no forces along its coordinates")]
    LoopForces,
    /// Forces along another number of coordinates than the joint has.
    #[error("forces along {found} coordinates, a {kind} joint has {expected}")]
    ForceCount {
        /// Number given.
        found: usize,
        /// Kind of the joint.
        kind: &'static str,
        /// Number of its coordinates.
        expected: usize,
    },
    /// Spring or damper of a coordinate.
    #[error(
        "coordinate {coordinate}: stiffness {stiffness} and damping {damping} must be >= 0, rest position {rest} finite"
    )]
    Constants {
        /// Number of the coordinate, from 1.
        coordinate: usize,
        /// Stiffness [N/m or N m/rad].
        stiffness: f64,
        /// Damping [N s/m or N m s/rad].
        damping: f64,
        /// Rest position [m or rad].
        rest: f64,
    },
    /// Springs about the axes of a spherical joint that are not alike.
    #[error("springs about the three axes must be alike, with the rest position 0")]
    UnlikeSprings,
    /// Stop of a coordinate.
    #[error(
        "coordinate {coordinate}: a stop from {lower} to {upper} with stiffness {stiffness} and damping {damping} needs lower < upper, \
         stiffness > 0, damping >= 0, and no rotation about a point"
    )]
    Stop {
        /// Number of the coordinate, from 1.
        coordinate: usize,
        /// Lower end [m or rad].
        lower: f64,
        /// Upper end [m or rad].
        upper: f64,
        /// Stiffness [N/m or N m/rad].
        stiffness: f64,
        /// Damping [s/m or s/rad].
        damping: f64,
    },
    /// Friction of a coordinate.
    #[error("coordinate {coordinate}: friction {force} must be >= 0, its velocity {velocity} > 0")]
    Friction {
        /// Number of the coordinate, from 1.
        coordinate: usize,
        /// Force of sliding [N or N m].
        force: f64,
        /// Velocity of the transition [m/s or rad/s].
        velocity: f64,
    },
    /// Friction about the axes of a spherical joint that is not alike.
    #[error("friction about the three axes must be alike")]
    UnlikeFriction,
    /// A bearing in a joint that has none.
    #[error(
        "a {kind} joint has no bearing with friction by its load; revolute, prismatic, cylindrical and spherical ones have, give others the size of their friction"
    )]
    NoBearing {
        /// Kind of the joint.
        kind: &'static str,
    },
    /// A bearing that cannot be.
    #[error(
        "bearing: friction {coefficient}, radius {radius} and collar {collar} must be >= 0, the radius of what turns, length {length} and velocity {velocity} > 0"
    )]
    Bearing {
        /// Coefficient of friction.
        coefficient: f64,
        /// Radius \[m\].
        radius: f64,
        /// Distance of the supports \[m\].
        length: f64,
        /// Radius of the collar \[m\].
        collar: f64,
        /// Velocity of the transition [m/s].
        velocity: f64,
    },
    /// A prescribed motion of a joint with a quaternion.
    #[error("the motion of a {kind} joint cannot be prescribed")]
    Prescribed {
        /// Kind of the joint.
        kind: &'static str,
    },
    /// A state with another number of coordinates than the joint has.
    #[error(
        "{positions} positions and {velocities} velocities, the {kind} joint has {n_positions} and {n_velocities} that are not prescribed"
    )]
    StateCount {
        /// Positions given.
        positions: usize,
        /// Velocities given.
        velocities: usize,
        /// Kind of the joint.
        kind: &'static str,
        /// Positions that are not prescribed.
        n_positions: usize,
        /// Velocities that are not prescribed.
        n_velocities: usize,
    },
    /// A state that is not finite.
    #[error("a coordinate or velocity is not finite")]
    NotFinite,
    /// A rotation without a direction.
    #[error("the quaternion is zero")]
    ZeroQuaternion,
    /// Velocities at the start that tear a loop apart.
    #[error(
        "velocities given at the start open the loop at {rate:.3e} m/s or rad/s; leave those out that follow from others, or correct them"
    )]
    LoopSpeed {
        /// Rate of the constraint [m/s or rad/s].
        rate: f64,
    },
    /// A loop that does not close.
    #[error(
        "the loop stays open by {gap:.3e} m or rad, limit 1e-11; start nearer to a closed position, or the parts do not fit"
    )]
    OpenLoop {
        /// Largest distance or angle [m or rad].
        gap: f64,
    },
}
