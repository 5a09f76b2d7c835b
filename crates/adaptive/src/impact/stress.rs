//! Stress along straight lines, from the dynamic and the quasistatic displacement together.
//!
//! Stress is linear: that of the modes and of the interface the body was reduced for comes from its
//! own model, and that of zones refined during the run from their fine models, built again for it
//! (theory Eq. A.17).

use std::f64::consts::PI;

use faer::Mat;
use iga_core::elasticity::kinematics::von_mises;
use nalgebra::Vector3;

use crate::body::reduced::ReducedBody;
use crate::error::AdaptiveError;
use crate::impact::ZoneModel;
use crate::record::warning::{Warning, WarningKind};
use crate::record::{BareForce, StressRecord, StressState};
use crate::spec::StressSpec;
use crate::system::body::FlexibleModel;

/// Stress along the line of `request` in the state `state` of `body`, with the models of the zones
/// that were refined during the run (theory Eqs. A.17, Q.7).
///
/// # Errors
/// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] if a point of the line is not in the body.
pub fn evaluate(
    request: &StressSpec,
    body: &FlexibleModel,
    zones: &[ZoneModel],
    state: &StressState,
) -> Result<StressRecord, AdaptiveError> {
    let own = displacement(&body.reduced, state);
    let on_zones = zones.iter().zip(&state.zones);
    let on_zones: Vec<(&ZoneModel, Vec<f64>)> =
        on_zones.map(|(zone, load)| (zone, zone.residual.displacement(&load.forces))).collect();
    let mut record = StressRecord { name: request.name.clone(), time: state.time, ..StressRecord::default() };
    for place in line(request) {
        let mut sum = body.body.gauge_at(&place)?.at(body.lookup(), &own);
        for (zone, u) in &on_zones {
            sum.add_scaled(&zone.model.field().gauge_at(&place)?.at(zone.model.field().lookup(), u), 1.0);
        }
        record.points.push(body.motion().in_space(&place).into());
        record.von_mises.push(von_mises(&sum.stress));
        record.stress.push(sum.stress);
    }
    Ok(record)
}

/// Displacement of all unknowns: `Φ q_e + u_hf(f_b)` \[m\].
fn displacement(reduced: &ReducedBody, state: &StressState) -> Vec<f64> {
    let shapes = &reduced.basis.shapes;
    let q = Mat::from_fn(state.elastic.len(), 1, |i, _| state.elastic[i]);
    let low = shapes * q;
    let mut u: Vec<f64> = low.col(0).iter().copied().collect();
    if let Some(residual) = &reduced.residual {
        let quasistatic = residual.displacement(&state.interface_forces);
        u.iter_mut().zip(quasistatic).for_each(|(u, v)| *u += v);
    }
    u
}

/// Points of the line in the model's components.
fn line(spec: &StressSpec) -> impl Iterator<Item = [f64; 3]> + '_ {
    let [from, to] = spec.ends;
    let last = spec.samples.max(2) - 1;
    (0..=last).map(move |i| {
        let s = i as f64 / last as f64;
        std::array::from_fn(|c| from[c] + s * (to[c] - from[c]))
    })
}

/// Share of the stress shown above which what is left out of it is told.
const LEFT_OUT: f64 = 0.05;

/// The stress of a contact at a place of a body, which what is shown of it leaves out (docs/theory.md
/// Eq. P.18).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    bare: BareForce,
    /// Thickness of plane models \[m\].
    thickness: Option<f64>,
    /// Distance of the place from the contact \[m\].
    distance: f64,
    /// The stress that is left out, and the one shown \[Pa\].
    stress: f64,
    shown: f64,
}

impl LeftOut {
    /// What the force `bare` on a body, `thickness` thick if it is of a plane model, stresses the place
    /// `at` in its frame by, where the stress `shown` \[Pa\] leaves it out.
    pub fn new(bare: &BareForce, thickness: Option<f64>, at: &Vector3<f64>, shown: f64) -> Self {
        let distance = (at - Vector3::from(bare.place)).norm();
        let stress = stress_near(bare.force, thickness, distance.max(bare.radius));
        Self { bare: *bare, thickness, distance, stress, shown }
    }

