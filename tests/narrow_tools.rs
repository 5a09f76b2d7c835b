//! Flat tools that are narrower than the elements under them: punches and blades on bodies of splines (docs/theory.md Eq. C.102), judged by the
//! same impacts with fine elements and stiff springs that the scenario gives.

use crate::support::scenarios;
use std::fmt::Write as _;

use adaptive::record::ImpactRecord;

/// What both bodies of a scenario say, and the material of tools: a hundred times as heavy as steel, so that an impact lasts longer than waves.
const WORLD: &str = "[simulation]\nend_time = 2.5e-5\n[materials.heavy]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 785000.0\n\
    [contacts.c]\ncontact_body = \"block\"\ntarget_body = \"tool\"\n";
/// Height of the tools over the block \[m\].
const GAP: f64 = 1e-6;

/// A block of the kind and the keys `block` under a tool with the keys `tool`, with further `keys` of the contact.
fn scenario(keys: &str, block: &str, tool: &str) -> String {
    format!(
        "{WORLD}{keys}\n[bodies.block]\nmaterial = \"steel\"\n{block}\n[bodies.tool]\nvelocity = {tool}\n"
    )
}

/// A tool of rigid `heavy` material with the motion, shape and place given, at 1 m/s.
fn rigid(motion: &str, geometry: &str, position: [f64; 3]) -> String {
    let along = if motion == "planar" { [0.0, -1.0, 0.0] } else { [0.0, 0.0, -1.0] };
    format!(
        "{along:?}\nmodel = \"rigid\"\nmotion = \"{motion}\"\nmaterial = \"heavy\"\ngeometry = {{ {geometry} }}\nposition = {position:?}"
    )
}

/// The only impact of `text` and the width of its zone \[m\]; its ledger is closed to the sum of the errors of its steps, and its momentum kept to round-off.
fn impact(text: &str) -> (ImpactRecord, f64) {
    let found = scenarios::run_text(text);
    let [impact] = &found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    assert!(found.energy_drift() < 1e-5, "ledger {:e}", found.energy_drift());
    let sum = |k: usize| found.samples[k].linear_momentum.map(f64::abs).iter().sum::<f64>();
    let change = (sum(found.samples.len() - 1) - sum(0)).abs();
    assert!(change < 1e-10 * sum(0), "momentum {change:e}");
    println!("{:.6e} N, {:.5e} s, {:.6e} N s", impact.peak_force, impact.end - impact.start, impact.impulse);
    let width = found.trials.last().expect("a trial").interval_widths[0];
    (*impact, width)
}

/// The same, whose zone is the one about a flat end of the extent `extent` along its first direction, `points` of which lie across the end.
fn narrow(text: &str, extent: f64, points: f64) -> ImpactRecord {
    let (found, width) = impact(text);
    // Widths have twenty bits, and round ends are looked at in steps.
    assert!((width / (extent * 16.0 / points) - 1.0).abs() < 0.01, "{width:e}");
    found
}

/// Whether peak force, duration and impulse agree to the share `within`.
fn check(name: &str, found: &ImpactRecord, wanted: &ImpactRecord, within: f64) {
    let of = |i: &ImpactRecord| [i.peak_force, i.end - i.start, i.impulse];
    for ((a, b), what) in of(found).into_iter().zip(of(wanted)).zip(["peak", "duration", "impulse"]) {
        println!("{name}: {what} {:+.2} %", 100.0 * (a / b - 1.0));
        assert!((a / b - 1.0).abs() < within, "{name}: {what} {a:e} {b:e}");
    }
}

/// Springs of twins: stiff enough to change the force by less than 0.3 % when ten times as stiff.
const STIFF: &str = "penalty = { initial = 1e18 }";

/// An axisymmetric block under a punch of 1 mm; with `by_hand` on elements that are given.
fn round(by_hand: bool) -> String {
    let (keys, mesh) = match by_hand {
        true => (STIFF, "discretisation = { refine = [{ marker = \"end\", width = 1e-3, elements = 40 }] }"),
        false => ("", ""),
    };
    let block = format!(
        "model = \"axisymmetric\"\ngeometry = {{ shape = \"rod\", radius = 0.0112838, length = 0.01 }}\nposition = [0.0, 0.0, -0.01]\n{mesh}"
    );
    scenario(
        keys,
        &block,
        &rigid("axial", "shape = \"cylinder\", radius = 5e-4, length = 0.01", [0.0, 0.0, GAP]),
    )
}

/// Twins have pressures that are the too stiff the longer their elements, with 40 across by 0.3 to 0.7 % of the force, zones 0.5 to 0.8 % too soft.
const TWINS: f64 = 0.02;

#[test]
fn a_round_punch_presses_as_on_fine_elements() {
    check("punch", &narrow(&round(false), 5e-4, 11.5), &impact(&round(true)).0, TWINS);
}

