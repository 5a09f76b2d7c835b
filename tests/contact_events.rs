//! Stick, slip and rest as rows of a result (theory section Q.5): against rigid mechanics.

use adaptive::record::EventKind;
use adaptive::run::recording::Recording;

use crate::support::fbimpact;
use crate::support::scenarios::{folder, run_text};

const GRAVITY: f64 = 9.81;

/// A rigid body of steel on a plane with the friction `friction` in the gravity `(x, 0, z)`, for `end` seconds.
fn on_plane(body: &str, [x, z]: [f64; 2], friction: f64, contact: &str, (end, start): (f64, &str)) -> String {
    format!(
        "[simulation]\nend_time = {end:?}\ngravity = [{x:?}, 0.0, {:?}]\nstart = \"{start}\"\n\
[bodies.a]\nmodel = \"rigid\"\nmaterial = \"steel\"\n{body}\n\
[bodies.floor]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\n\
[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"floor\"\nfriction = {friction:?}\n{contact}\n",
        -z
    )
}

fn plate(speed: f64) -> String {
    format!(
        "geometry = {{ shape = \"box\", size = [0.1, 0.08, 0.01] }}\nposition = [0.0, 0.0, 0.005]\nvelocity = [{speed:?}, 0.0, 0.0]"
    )
}

fn ball(speed: f64) -> String {
    format!(
        "geometry = {{ shape = \"sphere\", radius = 0.01 }}\nposition = [0.0, 0.0, 0.01]\nvelocity = [{speed:?}, 0.0, 0.0]"
    )
}

fn slope(ratio: f64, start: &str) -> Recording {
    let (sin, cos) = (0.3 * ratio).atan().sin_cos();
    let contact = "model = \"coarse\"\ndamping = 1000.0";
    run_text(&on_plane(&plate(0.0), [GRAVITY * sin, GRAVITY * cos], 0.3, contact, (0.02, start)))
}

fn kinds(recording: &Recording) -> Vec<EventKind> {
    recording.events.iter().map(|event| event.kind).collect()
}

/// When `kind` happens for the last time.
fn last(recording: &Recording, kind: EventKind) -> f64 {
    let found = recording.events.iter().rev().find(|event| event.kind == kind);
    found.map(|event| event.time).expect("an event of the kind")
}

#[test]
fn a_plate_on_a_slope_sticks_and_rests_or_slides() {
    use EventKind::{Rest, Slip, Stick, Touch};
    let holds = slope(0.9, "static");
    assert_eq!(kinds(&holds), [Touch, Stick, Rest]);
    assert!(holds.events.iter().all(|event| event.time <= 0.0), "{:?}", holds.events);
    assert_eq!(kinds(&slope(1.1, "given")), [Touch, Slip]);
}

#[test]
fn a_plate_with_speed_slides_and_comes_to_rest() {
    let (speed, friction) = (0.15, 0.3);
    let contact = "model = \"coarse\"\ndamping = 10000.0";
    let text = on_plane(&plate(speed), [0.0, GRAVITY], friction, contact, (0.07, "given"));
    let recording = run_text(&text);
    let expected = speed / (friction * GRAVITY);
    // Friction is less than its bound while the weight sets in, over some ten microseconds.
    for kind in [EventKind::Stick, EventKind::Rest] {
        let found = last(&recording, kind);
        assert!(
            (found / expected - 1.0).abs() < 5e-3,
            "{kind:?}: {found} {expected}, {:?}",
            recording.events
        );
    }
    assert!(recording.events.is_sorted_by_key(|event| event.time));
}

#[test]
fn a_ball_slides_until_it_rolls_and_never_rests() {
    use EventKind::{Slip, Stick, Touch};
    let (speed, friction) = (0.2, 0.1);
    let contact = "model = \"hertz\"\ndamping = 300.0";
    let text = on_plane(&ball(speed), [0.0, GRAVITY], friction, contact, (0.08, "given"));
    let recording = run_text(&text);
    assert_eq!(kinds(&recording), [Touch, Slip, Stick]);
    let file = folder("contact_events").join("ball.toml");
    std::fs::write(&file, &text).unwrap();
    let result = file.with_extension("h5");
    let (code, _, told) =
        fbimpact(&["run", file.to_str().unwrap(), "-o", result.to_str().unwrap(), "-q", "--force"]);
    assert_eq!(code, 0, "{told}");
    let (code, told, _) =
        fbimpact(&["metric", result.to_str().unwrap(), "events.time[2]", "events.normal_force[2]"]);
    let stored: Vec<f64> = told.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let event = recording.events[2];
    assert!(code == 0 && stored.contains(&event.time) && stored.contains(&event.normal_force), "{told}");
    let (_, told, _) = fbimpact(&["info", result.to_str().unwrap()]);
    assert!(told.contains("\nslip ") && told.contains("\nstick ") && !told.contains("\ntouch "), "{told}");
    // Friction brakes the ball by μ g and turns it by 5/2 μ g/R.
    let expected = 2.0 * speed / (7.0 * friction * GRAVITY);
    let found = last(&recording, Stick);
    // As above.
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}
