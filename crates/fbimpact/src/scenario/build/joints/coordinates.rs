//! Coordinates of joints: initial values, springs, dampers, drives, prescribed motions.

use adaptive::spec::{CoordinateSpec, TimeCurve};
use ffr_dynamics::system::joints::{Bearing, Friction, JointKind, Stop};
use nalgebra::{UnitQuaternion, Vector3};

use super::super::super::keys::units;
use super::super::super::section::{Checked, Section};
use super::super::curves::curve;

/// Velocity of the transition of friction: of a displacement [m/s].
const TRANSITION: f64 = 1e-4;
/// The same of an angle [rad/s].
const ANGULAR_TRANSITION: f64 = 1e-3;
/// Share of a coordinate that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Initial state of a joint and what acts along its coordinates.
#[derive(Debug, Default)]
pub struct Coordinates {
    /// Positions, a rotation as a quaternion.
    pub positions: Vec<f64>,
    /// Velocities.
    pub velocities: Vec<f64>,
    /// One entry a velocity.
    pub coordinates: Vec<CoordinateSpec>,
    /// Friction by the load of the joint.
    pub bearing: Option<Bearing>,
}

/// Reads all coordinates of a joint.
pub fn coordinates(section: &Section, kind: JointKind, closes_loop: bool) -> Option<Coordinates> {
    let n = kind.n_velocities();
    if closes_loop || n == 0 {
        return Some(Coordinates::default());
    }
    let positions = values(section, kind, ["angle", "displacement", "coordinates"]);
    let velocities = values(section, kind, ["angular_velocity", "velocity", "velocities"]);
    let constants = ["stiffness", "rest", "damping"].map(|key| constants(section, kind, key));
    let drives = curves(section, kind, "drive", "drives");
    let motions = curves(section, kind, "motion", "motions");
    let [stiffness, rest, damping] = constants;
    let (stiffness, rest, damping) = (stiffness?, rest?, damping?);
    let friction = friction(section, kind)?;
    // What is prescribed is not thrown back by a stop.
    let is_free = |k: usize| motions.as_ref().is_some_and(|motions| motions[k].is_none());
    let begins = |k: usize| positions.as_ref().filter(|_| is_free(k)).map(|x| x[k]);
    let stops = stops(section, kind, &begins)?;
    let bearing = section.optional("bearing", |joint, key| bearing(joint.table(key)?, kind)).ok()?;
    check_rotation(section, kind, &stiffness, &rest)?;
    let (drives, motions) = (drives?, motions?);
    check_prescribed(section, kind, &motions)?;
    check_drives(section, &drives, &motions)?;
    let mut coordinates = Vec::with_capacity(n);
    for (k, (drive, motion)) in drives.into_iter().zip(motions).enumerate() {
        let (stiffness, rest, damping) = (stiffness[k], rest[k], damping[k]);
        let (stop, friction) = (stops[k], friction[k]);
        coordinates.push(CoordinateSpec { stiffness, rest, damping, stop, friction, drive, motion });
    }
    let positions = with_quaternion(kind, positions?);
    Some(Coordinates { positions, velocities: velocities?, coordinates, bearing })
}

/// Initial positions or velocities, one a velocity: from the keys of the only angle, the only
/// displacement, or from a list.
fn values(section: &Section, kind: JointKind, [angle, displacement, list]: [&str; 3]) -> Option<Vec<f64>> {
    let n = kind.n_velocities();
    let mut values = vec![0.0; n];
    let mut is_sound = true;
    for (key, is_angle) in [(angle, true), (displacement, false)] {
        if section.item(key).is_none() {
            continue;
        }
        // Keys of joints without a single one are faults already.
        let k = (0..n).find(|&k| kind.is_angle(k) == is_angle)?;
        if section.item(list).is_some() {
            section.fault(key, format!("either \"{key}\" or \"{list}\" can be given, not both"));
            is_sound = false;
        }
        match section.number(key) {
            Some(value) => values[k] = value,
            None => is_sound = false,
        }
    }
    if section.item(list).is_some() {
        let given = section.numbers(list)?;
        if given.len() != n {
            let message = format!("{} entries, a {} joint has {n} coordinates", given.len(), kind.name());
            return section.refuse(list, message);
        }
        check_units(section, list, kind, 0)?;
        values = given.to_vec();
    }
    is_sound.then_some(values)
}

