//! Keys of `[bodies.NAME.copies]`.

use crate::scenario::keys::{Key, Kind, name_variants};
use crate::scenario::tables::ranges::{COORDINATE, LENGTH};

/// Most copies of one body; far more than can be simulated.
pub const MOST: u64 = 10_000;

/// How copies of a body stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrangement {
    /// One behind the other.
    Row,
    /// At the points of a grid.
    Grid,
    /// About an axis.
    Ring,
    /// Anywhere in a box.
    Random,
}

name_variants!(Arrangement {
    Row: "row", "One behind the other, the first where the body stands.", keys ROW;
    Grid: "grid", "At the points of a grid along the axes, the first where the body stands; x counts fastest.", keys GRID;
    Ring: "ring", "At equal angles about an axis, the first where the body stands.", keys RING;
    Random: "random", "Anywhere in a box and no two nearer than `distance`: one after the other at a place drawn at random until it is free.", keys RANDOM;
});

/// Copies in place of a body.
pub const COPIES: Key = Key::new("copies", Kind::Variants { tag: "arrangement", variants: Arrangement::VARIANTS })
    .otherwise("the body alone")
    .doc("Bodies of this kind in its place, called `NAME-1`, `NAME-2` and so on. Contacts take hold of all of them by `NAME-*`; joints, loads and output \
     name one of them. They share one model.");

const COUNT: Key = Key::measured("count", Kind::Integer(1, MOST), "–").doc("Number of copies.");

const ROW: &[Key] =
    &[COUNT, Key::measured("step", Kind::Vector(3, COORDINATE), "m").doc("Way from one copy to the next.")];

const GRID: &[Key] = &[
    Key::measured("counts", Kind::Counts(1, MOST), "–")
        .doc("Numbers of copies along x, y and z, no more than 10000 in all; two numbers make one layer."),
    Key::measured("spacing", Kind::Vector(3, COORDINATE), "m")
        .doc("Distances from one copy to the next along x, y and z."),
];

const RING: &[Key] = &[
    COUNT,
    Key::measured("centre", Kind::Vector(3, COORDINATE), "m")
        .default("[0.0, 0.0, 0.0]")
        .doc("A point of the axis, in space."),
    Key::measured("axis", Kind::Vector(3, COORDINATE), "–")
        .default("[0.0, 0.0, 1.0]")
        .doc("Direction of the axis, of any length but zero."),
    Key::new("turned", Kind::Boolean)
        .default("true")
        .doc("Whether orientations, velocities and angular velocities turn with the copies."),
];

const RANDOM: &[Key] = &[
    COUNT,
    Key::measured("from", Kind::Vector(3, COORDINATE), "m")
        .doc("A corner of the box of the copies' origins, seen from `position`."),
    Key::measured("to", Kind::Vector(3, COORDINATE), "m").doc("The opposite corner."),
    Key::measured("distance", Kind::Number(LENGTH), "m")
        .doc("Least distance of two origins: copies do not overlap if it is no less than the diameter of the ball about the origin that holds the body."),
    Key::measured("seed", Kind::Integer(0, 1_000_000_000), "–")
        .default("1")
        .doc("Number that chooses among all such arrangements; the same one gives the same arrangement on every machine."),
    Key::new("turned", Kind::Boolean)
        .default("false")
        .doc("Whether orientations are drawn at random, too, all alike."),
];
