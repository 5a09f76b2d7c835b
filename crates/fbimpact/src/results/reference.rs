//! The tables of the result reference, from the declarations that the recorder writes by.

use std::fmt::Write as _;

use adaptive::record::warning::WarningKind;
use result_files::stored::pressure_series::{AREA, POINT, POSITION, PRESSURE};
use result_files::tables::{EventRow, ImpactRow, PhaseRow, TableColumn, TableRow, TransferRow, TrialRow};

use super::columns::{self, Axis, Declaration, Stage, TIMINGS};

/// Attributes of the root.
const ATTRIBUTES: [(&str, &str); 12] = [
    ("format", "`fbimpact`"),
    (
        "format_version",
        "1, or 2 where bodies share datasets; raised when an old reader would misread a new file",
    ),
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
const FIXED: [(&str, &str, &str, &str); 16] = [
    (
        "/scenario",
        "text",
        "",
        "Scenario with overrides, defaults and the sizes chosen by the program filled in, as TOML; attributes `sha256` of the file as read, `file`, `inputs_sha256` of what the result follows from: scenario, files that it names, program.",
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
    (
        "/bodies/NAME/eigenfrequencies_uncertainty",
        "n_q",
        "Hz",
        "By how much the mesh may put them off; NaN of static answers and of bodies from files (docs/uncertainty.md).",
    ),
    ("/arrays/bodies/name", "n_b", "", "Names of the bodies, where these share datasets."),
    ("/joints/NAME/coordinates_names", "n_c", "", "Names of the coordinates."),
    ("/joints/NAME/velocities_names", "n_v", "", "Names of the velocities."),
    ("/points/NAME/component", "6", "", "Names of the components of stress and strain."),
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
        "Time for models kept between runs, a part of `sizes` and `reduction`; attributes `hits`, `misses` ([cache.md](cache.md)).",
    ),
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
    out += "| `/arrays/bodies/{position, rotation, velocity, angular_velocity, centre_of_mass}` | n × n_b × 3 or 4 | as of one body | The same of all n_b bodies, in place of those of each, where there are many or `output.arrays` says so. |\n";
    series("/joints/NAME", &columns::JOINT, &mut out);
    series("/joints/NAME", &columns::REACTION, &mut out);
    series("/gears/NAME", &[columns::GEAR], &mut out);
    series("/contacts/NAME", &columns::CONTACT, &mut out);
    series("/contacts/NAME", &columns::CONTACT_COUNTS, &mut out);
    series("/points/NAME", &columns::POINT, &mut out);
    series("/points/NAME", &columns::POINT_STRESS, &mut out);
    series("/points/NAME", &columns::POINT_STRAIN, &mut out);
    out += "\n### Fixed values\n\n| path | shape | unit | holds |\n|---|---|---|---|\n";
    for (path, shape, unit, text) in FIXED {
        let _ = writeln!(out, "| `{path}` | {shape} | {unit} | {text} |");
    }
    for (shape, (name, unit, text)) in
        [("m × 3", POSITION), ("m", AREA), ("sum of `pressure_points`", POINT), ("as `point`", PRESSURE)]
    {
        let _ = writeln!(out, "| `/pressure/NAME/{name}` | {shape} | {unit} | {text} |");
    }
    for Stage { name, description, .. } in TIMINGS {
        let _ = writeln!(
            out,
            "| `/timings/{name}` | 1 | s | {description} Complete and interrupted runs only. |"
        );
    }
    table::<PhaseRow>(&mut out);
    table::<ImpactRow>(&mut out);
    table::<EventRow>(&mut out);
    table::<TrialRow>(&mut out);
    table::<TransferRow>(&mut out);
    out += "\n### Kinds of `/warnings`\n\nThe identifier with which a warning begins, and what was found.\n\n| identifier | meaning |\n|---|---|\n";
    for kind in WarningKind::ALL {
        let _ = writeln!(out, "| `{}` | {} |", kind.identifier(), kind.meaning());
    }
    out
}

fn table<T: TableRow>(out: &mut String) {
    let _ = writeln!(
        out,
        "\n### Table `/{}`\n\n{}\n\n| column | unit | holds |\n|---|---|---|",
        T::NAME,
        T::DESCRIPTION
    );
    for TableColumn { name, unit, meaning } in T::COLUMNS {
        let _ = writeln!(out, "| `{name}` | {unit} | {meaning} |");
    }
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
            Axis::Tensor => ("n × 6", " Where the scenario asks for it; named by `component`."),
        };
        let unit = if d.axis == Axis::Coordinate { "of each, attribute `unit`" } else { d.unit };
        let _ = writeln!(out, "| `{group}/{}` | {shape} | {unit} | {}{note} |", d.name, d.description);
    }
}
