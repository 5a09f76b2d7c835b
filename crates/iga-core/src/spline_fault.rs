//! What can be wrong with knot vectors and with the levels of a hierarchical space, with the
//! numbers.

use thiserror::Error;

/// Why knots form no clamped knot vector, or not the one that an operation needs.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum KnotFault {
    /// Fewer knots than the degree needs.
    #[error("{count} knots, degree {degree} needs at least {least}")]
    TooFew {
        /// Number of knots.
        count: usize,
        /// Degree.
        degree: usize,
        /// Least number of knots.
        least: usize,
    },
    /// A knot that is no finite number.
    #[error("knot {index} is {value}, it must be finite")]
    NotFinite {
        /// Number of the knot, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A knot below the one before.
    #[error("knot {index} = {value} is below its predecessor {before}")]
    Falling {
        /// Number of the knot, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// Value of the knot before.
        before: f64,
    },
    /// End knots that are not repeated as often as a clamped vector needs.
    #[error("the end knots {} and {} must each stand {times} times", ends[0], ends[1])]
    NotClamped {
        /// First and last knot.
        ends: [f64; 2],
        /// How often each must stand.
        times: usize,
    },
    /// An interior knot repeated so often that the functions are torn there.
    #[error("an interior knot stands {times} times, degree {degree} allows {degree}")]
    TooOften {
        /// How often it stands.
        times: usize,
        /// Degree.
        degree: usize,
    },
    /// No breaks.
    #[error("no breaks given")]
    NoBreaks,
    /// Fewer than two breaks.
    #[error("{count} breaks, two are needed")]
    FewBreaks {
        /// How many there are.
        count: usize,
    },
    /// Breaks that do not rise.
    #[error("break {value} is not above {before}")]
    BreaksNotRising {
        /// The break.
        value: f64,
        /// The one before.
        before: f64,
    },
    /// A new knot at or beyond an end.
    #[error("new knot {knot} is not inside ({}, {})", domain[0], domain[1])]
    Outside {
        /// The knot.
        knot: f64,
        /// First and last knot of the vector.
        domain: [f64; 2],
    },
    /// A patch of no directions, or of more than three.
    #[error("{count} directions, 1 to 3 are possible")]
    Directions {
        /// Number of knot vectors.
        count: usize,
    },
    /// A direction that the patch does not have.
    #[error("direction {direction} does not exist, the patch has {dimension}")]
    NoDirection {
        /// Number of the direction, from 0.
        direction: usize,
        /// Number of directions.
        dimension: usize,
    },
    /// A finer vector of lower degree.
    #[error("degree {coarse} cannot be lowered to {fine}")]
    DegreeLowered {
        /// Degree of the coarse vector.
        coarse: usize,
        /// Degree of the fine one.
        fine: usize,
    },
    /// A finer vector with other ends.
    #[error("range {coarse:?} is refined by {fine:?}")]
    OtherRange {
        /// Ends of the coarse vector.
        coarse: (f64, f64),
        /// Ends of the fine one.
        fine: (f64, f64),
    },
    /// A knot that the finer vector has not, or not often enough.
    #[error("knot {knot} stands {times} times in the finer vector, {least} times are needed")]
    NotNested {
        /// The knot.
        knot: f64,
        /// How often the finer vector has it.
        times: usize,
        /// How often it must.
        least: usize,
    },
}

/// Why the levels of a hierarchical space do not follow from each other.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LevelFault {
    /// A level that splits no element, or one into no parts.
    #[error("a level that splits elements into {parts:?} parts refines nothing")]
    NoSplit {
        /// Parts of an element in each direction.
        parts: Vec<usize>,
    },
    /// Levels of different dimension.
    #[error("{found} directions after {expected}")]
    Directions {
        /// Directions of the new level.
        found: usize,
        /// Directions of the last one.
        expected: usize,
    },
    /// Levels of another patch.
    #[error("the coarsest level has not the knots of the patch")]
    OtherPatch,
    /// Another number of levels than the first patch has, or than patches.
    #[error("patch {patch} has {found} levels, the first one has {expected}")]
    LevelCount {
        /// The patch.
        patch: usize,
        /// Its number of levels.
        found: usize,
        /// Number of levels of the first patch.
        expected: usize,
    },
    /// Patches that are divided differently where they meet.
    #[error("patches {} and {} have other knots on level {level} along the face that they share", patches[0], patches[1])]
    SharedKnots {
        /// The patches.
        patches: [usize; 2],
        /// The level.
        level: usize,
    },
    /// Patches that share an edge or a corner and no face around it.
    #[error(
        "patches meet at an edge or a corner without faces that they share around it, and cannot be refined there"
    )]
    SharedEdge,
    /// A region that is no box of finite numbers, or lies outside the patch.
    #[error("region from {} to {} is not inside the parameters {} to {}", region[0], region[1], domain[0], domain[1])]
    Region {
        /// Lower and upper parameter of the region in the direction concerned.
        region: [f64; 2],
        /// First and last parameter of the patch there.
        domain: [f64; 2],
    },
    /// Levels of different degree.
    #[error("degree {coarse} cannot be refined to degree {fine}")]
    Degree {
        /// Degree of the coarse level.
        coarse: usize,
        /// Degree of the fine one.
        fine: usize,
    },
    /// A knot that the finer level has not.
    #[error("knot {knot} is not among the finer knots")]
    MissingKnot {
        /// The knot.
        knot: f64,
    },
}