/// A plane block under a blade of the width `width` at `x`, rigid or `is_flexible`.
fn blade(by_hand: bool, is_flexible: bool, width: f64, x: f64) -> String {
    let (keys, mesh) = match by_hand {
        true => (
            STIFF,
            format!(
                "discretisation = {{ refine = [{{ point = [{x}, 0.005], width = 1e-3, elements = 40 }}] }}"
            ),
        ),
        false => ("", String::new()),
    };
    let block = format!(
        "model = \"plane-strain\"\nthickness = 0.01\ngeometry = {{ shape = \"rectangle\", size = [0.02, 0.01] }}\n{mesh}"
    );
    let (shape, y) = (format!("shape = \"rectangle\", size = [{width}, 2e-3]"), 0.006 + GAP);
    let tool = match is_flexible {
        true => format!(
            "[0.0, -1.0, 0.0]\nmodel = \"plane-strain\"\nthickness = 0.01\nmaterial = \"steel\"\ngeometry = {{ {shape} }}\nposition = [{x}, {y}, 0.0]"
        ),
        false => rigid("planar", &shape, [x, y, 0.0]).replace("\"planar\"", "\"planar\"\nthickness = 0.01"),
    };
    scenario(keys, &block, &tool)
}

#[test]
fn blades_press_as_on_fine_elements() {
    for (name, is_flexible, width, x) in
        [("blade", false, 4e-4, 0.0), ("aside", false, 3e-4, 2.3e-3), ("flexible", true, 4e-4, 0.0)]
    {
        let of = |by_hand| blade(by_hand, is_flexible, width, x);
        check(name, &narrow(&of(false), width, 11.0), &impact(&of(true)).0, TWINS);
    }
}

/// Four-node elements of 0.05 mm over 0.4 by 2 mm about the origin, in metres, as an input file of Abaqus.
fn grid() -> String {
    let mut text = "*NODE\n".to_owned();
    for (i, j) in (0..41).flat_map(|j| (0..9).map(move |i| (i, j))) {
        let at = |k: usize, n: usize| 5e-5 * (k as f64 - 0.5 * n as f64);
        writeln!(text, "{}, {:e}, {:e}", 1 + i + 9 * j, at(i, 8), at(j, 40)).expect("written");
    }
    text += "*ELEMENT, TYPE=CPE4, ELSET=BLADE\n";
    for (e, (i, j)) in (0..40).flat_map(|j| (0..8).map(move |i| (i, j))).enumerate() {
        let a = 1 + i + 9 * j;
        writeln!(text, "{}, {a}, {}, {}, {}", e + 1, a + 1, a + 10, a + 9).expect("written");
    }
    text
}

#[test]
fn a_blade_of_finite_elements_presses_as_one_of_splines() {
    let folder = scenarios::folder("narrow_blade");
    std::fs::write(folder.join("blade.inp"), grid()).expect("written");
    let splines = blade(false, true, 4e-4, 0.0);
    let shape = "geometry = { shape = \"rectangle\", size = [0.0004, 2e-3] }";
    assert!(splines.contains(shape), "{splines}");
    let text = splines.replace(shape, "file = \"blade.inp\"\nunits = \"m\"");
    let meshed = scenarios::run(&scenarios::valid(&folder, &text, &[]));
    // Elements an eighth of the width long see little of the pressure at its rims: twice as long, the duration is off by 1.1 %.
    check("finite elements", &meshed.impacts[0], &impact(&splines).0, 0.01);
}

#[test]
fn a_blade_over_the_end_of_a_block_presses_with_what_lies_on_it() {
    // 0.35 mm of 0.4 do.
    let of = |by_hand| blade(by_hand, false, 4e-4, 9.85e-3);
    check("over the end", &narrow(&of(false), 3.5e-4, 11.0), &impact(&of(true)).0, TWINS);
}

/// A `block` under a rigid tool of the `geometry` at `place`, turned by `turn` degrees.
fn solid(block: &str, geometry: &str, place: [f64; 3], turn: f64) -> String {
    let tool = rigid("spatial", geometry, place);
    scenario("", block, &format!("{tool}\norientation_deg = [0.0, 0.0, {turn}]"))
}

const BOX: &str = "geometry = { shape = \"box\", size = [0.02, 0.02, 0.01] }";

#[test]
#[ignore = "second tier: half a minute"]
fn solid_punches_press_as_axisymmetric_ones_at_every_turn_and_place() {
    let cylinder = "geometry = { shape = \"cylinder\", radius = 0.0112838, length = 0.01 }\nposition = [0.0, 0.0, -0.01]";
    let round_end = "shape = \"cylinder\", radius = 5e-4, length = 0.01";
    let found = narrow(&solid(cylinder, round_end, [0.0, 0.0, GAP], 0.0), 1e-3, 11.0);
    check("cylinder", &found, &impact(&round(true)).0, 0.025);
    // Along the rows of elements and askew to them, where as many points lie under the end but for a few.
    let square = |turn: f64| {
        let text = solid(BOX, "shape = \"box\", size = [1e-3, 1e-3, 0.01]", [0.0, 0.0, 0.01 + GAP], turn);
        let turn = turn.to_radians();
        narrow(&text, 1e-3 * (turn.cos() + turn.sin()), 11.0)
    };
    check("turned", &square(30.0), &square(0.0), 0.01);
}
