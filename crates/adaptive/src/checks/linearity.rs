//! Limits of linear bodies: how far their parts rotate, how much they strain, and how near axial
//! loads are to the loads that buckle them (docs/theory.md Eqs. P.13, P.14).

use std::f64::consts::TAU;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::elasticity::Material;
use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::error::AdaptiveError;
use crate::record::finding::BodyQuantity;
use crate::record::warning::{Warning, WarningKind};
use crate::spec::ReductionSpec;
use crate::system::body::{BodyModel, FlexibleModel};
use crate::system::mode_gradients::GradientsAt;

/// Rotation of a part of a body against the body as a whole \[rad\] above which a warning is given:
/// a cantilever under a load at its tip, whose tip rotates by 1.5 times as much, then deflects by 1
/// % too much.
pub const LARGE_TURN: f64 = 0.1;
/// Rotation at which a run ends: a cantilever's tip has moved by more than its length \[rad\].
pub const HUGE_TURN: f64 = 1.2;
/// Strain above which a warning is given: the squares of strains, which are neglected, are a per
/// cent of them.
pub const LARGE_STRAIN: f64 = 1e-2;
/// Strain at which a run ends.
pub const HUGE_STRAIN: f64 = 0.5;
/// Ratio of axial load to buckling load above which a warning is given: deflections change by this
/// share.
pub const AXIAL_LOAD: f64 = 0.02;
/// Ratio of axial load to buckling load in compression at which a run ends: the estimate is better
/// than this factor.
pub const BUCKLED: f64 = 2.0;
/// Ratio of angular velocity to first natural frequency above which a warning is given: the square
/// of the frequency changes by up to 1.2 times the square of this ratio.
pub const FAST_SPIN: f64 = 0.2;

/// Strain by the centrifugal force of a spin that the basis does not answer above which a warning is
/// given: 2 MPa in steel, of which some per cent are wrong.
pub const SPIN_STRAIN: f64 = 1e-5;

/// Number of modes in which buckling is looked for: three pairs of bending modes of a rod.
const N_BUCKLING: usize = 6;
/// Ratio of the first frequency to that of waves along the body above which a body is not slender:
/// it would yield before it buckles.
const SLENDER: f64 = 2.0;
/// First frequency of a beam that is clamped at one end over that of the free beam:
/// (1.8751/4.7300)².
const CLAMPED: f64 = 0.157;
/// Largest number of entries that are kept of the gradients of a body's modes.
const MOST_NUMBERS: usize = 1 << 20;

/// The largest values that a body has reached of the quantities that linear theory limits.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Extremes {
    /// Largest turn of a part \[rad\], and when.
    pub turn: (f64, f64),
    /// Largest strain, and when.
    pub strain: (f64, f64),
    /// Load over buckling load of the largest size, negative in compression, and when.
    pub load: (f64, f64),
    /// Largest angular velocity over the first natural frequency, and when.
    pub spin: (f64, f64),
    /// Largest strain by the centrifugal force of a spin that the basis does not answer, and when.
    pub spin_strain: (f64, f64),
}

/// Rotations, strains and geometric stiffness of the modes of a body.
#[derive(Debug, Clone, Default, PartialEq)]
struct LinearBody {
    /// Turns of each mode, three numbers for every point, against the body as a whole.
    turns: DMatrix<f64>,
    /// Strains of each mode, six numbers for every point.
    strains: DMatrix<f64>,
    /// Largest turn and strain of each mode.
    largest: Vec<(f64, f64)>,
    /// Geometric stiffness by a unit of each mode between the lowest ones, over their frequencies
    /// (P.14).
    by_mode: Vec<DMatrix<f64>>,
    /// First natural frequency as the body is held [rad/s]; infinite where spin does not matter.
    first: f64,
    /// Half its size over the speed of its slowest waves along bars \[s\]; zero where nothing is left
    /// out of its modes.
    crossing: f64,
    /// Axes of the spins that its basis answers.
    spins: Vec<Vector3<f64>>,
    /// Time over which the load is averaged \[s\].
    memory: f64,
}

