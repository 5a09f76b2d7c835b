//! How long the force of a touch takes to rise, at a point and along a line (theory Eq. N.8).
//!
//! The force rises until the masses have been stopped, or until waves carry the motion away,
//! whichever comes first.

use std::f64::consts::PI;

use iga_core::nurbs::Face;
use iga_core::nurbs::Shape;

use crate::touch::hertz::{HertzLaw, LineLaw, LocalSurface, hertz_impact, line_impact};

/// Duration of a Hertz impact over its largest approach divided by the speed (Eq. C.23).
const HERTZ_TIME: f64 = 2.943_28;
/// Share of the force that would stop the masses below which waves carry the motion away before: a
/// compact body, whose waves come back before the force has risen, has the one about as large as
/// the other.
const CARRIED_AWAY: f64 = 0.75;
/// Chords of a side whose length is taken: those of a quarter circle are 0.04 % too short.
const CHORDS: usize = 16;

/// What sets the time of an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeScale {
    /// Hertz's law between two masses.
    Hertz,
    /// Rise of the force until waves carry the motion away.
    Waves,
    /// Line contact between two masses.
    Line,
    /// Line contact until waves carry the motion away.
    LineWaves,
    /// Waves through a body between flat faces.
    Flat,
}

impl TimeScale {
    /// Whether bodies touch along a line.
    pub fn is_line(self) -> bool {
        matches!(self, Self::Line | Self::LineWaves)
    }

    /// Whether the force comes like a step beside the time of the impact, so that no mode is the
    /// last that counts: between flat faces, and along a line from which waves carry the motion
    /// away.
    pub fn is_jump(self) -> bool {
        matches!(self, Self::Flat | Self::LineWaves)
    }
}

/// What the partners are, along the normal of their touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touching {
    /// Sum of the inverse effective masses [1/kg].
    pub inverse_mass: f64,
    /// Sum of the inverse impedances against waves [s/kg].
    pub mobility: f64,
    /// Closing speed [m/s].
    pub speed: f64,
}

/// A line along which bodies touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchLine {
    /// Its length \[m\].
    pub length: f64,
    /// Curvature of the gap across it [1/m].
    pub curvature: f64,
    /// Size of the bodies, over which they yield \[m\].
    pub size: f64,
}

/// Time of an impact at a point: the shorter of Hertz's, and twice the rise to the force at which
/// waves take up the speed.
pub fn point_time(surfaces: &[LocalSurface; 2], touching: Touching) -> Option<(TimeScale, f64)> {
    let Touching { inverse_mass, mobility, speed } = touching;
    let hertz = HERTZ_TIME * hertz_impact(surfaces, inverse_mass, speed)?.approach / speed;
    let rise = if mobility > 0.0 {
        2.0 * HertzLaw::new(surfaces)?.at_force(speed / mobility).approach / speed
    } else {
        f64::INFINITY
    };
    Some(if rise < hertz { (TimeScale::Waves, rise) } else { (TimeScale::Hertz, hertz) })
}

/// Time of an impact along a line: half a period of the spring that has its peak force and energy;
/// twice the rise to the force at which waves take up the speed, which run to both sides of the
/// line, if that is well below the peak.
pub fn line_time(
    surfaces: &[LocalSurface; 2],
    line: TouchLine,
    touching: Touching,
) -> Option<(TimeScale, f64)> {
    let TouchLine { length, curvature, size } = line;
    let Touching { inverse_mass, mobility, speed } = touching;
    let compliance: f64 = surfaces.iter().map(|s| s.compliance).sum();
    let (_, peak) = line_impact(curvature, compliance, inverse_mass * length, speed, size)?;
    let waves = 2.0 * speed / mobility;
    if mobility > 0.0 && waves < CARRIED_AWAY * peak * length {
        let law = LineLaw::new(curvature, compliance, size, length)?;
        return Some((TimeScale::LineWaves, 2.0 * law.approach(waves) / speed));
    }
    Some((TimeScale::Line, PI * speed / (inverse_mass * length * peak)))
}

