//! The tables of the result reference, from the declarations that the recorder writes by.

use std::fmt::Write as _;

use adaptive::warning::WarningKind;

use super::columns::{self, Axis, Declaration};
use super::pressure::{AREA, POINT, POSITION, PRESSURE};
use super::tables::{IMPACT_UNITS, PHASE_UNITS, TRANSFER_UNITS, TRY_UNITS};

/// A name with its unit and meaning.
type Row = (&'static str, &'static str, &'static str);

/// Attributes of the root.
const ATTRIBUTES: [(&str, &str); 12] = [
    ("format", "`fbimpact`"),
    ("format_version", "1; raised when an old reader would misread a new file"),
    ("program_version", "version of the program"),
    ("commit", "of its sources; `unknown` where there was no git"),
    ("compiler", "that built it"),
    ("target", "machine that it was built for"),
    ("threads", "number of threads of the run"),
    ("created", "start of the run, ISO 8601, UTC"),
    ("title", "of the scenario"),
    ("status", "`running`, `complete`, `interrupted` or `failed`"),
    ("message", "why the run is not complete"),
    ("resumptions", "how often the run was taken up"),
];

/// Fixed datasets besides series and tables: path, shape, unit, meaning.
const FIXED: [(&str, &str, &str, &str); 13] = [
    (
        "/scenario",
        "text",
        "",
        "Scenario with overrides, defaults and the sizes chosen by the program filled in, as TOML; attributes `sha256` of the file as read, `file`.",
    ),
    (
        "/warnings",
        "as many as there are",
        "",
        "Warnings of the run, texts of the form `identifier: subject: what was found; what to change`, in the order in which they were given.",
    ),
    ("/xyz", "3", "", "Names of the components of vectors."),
    ("/wxyz", "4", "", "Names of the components of quaternions."),
    (
        "/bodies/NAME/eigenfrequencies",
        "n_q",
        "Hz",
        "Eigenfrequencies of the elastic coordinates; flexible bodies only.",
    ),
    ("/joints/NAME/coordinates_names", "n_c", "", "Names of the coordinates."),
    ("/joints/NAME/velocities_names", "n_v", "", "Names of the velocities."),
    ("/stress/NAME/distance", "m", "m", "Distance from the first point of the line."),
    ("/stress/NAME/points", "m × 3", "m", "Undeformed points, in the body's frame; named by `coordinate`."),
    (
        "/stress/NAME/stress",
        "m × 6",
        "Pa",
        "Components of stress, named by `component`; attribute `time` in s.",
    ),
    ("/stress/NAME/von_mises", "m", "Pa", "Von Mises stress; attribute `time` in s."),
    ("/stress/NAME/{coordinate, component}", "3, 6", "", "Names of the components."),
    (
        "/timings/cache",
        "1",
        "s",
        "Time for models kept between runs, a part of `reduction`; attributes `hits`, `misses` ([cache.md](cache.md)).",
    ),
];

/// Columns of `/phases`.
const PHASES: [(&str, &str); 7] = [
    ("kind", "`free` or `impact`"),
    ("start", "time at which it starts"),
    ("end", "time at which it ends"),
    ("steps", "accepted steps"),
    ("rejected", "rejected steps"),
    ("evaluations", "evaluations of the right-hand side"),
    ("wall_time", "wall time"),
];

/// Columns of `/impacts`.
const IMPACTS: [(&str, &str); 9] = [
    ("contact", "name of the contact"),
    ("start", "first contact"),
    ("end", "last contact"),
    ("peak_force", "largest normal force"),
    ("peak_time", "its time"),
    ("impulse", "normal force over time"),
    (
        "approach_velocity",
        "of the bodies' rigid motions at the place of contact when it closes, along the normal at the peak (theory A.31)",
    ),
    (
        "separation_velocity",
        "the same when it opens for the last time, positive apart; NaN if the run ends in contact",
    ),
    (
        "restitution",
        "ratio of the two (theory A.32); NaN where it has no meaning: no approach, run ended in contact, the motions still \
         approach each other when the contact opens, another contact pressed the same bodies meanwhile",
    ),
];

/// Columns of `/tries`.
const TRIES: [(&str, &str); 18] = [
    (
        "impact",
        "index of the impact, its row in `/impacts`; arrays count from 0, numbers that people see from 1",
    ),
    ("try", "number of the try, from 1"),
    ("start", "time at which it starts"),
    ("stop", "time reached"),
    ("penalty_start", "penalty factor at the start"),
    ("penalty_end", "penalty factor at the end"),
    ("interval_widths", "width of the contact interval in two directions"),
    ("utilisation", "largest part of it in contact, in two directions"),
    ("elements", "elements of the fine model"),
    ("freedoms", "its freedoms"),
    ("interface_freedoms", "those in the contact zone"),
    ("steps", "accepted steps"),
    ("rejected", "rejected steps"),
    ("peak_force", "largest normal force"),
    ("outcome", "`accepted`, `rejected` or `failed`"),
    ("reason", "why"),
    ("wall_time", "wall time"),
    ("cpu_time", "processor time of the whole process"),
];

/// Columns of `/transfers`.
const TRANSFERS: [(&str, &str); 11] = [
    ("time", "when"),
    ("direction", "`coarse to fine`, `fine to coarse` or `penalty`"),
    ("contact", "name of the contact"),
    ("energy_before", "total energy before"),
    ("energy_after", "total energy after"),
    ("momentum_change", "length of the change of linear momentum"),
    (
        "face",
        "face of the contact body that the interval of the fine model lies on, counted through its patches; -1 if none came",
    ),
    ("centre", "parameters of the interval's centre in the face's patch"),
    ("target_face", "the same of the target body"),
    ("target_centre", "the same of the target body"),
    ("interval_widths", "widths of the interval along the surface"),
];

/// Datasets of `/timings`.
const TIMINGS: [Row; 6] = [
    ("assembly", "s", "Geometry and assembly of the matrices."),
    ("reduction", "s", "Eigenmodes and compliance."),
    ("search", "s", "Contact search."),
    ("contact", "s", "Contact solver."),
    ("integration", "s", "Time integration without contact."),
    ("output", "s", "Writing results."),
];

/// The tables as Markdown.
pub fn markdown() -> String {
    let mut out = String::from("### Attributes of the root\n\n| attribute | holds |\n|---|---|\n");
    for (name, text) in ATTRIBUTES {
        let _ = writeln!(out, "| `{name}` | {text} |");
    }
    out += "\n### Time series\n\nn stored instants, n_q elastic coordinates, n_c coordinates and n_v velocities of a joint.\n\n";
    out += "| path | shape | unit | holds |\n|---|---|---|---|\n";
    series("", &[columns::TIME], &mut out);
    series("", &[columns::PHASE], &mut out);
    series("/energies", &columns::ENERGIES, &mut out);
    series("/momentum", &columns::MOMENTUM, &mut out);
    series("/bodies/NAME", &columns::BODY, &mut out);
    series("/joints/NAME", &columns::JOINT, &mut out);
    series("/joints/NAME", &columns::REACTION, &mut out);
    series("/contacts/NAME", &columns::CONTACT, &mut out);
    series("/contacts/NAME", &columns::CONTACT_COUNTS, &mut out);
    series("/points/NAME", &columns::POINT, &mut out);
    out += "\n### Fixed values\n\n| path | shape | unit | holds |\n|---|---|---|---|\n";
    for (path, shape, unit, text) in FIXED {
        let _ = writeln!(out, "| `{path}` | {shape} | {unit} | {text} |");
    }
    for (shape, (name, unit, text)) in
        [("m × 3", POSITION), ("m", AREA), ("sum of `pressure_points`", POINT), ("as `point`", PRESSURE)]
    {
        let _ = writeln!(out, "| `/pressure/NAME/{name}` | {shape} | {unit} | {text} |");
    }
    for (name, unit, text) in TIMINGS {
        let _ =
            writeln!(out, "| `/timings/{name}` | 1 | {unit} | {text} Complete and interrupted runs only. |");
    }
    for (name, text, units, meanings) in [
        ("phases", "Phases of the run.", PHASE_UNITS, &PHASES[..]),
        ("impacts", "Impacts in the order of their ends.", IMPACT_UNITS, &IMPACTS),
        ("tries", "Tries of every impact phase, one row a try and contact.", TRY_UNITS, &TRIES),
        (
            "transfers",
            "Changes of models in the course of the run, and what they did to the ledger.",
            TRANSFER_UNITS,
            &TRANSFERS,
        ),
    ] {
        let _ = writeln!(out, "\n### Table `/{name}`\n\n{text}\n\n| column | unit | holds |\n|---|---|---|");
        for ((column, unit), (_, meaning)) in units_of(units).zip(meanings) {
            let _ = writeln!(out, "| `{column}` | {unit} | {meaning} |");
        }
    }
    out += "\n### Kinds of `/warnings`\n\nThe identifier with which a warning begins, and when one is given.\n\n| identifier | holds |\n|---|---|\n";
    for kind in WarningKind::ALL {
        let _ = writeln!(out, "| `{}` | {} |", kind.identifier(), kind.meaning());
    }
    out
}

/// Names and units in the text `name: unit, name: unit`.
fn units_of(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split(", ").filter_map(|entry| entry.split_once(": "))
}

fn series<T>(group: &str, declarations: &[Declaration<T>], out: &mut String) {
    for d in declarations {
        let (shape, note) = match d.axis {
            Axis::Scalar => ("n", ""),
            Axis::Space => ("n × 3", ""),
            Axis::Quaternion => ("n × 4", ""),
            Axis::Mode => ("n × n_q", " Flexible bodies only."),
            Axis::Coordinate if d.name == "coordinates" => ("n × n_c", ""),
            Axis::Coordinate => ("n × n_v", ""),
        };
        let unit = if d.axis == Axis::Coordinate { "of each, attribute `unit`" } else { d.unit };
        let _ = writeln!(out, "| `{group}/{}` | {shape} | {unit} | {}{note} |", d.name, d.description);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_of_a_table_has_its_meaning() {
        let tables = [
            (PHASE_UNITS, &PHASES[..]),
            (IMPACT_UNITS, &IMPACTS),
            (TRY_UNITS, &TRIES),
            (TRANSFER_UNITS, &TRANSFERS),
        ];
        for (units, meanings) in tables {
            let units: Vec<&str> = units_of(units).map(|(name, _)| name).collect();
            let meanings: Vec<&str> = meanings.iter().map(|(name, _)| *name).collect();
            assert_eq!(units, meanings);
        }
    }
}
