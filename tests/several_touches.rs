//! Bodies that touch at several places at once: a zone about each, in one problem (docs/theory.md section A.12).

use crate::support::scenarios;

use adaptive::record::warning::WarningKind;
use adaptive::run::recording::Recording;

const STEEL: &str = "[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\nyield_strength = 100e6\n";
/// Lowest points of the feet, on a curve of degree four \[m\].
const FOOT: [f64; 2] = [0.015_491_933_384, 0.003_2];

/// Settings that resolve both feet by themselves, on elements that are given.
const BY_HAND: &str = "model = \"quasistatic\"\ninterval = { width = 0.12 }\npenalty = { initial = 5e17 }\n";

fn refined(points: [[f64; 2]; 2]) -> String {
    let zone = |point| format!("{{ point = {point:?}, width = 4e-4, elements = 48 }}");
    format!("discretisation = {{ refine = [{}, {}] }}\n", zone(points[0]), zone(points[1]))
}

/// A plane bridge on two round feet that falls on `floor`, turned by `turn` degrees; with `by_hand` on elements that are given.
fn bridge(turn: f64, floor: &str, by_hand: bool) -> String {
    let [x, y] = FOOT;
    let mesh = if by_hand { refined([[-x, y], [x, y]]) } else { String::new() };
    let law = if by_hand { BY_HAND } else { "" };
    format!(
        "[simulation]\nend_time = 1e-4\n{STEEL}[bodies.p]\nmodel = \"plane-strain\"\nthickness = 0.01\nmaterial = \"steel\"\n\
         position = [0.0, {}, 0.0]\nvelocity = [0.0, -0.2, 0.0]\norientation_deg = [0.0, 0.0, {turn}]\n{mesh}reduction = {{ modes = 20 }}\n\
         [bodies.p.geometry]\nshape = \"nurbs\"\ndegrees = [4, 1]\nknots = [[0, 0, 0, 0, 0, 1, 1, 1, 1, 1], [0, 0, 1, 1]]\n\
         control_points = [[-0.02, 0.004], [-0.01, 0.0], [0.0, 0.012], [0.01, 0.0], [0.02, 0.004], \
         [-0.02, 0.02], [-0.01, 0.02], [0.0, 0.02], [0.01, 0.02], [0.02, 0.02]]\n\
         {floor}[contacts.c]\ncontact_body = \"p\"\ntarget_body = \"floor\"\n{law}",
        1e-6 + 4e-6 * f64::from(turn > 0.0) - y
    )
}

const PLANE: &str =
    "[bodies.floor]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 1.0, 0.0]\n";

/// A beam under both feet.
fn beam(by_hand: bool) -> String {
    let mesh = if by_hand { refined([[-FOOT[0], 0.005], [FOOT[0], 0.005]]) } else { String::new() };
    format!(
        "[bodies.floor]\nmodel = \"plane-strain\"\nthickness = 0.01\nmaterial = \"steel\"\n\
         geometry = {{ shape = \"rectangle\", size = [0.06, 0.01] }}\nposition = [0.0, -0.005, 0.0]\n{mesh}"
    )
}

/// Peak force \[N\] and impulse [N s] of the only impact of `text`, whose momenta and ledger balance.
fn impact(text: &str) -> ([f64; 2], Recording) {
    let found = scenarios::run_text(text);
    let [impact] = &found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    // The tolerance of the steps over their number.
    assert!(found.energy_drift() < 1e-5, "ledger {:e}", found.energy_drift());
    let momentum = |k: usize| found.samples[k].linear_momentum[1];
    let change = momentum(found.samples.len() - 1) - momentum(0);
    // On the plane the impulse is what the momentum changes by, between two bodies it does not change.
    let wanted = if text.contains("normal = ") { impact.impulse } else { 0.0 };
    // Sums of a thousand steps, each of the tolerance 1e-8 at most.
    println!("{:e} of the impulse", (change - wanted) / impact.impulse);
    assert!((change - wanted).abs() < 1e-6 * impact.impulse, "{change} {wanted}");
    ([impact.peak_force, impact.impulse], found)
}