/// Rotation vectors as quaternions.
fn with_quaternion(kind: JointKind, values: Vec<f64>) -> Vec<f64> {
    let Some(w) = kind.quaternion() else { return values };
    let vector = Vector3::new(values[w], values[w + 1], values[w + 2]);
    let q = UnitQuaternion::from_scaled_axis(vector);
    values[..w].iter().copied().chain([q.w, q.i, q.j, q.k]).collect()
}

/// Friction along the coordinates.
fn friction(section: &Section, kind: JointKind) -> Option<Vec<Option<Friction>>> {
    let forces = constants(section, kind, "friction")?;
    let velocities = if section.item("friction_velocity").is_some() {
        constants(section, kind, "friction_velocity")?
    } else {
        let default = |k: usize| if kind.is_angle(k) { ANGULAR_TRANSITION } else { TRANSITION };
        (0..forces.len()).map(default).collect()
    };
    if let Some(w) = kind.quaternion() {
        for (key, values) in [("friction", &forces), ("friction_velocity", &velocities)] {
            if values[w..].iter().any(|f| f.to_bits() != values[w].to_bits()) {
                let message = format!("must be alike about the three axes of a {} joint", kind.name());
                return section.refuse(key, message);
            }
        }
    }
    let pairs = forces.into_iter().zip(velocities);
    Some(pairs.map(|(force, velocity)| (force > 0.0).then_some(Friction { force, velocity })).collect())
}

/// Friction by the load of the joint; what is not given is held without.
fn bearing(table: &Section, kind: JointKind) -> Option<Bearing> {
    let or =
        |key: &str, none: f64| table.optional(key, Section::number).ok().map(|given| given.unwrap_or(none));
    // Of other kinds the table itself is a fault.
    let turns = matches!(kind, JointKind::Revolute | JointKind::Cylindrical | JointKind::Spherical);
    if table.item("radius").is_none() && turns {
        let message = format!("required key is missing: the radius at which a {} joint slides", kind.name());
        return table.refuse("radius", message);
    }
    Some(Bearing {
        coefficient: table.number("friction")?,
        radius: or("radius", 0.0)?,
        length: or("length", f64::INFINITY)?,
        collar: or("collar", 0.0)?,
        velocity: table.number("velocity")?,
    })
}

/// Stops of the coordinates: the one of the only coordinate, or those of a list; `begins`: where a
/// coordinate that is free begins.
fn stops(
    section: &Section,
    kind: JointKind,
    begins: &dyn Fn(usize) -> Option<f64>,
) -> Option<Vec<Option<Stop>>> {
    let mut stops = vec![None; kind.n_velocities()];
    if section.item("stops").is_some_and(|i| matches!(i.value, Checked::Invalid)) {
        return None;
    }
    let mut is_sound = true;
    let mut take = |table: &Section, k: usize, stops: &mut Vec<Option<Stop>>| {
        stops[k] = stop(table, kind, k, begins(k));
        is_sound &= stops[k].is_some();
    };
    if let Some(single) = section.table("stop") {
        take(single, 0, &mut stops);
    }
    for entry in section.tables("stops") {
        let k = coordinate_number(entry, kind)?;
        if kind.quaternion().is_some_and(|w| k >= w) {
            let message = format!("the rotation of a {} joint has no stops, it has no angles", kind.name());
            return entry.refuse("coordinate", message);
        }
        if stops[k].is_some() {
            return entry.refuse("coordinate", format!("coordinate {k} has a \"stop\" already"));
        }
        take(entry, k, &mut stops);
    }
    is_sound.then_some(stops)
}

