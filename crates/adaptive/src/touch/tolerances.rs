//! By how much what counts as equal may differ where two bodies touch: every tolerance of this
//! room, with its reason.

/// Angle \[rad\] by which flat faces and lines may be inclined at the first touch and still meet as
/// a whole: round-off of angles in files.
pub const PARALLEL_AT_START: f64 = 1e-6;
/// The same at a touch in the run: motions err by some 1e-6 of the way, and the faces of bodies
/// that swing and ring turn by more; over 20 mm it is 2 um, which bodies at 1 m/s close in 2 us.
pub const PARALLEL_IN_RUN: f64 = 1e-4;
/// Largest angle \[rad\] between the normals of two surfaces that count as facing each other: the
/// error of normals of meshes is smaller.
pub const FACING: f64 = 5e-3;
/// Angle \[rad\] by which the normal at the nearest place may miss the direction to the partner:
/// places across the curved direction are known to the root of round-off, and bodies that ring turn
/// by less.
pub const ACROSS_LINE: f64 = 1e-3;
/// Cosine above which two directions are equal; the direction of a touch is one of the normals or
/// computed from them.
pub const SAME_DIRECTION: f64 = 1.0 - 1e-12;
/// Curvature times size of a body below which a surface is flat: round-off of nets and nodes.
pub const FLAT: f64 = 1e-6;
/// Ratio of the smaller to the larger curvature of the gap below which surfaces touch along a line;
/// curvatures fitted to meshes are more accurate.
pub const STRAIGHT: f64 = 1e-3;
/// Length of a line over the size of a body below which it is a point, such as a circle about the
/// axis that has shrunk to it.
pub const SHORTEST_LINE: f64 = 1e-2;
/// Distance along an edge, as a share of the bodies' size, at which it is checked whether the edge
/// lies along a face.
pub const ALONG_EDGE: f64 = 0.1;
/// Gap or overlap, as a share of the size of a body, that is round-off of places: positions of some
/// sizes are known to 1e-16 of them, and shapes to 1e-12.
pub const ROUND_OFF: f64 = 1e-9;
/// Points of whole surfaces that are farther than the nearest one by no more than this share of the
/// smaller body's size are going to touch: bodies yield by less in all impacts that leave them elastic.
pub const TOUCHED_SURFACE: f64 = 1e-3;
/// Angle \[rad\] by which the faces beside an edge open at least against what it presses: the partner then comes nowhere near them while
/// bodies yield by [`TOUCHED_SURFACE`].
pub const OPENING: f64 = 0.1;