fn agree(found: [f64; 2], truth: [f64; 2]) {
    println!("{found:?} by itself, {truth:?} by hand");
    // Two discretisations, each right to 0.1 % by its band of zone and penalty factor.
    let is_same = found.iter().zip(truth).all(|(a, b)| (a / b - 1.0).abs() < 2e-3);
    assert!(is_same, "{found:?} {truth:?}");
}

#[test]
fn both_feet_on_a_plane_carry_the_body() {
    let (found, run) = impact(&bridge(0.0, PLANE, false));
    agree(found, impact(&bridge(0.0, PLANE, true)).0);
    // It was told by the first trial, and the second zone costs no more trials.
    assert!(run.trials.len() <= 3, "{} trials", run.trials.len());
    let places = run.transfers.iter().filter_map(|t| t.site).map(|site| site.places().count()).max();
    assert_eq!(places, Some(2));
    // Feet are alike, but for the share by which zones differ that are given by hand.
    let turn = run.samples.last().expect("samples").angular_momentum[2];
    assert!(turn.abs() < 2e-4 * found[1] * FOOT[0], "{turn:e}");
}

#[test]
fn a_foot_that_lands_while_the_other_one_presses_joins_it() {
    agree(impact(&bridge(0.005, PLANE, false)).0, impact(&bridge(0.005, PLANE, true)).0);
}

#[test]
fn a_fork_on_a_bar_has_two_zones_on_both() {
    let (found, run) = impact(&bridge(0.0, &beam(false), false));
    agree(found, impact(&bridge(0.0, &beam(true), true)).0);
    let zones = run.transfers.iter().filter_map(|t| t.target_site).map(|site| site.places().count()).max();
    assert_eq!(zones, Some(2));
}

#[test]
fn what_yields_is_told_of_the_foot_that_is_pressed_hardest() {
    // The first foot has let go by then, the second one has not landed yet \[s\].
    let between = 2.05e-5;
    // Turn [degrees], spin [rad/s], and which foot is pressed harder; each pressed alone, in a zone of its own.
    for (turn, spin, hardest) in
        [(0.008, 4.0, 1), (0.008, 8.0, 1), (0.01, 4.0, 1), (0.01, 0.0, 2), (0.013, 4.0, 2)]
    {
        let told = |end: f64| {
            let text = bridge(turn, PLANE, false)
                .replace("end_time = 1e-4", &format!("end_time = {end:e}"))
                .replace("reduction =", &format!("angular_velocity = [0.0, 0.0, {spin:?}]\nreduction ="));
            let run = scenarios::run_text(&text);
            let peak =
                run.impacts.iter().max_by(|a, b| a.peak_force.total_cmp(&b.peak_force)).expect("an impact");
            let yields: Vec<_> = run.warnings.iter().filter(|w| w.kind == WarningKind::Yields).collect();
            let [yields] = yields[..] else { panic!("{turn} {spin} {end:e}: {} warnings", yields.len()) };
            assert_eq!(
                yields.time.to_bits(),
                peak.peak_time.to_bits(),
                "{turn} {spin} {end:e}: {yields:?} of {peak:?}"
            );
            (peak.peak_time, yields.value)
        };
        let ((time, value), (_, first)) = (told(1e-4), told(between));
        assert_eq!(if time < between { 1 } else { 2 }, hardest, "{turn} {spin}");
        // Of the end of the step that is nearest to the peak, in runs of other steps: the force there is less by the square of a step over
        // the time of the impact, some thirty of them. Peaks of the feet differ by more than a hundredth.
        let is_of_first = (value / first - 1.0).abs() < 1e-3;
        assert_eq!(
            is_of_first,
            hardest == 1,
            "{turn} {spin}: {value:e} Pa, the first foot alone {first:e} Pa"
        );
    }
}
