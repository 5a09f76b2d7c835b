//! Directions in which a part falls onto a floor: faces, edges and corners of the box around it, or directions spread over
//! the sphere.

use std::f64::consts::TAU;
use std::str::FromStr;

use adaptive::surface::Surface;
use ffr_dynamics::body::RigidMotion;
use nalgebra::{Unit, UnitQuaternion, Vector3};

/// Most directions; more runs are a sweep.
const MOST: usize = 10_000;

/// What a part is turned toward the floor with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Toward {
    /// Parts of the box around it, by the numbers of sides that meet there: faces 1, edges 2, corners 3.
    Box(Vec<usize>),
    /// So many directions, spread over the sphere.
    Sphere(usize),
}

/// What a part falls on.
#[derive(Debug, Clone, PartialEq)]
pub enum Ground {
    /// A rigid plane.
    Rigid,
    /// A layer of a material on rigid ground, so thick \[m\].
    Layer(String, f64),
}

impl FromStr for Ground {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "rigid" {
            return Ok(Self::Rigid);
        }
        let layer = text.split_once(':').and_then(|(material, thickness)| {
            let thickness: f64 = thickness.trim().parse().ok()?;
            let is_sound = thickness > 0.0 && thickness.is_finite() && !material.trim().is_empty();
            is_sound.then(|| Self::Layer(material.trim().to_owned(), thickness))
        });
        layer.ok_or_else(|| {
            "must be rigid, or MATERIAL:THICKNESS in metres, as aluminium:0.01; other floors stand in a scenario"
                .to_owned()
        })
    }
}

/// Parts of a box by the numbers of sides that meet there.
const PARTS: [(&str, usize); 3] = [("faces", 1), ("edges", 2), ("corners", 3)];

impl FromStr for Toward {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Ok(n) = text.parse::<usize>() {
            let fits = (1..=MOST).contains(&n);
            return fits.then_some(Self::Sphere(n)).ok_or_else(|| format!("must be 1 to {MOST} directions"));
        }
        let part = |word: &str| PARTS.iter().find(|(name, _)| *name == word.trim()).map(|(_, n)| *n);
        let parts: Option<Vec<usize>> = text.split(',').map(part).collect();
        parts.map(Self::Box).ok_or_else(|| {
            "must be some of faces, edges and corners, with commas between, or a number of directions"
                .to_owned()
        })
    }
}

/// A way for a part to lie above a floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Orientation {
    /// What is turned down, such as `edge-x-z+`.
    pub name: String,
    /// The direction of the part that points down.
    pub down: Unit<Vector3<f64>>,
}

/// The orientations of a part that moves by `motion`, in the box from `low` to `high`, whose centre of mass is `centre`. Under an
/// edge or a corner of the box the centre of mass is straight above it, which leaves the fall most energy. A plane part is turned in
/// its plane, where its box has sides and corners; one with an axis falls on its ends.
pub fn orientations(
    toward: &Toward,
    motion: RigidMotion,
    [low, high]: [Vector3<f64>; 2],
    centre: &Vector3<f64>,
) -> Vec<Orientation> {
    let turns = |signs: &Vector3<f64>| match motion {
        RigidMotion::Spatial => true,
        RigidMotion::Planar => signs.z == 0.0,
        RigidMotion::Axial => signs.x == 0.0 && signs.y == 0.0,
    };
    let parts = match toward {
        Toward::Box(parts) => parts,
        Toward::Sphere(n) => return if motion == RigidMotion::Planar { around(*n) } else { spread(*n) },
    };
    let signs = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|k| [0.0, -1.0, 1.0][k]));
    let mut all: Vec<(usize, Orientation)> = Vec::new();
    for signs in signs.map(Vector3::<f64>::from).filter(turns) {
        let sides = signs.iter().filter(|s| s.abs() > 0.0).count();
        // Where two sides of a plane part meet is a corner.
        let meeting = if motion == RigidMotion::Planar && sides == 2 { 3 } else { sides };
        let Some((kind, _)) = PARTS.iter().find(|(_, n)| *n == meeting && parts.contains(n)) else {
            continue;
        };
        let end = Vector3::from_fn(|i, _| if signs[i] > 0.0 { high[i] } else { low[i] });
        let way = if sides == 1 { signs } else { (end - centre).component_mul(&signs.abs()) };
        let letter = |i: usize| match signs[i] {
            s if s > 0.0 => format!("{}+", ["x", "y", "z"][i]),
            s if s < 0.0 => format!("{}-", ["x", "y", "z"][i]),
            _ => String::new(),
        };
        let name = format!("{}-{}", kind.trim_end_matches('s'), (0..3).map(letter).collect::<String>());
        // A flat part has no extent to a side; its sides tell the direction.
        let down = Unit::try_new(way, 0.0).unwrap_or_else(|| Unit::new_normalize(signs));
        all.push((sides, Orientation { name, down }));
    }
    all.sort_by_key(|(sides, _)| *sides);
    all.into_iter().map(|(_, orientation)| orientation).collect()
}

