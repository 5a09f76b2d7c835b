//! Copies of a body, and contacts of many bodies in one table, are the bodies and contacts that one would have typed.

use std::path::Path;

use fbimpact::scenario::{self, Fault, Scenario};
use nalgebra::Vector3;

const BALL: &str =
    "model = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = \"10 mm\" }\n";

fn parse(text: &str) -> Result<Scenario, Vec<Fault>> {
    let text = format!("[simulation]\nend_time = 1e-3\n{text}");
    scenario::parse(Path::new("case.toml"), text.as_bytes(), &[]).map_err(|f| f.list().to_vec())
}

fn read(text: &str) -> Scenario {
    parse(text).unwrap_or_else(|faults| panic!("{faults:#?}"))
}

fn copies(how: &str) -> Scenario {
    read(&format!("[bodies.ball]\n{BALL}{how}"))
}

fn positions(scenario: &Scenario) -> Vec<Vector3<f64>> {
    scenario.run.bodies.iter().map(|body| body.motion.position).collect()
}

#[test]
fn a_row_with_contacts_by_star_is_the_run_of_bodies_and_contacts_typed_one_by_one() {
    let floor =
        "[bodies.floor]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nposition = [0.0, 0.0, -0.1]\n";
    let short = format!(
        "[bodies.ball]\n{BALL}position = [\"1 mm\", 0.0, 0.0]\nvelocity = [0.0, 0.0, -1.0]\ncopies = {{ arrangement = \"row\", count = 3, step = [\"25 mm\", 0.0, 0.0] }}\n\
         {floor}[contacts.each]\ncontact_body = \"ball-*\"\ntarget_body = \"ball-*\"\nmodel = \"hertz\"\n\
         [contacts.floor]\ncontact_body = \"ball-*\"\ntarget_body = \"floor\"\nmodel = \"hertz\"\nfriction = 0.1\n"
    );
    let mut long = String::new();
    for i in 0..3 {
        let x = 0.001 + 0.025 * f64::from(i);
        long += &format!(
            "[bodies.ball-{}]\n{BALL}position = [{x:?}, 0.0, 0.0]\nvelocity = [0.0, 0.0, -1.0]\n",
            i + 1
        );
    }
    long += floor;
    for (a, b) in [(1, 2), (1, 3), (2, 3)] {
        long += &format!(
            "[contacts.each-{a}-{b}]\ncontact_body = \"ball-{a}\"\ntarget_body = \"ball-{b}\"\nmodel = \"hertz\"\n"
        );
    }
    for a in 1..=3 {
        long += &format!(
            "[contacts.floor-{a}]\ncontact_body = \"ball-{a}\"\ntarget_body = \"floor\"\nmodel = \"hertz\"\nfriction = 0.1\n"
        );
    }
    let (short, long) = (read(&short), read(&long));
    assert_eq!(short.run, long.run);
    assert_eq!(read_again(&short).run, short.run, "the scenario in the result is that of ordinary bodies");
}

fn read_again(scenario: &Scenario) -> Scenario {
    scenario::parse(Path::new("resolved.toml"), scenario.source.resolved.as_bytes(), &[]).expect("reads back")
}

#[test]
fn grids_and_rings_stand_where_they_should() {
    let grid = positions(&copies(
        "position = [1.0, 2.0, 3.0]\ncopies = { arrangement = \"grid\", counts = [2, 3, 2], spacing = [0.1, 0.2, 0.3] }",
    ));
    assert_eq!(grid.len(), 12);
    // Numbers of one or two operations: the last digit.
    let at = |i: usize, expected: [f64; 3]| {
        assert!((grid[i] - Vector3::from(expected)).norm() < 1e-15 * 8.0, "{:?}", grid[i])
    };
    at(1, [1.1, 2.0, 3.0]);
    at(2, [1.0, 2.2, 3.0]);
    at(11, [1.1, 2.4, 3.3]);
    assert_eq!(
        copies("copies = { arrangement = \"grid\", counts = 2, spacing = [1.0, 1.0, 1.0] }").bodies.len(),
        8
    );
    assert_eq!(
        copies("copies = { arrangement = \"grid\", counts = [2, 3], spacing = [1.0, 1.0, 1.0] }")
            .bodies
            .len(),
        6
    );

    let ring = |more: &str| {
        copies(&format!(
            "position = [0.5, 0.0, 0.2]\nvelocity = [1.0, 0.0, 2.0]\norientation_deg = [90, 0, 0]\ncopies = {{ arrangement = \"ring\", count = 4{more} }}"
        ))
    };
    let turned = &ring("").run.bodies[1].motion;
    assert!((turned.position - Vector3::new(0.0, 0.5, 0.2)).norm() < 1e-15);
    assert!((turned.velocity - Vector3::new(0.0, 1.0, 2.0)).norm() < 1e-15);
    // A quarter of a turn about z of one about x is a third of a turn about (1, 1, 1): all components are 1/2.
    assert!(turned.rotation.coords.iter().all(|x| (x - 0.5).abs() < 1e-15), "{turned:?}");
    let kept = &ring(", turned = false, centre = [0.0, 0.0, 9.0], axis = [0, 0, -2]").run.bodies[1].motion;
    assert!((kept.position - Vector3::new(0.0, -0.5, 0.2)).norm() < 2e-15);
    assert_eq!(kept.velocity, Vector3::new(1.0, 0.0, 2.0));
}