/// The stop of coordinate `k`, which begins at `position` if it is free.
fn stop(section: &Section, kind: JointKind, k: usize, position: Option<f64>) -> Option<Stop> {
    for key in ["lower", "upper", "stiffness", "damping", "initial_overlap"] {
        check_units(section, key, kind, k)?;
    }
    let end = |key: &str, none: f64| {
        if section.item(key).is_some() { section.number(key) } else { Some(none) }
    };
    let (lower, upper) = (end("lower", f64::NEG_INFINITY)?, end("upper", f64::INFINITY)?);
    if lower.is_infinite() && upper.is_infinite() {
        let message = "required key is missing: a stop has a \"lower\" or an \"upper\" end";
        return section.refuse("upper", message);
    }
    if lower >= upper {
        let lower = section.item("lower").map_or_else(String::new, |item| item.shown.clone());
        return section.refuse("upper", format!("must be > lower = {lower}"));
    }
    let allowed = section.number("initial_overlap")?;
    if let Some(x) = position {
        let (key, beyond) = if x > upper { ("upper", x - upper) } else { ("lower", lower - x) };
        // The difference of two numbers that are given has round-off.
        if beyond > allowed + ROUND_OFF * x.abs() {
            let message = format!(
                "ends the travel, and the joint begins at {x}, {beyond:e} beyond it: it would be thrown back; begin within the travel, \
                 move its end, or allow so much with \"initial_overlap\", as for a body that rests on its stop"
            );
            return section.refuse(key, message);
        }
    }
    Some(Stop { lower, upper, stiffness: section.number("stiffness")?, damping: section.number("damping")? })
}

/// The coordinate that an entry of a list belongs to.
fn coordinate_number(entry: &Section, kind: JointKind) -> Option<usize> {
    let (k, n) = (entry.integer("coordinate")?, kind.n_velocities());
    if k >= n {
        let message = format!("must be < {n}, the coordinates of a {} joint", kind.name());
        return entry.refuse("coordinate", message);
    }
    Some(k)
}

/// Faults numbers of key `key` that were given in a unit which is not that of their coordinate, `k`
/// and those behind it.
fn check_units(section: &Section, key: &str, kind: JointKind, k: usize) -> Option<()> {
    let Some(item) = section.item(key) else { return Some(()) };
    item.units.iter().try_for_each(|(place, unit)| check_unit((section, key), unit, kind, k + place))
}

/// The same of a quantity over time along coordinate `k`.
fn check_curve_units(section: &Section, key: &str, kind: JointKind, k: usize) -> Option<()> {
    check_units(section, key, kind, k)?;
    let Some(table) = section.table(key) else { return Some(()) };
    let mut units = table.items.iter().flat_map(|item| item.units.iter().map(|(_, unit)| (item.name, unit)));
    units.try_for_each(|(name, unit)| check_unit((table, name), unit, kind, k))
}

/// Faults a number in `unit` at `key` of `section` where that is not one of coordinate `k`.
fn check_unit((section, key): (&Section, &str), unit: &str, kind: JointKind, k: usize) -> Option<()> {
    let is_angle = kind.is_angle(k);
    let Some(wanted) = units::in_place_of(unit, is_angle) else { return Some(()) };
    let quantity = if is_angle { "an angle" } else { "a displacement" };
    let message = format!(
        "wrong unit: coordinate {k} of a {} joint is {quantity}, known here are {}",
        kind.name(),
        units::names(wanted)
    );
    section.refuse(key, message)
}

/// Constants of springs or dampers, one a velocity; zero if not given.
fn constants(section: &Section, kind: JointKind, key: &str) -> Option<Vec<f64>> {
    let n = kind.n_velocities();
    if section.item(key).is_none() {
        return Some(vec![0.0; n]);
    }
    let given = section.numbers(key)?;
    if given.len() <= n {
        check_units(section, key, kind, 0)?;
    }
    let is_uniform = (0..n).all(|k| kind.is_angle(k) == kind.is_angle(0));
    match given {
        [value] if is_uniform => Some(vec![*value; n]),
        _ if given.len() == n => Some(given.to_vec()),
        _ => {
            let message = format!(
                "{} entr{}, a {} joint has {n} coordinates",
                given.len(),
                if given.len() == 1 { "y" } else { "ies" },
                kind.name()
            );
            section.refuse(key, message)
        }
    }
}