/// Directions of equal areas of the sphere along a spiral, turned by the golden angle from one to the next.
fn spread(n: usize) -> Vec<Orientation> {
    let golden = TAU * (1.0 - 2.0 / (1.0 + 5.0_f64.sqrt()));
    let digits = n.to_string().len();
    let direction = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let (r, angle) = ((1.0 - z * z).max(0.0).sqrt(), golden * i as f64);
        let down = Unit::new_normalize(Vector3::new(r * angle.cos(), r * angle.sin(), z));
        Orientation { name: format!("direction-{:0digits$}", i + 1), down }
    };
    (0..n).map(direction).collect()
}

/// Directions at equal angles in the plane.
fn around(n: usize) -> Vec<Orientation> {
    let digits = n.to_string().len();
    let direction = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
        let down = Unit::new_normalize(Vector3::new(sin, -cos, 0.0));
        Orientation { name: format!("direction-{:0digits$}", i + 1), down }
    };
    (0..n).map(direction).collect()
}

/// A plane on which a part falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// A point of it \[m\].
    pub point: Vector3<f64>,
    /// Its normal, upwards.
    pub up: Unit<Vector3<f64>>,
}

/// Position and rotation of a part with the direction `down` towards the floor, its lowest point by `gap` above it and its
/// centre of mass `centre` above the floor's point; `None` of a part without a surface.
pub fn pose(
    surface: &dyn Surface,
    down: &Unit<Vector3<f64>>,
    (floor, gap): (&Floor, f64),
    centre: &Vector3<f64>,
) -> Option<(Vector3<f64>, UnitQuaternion<f64>)> {
    let motion = surface.motion();
    let rotation = UnitQuaternion::rotation_between(down, &-floor.up.into_inner())
        // Half a turn about any direction across, of a plane part about its normal.
        .unwrap_or_else(|| {
            let across = match motion {
                RigidMotion::Planar => Vector3::z(),
                _ => down.cross(&Vector3::ith(down.iamin(), 1.0)),
            };
            UnitQuaternion::from_axis_angle(&Unit::new_normalize(across), 0.5 * TAU)
        });
    let upwards = motion.components((-down.into_inner()).as_ref());
    let lowest = motion.in_space(&surface.lowest(&upwards.into())?.point);
    let (up, aside) = (floor.up.into_inner(), rotation * centre);
    let position = floor.point - aside + up * (up.dot(&aside) + gap - up.dot(&(rotation * lowest)));
    Some((position, rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(toward: &str) -> Vec<Orientation> {
        let bounds = [Vector3::new(-1.0, -2.0, -3.0), Vector3::new(1.0, 2.0, 3.0)];
        let toward = toward.parse().expect("parts of a box");
        orientations(&toward, RigidMotion::Spatial, bounds, &Vector3::zeros())
    }

    #[test]
    fn a_box_has_26_parts_that_point_from_its_centre_to_them() {
        let all = of("faces,edges,corners");
        let names: Vec<&str> = all.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(all.len(), 26);
        assert!(
            names[..6].iter().all(|n| n.starts_with("face-"))
                && names[18..].iter().all(|n| n.starts_with("corner-"))
        );
        let edge = &all[names.iter().position(|n| *n == "edge-x-z+").expect("an edge")];
        assert!((edge.down.into_inner() - Vector3::new(-1.0, 0.0, 3.0).normalize()).norm() < 1e-15);
        assert_eq!(of("corners").len(), 8);
        assert_eq!(of("edges, faces").len(), 18);
        for wrong in ["sides", "", "0", "-3", "faces;edges", "100000"] {
            assert!(wrong.parse::<Toward>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn plane_parts_have_sides_and_corners_round_ones_have_ends() {
        let bounds = [Vector3::new(-1.0, -2.0, 0.0), Vector3::new(1.0, 2.0, 0.0)];
        let of = |toward: &str, motion| {
            let all = orientations(&toward.parse().expect("a choice"), motion, bounds, &Vector3::zeros());
            all.into_iter().map(|o| (o.name, o.down.into_inner())).collect::<Vec<_>>()
        };
        let all = of("faces,edges,corners", RigidMotion::Planar);
        assert!(all.len() == 8 && all.iter().all(|(_, down)| down.z == 0.0), "{all:?}");
        let corner = all.iter().find(|(name, _)| name == "corner-x-y+").expect("a corner");
        assert!((corner.1 - Vector3::new(-1.0, 2.0, 0.0).normalize()).norm() < 1e-15);
        assert_eq!(of("edges", RigidMotion::Planar).len(), 0);
        let all = of("4", RigidMotion::Planar);
        assert!(
            (all[0].1 + Vector3::y()).norm() < 1e-15 && (all[1].1 - Vector3::x()).norm() < 1e-15,
            "{all:?}"
        );
        let all = of("faces,edges,corners", RigidMotion::Axial);
        assert_eq!(all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["face-z-", "face-z+"]);
    }

    #[test]
    fn directions_are_spread_over_the_sphere() {
        let all = of("200");
        // Mean and second moment of a uniform distribution: 0 and 1/3. Stripes of equal area leave 1/n along z, the golden angle some 1/n across.
        let sum: Vector3<f64> = all.iter().map(|o| o.down.into_inner()).sum();
        assert!(sum.norm() / 200.0 < 0.01, "{sum}");
        let second: f64 = all.iter().map(|o| o.down.x * o.down.x).sum::<f64>() / 200.0;
        assert!((second - 1.0 / 3.0).abs() < 0.01, "{second}");
    }
}