/// The limits of linear theory for the bodies of a run.
#[derive(Debug, Clone, Default)]
pub struct LinearLimits {
    bodies: Vec<LinearBody>,
    /// Extreme values since the last [`LinearLimits::begin`].
    extremes: Vec<Extremes>,
    /// Averages of the geometric stiffness, body after body, and their time.
    averages: Vec<DMatrix<f64>>,
    time: Option<f64>,
}

impl LinearLimits {
    /// Limits of the bodies `models`; `held` gives, where a joint holds all of a body, how its
    /// modes turn there.
    ///
    /// # Errors
    /// [`AdaptiveError`] if a body cannot be evaluated.
    pub fn new<'a>(
        models: &[BodyModel],
        held: impl Fn(usize) -> Option<&'a ffr_dynamics::kinematics::Marker>,
    ) -> Result<Self, AdaptiveError> {
        let bodies: Vec<LinearBody> = models
            .iter()
            .enumerate()
            .map(|(b, model)| LinearBody::new(model, held(b)))
            .collect::<Result<_, _>>()?;
        let averages = bodies.iter().map(LinearBody::no_load).collect();
        Ok(Self { extremes: vec![Extremes::default(); bodies.len()], averages, bodies, time: None })
    }

    /// The averages of the loads, to be stored with the run.
    pub fn averages(&self) -> Vec<f64> {
        self.averages.iter().flat_map(|a| a.iter().copied()).collect()
    }

    /// Begins a phase, or a trial of one, with stored `averages`; with none of them the first look
    /// gives them.
    pub fn begin(&mut self, averages: &[f64], time: f64) {
        self.extremes.fill(Extremes::default());
        let n: usize = self.averages.iter().map(DMatrix::len).sum();
        self.time = (averages.len() == n && n > 0).then_some(time);
        if self.time.is_some() {
            let stored = self.averages.iter_mut().flat_map(|a| a.iter_mut());
            stored.zip(averages).for_each(|(to, from)| *to = *from);
        }
    }

    /// Takes the motions `states` at time `time`.
    ///
    /// # Errors
    /// [`AdaptiveError::ImplausibleBody`] if a body of `models` is far beyond a limit.
    pub fn note(
        &mut self,
        models: &[BodyModel],
        states: &[BodyState],
        time: f64,
    ) -> Result<(), AdaptiveError> {
        let elapsed = self.time.map(|before| time - before);
        self.time = Some(time);
        for (b, (body, state)) in self.bodies.iter().zip(states).enumerate() {
            // Own modes of a fine model may be of another number.
            if body.largest.is_empty() || body.largest.len() != state.elastic.len() {
                continue;
            }
            let average = &mut self.averages[b];
            let share = elapsed.map_or(1.0, |dt| 1.0 - (-dt / body.memory).exp());
            if !average.is_empty() && share > 0.0 {
                *average *= 1.0 - share;
                for (q, matrix) in state.elastic.iter().zip(&body.by_mode) {
                    *average += matrix * (share * q);
                }
            }
            let (turn, strain) = body.deformation(&state.elastic);
            let spin = state.angular_velocity_in_body.norm() / body.first;
            let spin_strain = body.spin_strain(&state.angular_velocity_in_body);
            let load = extreme_eigenvalue(average);
            let found = &mut self.extremes[b];
            for (largest, value) in [
                (&mut found.turn, turn),
                (&mut found.strain, strain),
                (&mut found.load, load),
                (&mut found.spin, spin),
                (&mut found.spin_strain, spin_strain),
            ] {
                if value.abs() > largest.0.abs() || value.is_nan() {
                    *largest = (value, time);
                }
            }
            let beyond = [
                (BodyQuantity::Turn, turn, HUGE_TURN),
                (BodyQuantity::Strain, strain, HUGE_STRAIN),
                (BodyQuantity::Load, -load, BUCKLED),
            ];
            if let Some((quantity, value, limit)) = beyond.into_iter().find(|(_, value, limit)| value > limit)
            {
                let body = models[b].name.clone();
                return Err(AdaptiveError::ImplausibleBody { body, time, quantity, value, limit });
            }
        }
        Ok(())
    }

    /// Warnings of what the motions have shown since the last [`LinearLimits::begin`], with the
    /// indices of the bodies.
    pub fn warnings(&self, models: &[BodyModel]) -> Vec<(usize, Warning)> {
        let of_body = |(b, found): (usize, &Extremes)| {
            let name = &models[b].name;
            warnings(name, found).map(move |warning| (b, warning)).collect::<Vec<_>>()
        };
        self.extremes.iter().enumerate().flat_map(of_body).collect()
    }
}

