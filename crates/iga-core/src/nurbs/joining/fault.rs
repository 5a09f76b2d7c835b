//! Why patches make no body.

use thiserror::Error;

use crate::SplineError;

/// Why patches given one by one make no body. Faces are called as in
/// [`crate::nurbs::joining::face_name`].
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum JoinFault {
    /// Nothing is given.
    #[error("no patch is given, one at least is needed")]
    NoPatch,
    /// Patches of lines, surfaces and solids in one body.
    #[error("patch {patch} has {found} parametric directions, patch 0 has {expected}")]
    Directions {
        /// Number of the patch, from 0.
        patch: usize,
        /// Its number of directions.
        found: usize,
        /// Number of directions of the first patch.
        expected: usize,
    },
    /// A patch that is none, or is folded.
    #[error("patch {patch}: {source}")]
    Patch {
        /// Number of the patch, from 0.
        patch: usize,
        /// What is wrong with it.
        source: Box<SplineError>,
    },
    /// Two faces that are the same surface and not the same spline.
    #[error(
        "faces {} and {} lie on one another, but {difference}; insert knots or raise degrees in the program that made them until both are the same spline",
        faces[0], faces[1]
    )]
    Mismatch {
        /// Names of the faces.
        faces: [String; 2],
        /// What differs.
        difference: String,
    },
    /// Two faces that meet on a part of them.
    #[error(
        "faces {} and {} meet only partly, at ({}, {}, {}) m among others; cut the larger one so that whole faces meet",
        faces[0], faces[1], point[0], point[1], point[2]
    )]
    Partly {
        /// Names of the faces.
        faces: [String; 2],
        /// A point of both \[m\].
        point: [f64; 3],
    },
    /// Two faces with a slit between them.
    #[error(
        "faces {} and {} are {distance:.2e} m apart, {share:.1e} of the size of their patches; give both the same control points, or leave a real gap",
        faces[0], faces[1]
    )]
    Gap {
        /// Names of the faces.
        faces: [String; 2],
        /// Largest distance of control points \[m\].
        distance: f64,
        /// The same as a share of the size of the patches.
        share: f64,
    },
    /// A face of three patches or more.
    #[error("faces {} are one and the same; a face has a patch on either side and no third one", faces.join(", "))]
    Shared {
        /// Names of the faces.
        faces: Vec<String>,
    },
    /// Two patches that fill the same space.
    #[error("patches {} and {} overlap, at ({}, {}, {}) m among others; remove one of them", patches[0], patches[1], point[0], point[1], point[2])]
    Overlap {
        /// Numbers of the patches, from 0.
        patches: [usize; 2],
        /// A point of both \[m\].
        point: [f64; 3],
    },
    /// A patch that is connected with no other.
    #[error(
        "patch {patch} shares no face with patch 0, nor with a patch that is connected with it; parts that are not joined are bodies of their own"
    )]
    Apart {
        /// Number of the patch, from 0.
        patch: usize,
    },
    /// Two faces that the file says are joined.
    #[error("faces {} and {} are joined by the file and do not lie on one another", faces[0], faces[1])]
    NotJoined {
        /// Names of the faces.
        faces: [String; 2],
    },
}