    /// Index of the contact.
    pub fn contact(&self) -> usize {
        self.bare.contact as usize
    }

    /// Whether it is worth a word.
    pub fn counts(&self) -> bool {
        self.stress > LEFT_OUT * self.shown
    }

    /// The one of both that leaves out more, as a share of what it shows.
    #[must_use]
    pub fn or_worse(self, other: Self) -> Self {
        if other.stress * self.shown > self.stress * other.shown { other } else { self }
    }

    /// The warning of the stress called `request` at the time `time` \[s\]; `contact` is the name of the
    /// contact.
    pub fn warning(&self, request: String, contact: &str, time: f64) -> Warning {
        let Self { distance, stress, shown, .. } = *self;
        // Where it is that share: stress falls with the distance, or its square.
        let ratio = stress / (LEFT_OUT * shown);
        let far =
            distance.max(self.bare.radius) * if self.thickness.is_some() { ratio } else { ratio.sqrt() };
        Warning {
            kind: WarningKind::LocalStress,
            subject: request,
            time,
            value: stress,
            limit: LEFT_OUT * shown,
            message: format!(
                "the {shown:.3e} Pa shown {distance:.2e} m from contact \"{contact}\" are those of the body's modes alone; the force of \
                 {:.3e} N stresses that place by up to {stress:.3e} Pa, for how bodies yield at the touch is not part of the contact's model",
                self.bare.force
            ),
            remedy: format!(
                "leave contacts.{contact}.model out for the stress near the touch, or ask for places at least {far:.1e} m from it"
            ),
        }
    }
}

/// Largest stress at the distance `r` \[m\] from a force on a half space, straight below it: of a point
/// 3F/(2πr²) (Boussinesq), of a line over the thickness `t` 2F/(πrt) (Flamant). At the rim of Hertz's
/// contact these are his largest pressures \[Pa\].
fn stress_near(force: f64, thickness: Option<f64>, r: f64) -> f64 {
    match thickness {
        None => 1.5 * force / (PI * r * r),
        Some(t) => 2.0 * force / (PI * r * t),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stress_at_the_rim_is_the_pressure_in_the_middle() {
        // p0 = 3F/(2πa²) of a circle, 2F/(πat) of a strip; round-off. Outside it falls off.
        let (force, a, t) = (100.0, 1e-4, 0.02);
        let bare = BareForce { force, radius: a, ..BareForce::default() };
        let at = |x: f64, thickness| LeftOut::new(&bare, thickness, &Vector3::new(x, 0.0, 0.0), 1e6).stress;
        let circle = 1.5 * force / (PI * a * a);
        let strip = 2.0 * force / (PI * a * t);
        for (thickness, pressure, share) in [(None, circle, 0.25), (Some(t), strip, 0.5)] {
            assert!((at(0.0, thickness) / pressure - 1.0).abs() < 1e-14);
            assert!((at(2.0 * a, thickness) / pressure - share).abs() < 1e-14);
        }
    }

    #[test]
    fn what_is_told_says_how_far_away_it_counts_no_more() {
        let bare = BareForce { force: 200.0, radius: 1e-4, ..BareForce::default() };
        let near = LeftOut::new(&bare, None, &Vector3::new(0.0, 0.0, 3e-4), 1e6);
        assert!(near.counts());
        let told = near.warning("output.points.p".into(), "c", 1e-5);
        // sqrt(1.5 · 200/(π · 0.05 · 1e6)) = 4.37e-2 m.
        assert!(told.remedy.contains("4.4e-2 m"), "{}", told.line());
        assert!(!LeftOut::new(&bare, None, &Vector3::new(0.0, 0.0, 0.0438), 1e6).counts());
    }
}