/// Warnings of body `name` that has gone as far as `found`.
fn warnings(name: &str, found: &Extremes) -> impl Iterator<Item = Warning> {
    let warning = |kind, (value, time): (f64, f64), limit, message, remedy: &str| Warning {
        kind,
        subject: format!("body \"{name}\""),
        time,
        value,
        limit,
        message,
        remedy: remedy.to_owned(),
    };
    const DIVIDE: &str =
        "divide the body into two or more, joined by `fixed` (docs/limits.md, with what that gives)";
    let turn = found.turn.0;
    let load = found.load.0;
    let all = [
        (turn > LARGE_TURN).then(|| {
            let message = format!(
                "parts of it turn by up to {turn:.2} rad against the whole by deformation; from {LARGE_TURN} rad on linear deformation is off by \
                 1 % and more, as the square of this angle"
            );
            warning(WarningKind::LargeTurn, found.turn, LARGE_TURN, message, DIVIDE)
        }),
        (found.strain.0 > LARGE_STRAIN).then(|| {
            let message = format!(
                "its strain reaches {:.1e}; linear elasticity is right to about the strain itself, and most materials have yielded before",
                found.strain.0
            );
            let remedy = "check loads and the units of the material, or take the result as one beyond the yield point of the material";
            warning(WarningKind::LargeStrain, found.strain, LARGE_STRAIN, message, remedy)
        }),
        (load.abs() > AXIAL_LOAD).then(|| {
            let side = if load < 0.0 { "pressed along itself" } else { "pulled along itself" };
            let message = format!(
                "it is {side} by some {:.0} % of the load that buckles it as it is held: deflections and squares of frequencies are off by \
                 about as much",
                100.0 * load.abs()
            );
            warning(WarningKind::AxialLoad, found.load, AXIAL_LOAD, message, DIVIDE)
        }),
        (found.spin.0 > FAST_SPIN).then(|| {
            let message = format!(
                "it spins at {:.2} of its first natural frequency: centrifugal forces change the square of that by up to {:.0} %",
                found.spin.0,
                120.0 * found.spin.0.powi(2)
            );
            let remedy = format!("set bodies.{name}.geometric_stiffening = true, or divide the body into two or more, joined by `fixed`");
            warning(WarningKind::FastSpin, found.spin, FAST_SPIN, message, &remedy)
        }),
        (found.spin_strain.0 > SPIN_STRAIN).then(|| {
            let message = format!(
                "it has a spin whose centrifugal force strains it by {:.0e} and more and to which its modes have no static answer: stress by \
                 it is off by up to a tenth",
                found.spin_strain.0
            );
            let remedy = format!(
                "give more bodies.{name}.reduction.modes until the stress stays; a spin that is given at the start, or prescribed, has its \
                 static answer, unless static_answers = false"
            );
            warning(WarningKind::SpinStress, found.spin_strain, SPIN_STRAIN, message, &remedy)
        }),
    ];
    all.into_iter().flatten()
}

/// Speed of the body's slowest waves along bars [m/s]; infinite if its material is not known.
fn bar_speed(flexible: &FlexibleModel) -> f64 {
    flexible.body.slowest_material().map_or(f64::INFINITY, Material::bar_speed)
}

