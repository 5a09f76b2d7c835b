//! Forces over time that are something else than their points say: cubic splines that nobody has
//! asked for, which run beyond the points between them and go on behind the last one.

use adaptive::spec::time_curve::CubicSpline;

use crate::scenario::section::Section;
use crate::scenario::tables::{CurveKind, Interpolation};

/// Share of the range of the values by which a spline may run beyond them without a word: one
/// through seven or more points of each wave of a sine runs 5 % beyond them at most, to its peaks.
const BEYOND: f64 = 0.05;
/// Places between two points at which a spline is looked at.
const PLACES: usize = 8;

/// What is to be said of the tables over time below `section`, of a run that ends at `end` \[s\].
pub fn of_all(section: &Section, end: f64) -> Vec<String> {
    let inner = section.items.iter().flat_map(|item| item.value.subtables());
    inner.flat_map(|(_, table)| of_one(table, end).into_iter().chain(of_all(table, end))).collect()
}

/// The doubts about the force of one table.
fn of_one(table: &Section, end: f64) -> Vec<String> {
    let is_spline = table.choice("kind") == Some(CurveKind::Table)
        && table.choice("interpolation") == Some(Interpolation::Smooth)
        && !table.given("interpolation");
    let is_force = table.quantity.starts_with('N');
    let is_periodic = table.boolean("periodic") == Some(true);
    let (Some(times), Some(values)) = (table.numbers("times"), table.numbers("values")) else {
        return Vec::new();
    };
    if !is_spline || !is_force {
        return Vec::new();
    }
    let spline = if is_periodic { CubicSpline::periodic } else { CubicSpline::new };
    let Some(spline) = spline(times.to_vec(), values.to_vec()) else { return Vec::new() };
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
    };
    let (least, most) = range(&mut values.iter().copied());
    let allowed = BEYOND * (most - least);
    let remedy =
        "give \"interpolation\" with \"linear\" for lines between the points, \"smooth\" if this is meant";
    let mut doubts = Vec::new();
    let between = times
        .windows(2)
        .flat_map(|pair| (1..PLACES).map(move |k| pair[0] + (pair[1] - pair[0]) * k as f64 / PLACES as f64));
    let (low, high) = range(&mut between.map(|t| spline.at(t)[0]));
    let worst = if least - low > high - most { low } else { high };
    if worst < least - allowed || worst > most + allowed {
        doubts.push(format!(
            "{}: a cubic spline runs through its points and reaches {worst:.4e} between them, their values lie from {least:.4e} to \
             {most:.4e}; {remedy}",
            table.path
        ));
    }
    let last = times[times.len() - 1];
    if !is_periodic && last < end {
        let at_end = spline.at(end)[0];
        if at_end < least - allowed || at_end > most + allowed {
            doubts.push(format!(
                "{}: behind its last point, at {last:.4e} s, it goes on with a constant rate and reaches {at_end:.4e} at the end of the \
                 run; {remedy}",
                table.path
            ));
        }
    }
    doubts
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scenario::parse;

    /// Doubts about a force of the given points in a run of 10 ms.
    fn doubts(points: &str) -> Vec<String> {
        let text = format!(
            "[simulation]\nend_time = 1e-2\n[bodies.a]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1.0, 1.0, 1.0]\n\
             [loads.f]\nbody = \"a\"\npoint = [0.0, 0.0, 0.0]\nforce_x = {{ kind = \"table\", {points} }}\n"
        );
        parse(Path::new("a.toml"), text.as_bytes(), &[]).expect("a scenario").doubts
    }

    #[test]
    fn splines_that_leave_their_points_are_told() {
        let spike = "times = [0.0, 0.001, 0.002, 0.003, 0.004], values = [0.0, 0.0, 100.0, 0.0, 0.0]";
        let found = doubts(spike);
        assert!(found.len() == 2 && found[0].contains("between them"), "{found:?}");
        assert!(found[1].contains("goes on with a constant rate"), "{found:?}");
        for asked in ["linear", "steps", "smooth"] {
            assert!(doubts(&format!("{spike}, interpolation = \"{asked}\"")).is_empty(), "{asked}");
        }
        // Lines are what they are; eight points of a wave have peaks 4 % beyond the points at most.
        assert!(doubts("times = [0.0, 0.02], values = [0.0, 5.0]").is_empty());
        let wave = |k: usize| (std::f64::consts::TAU * (k as f64 + 0.5) / 8.0).sin();
        let (times, values): (Vec<f64>, Vec<f64>) = (0..9).map(|k| (k as f64 * 2e-3, wave(k))).unzip();
        assert!(doubts(&format!("times = {times:?}, values = {values:?}")).is_empty());
    }
}