/// Length of a plane body along itself: half its circumference, of a thin one the length of its
/// middle line \[m\].
pub fn length_along(shape: &Shape) -> f64 {
    let patches = &shape.patches;
    let side = |face: Face| -> f64 {
        let patch = &patches[face.id.patch];
        let (lower, upper) = patch.domain();
        let of_direction = |d: usize| -> f64 {
            let at = |k: usize| {
                let mut xi = face.on_face(&lower);
                xi[d] = lower[d] + (upper[d] - lower[d]) * k as f64 / CHORDS as f64;
                patch.point(&xi)
            };
            let chord = |k: usize| -> f64 {
                let (a, b) = (at(k), at(k + 1));
                a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
            };
            (0..CHORDS).map(chord).sum()
        };
        face.directions().map(of_direction).sum()
    };
    0.5 * Face::outer(patches, false).into_iter().map(side).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hertz_impact::HertzImpact;
    use approx::assert_relative_eq;
    use contact_qs::law::hertz::{HertzPair, Solid};

    const STEEL: Solid = Solid { young: 210e9, poisson: 0.3 };
    const ALUMINIUM: Solid = Solid { young: 72.8e9, poisson: 0.33 };

    fn touching(inverse_mass: f64, mobility: f64, speed: f64) -> Touching {
        Touching { inverse_mass, mobility, speed }
    }

    #[test]
    fn masses_have_the_time_of_hertz() {
        let pair = HertzPair::new([STEEL, ALUMINIUM], [0.01, 0.03]);
        let impact = HertzImpact::new(pair, [0.03, 0.2], 0.4);
        let surfaces = [
            LocalSurface::sphere(0.01, STEEL.compliance()),
            LocalSurface::sphere(0.03, ALUMINIUM.compliance()),
        ];
        let (scale, time) = point_time(&surfaces, touching(1.0 / 0.03 + 1.0 / 0.2, 0.0, 0.4)).unwrap();
        assert_eq!(scale, TimeScale::Hertz);
        // Six digits of the constant.
        assert_relative_eq!(time, impact.duration(), max_relative = 1e-5);
    }

    #[test]
    fn a_long_rod_rises_against_its_impedance() {
        // Aluminium rod of 1 m, radius 10 mm, spherical end, 0.3 m/s: the force rises towards A
        // sqrt(E rho) v = 1343 N.
        let surfaces = [LocalSurface::sphere(0.01, ALUMINIUM.compliance()), LocalSurface::plane(0.0)];
        let impedance = PI * 1e-4 * (72.8e9_f64 * 2789.0).sqrt();
        let (scale, time) = point_time(&surfaces, touching(1.0 / 0.8733, 1.0 / impedance, 0.3)).unwrap();
        assert_eq!(scale, TimeScale::Waves);
        let pair = HertzPair::new([ALUMINIUM, Solid::RIGID], [0.01, f64::INFINITY]);
        assert_relative_eq!(time, 2.0 * pair.approach(impedance * 0.3) / 0.3, max_relative = 1e-9);
    }

    #[test]
    fn a_line_contact_is_half_a_period_of_its_spring() {
        let disc = LocalSurface { curvatures: [10.0, 0.0], ..LocalSurface::plane(STEEL.compliance()) };
        let surfaces = [disc, LocalSurface::plane(0.0)];
        let (inverse_mass, speed, length) = (1.0 / 246.0, 0.1, 0.5);
        let line = TouchLine { length, curvature: 10.0, size: 0.2 };
        let (scale, time) = line_time(&surfaces, line, touching(inverse_mass, 0.0, speed)).unwrap();
        assert_eq!(scale, TimeScale::Line);
        let (_, force) = line_impact(10.0, STEEL.compliance(), inverse_mass * length, speed, 0.2).unwrap();
        // Stiffness from energy and force: F^2 / (m v^2).
        let force = force * length;
        let stiffness = force * force * inverse_mass / (speed * speed);
        assert_relative_eq!(time, PI / (stiffness * inverse_mass).sqrt(), max_relative = 1e-12);
        // A solid disc of steel, 246 kg for a metre of its axis, keeps that time with the impedance
        // of a bar of its size: waves come back in time.
        let mobility = 0.2 / (246.0 * (210e9_f64 / 7850.0).sqrt());
        let kept =
            line_time(&surfaces, TouchLine { length: 1.0, ..line }, touching(inverse_mass, mobility, speed));
        assert_eq!(kept.unwrap().0, TimeScale::Line);
    }

    #[test]
    fn a_thin_ring_rises_against_the_waves_in_its_wall() {
        // Outer radius 50 mm, wall 5 mm, 10 mm thick: L/(m c) of its middle line is that of a bar
        // of its section, 1/(ρ c A).
        let (density, speed_of_waves) = (7850.0, 5172.0);
        let (section, along) = (5e-5, PI * 0.095);
        let mass = density * section * along;
        let mobility = along / (mass * speed_of_waves);
        assert_relative_eq!(mobility, 1.0 / (density * speed_of_waves * section), max_relative = 1e-12);
        let ring = LocalSurface { curvatures: [20.0, 0.0], ..LocalSurface::plane(STEEL.compliance()) };
        let surfaces = [ring, LocalSurface::plane(0.0)];
        let line = TouchLine { length: 0.01, curvature: 20.0, size: 0.1 };
        let (scale, time) = line_time(&surfaces, line, touching(1.0 / mass, mobility, 0.1)).unwrap();
        let (_, alone) = line_time(&surfaces, line, touching(1.0 / mass, 0.0, 0.1)).unwrap();
        assert_eq!(scale, TimeScale::LineWaves);
        assert!(time < 0.5 * alone, "{time:e} {alone:e}");
        // Its force is that of waves to both sides.
        let law = LineLaw::new(20.0, STEEL.compliance(), 0.1, 0.01).unwrap();
        let (force, _) = crate::touch::hertz::ImpactLaw::Line(law).force(0.5 * time * 0.1);
        assert_relative_eq!(force, 2.0 * 0.1 / mobility, max_relative = 1e-9);
    }
}