/// Springs of a rotation about a point pull along the rotation vector.
fn check_rotation(section: &Section, kind: JointKind, stiffness: &[f64], rest: &[f64]) -> Option<()> {
    let Some(w) = kind.quaternion() else { return Some(()) };
    if stiffness[w..].iter().any(|s| s.to_bits() != stiffness[w].to_bits()) {
        let message = format!("the springs about the three axes of a {} joint must be alike", kind.name());
        return section.refuse("stiffness", message);
    }
    if rest[w..].iter().any(|r| *r != 0.0) {
        let message = format!("springs about the three axes of a {} joint are relaxed at 0", kind.name());
        return section.refuse("rest", message);
    }
    Some(())
}

/// A prescribed coordinate has no initial value of its own, and rotations about a point cannot be
/// prescribed.
fn check_prescribed(section: &Section, kind: JointKind, motions: &[Option<TimeCurve>]) -> Option<()> {
    if motions.iter().all(Option::is_none) {
        return Some(());
    }
    let key = if section.given("motion") { "motion" } else { "motions" };
    if kind.quaternion().is_some() {
        let message = format!("the motion of a {} joint cannot be prescribed", kind.name());
        return section.refuse(key, message);
    }
    if motions.iter().flatten().any(|motion| matches!(motion, TimeCurve::Piecewise(_))) {
        let message = "a prescribed motion needs interpolation \"smooth\": with another its velocity jumps";
        return section.refuse(key, message);
    }
    let mut is_sound = true;
    let singles = [("angle", true), ("angular_velocity", true), ("displacement", false), ("velocity", false)];
    for (single, is_angle) in singles {
        let is_prescribed =
            motions.iter().enumerate().any(|(k, m)| m.is_some() && kind.is_angle(k) == is_angle);
        if section.given(single) && is_prescribed {
            section.fault(single, format!("follows from \"{key}\""));
            is_sound = false;
        }
    }
    is_sound.then_some(())
}

/// Faults drives of prescribed coordinates, on which nothing depends.
fn check_drives(
    section: &Section,
    drives: &[Option<TimeCurve>],
    motions: &[Option<TimeCurve>],
) -> Option<()> {
    let key = if section.given("drive") { "drive" } else { "drives" };
    let both = |k: &usize| drives[*k].is_some() && motions[*k].is_some();
    let k = (0..drives.len()).find(both);
    if let Some(k) = k {
        let message = format!(
            "the motion of coordinate {k} is prescribed, no force along it changes anything: leave out the one or the other"
        );
        section.fault(key, message);
    }
    k.is_none().then_some(())
}

/// Quantities over time along the coordinates: from the key for the only one, or from a list.
fn curves(section: &Section, kind: JointKind, single: &str, list: &str) -> Option<Vec<Option<TimeCurve>>> {
    let n = kind.n_velocities();
    let mut curves = vec![None; n];
    if section.given(single) {
        check_curve_units(section, single, kind, 0)?;
        curves[0] = curve(section, single).ok()?;
    }
    let entries = section.tables(list);
    if section.item(list).is_some_and(|i| matches!(i.value, Checked::Invalid)) {
        return None;
    }
    for entry in entries {
        let k = coordinate_number(entry, kind)?;
        check_curve_units(entry, "curve", kind, k)?;
        let found = curve(entry, "curve").ok()?;
        if curves[k].is_some() {
            return entry.refuse("coordinate", format!("coordinate {k} has a \"{single}\" already"));
        }
        curves[k] = found;
    }
    Some(curves)
}
