//! Contact that moves along a surface while it lasts: as exact as contact that stays, whichever body is called the contact body.

use adaptive::record::warning::WarningKind;

use crate::support::scenarios::{self, run};

/// A disc falls at 1 m/s on a block while it slides over it without friction at `speed` \[m/s\], so that it passes the middle at its largest force.
fn text(speed: f64, [contact, target]: [&str; 2]) -> String {
    format!(
        "[simulation]\nend_time = 1.2e-4\nstop_after_impacts = 1\n\
         [bodies.block]\nmodel = \"plane-strain\"\nthickness = 0.01\nmaterial = \"steel\"\n\
         geometry = {{ shape = \"rectangle\", size = [0.06, 0.03] }}\n\
         [bodies.disc]\nmodel = \"plane-strain\"\nthickness = 0.01\nmaterial = \"aluminium\"\n\
         geometry = {{ shape = \"disc\", radius = 0.01 }}\nposition = [{}, 0.0250001, 0.0]\nvelocity = [{speed}, -1.0, 0.0]\n\
         [contacts.c]\ncontact_body = \"{contact}\"\ntarget_body = \"{target}\"\n",
        -30e-6 * speed
    )
}

#[test]
fn a_disc_that_slides_over_a_block_presses_it_as_one_that_falls_straight() {
    slides_as_it_falls(&[["disc", "block"]], &[45.0]);
}

#[test]
#[ignore = "second tier: ten seconds"]
fn discs_that_slide_faster_and_in_the_other_role_press_as_those_that_fall_straight() {
    slides_as_it_falls(&[["block", "disc"], ["disc", "block"]], &[45.0, 120.0]);
}

fn slides_as_it_falls(roles: &[[&str; 2]], speeds: &[f64]) {
    let folder = scenarios::folder("moving_contact");
    let peak = |speed: f64, bodies: [&str; 2]| {
        let found = run(&scenarios::valid(&folder, &text(speed, bodies), &[]));
        // Aluminium yields at a hundredth of this speed.
        let is_known = found.warnings.iter().all(|warning| warning.kind == WarningKind::Yields);
        assert!(is_known, "{speed} m/s: {:?}", found.warnings);
        found.impacts[0].peak_force
    };
    let straight = peak(0.0, ["block", "disc"]);
    for &bodies in roles {
        // On the way of 1 and 5 widths of the contact; the speeds are 0.9 and 2.4 % of those of waves.
        for &speed in speeds {
            let found = peak(speed, bodies);
            // The share by which the rows of elements of an interval may change a peak. With as many rows on the whole way these impacts were refused.
            assert!(
                (found / straight - 1.0).abs() < 1e-2,
                "{bodies:?} {speed} m/s: {found} N, straight {straight} N"
            );
        }
    }
}
