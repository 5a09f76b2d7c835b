//! Numbers that make no model.

use faer::MatRef;
use thiserror::Error;

/// Model data that do not fit together. Texts are fragments that read after "model data do not fit:
/// ".
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DataError {
    /// A number that is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which.
        what: String,
    },
    /// A number outside of the range in which it has a meaning.
    #[error("{what} is {value}, must be {range}")]
    OutOfRange {
        /// Which, with its unit.
        what: String,
        /// The number.
        value: f64,
        /// The range, as text.
        range: &'static str,
    },
    /// A list of the wrong length.
    #[error("{what}: {found}, must be {expected}")]
    Count {
        /// Name of the list.
        what: String,
        /// Number there is.
        found: usize,
        /// Number that is needed.
        expected: usize,
    },
    /// A matrix of the wrong size.
    #[error("{what} is {} x {}, must be {} x {}", found.0, found.1, expected.0, expected.1)]
    Size {
        /// Which.
        what: String,
        /// Rows and columns that there are.
        found: (usize, usize),
        /// Rows and columns that are needed.
        expected: (usize, usize),
    },
    /// A matrix that should be symmetric.
    #[error("{what} is not symmetric")]
    NotSymmetric {
        /// Which.
        what: String,
    },
    /// An entry of a matrix that differs from its mirror image.
    #[error(
        "{matrix} is not symmetric: {matrix}[{row}, {column}] = {value:e}, {matrix}[{column}, {row}] = {mirrored:e}"
    )]
    Asymmetric {
        /// Name of the matrix.
        matrix: String,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The entry.
        value: f64,
        /// Its mirror image.
        mirrored: f64,
    },
    /// An entry of a matrix that is not finite, or in a place where there must be none.
    #[error("{matrix}[{row}, {column}] {fault}")]
    Entry {
        /// Name of the matrix.
        matrix: String,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// What is wrong with it.
        fault: EntryFault,
    },
    /// An unknown, or a node, that is named twice or does not exist.
    #[error("{what}: {number} of {count} is named twice or does not exist")]
    Index {
        /// Name of the list that numbers it.
        what: String,
        /// The number, from 0.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// A mass distribution that no body has.
    #[error(
        "no distribution of mass has this inertia: a second moment about the centre of mass is {moment:.3e} kg m2, must not be negative (a principal moment of inertia exceeds the sum of the others by twice that)"
    )]
    Inertia {
        /// Smallest second moment about the centre of mass [kg m²].
        moment: f64,
    },
    /// Mode shapes that are not orthonormal with the mass.
    #[error(
        "modes {first} and {second} deviate from mass-orthonormality by {deviation:.1e}, limit {limit:.0e}"
    )]
    NotOrthonormal {
        /// First mode, from 1.
        first: usize,
        /// Second mode, from 1.
        second: usize,
        /// Deviation.
        deviation: f64,
        /// Largest that is allowed.
        limit: f64,
    },
    /// Damping that adds energy.
    #[error("the damping matrix adds energy: its smallest eigenvalue is {eigenvalue:.3e}")]
    NegativeDamping {
        /// Smallest eigenvalue [1/s].
        eigenvalue: f64,
    },
    /// Rigid motions that are not independent.
    #[error("the rigid motions are not independent, has the body no extent?")]
    NoExtent,
    /// A stiffness that resists a rigid motion.
    #[error(
        "the stiffness matrix resists rigid motion {motion} with {force:.3e} N (limit {limit:.3e} N), is an unknown missing?"
    )]
    RigidMotionResisted {
        /// Number of the rigid motion, from 0.
        motion: usize,
        /// Largest force by a unit of it.
        force: f64,
        /// Largest that is round-off.
        limit: f64,
    },
    /// A support that does not hold the body.
    #[error("{support} leave {free} rigid motions free, {remedy}")]
    NotHeld {
        /// What should hold the body.
        support: String,
        /// Number of rigid motions that are left.
        free: usize,
        /// What to change.
        remedy: &'static str,
    },
    /// A marker that does not follow a rigid motion of its body.
    #[error(
        "the marker at {position:?} m does not follow the body's {motion}: it moves and turns by {found:?} instead of {expected:?}"
    )]
    MarkerNotRigid {
        /// Position of the marker in the body's frame \[m\].
        position: [f64; 3],
        /// Which motion.
        motion: &'static str,
        /// Displacement and rotation by a unit of it.
        found: Box<[f64; 6]>,
        /// Displacement and rotation that a rigid body would have.
        expected: Box<[f64; 6]>,
    },
    /// A place that has no rotation about every axis.
    #[error("{marker} lie in one place or in line and do not define a rotation, {remedy}")]
    NoRotation {
        /// What lies so.
        marker: &'static str,
        /// What to change.
        remedy: &'static str,
    },
    /// A tangent frame for a body that has the stiffening of another frame.
    #[error(
        "a body with geometric stiffening keeps its frame; add the stiffening of the tangent frame's modes"
    )]
    FrameOfStiffenedBody,
    /// A factorisation whose last unknowns are not those asked for.
    #[error("the problem was factorised for another interface")]
    ForeignInterface,
    /// A mass matrix whose entries lie outside of those of the unknowns.
    #[error("the mass matrix does not fit the unknowns")]
    ForeignMass,
    /// Damping coefficients that are too few, too many, negative or not finite.
    #[error("body \"{body}\": damping must have {modes} coefficients, finite and not negative")]
    Damping {
        /// Name of the body.
        body: String,
        /// Number of its modes.
        modes: usize,
    },
    /// A list that is not in rising order.
    #[error("{what} must rise, entry {number} does not")]
    Unsorted {
        /// Which list.
        what: &'static str,
        /// Number of the entry, from 0.
        number: usize,
    },
    /// A frame that follows a marker which moves with the modes, or which there is not.
    #[error("the frame follows the marker \"{marker}\", {fault}")]
    FrameMarker {
        /// Name of the marker.
        marker: String,
        /// What is wrong with it.
        fault: &'static str,
    },
    /// Something that this kind of model does not have.
    #[error("{model} models have no {what}")]
    NotInModel {
        /// Kind of model.
        model: &'static str,
        /// What they do not have.
        what: &'static str,
    },
    /// A part of the model with a name, and what is wrong with it.
    #[error("{part}: {source}")]
    In {
        /// Kind and name of the part.
        part: String,
        /// What is wrong.
        source: Box<DataError>,
    },
}

