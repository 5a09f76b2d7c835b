//! Gears: two joint coordinates whose rates have a fixed ratio (docs/theory.md Eq. M.37 to M.40).

use super::specification::GearSpec;
use crate::error::DynamicsError;
use crate::system::joints::JointKind;

/// Difference of the ratios of two ways from one coordinate to another, as a share, above which
/// they contradict each other: decimal numbers multiplied by each other agree better.
const CONTRADICTION: f64 = 1e-9;

/// A joint coordinate that takes part in a gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GearedCoordinate {
    /// Body that is the child of the joint.
    pub body: usize,
    /// Number of the velocity of the joint.
    pub velocity: usize,
    /// Its place among all rates; none of a coordinate whose motion is prescribed.
    pub rate: Option<usize>,
}

/// A gear: the second coordinate moves `ratio` times as fast as the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Gear {
    /// Name.
    pub name: String,
    /// First coordinate.
    pub first: GearedCoordinate,
    /// Second coordinate.
    pub second: GearedCoordinate,
    /// Rate of the second by that of the first.
    pub ratio: f64,
    /// Second coordinate where the first is zero.
    pub offset: f64,
}

impl Gear {
    /// Both coordinates with the factors by which the gear's force acts along them.
    pub(in crate::system) fn terms(&self) -> [(&GearedCoordinate, f64); 2] {
        [(&self.first, -self.ratio), (&self.second, 1.0)]
    }

    /// Rate of the constraint for rates of all free coordinates.
    pub(in crate::system) fn rate(&self, rates: &[f64]) -> f64 {
        self.terms().into_iter().filter_map(|(at, factor)| at.rate.map(|k| factor * rates[k])).sum()
    }

    /// Adds the force of the gear to forces along all free coordinates.
    pub(in crate::system) fn add_force(&self, force: f64, forces: &mut [f64]) {
        for (at, factor) in self.terms() {
            if let Some(k) = at.rate {
                forces[k] += factor * force;
            }
        }
    }
}

/// A joint of the tree as far as gears are concerned.
#[derive(Debug, Clone, Copy)]
pub struct GearJoint<'a> {
    /// Name.
    pub name: &'a str,
    /// Kind.
    pub kind: JointKind,
    /// Places of its velocities among all rates; none of prescribed ones.
    pub rates: [Option<usize>; 6],
}

/// The gears between `joints`, one of each body.
///
/// # Errors
/// [`DynamicsError::Gear`] for joints and coordinates that do not exist, ratios of no use and chains that contradict themselves.
pub(super) fn resolve(specs: &[GearSpec], joints: &[GearJoint<'_>]) -> Result<Vec<Gear>, DynamicsError> {
    let mut gears = Vec::with_capacity(specs.len());
    let mut chains = Chains::default();
    for spec in specs {
        let gear = chains.gear(spec, joints);
        gears.push(gear.map_err(|fault| DynamicsError::Gear { gear: spec.name.clone(), fault })?);
    }
    Ok(gears)
}

/// The first fault of `specs` between `joints`, if there is one.
///
/// # Errors
/// What is wrong, as in [`crate::system::MultibodyModel::new`].
pub fn check(specs: &[GearSpec], joints: &[GearJoint<'_>]) -> Result<(), String> {
    let mut chains = Chains::default();
    specs.iter().try_for_each(|spec| chains.gear(spec, joints).map(|_| ()))
}

fn coordinate(
    (joint, velocity): &(String, usize),
    joints: &[GearJoint<'_>],
) -> Result<GearedCoordinate, String> {
    let Some((body, found)) = joints.iter().enumerate().find(|(_, j)| j.name == joint) else {
        return Err(format!(
            "there is no joint \"{joint}\" with coordinates; joints that close loops have none"
        ));
    };
    // Those of a rotation about a point are no rates of coordinates.
    let coordinates = found.kind.quaternion().unwrap_or(found.kind.n_velocities());
    if *velocity >= coordinates {
        let (joint, kind) = (joint.clone(), found.kind.name());
        return Err(format!(
            "joint \"{joint}\" has no coordinate {velocity} for a gear: a {kind} joint has {coordinates} displacements and angles, counted from 0"
        ));
    }
    Ok(GearedCoordinate { body, velocity: *velocity, rate: found.rates[*velocity] })
}

/// Coordinates that gears join, each with its ratio to the first of its chain.
#[derive(Debug, Default)]
struct Chains {
    /// Coordinate, number of the chain, rate by that of the chain.
    members: Vec<(GearedCoordinate, usize, f64)>,
}

impl Chains {
    /// The gear of `spec`, which joins two chains.
    fn gear(&mut self, spec: &GearSpec, joints: &[GearJoint<'_>]) -> Result<Gear, String> {
        let GearSpec { name, first, second, ratio, offset } = spec;
        let (first, second) = (coordinate(first, joints)?, coordinate(second, joints)?);
        let gear = Gear { name: name.clone(), first, second, ratio: *ratio, offset: *offset };
        if first == second {
            return Err("both sides are the same coordinate, which has no ratio to itself; name another joint or coordinate for one of them".into());
        }
        if *ratio == 0.0 || !ratio.is_finite() {
            return Err(format!("ratio {ratio} must be finite and not zero"));
        }
        if !offset.is_finite() {
            return Err(format!("offset {offset} must be finite"));
        }
        self.join(&gear)?;
        Ok(gear)
    }

    fn find(&mut self, at: GearedCoordinate) -> (usize, f64) {
        if let Some((_, chain, ratio)) = self.members.iter().find(|(other, ..)| *other == at) {
            return (*chain, *ratio);
        }
        let chain = self.members.len(); // as many as there were coordinates at most
        self.members.push((at, chain, 1.0));
        (chain, 1.0)
    }

    /// Joins the chains of both coordinates of `gear`.
    fn join(&mut self, gear: &Gear) -> Result<(), String> {
        let ((from, first), (to, second)) = (self.find(gear.first), self.find(gear.second));
        let factor = gear.ratio * first;
        if from == to {
            let is_same = (factor - second).abs() <= CONTRADICTION * factor.abs().max(second.abs());
            return if is_same {
                Err("the other gears between these coordinates say the same already; leave one out".into())
            } else {
                Err(format!(
                    "ratio {given} contradicts the other gears, by which it is {found}: the chain would lock; leave one gear out or correct a ratio",
                    given = gear.ratio,
                    found = second / first
                ))
            };
        }
        for (_, chain, ratio) in self.members.iter_mut().filter(|(_, chain, _)| *chain == to) {
            (*chain, *ratio) = (from, *ratio * factor / second);
        }
        let driven = self.members.iter().filter(|(at, chain, _)| *chain == from && at.rate.is_none()).count();
        if driven > 1 {
            Err("it joins two coordinates whose motions are both prescribed; prescribe one, the other follows".into())
        } else {
            Ok(())
        }
    }
}
