//! The reference page of the scenario file, from the key tables.

use std::fmt::Write as _;

use crate::scenario::changes::standard_materials::{STANDARD_MATERIALS, StandardMaterial};
use crate::scenario::keys::units;
use crate::scenario::keys::{Choice, Key, Kind, Named, Variant};
use crate::scenario::tables::{CurveKind, SCENARIO, ShapeName};

/// Text before the tables.
const HEAD: &str = "\
# Scenario file

A scenario is a TOML file. This page is printed by `fbimpact reference`; every line of it stands in the key tables that
the program checks a scenario against.

- SI units and radians. Where the table says so, a key that ends in `_deg` may be given instead, in degrees.
- A number may have a unit, as a text with a space between: `\"10 mm\"`, `[\"10 mm\", 0.0, \"2 cm\"]`, `\"20 deg\"`, `\"210 GPa\"`, `\"3000 rpm\"`; the end of this page has
  the units. Where the unit depends on another key, as `m, rad` on the type of a joint, it is that of the coordinate: lengths for displacements, angles for rotations.
- Unknown keys, wrong types, numbers outside their range, NaN and infinities are faults, and so are keys on which nothing depends; only
  materials may be described of which no body is made. All faults of a file are
  reported together, each with file, line, key, value and what is allowed; the exit code is 3.
- `--set KEY=VALUE` changes a key before the checks: `--set bodies.ball.velocity=[0,0,-0.2]`,
  `--set bodies.ball.discretisation.refine[0].elements=32`. A value that is not TOML is taken as a string.
- Names of bodies, materials, contacts and outputs have 1 to 64 letters, digits, `_` and `-`.
- Points of a body are given in the components of its model: `[x, y, z]` for `solid`, `[x, y]` for plane models,
  `[r, z]` for `axisymmetric` ones. Bodies from files have no points, only the markers of their file.
- Joints and loads hold parts of flexible bodies, not points: a `face`, a `point` with a `radius`, or a marker that has one of
  them ([Places](places.md) says what that means and shows the faces).
- The first line `#:schema <path to the output of fbimpact schema>` lets editors complete and check the file.
";

/// The page as Markdown.
pub fn markdown() -> String {
    let mut out = HEAD.to_owned();
    let _ = writeln!(out, "\n## Top level\n");
    section(SCENARIO, "", &mut out);
    places(&mut out);
    curves(&mut out);
    materials(&mut out);
    let _ = writeln!(out, "\n## Units\n\nBy quantity, the unit of plain numbers first.\n");
    for units in units::all() {
        let names: Vec<String> = units.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(out, "- {}", names.join(", "));
    }
    out
}

/// The materials that need no table.
fn materials(out: &mut String) {
    let _ = writeln!(
        out,
        "\n## Materials by name\n\nA body may name one of these without a table; a table `[materials.NAME]` of the scenario's own takes its \
         place, `--set materials.NAME.KEY=VALUE` changes one value. The values used stand in the result file.\n\n\
         | name | Young's modulus [GPa] | Poisson's ratio | density [kg/m³] | yield strength [MPa] | source |\n|---|---|---|---|---|---|"
    );
    for StandardMaterial { name, youngs_modulus, poissons_ratio, density, yield_strength, source } in
        STANDARD_MATERIALS
    {
        let strength =
            if yield_strength.is_finite() { (yield_strength / 1e6).to_string() } else { "–".into() };
        let _ = writeln!(
            out,
            "| `{name}` | {} | {poissons_ratio} | {density} | {strength} | {source} |",
            youngs_modulus / 1e9
        );
    }
}

/// The forms of a quantity over time.
fn curves(out: &mut String) {
    let _ = writeln!(
        out,
        "\n## Quantities over time\n\nDrives, prescribed motions and loads are given as a number, which is a constant, or as a table: \
         `motion = {{ kind = \"spin-up\", rate = 6.0, duration = 15.0 }}`. The key `kind` decides on the others. \
         Values have the unit of the key that they are given for, `U`."
    );
    for Variant { choice, keys } in CurveKind::VARIANTS {
        let _ = writeln!(out, "\n### `kind = \"{}\"`\n\n{}\n", choice.name, choice.doc);
        rows(keys, out);
    }
}

fn section(keys: &[Key], path: &str, out: &mut String) {
    rows(keys, out);
    for key in keys {
        let name = if path.is_empty() { key.name.to_owned() } else { format!("{path}.{}", key.name) };
        match &key.kind {
            Kind::Table(keys) => chapter(&format!("[{name}]"), key.doc, keys, &name, out),
            Kind::Named(keys) | Kind::NamedByFile(keys) => {
                let name = format!("{name}.NAME");
                chapter(&format!("[{name}]"), key.doc, keys, &name, out);
            }
            Kind::Tables(keys) => chapter(&format!("[[{name}]]"), key.doc, keys, &name, out),
            Kind::Variants { tag, variants } => {
                let _ =
                    writeln!(out, "\n## `[{name}]`\n\n{} The key `{tag}` decides on the others.", key.doc);
                for Variant { choice, keys } in *variants {
                    let _ = writeln!(out, "\n### `{tag} = \"{}\"`\n\n{}", choice.name, choice.doc);
                    shape(choice.name, out);
                    if !keys.is_empty() {
                        out.push('\n');
                        rows(keys, out);
                    }
                }
            }
            _ => {}
        }
    }
}