/// What is wrong with an entry of a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum EntryFault {
    /// Its row or column does not exist.
    #[error("lies outside of the {0} x {0} matrix")]
    Outside(usize),
    /// It is not finite.
    #[error("= {0} is not finite")]
    NotFinite(f64),
    /// It lies above the diagonal of a lower triangle.
    #[error("lies above the diagonal of a lower triangle")]
    AboveDiagonal,
    /// It stands on the diagonal and is not positive.
    #[error("= {0:e} must be positive, is there a node without material?")]
    NotPositive(f64),
}

impl DataError {
    /// The same with the name of the part of the model that it concerns.
    pub fn in_part(self, part: impl Into<String>) -> Self {
        Self::In { part: part.into(), source: Box::new(self) }
    }
}

/// Checks that `matrix` is `n x n` and finite.
///
/// # Errors
/// [`DataError::Size`], [`DataError::NotFinite`].
pub fn check_square(what: &str, matrix: MatRef<'_, f64>, n: usize) -> Result<(), DataError> {
    let (what, found) = (what.to_owned(), (matrix.nrows(), matrix.ncols()));
    if found != (n, n) {
        return Err(DataError::Size { what, found, expected: (n, n) });
    }
    if matrix.norm_max().is_finite() { Ok(()) } else { Err(DataError::NotFinite { what }) }
}
