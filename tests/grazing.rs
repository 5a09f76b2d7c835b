//! Bodies that graze each other for a small part of a step: the touch is neither missed nor coarse.

use crate::support::scenarios::{self, run};
use std::path::Path;

/// Two equal rigid balls of 10 mm, the first of which flies past the second at 20 m/s and would
/// overlap it by a micrometre.
const PASSING: &str = "[simulation]\nend_time = 2e-3\n\
    [bodies.a]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.01 }\n\
    position = [-0.02, 0.019999, 0]\nvelocity = [20, 0, 0]\n\
    [bodies.b]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.01 }\n\
    [contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\nmodel = \"hertz\"\n";

/// The same on an arm that turns at 1000 rad/s, overlapping by 0.2 mm.
const TURNING: &str = "[simulation]\nend_time = 3e-3\n\
    [bodies.a]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.001 }\n\
    [joints.h]\ntype = \"revolute\"\naxis = [0, 0, 1]\nparent = { body = \"ground\", point = [0, 0, 0] }\n\
    child = { body = \"a\", point = [-0.1, 0, 0] }\nangular_velocity = 1000.0\n\
    [bodies.b]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.001 }\n\
    position = [0, 0.1018, 0]\n\
    [contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\nmodel = \"hertz\"\n";

/// A ball that lies nearer to a third body all the time than the others come to each other before
/// they touch.
const BESIDE: &str = "[bodies.d]\nmodel = \"rigid\"\nmaterial = \"steel\"\n\
    geometry = { shape = \"sphere\", radius = 0.01 }\nposition = [0, -0.02000001, 0]\n\
    [contacts.d]\ncontact_body = \"b\"\ntarget_body = \"d\"\nmodel = \"hertz\"\n";

/// Peak and impulse of the first impact of contact `c`.
fn impact(text: &str, changes: &[&str]) -> Option<[f64; 2]> {
    let found = run(&scenarios::valid(Path::new("."), text, changes));
    let contact = found.layout.contacts.iter().position(|name| *name == "c").expect("the contact") as u32;
    found.impacts.iter().find(|impact| impact.contact == contact).map(|i| [i.peak_force, i.impulse])
}

#[test]
fn a_touch_of_a_small_part_of_a_step_is_felt() {
    for (name, text) in [
        ("passing", PASSING.to_owned()),
        ("turning", TURNING.to_owned()),
        ("beside another body", format!("{PASSING}{BESIDE}")),
    ] {
        // Steps of a microsecond are a twentieth or a third of the touch: none can be stepped over.
        let fine = impact(&text, &["simulation.impact.max_step=2e-7"]).expect("the impact, in short steps");
        let found = impact(&text, &[]).unwrap_or_else(|| panic!("{name}: no impact"));
        for (found, fine) in found.iter().zip(fine) {
            // A peak between two states is taken by a parabola.
            assert!((found / fine - 1.0).abs() < 1e-2, "{name}: {found} {fine}");
        }
    }
}