/// Models of a shape, with the names of its points and faces.
fn shape(name: &str, out: &mut String) {
    let code = |list: &[&str]| list.iter().map(|m| format!("`{m}`")).collect::<Vec<_>>().join(", ");
    out.push('\n');
    for facts in ShapeName::named(name).map_or(&[][..], ShapeName::models) {
        let part = |what: &str, names: &[&str]| {
            if names.is_empty() { String::new() } else { format!("; {what} {}", code(names)) }
        };
        let (markers, faces) = (part("markers", facts.markers), part("faces", facts.faces));
        let _ = writeln!(out, "- model `{}`{markers}{faces}", facts.model.name());
    }
}

fn chapter(title: &str, doc: &str, keys: &[Key], path: &str, out: &mut String) {
    let _ = writeln!(out, "\n## `{title}`\n\n{doc}\n");
    section(keys, path, out);
}

/// Keys of the part of a body that a joint, a load or a marker takes hold of, which stand once on
/// the page.
const PLACE: [&str; 5] = ["marker", "face", "point", "radius", "coupling"];

/// Whether `keys` name such a part.
fn has_place(keys: &[Key]) -> bool {
    PLACE[1..].iter().all(|name| keys.iter().any(|key| key.name == *name))
}

/// The keys of a place, with all that they say of any.
fn places(out: &mut String) {
    let inside = |keys: &'static [Key], name: &str| -> &'static [Key] {
        match keys.iter().find(|key| key.name == name).map(|key| &key.kind) {
            Some(Kind::Table(keys) | Kind::Named(keys)) => keys,
            _ => &[],
        }
    };
    let of_joints = inside(inside(SCENARIO, "joints"), "parent");
    let _ = writeln!(
        out,
        "\n## Places on bodies\n\nWhat a side of a joint, a load or a marker takes hold of; `[bodies.NAME.markers.NAME]` has no `marker`. \
         What it means, and the faces of all shapes: [Places](places.md).\n"
    );
    out.push_str(TABLE);
    for key in of_joints.iter().filter(|key| PLACE.contains(&key.name)) {
        row(key, out);
    }
}

/// Head of a table of keys.
const TABLE: &str = "| key | value | unit | default | meaning |\n|---|---|---|---|---|\n";

fn rows(keys: &[Key], out: &mut String) {
    out.push_str(TABLE);
    let is_place = |key: &Key| has_place(keys) && PLACE.contains(&key.name);
    let place: Vec<String> =
        keys.iter().filter(|key| is_place(key)).map(|key| format!("`{}`", key.name)).collect();
    let mut is_told = false;
    for key in keys {
        if !is_place(key) {
            row(key, out);
        } else if !is_told {
            is_told = true;
            let _ = writeln!(
                out,
                "| {} | – | – | one must be given | [Place](#places-on-bodies) on the body. |",
                place.join(", ")
            );
        }
    }
}

fn row(key: &Key, out: &mut String) {
    let degrees = if key.degrees { format!(", `{}_deg`", key.name) } else { String::new() };
    let default = match (key.need.default().as_deref(), key.need.otherwise()) {
        (Some("{}" | "[]"), _) => "empty".to_owned(),
        (Some(text), _) => format!("`{text}`"),
        (None, Some(text)) => text,
        (None, None) => "**required**".to_owned(),
    };
    let value = match &key.kind {
        Kind::Choice(choices) => list(choices),
        Kind::Choices(choices) => format!("a list of some of {}", list(choices)),
        Kind::ChoiceOrNumber(choices, range) => {
            format!("{}, or a number {}", list(choices), range.words())
        }
        Kind::NumberOrVariants { range, .. } => {
            format!("a number {}, or a [table](#quantities-over-time)", range.words())
        }
        kind => kind.allowed(""),
    };
    let unit = if key.unit.is_empty() { "–" } else { key.unit };
    let conditions = key.conditions().replace('"', "`");
    let _ =
        writeln!(out, "| `{}`{degrees} | {value} | {unit} | {default} | {}{conditions} |", key.name, key.doc);
}

fn list(choices: &[Choice]) -> String {
    let shown: Vec<String> = choices.iter().map(|c| format!("`\"{}\"`: {}", c.name, c.doc)).collect();
    shown.join("; ")
}
