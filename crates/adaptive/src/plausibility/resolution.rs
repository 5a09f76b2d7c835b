//! What a result leaves out: modes against the duration of impacts, elements against waves and against places of joints and loads, stored
//! instants against vibrations (docs/theory.md Eqs. P.5 to P.7, P.10).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use ffr_dynamics::system::force::BodyState;
use iga_core::elasticity::Model;
use iga_core::extent::Extent;
use iga_core::nurbs::Patch;

use crate::body_model::{BodyModel, ElasticModel};
use crate::record::ImpactRecord;
use crate::spec::{Coupling, Place};
use crate::warning::{Warning, WarningKind};

/// Product of the highest frequency kept and the duration of an impact from which on the spectrum of the force, that of a half
/// sine, is below `1/(4·3.57² - 1)`, a fiftieth of its mean (Eq. P.5): twice what the program allows where it chooses the modes (Eq. N.5).
const CYCLES: f64 = 3.57;
/// Relative error of a frequency above which a mesh is too coarse for its wave (Eq. P.6).
const FREQUENCY_ERROR: f64 = 1e-2;
/// Share of a body's vibration that a mode must carry to be worth storing (Eq. P.7).
const AUDIBLE: f64 = 1e-2;
/// Share of the largest energy of the run that the vibration of a body must carry.
const STRONG: f64 = 1e-3;

/// Relative error of what a place yields under its own load above which its elements are too coarse (Eq. P.10).
const PLACE_ERROR: f64 = 5e-2;

/// Duration of the half sine with the peak and the impulse of an impact, and no longer than the impact \[s\].
pub fn pulse_duration(impact: &ImpactRecord) -> f64 {
    let duration = impact.end - impact.start;
    let pulse = FRAC_PI_2 * impact.impulse.abs() / impact.peak_force;
    if pulse > 0.0 && pulse < duration { pulse } else { duration }
}

/// Highest frequency of the free modes kept \[Hz\]: static answers and modes of an interface stand for what follows its forces.
fn highest_free_mode(body: &BodyModel) -> Option<f64> {
    body.frequencies().into_iter().take(body.coordinates().free).reduce(f64::max)
}

/// The warning of a body whose modes end below what an impact excites, if they do (Eq. P.5).
pub fn few_modes(body: &BodyModel, impact: &ImpactRecord) -> Option<Warning> {
    let highest = highest_free_mode(body)?;
    let duration = pulse_duration(impact);
    let limit = CYCLES / duration;
    let is_few = duration > 0.0 && highest < limit;
    is_few.then(|| Warning {
        kind: WarningKind::FewModes,
        subject: subject(body),
        time: impact.end,
        value: highest,
        limit,
        message: format!(
            "the impact that ended at t = {:.6e} s was a pulse of {duration:.3e} s and excites frequencies up to {limit:.4e} Hz, the \
             highest mode kept has {highest:.4e} Hz",
            impact.end
        ),
        remedy: match body.elastic() {
            Some(_) => format!("raise bodies.{}.reduction.modes", body.name),
            None => format!("give the file of body \"{}\" more modes", body.name),
        },
    })
}

/// The warning of a body whose mesh has too few elements for the wave of its highest mode, if it has (Eq. P.6).
pub fn coarse_mesh(body: &BodyModel) -> Option<Warning> {
    let elastic = body.elastic()?;
    let highest = highest_free_mode(body).filter(|f| *f > 0.0)?;
    let wave = shortest_wave(elastic, highest);
    let element = longest_element(&elastic.body.shape.patches);
    let (found, limit) = (wave / element, elements_per_wave(degree(&elastic.body.shape.patches)));
    let is_coarse = found < limit;
    is_coarse.then(|| Warning {
        kind: WarningKind::CoarseMesh,
        subject: subject(body),
        time: 0.0,
        value: found,
        limit,
        message: format!(
            "waves at {highest:.4e} Hz, its highest mode, are {wave:.3e} m long and cover {found:.2} of its longest elements of \
             {element:.3e} m; {limit:.1} give the frequency to {:.0} %",
            100.0 * FREQUENCY_ERROR
        ),
        remedy: format!("raise bodies.{0}.discretisation.elements or its degree, or keep fewer modes", body.name),
    })
}