#[test]
fn copies_at_random_are_apart_and_the_same_for_the_same_seed() {
    let random = |more: &str| {
        let how =
            "arrangement = \"random\", count = 200, from = [0, 0, 0], to = [0.2, 0.2, 0.2], distance = 0.02";
        copies(&format!("position = [1.0, 0.0, 0.0]\ncopies = {{ {how}{more} }}"))
    };
    let first = random("");
    let places = positions(&first);
    for (i, a) in places.iter().enumerate() {
        assert!((0..3).all(|k| (0.0..=0.2).contains(&(a - Vector3::x())[k])), "{a}");
        assert!(places[..i].iter().all(|b| (a - b).norm() >= 0.02), "{a}");
    }
    assert_eq!(first.run, random("").run);
    assert_ne!(places, positions(&random(", seed = 2")));
    let turned = random(", turned = true");
    assert_eq!(places, positions(&turned));
    // Means of 200 unit quaternions of the uniform distribution are 0 within 1/2 / sqrt(200) = 0.035; four of those.
    for k in 0..4 {
        let mean = turned.run.bodies.iter().map(|body| body.motion.rotation.coords[k]).sum::<f64>() / 200.0;
        assert!(mean.abs() < 0.14, "{k}: {mean}");
    }
}

#[test]
fn fifty_balls_in_a_box_are_three_tables_of_contacts_at_most() {
    let mut text = format!(
        "[bodies.ball]\n{BALL}copies = {{ arrangement = \"grid\", counts = [5, 5, 2], spacing = [0.03, 0.03, 0.03] }}\n"
    );
    for (side, normal) in [("left", "[1, 0, 0]"), ("right", "[-1, 0, 0]"), ("floor", "[0, 0, 1]")] {
        text += &format!(
            "[bodies.wall-{side}]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nposition = [{}, 0.0, -0.5]\nnormal = {normal}\n",
            match side {
                "left" => -0.5,
                "right" => 0.5,
                _ => 0.0,
            }
        );
    }
    text += "[contacts.ball]\ncontact_body = \"ball-*\"\ntarget_body = \"ball-*\"\nmodel = \"hertz\"\n\
             [contacts.wall]\ncontact_body = \"ball-*\"\ntarget_body = \"wall-*\"\nmodel = \"hertz\"\n";
    let scenario = read(&text);
    assert_eq!(scenario.run.contacts.len(), 50 * 49 / 2 + 50 * 3);
    let names: Vec<&str> = scenario.run.contacts.iter().map(|contact| contact.name.as_str()).collect();
    assert!(
        names.contains(&"ball-3-17") && names.contains(&"wall-50-floor") && !names.contains(&"ball-17-3")
    );
}

#[test]
fn faults_are_told_once_at_the_key_that_stands_in_the_file() {
    let many = "copies = { arrangement = \"row\", count = 30, step = [1, 0, 0] }\n";
    let contacts = "[contacts.hit]\ncontact_body = \"ball-*\"\ntarget_body = \"ball-*\"\n";
    let one = |text: &str, key: &str, words: &str| {
        let faults = parse(text).expect_err("a fault");
        let [fault] = &faults[..] else { panic!("{key}: {faults:#?}") };
        assert!(fault.key == key && fault.message.contains(words) && fault.line().is_some(), "{fault}");
    };
    let ball = format!("[bodies.ball]\n{BALL}");
    one(&format!("{ball}{many}wrong = 1\n"), "bodies.ball.wrong", "unknown key");
    one(&format!("{ball}{many}velocity = [1, 2]\n"), "bodies.ball.velocity", "3 numbers");
    one(
        &format!("{ball}{many}{contacts}model = \"hertz\"\nfriction = -1\n"),
        "contacts.hit.friction",
        ">= 0",
    );
    one(&format!("{ball}{many}[bodies.ball-3]\n{BALL}"), "bodies.ball.copies", "ball-3");
    one(
        &format!("{ball}{many}{}", contacts.replace("target_body = \"ball-*\"", "target_body = \"bell-*\"")),
        "contacts.hit.target_body",
        "no body has a name like that",
    );
    one(
        &format!("{ball}{}", contacts.replace("target_body = \"ball-*\"", "target_body = \"ball\"")),
        "contacts.hit.contact_body",
        "no body has a name like that",
    );
    one(
        &format!(
            "{ball}{many}{}",
            contacts.replace("\"ball-*\"", "\"ball-3*\"").replace("count = 30", "count = 3")
        )
        .replace("count = 30", "count = 3"),
        "contacts.hit.target_body",
        "no pair",
    );
    one(
        &format!("{ball}{many}{}", contacts.replacen("ball-*", "*-*", 1)),
        "contacts.hit.contact_body",
        "one *",
    );
    one(
        &format!("{ball}copies = {{ arrangement = \"grid\", counts = 100, spacing = [1, 1, 1] }}"),
        "bodies.ball.copies.counts",
        "10000",
    );
    one(
        &format!("{ball}copies = {{ arrangement = \"ring\", count = 3, axis = [0, 0, 0] }}"),
        "bodies.ball.copies.axis",
        "zero",
    );
    let full =
        "copies = { arrangement = \"random\", count = 99, from = [0, 0, 0], to = [1, 1, 1], distance = 0.5 }";
    one(&format!("{ball}{full}"), "bodies.ball.copies.distance", "of 99 copies fit");
}
