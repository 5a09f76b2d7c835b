//! `fbimpact modes --system`: eigenfrequencies of the assembled system.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use ffr_dynamics::system::{SystemMode, SystemModes};

use crate::cache;
use crate::cli::CacheArguments;
use crate::commands::scenario_file;
use crate::commands::{Means, print, threads};
use crate::error::AppError;
use crate::progress::while_building;
use crate::scenario::Override;
use crate::simulate;

/// Least share of a body in the kinetic energy of a mode that is listed.
const LISTED: f64 = 0.01;
/// Part of a mode's stiffness without a potential that is worth a word: far above round-off;
/// squared, as it moves frequencies that are apart, far below a per mille.
const ASYMMETRY: f64 = 1e-6;
/// Acceleration up to which a pose counts as equilibrium [m/s²]: a millionth of gravity on earth.
const BALANCED: f64 = 1e-5;

/// Vibrations of a system, for people and for programs.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
struct Report {
    /// Eigenfrequencies of all modes that are not unstable \[Hz\], rising; zero for rigid motions.
    frequencies: Vec<f64>,
    /// One entry per frequency: shares of the bodies.
    modes: Vec<Mode>,
    /// Modes that grow.
    unstable: Vec<Unstable>,
    /// Modes of zero frequency.
    rigid_body_modes: usize,
    /// Coordinates of joints and modes.
    coordinates: usize,
    /// Independent constraints of loops.
    constraints: usize,
    /// Acceleration of the pose left alone, root mean square over the mass [m/s²].
    acceleration: f64,
    /// Part of the stiffness of modes that has no potential and is left out.
    asymmetry: f64,
}

/// A mode.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
struct Mode {
    /// Eigenfrequency \[Hz\].
    frequency: f64,
    /// Damping ratio, 1 being critical; none of a rigid motion.
    damping_ratio: Option<f64>,
    /// Shares of kinetic energy by body.
    participation: BTreeMap<String, f64>,
}

/// A mode that grows.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
struct Unstable {
    /// Rate of growth \[1/s\].
    growth_rate: f64,
    /// Shares of kinetic energy by body.
    participation: BTreeMap<String, f64>,
}

/// Builds the system and prints its spectrum at the initial pose; `is_static`: after the elastic
/// coordinates have come to rest under the forces there, whatever the scenario says.
///
/// # Errors
/// Whatever reading and building answer; [`AppError::Model`] if there is no equilibrium.
pub fn system_modes(
    path: &Path,
    overrides: &[Override],
    (is_static, json): (bool, bool),
    means: Means<'_>,
    cache: &CacheArguments,
) -> Result<(), AppError> {
    let n_threads = threads(means.threads)?;
    let scenario = scenario_file::read(path, overrides)?;
    let cache = cache::open(&cache.settings());
    let build = || simulate::system_modes_with(&scenario, is_static, n_threads, &cache);
    let (names, modes) = while_building(means.bar, build)?;
    let report = Report::new(&names, &modes);
    let text =
        if json { serde_json::to_string_pretty(&report).map(|t| t + "\n") } else { Ok(report.table()) };
    print(&text?)
}

impl Report {
    fn new(names: &[String], system: &SystemModes) -> Self {
        let participation = |mode: &SystemMode| -> BTreeMap<String, f64> {
            let shares = names.iter().cloned().zip(mode.shares.iter().copied());
            shares.filter(|(_, share)| *share >= LISTED).collect()
        };
        let (unstable, stable): (Vec<&SystemMode>, Vec<_>) =
            system.modes.iter().partition(|m| m.squared_frequency < 0.0);
        let stable = stable.into_iter();
        let modes: Vec<Mode> = stable
            .map(|m| Mode {
                frequency: m.frequency(),
                damping_ratio: m.damping_ratio(),
                participation: participation(m),
            })
            .collect();
        Self {
            frequencies: modes.iter().map(|m| m.frequency).collect(),
            rigid_body_modes: modes.iter().filter(|m| m.frequency <= 0.0).count(),
            unstable: unstable
                .into_iter()
                .map(|m| Unstable { growth_rate: m.growth_rate(), participation: participation(m) })
                .collect(),
            modes,
            coordinates: system.n_coordinates,
            constraints: system.n_constraints,
            acceleration: system.acceleration,
            asymmetry: system.asymmetry,
        }
    }

    /// For people. Writing to a string cannot fail.
    fn table(&self) -> String {
        let mut out = format!(
            "system: {} coordinates, {} independent constraints of loops, {} modes of rigid motion, {} unstable modes\n",
            self.coordinates,
            self.constraints,
            self.rigid_body_modes,
            self.unstable.len()
        );
        if self.acceleration > BALANCED {
            let _ = writeln!(
                out,
                "the pose is no equilibrium, left alone it accelerates by {:.3e} m/s²: the modes are those of the system held there by its inertia forces",
                self.acceleration
            );
        }
        if self.asymmetry > ASYMMETRY {
            let _ = writeln!(
                out,
                "following loads or moments have no potential: up to {:.1e} of the stiffness of modes that they couple is left out",
                self.asymmetry
            );
        }
        for mode in &self.unstable {
            let rate = format!("e^({:.6} t/s)", mode.growth_rate);
            let _ = writeln!(out, "unstable {rate:>16}     {}", shares(&mode.participation));
        }
        let is_damped = self.modes.iter().any(|m| m.damping_ratio.is_some_and(|z| z > 0.0));
        for (i, mode) in self.modes.iter().enumerate() {
            let ratio = mode.damping_ratio.filter(|_| is_damped);
            let ratio = ratio.map_or(String::new(), |z| format!("damping ratio {z:.6}  "));
            let by = shares(&mode.participation);
            let _ = writeln!(out, "{:>6} {:>18.6} Hz  {ratio}{by}", i + 1, mode.frequency);
        }
        out
    }
}

/// Shares, the largest first.
fn shares(participation: &BTreeMap<String, f64>) -> String {
    let mut list: Vec<(&String, f64)> = participation.iter().map(|(name, share)| (name, *share)).collect();
    list.sort_by(|a, b| b.1.total_cmp(&a.1));
    list.iter().map(|(name, share)| format!("{name} {:.1} %", 100.0 * share)).collect::<Vec<_>>().join(", ")
}