/// The warning of a body on which joints or loads hold a disc or ball that its elements do not resolve: of the worst one (Eq. P.10).
pub fn coarse_place(body: &BodyModel) -> Option<Warning> {
    let elastic = body.elastic()?;
    let spec = &elastic.body.spec;
    // Elements over the radius that a place has and needs.
    let sizes = elastic.interface.loads.iter().filter_map(|load| {
        let Place::Area(area) = &load.place else { return None };
        let Extent::Around { radius, .. } = &area.extent else { return None };
        let element = area.extent.longest_element(&spec.shape, &elastic.body.space, &spec.model).ok()??;
        let is_moment = load.directions.iter().any(|d| d[3..].iter().any(|m| *m != 0.0));
        Some((load, area, radius / element, elements_per_radius(area.coupling, is_moment)))
    });
    let (load, area, found, limit) = sizes.min_by(|a, b| (a.2 / a.3).total_cmp(&(b.2 / b.3)))?;
    let remedy = match area.coupling {
        Coupling::Average => "refine bodies.{}.discretisation there or give the place a larger radius",
        Coupling::Rigid => {
            "take coupling = \"average\", hold a whole face, refine bodies.{}.discretisation there or give the place a larger radius"
        }
    };
    (found < limit).then(|| Warning {
        kind: WarningKind::CoarsePlace,
        subject: subject(body),
        time: 0.0,
        value: found,
        limit,
        message: format!(
            "{}, held by {}, has {found:.2} elements over its radius; {limit:.1} give what it yields to {:.0} %",
            area.extent.name(),
            load.name,
            100.0 * PLACE_ERROR
        ),
        remedy: remedy.replace("{}", &body.name),
    })
}

/// Elements over the radius of a disc or ball at which it yields right to [`PLACE_ERROR`] (Eq. P.10): `C (h/a)²` is missing on average,
/// `C h/a` of a rigid one, whose elements at the rim are rigid as a whole; more under moments, which turn no more than the place itself.
fn elements_per_radius(coupling: Coupling, is_moment: bool) -> f64 {
    match (coupling, is_moment) {
        (Coupling::Average, false) => (0.05 / PLACE_ERROR).sqrt(),
        (Coupling::Average, true) => (0.25 / PLACE_ERROR).sqrt(),
        (Coupling::Rigid, false) => 0.6 / PLACE_ERROR,
        (Coupling::Rigid, true) => 1.0 / PLACE_ERROR,
    }
}

/// The warning of a body that vibrates faster than its states are stored, `interval` apart, after the time `time`; `state`: its
/// motion then, `scale`: largest energy of the run \[J\] (Eq. P.7).
pub fn sparse_output(
    body: &BodyModel,
    state: &BodyState,
    (time, interval): (f64, f64),
    scale: f64,
) -> Option<Warning> {
    let frequencies = body.frequencies();
    if frequencies.len() != state.elastic.len() {
        return None; // a fine model with modes of its own
    }
    let coordinates = state.elastic.iter().zip(&state.elastic_rates);
    let energies: Vec<f64> = frequencies
        .iter()
        .zip(coordinates)
        .map(|(f, (q, rate))| 0.5 * ((TAU * f * q).powi(2) + rate * rate))
        .collect();
    let total: f64 = energies.iter().sum();
    if total < STRONG * scale {
        return None;
    }
    let heard = frequencies.iter().zip(&energies).filter(|(_, e)| **e >= AUDIBLE * total);
    let highest = heard.map(|(f, _)| *f).fold(0.0, f64::max);
    let limit = 0.5 / highest;
    let is_sparse = highest > 0.0 && interval > limit;
    is_sparse.then(|| Warning {
        kind: WarningKind::SparseOutput,
        subject: subject(body),
        time,
        value: interval,
        limit,
        message: format!(
            "it vibrates at frequencies up to {highest:.4e} Hz after the impact that ended at t = {time:.6e} s, states are stored every \
             {interval:.3e} s and show no more than {:.4e} Hz",
            0.5 / interval
        ),
        remedy: format!("lower output.free_interval to {limit:.2e} or less"),
    })
}

fn subject(body: &BodyModel) -> String {
    format!("body \"{}\"", body.name)
}

/// Length of the shortest wave of frequency `frequency` that a body carries \[m\]: of shear or, where that is longer than twice the
/// body is thick, of bending (longitudinal in axisymmetric models).
fn shortest_wave(elastic: &ElasticModel, frequency: f64) -> f64 {
    let material = &elastic.body.spec.material;
    let (young, density) = (material.youngs_modulus(), material.density());
    let shear = (young / (2.0 * (1.0 + material.poissons_ratio()) * density)).sqrt() / frequency;
    let thickness = thickness(elastic);
    if shear <= 2.0 * thickness {
        return shear;
    }
    let bar = (young / density).sqrt();
    match elastic.body.spec.model {
        Model::Axisymmetric => bar / frequency,
        // c_b = sqrt(ω r c_0) with the radius of gyration r = d / sqrt(12) of a rectangle.
        _ => (TAU * frequency * thickness / 12.0_f64.sqrt() * bar).sqrt() / frequency,
    }
}