/// Half the size of a body over the speed of its waves \[s\]; zero of one with all its modes.
fn crossing(flexible: &FlexibleModel) -> f64 {
    let is_whole = flexible.body.settings().reduction == ReductionSpec::All;
    if is_whole { 0.0 } else { 0.5 * flexible.body.size() / bar_speed(flexible) }
}

impl LinearBody {
    fn new(
        model: &BodyModel,
        held: Option<&ffr_dynamics::kinematics::Marker>,
    ) -> Result<Self, AdaptiveError> {
        let frequencies: Vec<f64> = model.frequencies().iter().map(|f| TAU * f).collect();
        let n = frequencies.len();
        let Some(fields) = model.mode_fields().filter(|_| n > 0 && model.data.motion != RigidMotion::Axial)
        else {
            return Ok(Self { first: f64::INFINITY, ..Self::default() });
        };
        let lowest: Vec<usize> = (0..model.coordinates().free.min(n)).take(N_BUCKLING).collect();
        let first = lowest.first().map_or(f64::INFINITY, |j| frequencies[*j]);
        let is_slender = model
            .flexible()
            .is_some_and(|flexible| first * flexible.body.size() < SLENDER * bar_speed(flexible));
        let held = held.filter(|marker| marker.n_modes() == n || marker.is_still());
        let at_marker = |j: usize| {
            held.filter(|marker| marker.n_modes() == n)
                .map_or_else(Vector3::zeros, |marker| Vector3::from_fn(|c, _| marker.rotation_row(c)[j]))
        };
        let turned: Vec<Matrix3<f64>> = (0..n).map(|j| at_marker(j).cross_matrix()).collect();
        let mut by_mode = vec![DMatrix::<f64>::zeros(lowest.len(), lowest.len()); n];
        let mut points: Vec<GradientsAt> = Vec::new();
        let (mut whole, mut mass) = (vec![Vector3::zeros(); n], 0.0);
        let (mut every, mut number) = (1_usize, 0_usize);
        fields.for_each_point(&mut |at| {
            mass += at.mass;
            for (sum, gradient) in whole.iter_mut().zip(&at.gradients) {
                *sum += turn_of(gradient) * at.mass;
            }
            if is_slender && !at.stresses.is_empty() {
                add_stiffness(&at, &lowest, &turned, &mut by_mode);
            }
            if number % every == 0 {
                points.push(at);
                if points.len() * n * 9 > MOST_NUMBERS {
                    // Every second of those kept, and of those to come.
                    let mut k = 0_usize;
                    points.retain(|_| {
                        k += 1;
                        k % 2 == 1
                    });
                    every *= 2;
                }
            }
            number += 1;
        })?;
        whole.iter_mut().for_each(|sum| *sum /= mass);
        let scale = model.data.mass / mass;
        for matrix in &mut by_mode {
            for (a, i) in lowest.iter().enumerate() {
                for (b, j) in lowest.iter().enumerate() {
                    matrix[(a, b)] *= scale / (frequencies[*i] * frequencies[*j]);
                }
            }
        }
        let first = if held.is_some() { CLAMPED * first } else { first };
        let is_stiffened = model.data.geometric_stiffening().is_some();
        if !is_slender || is_stiffened {
            by_mode.clear();
        }
        let turns = DMatrix::from_fn(3 * points.len(), n, |row, j| {
            (turn_of(&points[row / 3].gradients[j]) - whole[j])[row % 3]
        });
        let strains =
            DMatrix::from_fn(6 * points.len(), n, |row, j| strain_of(&points[row / 6].gradients[j])[row % 6]);
        let size = |of: &DMatrix<f64>, width: usize, j: usize| {
            let column = (0..of.nrows() / width)
                .map(|p| (0..width).map(|c| of[(p * width + c, j)].powi(2)).sum::<f64>());
            column.fold(0.0, f64::max).sqrt()
        };
        let largest = (0..n).map(|j| (size(&turns, 3, j), size(&strains, 6, j))).collect();
        Ok(Self {
            turns,
            strains,
            largest,
            by_mode,
            crossing: model.flexible().map_or(0.0, crossing),
            spins: model.flexible().map_or_else(Vec::new, |flexible| flexible.interface.loads.spins.clone()),
            first: if is_stiffened { f64::INFINITY } else { first },
            memory: 1.0 / first,
        })
    }

