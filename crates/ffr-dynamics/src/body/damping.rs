//! Damping of elastic coordinates: Rayleigh's from two frequencies, and a ratio for each mode.
//!
//! Modes are mass-orthonormal, so that `D_e = α_1 M_e + α_2 K_e` is diagonal (docs/theory.md
//! Eqs. F.26 to F.28; \[B\] Eqs. 26-28). Damping acts on the elastic coordinates alone: rigid
//! motion loses nothing, whatever the mass-proportional part.

use std::f64::consts::{PI, TAU};

use super::standard_input_data::ModalDamping;
use crate::data_error::DataError;
use crate::error::DynamicsError;

/// Rayleigh damping `D_e = α_1 M_e + α_2 K_e`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayleighDamping {
    /// Factor `α_1` of the mass matrix [1/s].
    pub mass: f64,
    /// Factor `α_2` of the stiffness matrix \[s\].
    pub stiffness: f64,
}

impl RayleighDamping {
    /// Damping whose ratio is `ratio` (κ) at both `frequencies` \[Hz\], less between and more
    /// outside them (Eq. F.26).
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a frequency is not positive or the ratio is negative.
    pub fn from_frequencies(frequencies: [f64; 2], ratio: f64) -> Result<Self, DynamicsError> {
        let [first, second] = frequencies;
        let is_frequency = |f: f64| f > 0.0 && f.is_finite();
        if !is_frequency(first) || !is_frequency(second) {
            let value = if is_frequency(first) { second } else { first };
            let what = "a frequency of Rayleigh damping [Hz]".to_owned();
            return Err(DataError::OutOfRange { what, value, range: "> 0 and finite" }.into());
        }
        check_ratio(ratio, "Rayleigh damping")?;
        let stiffness = ratio / (PI * (first + second)); // [B] Eq. 27
        Ok(Self { mass: 4.0 * PI * PI * first * second * stiffness, stiffness }) // [B] Eq. 26
    }

    /// Damping ratio at `frequency` \[Hz\]: `(α_1/ω + α_2 ω)/2` (Eq. F.27).
    pub fn ratio(&self, frequency: f64) -> f64 {
        let omega = TAU * frequency;
        0.5 * (self.mass / omega + self.stiffness * omega)
    }

    /// Coefficients `α_1 + α_2 ω_j²` of modes with squared frequencies `modal_stiffness` [rad²/s²].
    pub fn modal(&self, modal_stiffness: &[f64]) -> ModalDamping {
        ModalDamping::PerMode(modal_stiffness.iter().map(|k| self.mass + self.stiffness * k).collect())
    }
}

/// What the damping ratios of a body's vibrations are, whatever holds it.
#[derive(Debug, Clone, PartialEq)]
pub enum DampingLaw {
    /// A ratio for each mode, the last for all that follow.
    Ratios(Vec<f64>),
    /// Rayleigh damping.
    Rayleigh(RayleighDamping),
}

impl DampingLaw {
    /// Ratio of mode `number` (from 0) of the angular frequency `omega` [rad/s].
    pub fn ratio(&self, number: usize, omega: f64) -> f64 {
        match self {
            Self::Ratios(ratios) => ratios.get(number).or(ratios.last()).copied().unwrap_or(0.0),
            Self::Rayleigh(damping) => damping.ratio(omega / TAU),
        }
    }

    /// Whether it damps at all.
    pub fn is_any(&self) -> bool {
        match self {
            Self::Ratios(ratios) => ratios.iter().any(|r| *r > 0.0),
            Self::Rayleigh(damping) => damping.mass > 0.0 || damping.stiffness > 0.0,
        }
    }
}

impl ModalDamping {
    /// Coefficients `2 ζ_j ω_j` (Eq. F.28) from one damping ratio for each mode, 1 being critical;
    /// `modal_stiffness`: squared frequencies [rad²/s²].
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if numbers differ or a ratio is negative.
    pub fn from_ratios(ratios: &[f64], modal_stiffness: &[f64]) -> Result<Self, DynamicsError> {
        if ratios.len() != modal_stiffness.len() {
            let (found, expected) = (ratios.len(), modal_stiffness.len());
            return Err(DataError::Count { what: "damping ratios of modes".into(), found, expected }.into());
        }
        for (j, &ratio) in ratios.iter().enumerate() {
            check_ratio(ratio, &format!("mode {}", j + 1))?;
        }
        Ok(Self::PerMode(ratios.iter().zip(modal_stiffness).map(|(z, k)| 2.0 * z * k.sqrt()).collect()))
    }
}

fn check_ratio(ratio: f64, subject: &str) -> Result<(), DynamicsError> {
    if ratio >= 0.0 && ratio.is_finite() {
        return Ok(());
    }
    let what = format!("the damping ratio of {subject}");
    Err(DataError::OutOfRange { what, value: ratio, range: ">= 0 and finite" }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rayleigh_ratio_is_kappa_at_both_frequencies_and_less_between() {
        let damping = RayleighDamping::from_frequencies([2e3, 5e4], 0.03).unwrap();
        for f in [2e3, 5e4] {
            assert!((damping.ratio(f) - 0.03).abs() < 1e-16); // round-off
        }
        // Least at the geometric mean: sqrt(α_1 α_2).
        let least = damping.ratio(1e4);
        assert!((least - (damping.mass * damping.stiffness).sqrt()).abs() < 1e-16 && least < 0.03);
    }

    #[test]
    fn rayleigh_and_ratios_agree_mode_by_mode() {
        let stiffness: Vec<f64> = [1e3, 7e3, 9e4].iter().map(|f| (TAU * f).powi(2)).collect();
        let damping = RayleighDamping::from_frequencies([1e3, 1e5], 0.1).unwrap();
        let ratios: Vec<f64> = [1e3, 7e3, 9e4].iter().map(|&f| damping.ratio(f)).collect();
        let by_ratio = ModalDamping::from_ratios(&ratios, &stiffness).unwrap();
        let (ModalDamping::PerMode(a), ModalDamping::PerMode(b)) = (damping.modal(&stiffness), by_ratio)
        else {
            panic!("both are diagonal");
        };
        assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-14 * x)); // round-off
    }

    #[test]
    fn values_that_make_no_damping_are_refused() {
        assert!(RayleighDamping::from_frequencies([0.0, 1.0], 0.1).is_err());
        assert!(RayleighDamping::from_frequencies([1.0, f64::NAN], 0.1).is_err());
        assert!(RayleighDamping::from_frequencies([1.0, 2.0], -0.1).is_err());
        assert!(ModalDamping::from_ratios(&[0.1], &[1.0, 2.0]).is_err());
        assert!(ModalDamping::from_ratios(&[f64::INFINITY], &[1.0]).is_err());
    }
}