/// Least extent of the body along an axis \[m\]; of an axisymmetric one twice its radius counts.
fn thickness(elastic: &ElasticModel) -> f64 {
    let nodes = &elastic.body.assembled.nodes;
    let is_axisymmetric = elastic.body.spec.model == Model::Axisymmetric;
    let extent = |c: usize| {
        let (low, high) = nodes
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x[c]), high.max(x[c])));
        if is_axisymmetric && c == 0 { 2.0 * high } else { high - low }
    };
    (0..elastic.body.assembled.motion.n_components()).map(extent).fold(f64::INFINITY, f64::min)
}

/// Longest side of an element \[m\].
fn longest_element(patches: &[Patch]) -> f64 {
    let mut longest = 0.0_f64;
    for patch in patches {
        let breaks: Vec<Vec<f64>> = patch.knots().iter().map(|k| k.breaks()).collect();
        let corner = |i: &[usize; 3]| {
            let mut xi = [0.0; 3];
            for (d, list) in breaks.iter().enumerate() {
                xi[d] = list[i[d].min(list.len() - 1)];
            }
            patch.point(&xi)
        };
        let counts = std::array::from_fn::<usize, 3, _>(|d| breaks.get(d).map_or(1, Vec::len));
        for i in (0..counts[0] * counts[1] * counts[2])
            .map(|k| [k % counts[0], k / counts[0] % counts[1], k / (counts[0] * counts[1])])
        {
            let here = corner(&i);
            for d in (0..breaks.len()).filter(|d| i[*d] + 1 < counts[*d]) {
                let mut next = i;
                next[d] += 1;
                let there = corner(&next);
                let square: f64 = here.iter().zip(&there).map(|(a, b)| (a - b) * (a - b)).sum();
                longest = longest.max(square.sqrt());
            }
        }
    }
    longest
}

/// Lowest degree of a patch in any direction.
fn degree(patches: &[Patch]) -> usize {
    patches.iter().flat_map(|p| p.knots().iter().map(|k| k.degree())).min().unwrap_or(1)
}

/// Elements a wave at which the frequency errs by [`FREQUENCY_ERROR`]: `C_p (2π/n)^(2p)` with the constants of smooth splines on a
/// line (Cottrell, Reali, Bazilevs & Hughes 2006); two at least, as for any signal (Eq. P.6).
fn elements_per_wave(degree: usize) -> f64 {
    let constant: f64 = match degree {
        0 | 1 => 1.0 / 24.0,
        2 => 1.0 / 1440.0,
        _ => 1.0 / 60480.0,
    };
    let order = 2.0 * degree.clamp(1, 3) as f64;
    (2.0 * PI * (constant / FREQUENCY_ERROR).powf(1.0 / order)).max(2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spectrum_of_a_half_sine_is_a_fiftieth_beyond_the_limit() {
        // |F(f)|/F(0) = |cos(π f T)/(1 - 4 f² T²)|, its bound at the limit; to three digits.
        assert!((1.0 / (4.0 * CYCLES * CYCLES - 1.0) - 0.02).abs() < 1e-4);
        let impact = |duration: f64, peak: f64, impulse: f64| ImpactRecord {
            end: duration,
            peak_force: peak,
            impulse,
            ..ImpactRecord::default()
        };
        // A half sine of 2 s and peak 3 has the impulse 2/π · 3 · 2; round-off.
        assert!((pulse_duration(&impact(10.0, 3.0, 12.0 / PI)) - 2.0).abs() < 1e-12);
        assert!(
            (pulse_duration(&impact(1.0, 3.0, 12.0 / PI)) - 1.0).abs() < 1e-12,
            "no longer than the impact"
        );
        assert!((pulse_duration(&impact(1.0, 0.0, 0.0)) - 1.0).abs() < 1e-12, "without force");
    }

    #[test]
    fn higher_degrees_need_fewer_elements_a_wave() {
        // (2π/n)² / 24 = 0.01, (2π/n)⁴ / 1440 = 0.01, (2π/n)⁶ / 60480 = 0.01.
        for (degree, n) in [(1, 12.83), (2, 3.225), (3, 2.161), (5, 2.161)] {
            assert!((elements_per_wave(degree) - n).abs() < 1e-2, "{degree}: {}", elements_per_wave(degree));
        }
    }
}