    /// The strain `(ω a/c)²` by the centrifugal force of the spin `turn` [rad/s], times the sine of
    /// the angle to the next axis that the basis answers.
    fn spin_strain(&self, turn: &Vector3<f64>) -> f64 {
        let rate = turn.norm();
        let sine = |axis: &Vector3<f64>| axis.cross(turn).norm() / rate;
        let away = if rate > 0.0 { self.spins.iter().map(sine).fold(1.0, f64::min) } else { 0.0 };
        (rate * self.crossing).powi(2) * away
    }

    /// The geometric stiffness without load.
    fn no_load(&self) -> DMatrix<f64> {
        let n = self.by_mode.first().map_or(0, DMatrix::nrows);
        DMatrix::zeros(n, n)
    }

    /// Largest turn \[rad\] and strain with the coordinates `q`; bounds of them as long as these
    /// are below the limits of the warnings.
    fn deformation(&self, q: &[f64]) -> (f64, f64) {
        let bound = |of: fn(&(f64, f64)) -> f64| -> f64 {
            self.largest.iter().zip(q).map(|(largest, q)| of(largest) * q.abs()).sum()
        };
        let (turn, strain) = (bound(|l| l.0), bound(|l| l.1));
        let exact = |fields: &DMatrix<f64>, width: usize| {
            let at = |p: usize| {
                let value = |c: usize| -> f64 {
                    q.iter().enumerate().map(|(j, q)| fields[(p * width + c, j)] * q).sum()
                };
                (0..width).map(|c| value(c).powi(2)).sum::<f64>().sqrt()
            };
            (0..fields.nrows() / width).map(at).fold(0.0, f64::max)
        };
        (
            if turn > LARGE_TURN { exact(&self.turns, 3) } else { turn },
            if strain > LARGE_STRAIN { exact(&self.strains, 6) } else { strain },
        )
    }
}

/// Adds the geometric stiffness of the modes `lowest` by the stress of each mode at a point; their
/// rotation at a held place is subtracted (P.14).
fn add_stiffness(at: &GradientsAt, lowest: &[usize], turned: &[Matrix3<f64>], to: &mut [DMatrix<f64>]) {
    let volume = at.mass / at.density;
    let own: Vec<Matrix3<f64>> = lowest.iter().map(|j| at.gradients[*j] - turned[*j]).collect();
    for (sum, stress) in to.iter_mut().zip(&at.stresses) {
        for (a, left) in own.iter().enumerate() {
            let pulled = left * stress * volume;
            for (b, right) in own.iter().enumerate().skip(a) {
                let value = pulled.dot(right);
                sum[(a, b)] += value;
                if a != b {
                    sum[(b, a)] += value;
                }
            }
        }
    }
}

/// Half the curl of a displacement.
fn turn_of(g: &Matrix3<f64>) -> Vector3<f64> {
    0.5 * Vector3::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)])
}

/// Strains, those of shear so that the sum of the squares is that of the tensor.
fn strain_of(g: &Matrix3<f64>) -> [f64; 6] {
    let shear = |i: usize, j: usize| std::f64::consts::FRAC_1_SQRT_2 * (g[(i, j)] + g[(j, i)]);
    [g[(0, 0)], g[(1, 1)], g[(2, 2)], shear(0, 1), shear(1, 2), shear(2, 0)]
}

/// The eigenvalue of largest absolute value; where the norm of the matrix, which bounds it, is
/// below the limit of the warning, the norm.
fn extreme_eigenvalue(matrix: &DMatrix<f64>) -> f64 {
    let size = matrix.norm();
    if size <= AXIAL_LOAD || size.is_nan() {
        return size; // a bound; not a number stays none
    }
    let values = matrix.clone().symmetric_eigenvalues();
    values.iter().fold(0.0, |most: f64, v| if v.abs() > most.abs() { *v } else { most })
}
