//! Contact intervals of any size are resolved: tiny partners, slow touches, ends of the simulated time just after the touch.

use crate::bodies;
use crate::bodies::wanted_at;
use crate::impacts::{STEEL, Solid, Trace, ball, contact, disc, finished, spec, sphere, try_run};
use adaptive::body::fine::refined::{Division, FineMesh, FineSettings};
use adaptive::body::splines::ElasticBody;
use adaptive::spec::DivisionRule;
use adaptive::spec::{
    BodyKind, BodySpec, ContactLaw, DiscretisationSpec, ElasticSpec, InitialMotion, PenaltySearch,
    ReductionSpec, RunSpec, SurfaceLaw, Target,
};
use contact_qs::law::Friction;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::solid;
use iga_core::space::Space;
use nalgebra::{UnitQuaternion, Vector3};

fn floor() -> Target {
    Target::plane(Vector3::zeros(), Vector3::z())
}

fn with_law(run: &RunSpec, change: impl Fn(&mut SurfaceLaw)) -> RunSpec {
    let mut run = run.clone();
    for contact in &mut run.contacts {
        let ContactLaw::Surface(law) = &mut contact.law else { panic!("a contact of surfaces") };
        change(law);
    }
    run
}

/// Two spheres that touch at the origin, the upper one falling.
fn spheres(radii: [f64; 2], solid: Solid, speed: f64, end: f64) -> RunSpec {
    let bodies = vec![
        sphere("upper", radii[0], solid, (radii[0], -speed)),
        sphere("lower", radii[1], solid, (-radii[1], 0.0)),
    ];
    spec(bodies, vec![contact("impact", 0, Target::Body(1))], end)
}

/// Peak force, contact radius and duration of Hertz's impact of two spheres of one material.
fn hertz(radii: [f64; 2], solid: Solid, speed: f64) -> [f64; 3] {
    let [m1, m2] = radii.map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3) * solid.density);
    let radius = radii[0] * radii[1] / (radii[0] + radii[1]);
    let stiffness = 2.0 / 3.0 * solid.youngs / (1.0 - solid.poisson.powi(2)) * radius.sqrt();
    let approach = (1.25 * m1 * m2 / (m1 + m2) * speed * speed / stiffness).powf(0.4);
    [stiffness * approach.powf(1.5), (radius * approach).sqrt(), 2.943 * approach / speed]
}

#[test]
fn contacts_far_smaller_than_the_elements_are_resolved() {
    let soft = Solid { youngs: 10.9e9, poisson: 0.094, density: 14_136.0 };
    for (radii, solid, speed) in [
        ([1.48e-3, 0.3415], soft, 0.0546), // unequal
        ([0.01; 2], STEEL, 1e-6),          // slow
        ([1e-4, 0.5], STEEL, 0.1),         // very unequal
        ([0.5, 1e-3], STEEL, 1e-6),        // both
    ] {
        let [peak, radius, duration] = hertz(radii, solid, speed);
        let run = spheres(radii, solid, speed, 1.2 * duration);
        let trace = finished(&run);
        let found = trace.impacts[0].peak_force;
        let momentum = trace.momentum_change(1.0) / (4.2 * radii[0].powi(3) * solid.density * speed);
        let last = trace.trials.last().unwrap();
        println!(
            "{radii:?} {speed:e}: peak {:+.4}, ledger {:.1e}, momentum {momentum:.1e}, {} trials, {} degrees of freedom",
            found / peak - 1.0,
            trace.energy_drift(),
            trace.trials.len(),
            last.dofs
        );
        // Claims of the project where contact radii are below 5 % of the smaller sphere's.
        assert!(radius < 0.05 * radii[0].min(radii[1]) && (found / peak - 1.0).abs() < 2e-2);
        assert!(trace.energy_drift() < 1e-5 && momentum < 1e-12);
        assert!((0.5..0.95).contains(&last.utilisation[0]), "{last:?}");

        // Five levels of at most ten knots are not enough; the message says so in metres, with the key.
        let printed = with_law(&run, |law| law.interval.division = DivisionRule::Printed);
        let error = try_run(&printed, &mut Trace::default()).expect_err("Algorithm 3").to_string();
        assert!(error.contains("interval.division") && error.contains(" m: 5 levels"), "{error}");
    }
}

#[test]
fn an_impact_that_the_end_of_the_run_cuts_off_has_a_zone_that_fits_it() {
    let bodies = || vec![sphere("ball", 0.01, STEEL, (0.01, -0.1))];
    let k = 4.0 / 3.0 * STEEL.youngs / (1.0 - STEEL.poisson * STEEL.poisson) * 0.1;
    for end in [1e-9, 1e-6, 1e-5] {
        let short = finished(&spec(bodies(), vec![contact("floor", 0, floor())], end));
        let last = short.trials.last().unwrap();
        // A first interval for all of the impact was 100, 3 and 1.7 times too wide.
        assert!((0.5..0.95).contains(&last.utilisation[0]), "{last:?}");
        // Its ball has hardly been braked: by 2/5 F δ of m v²/2, 2 % at 10 µs, of which the force has the 1.5 times.
        let expected = k * (0.1 * end).powf(1.5);
        assert!((last.peak_force / expected - 1.0).abs() < 0.03, "{end:e}: {} {expected}", last.peak_force);
        assert!((short.last().time - end).abs() < 1e-20);
    }
}

#[test]
fn a_run_may_end_at_the_touch() {
    let bodies = vec![sphere("ball", 0.01, STEEL, (0.010_001, -0.1))];
    let trace = finished(&spec(bodies, vec![contact("floor", 0, floor())], 1e-5));
    assert!((trace.last().time - 1e-5).abs() < 1e-18);
    assert!(trace.energy_drift() < 1e-9, "{:e}", trace.energy_drift());
}

#[test]
fn a_body_that_slides_along_a_plane_without_pressing_is_simulated() {
    let motion = InitialMotion {
        position: Vector3::new(0.0, 0.1, 0.0),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::x(),
        angular_velocity: Vector3::zeros(),
    };
    let plane = Target::plane(Vector3::zeros(), Vector3::y());
    let run = spec(vec![disc("disc", 0.1, 1.0, true, STEEL, motion)], vec![contact("floor", 0, plane)], 1e-3);
    let trace = finished(&with_law(&run, |law| law.friction = Some(Friction::new(0.3))));
    // It goes on as it did: what touches is round-off.
    let velocity = trace.last().bodies[0].velocity;
    assert!((velocity[0] - 1.0).abs() < 1e-7 && velocity[1].abs() < 1e-7, "{velocity:?}");
    assert!(trace.energy_drift() < 1e-9);
}

#[test]
fn a_chain_that_the_wave_has_not_passed_is_simulated() {
    let n = 5;
    let body = |i: usize| -> BodySpec {
        sphere(&format!("s{i}"), 0.01, STEEL, (0.02 * i as f64, if i + 1 == n { -0.1 } else { 0.0 }))
    };
    let pair = |i: usize| contact(&format!("c{i}"), i + 1, Target::Body(i));
    let trace = finished(&spec((0..n).map(body).collect(), (0..n - 1).map(pair).collect(), 3e-5));
    assert!((trace.last().time - 3e-5).abs() < 1e-18);
    assert!(trace.energy_drift() < 1e-5, "{:e}", trace.energy_drift());
    let mass = 4.0 / 3.0 * std::f64::consts::PI * 1e-6 * STEEL.density;
    assert!(trace.momentum_change(0.1 * mass) < 1e-12);
}

/// A steel cylinder of 30 mm, or twice its radius if that is more, on its side, its axis turned by `angle` from the `x` axis.
fn lying_cylinder(name: &str, radius: f64, angle: f64, (height, speed): (f64, f64)) -> BodySpec {
    let length = 0.03_f64.max(2.0 * radius);
    let shape = solid::cylinder(radius, length).unwrap();
    let material = Material::new(STEEL.youngs, STEEL.poisson, STEEL.density).unwrap();
    let discretisation =
        DiscretisationSpec { degrees: vec![2; 3], elements: vec![4; 3], knots: None, refine: Vec::new() };
    let reduction = ReductionSpec::CraigBampton { modes: 5, fixed_interface_modes: None };
    let elastic = ElasticSpec::new(shape, Model::Solid, material, discretisation, reduction);
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
        * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    // The frame of a cylinder is at one end of its axis.
    let position = rotation * Vector3::new(0.0, 0.0, -0.5 * length) + Vector3::new(0.0, 0.0, height);
    let velocity = Vector3::new(0.0, 0.0, speed);
    let motion = InitialMotion { position, rotation, velocity, angular_velocity: Vector3::zeros() };
    BodySpec { name: name.into(), kind: BodyKind::Elastic(Box::new(elastic)), motion }
}

/// Force of Hertz's elliptic contact of two steel bodies for an approach of 1 m, `F = k δ^1.5`, of relative curvatures `a < b`
/// \[1/m\] (Johnson, Contact Mechanics, Eqs. 4.25 to 4.29); elliptic integrals by the arithmetic-geometric mean.
fn elliptic_stiffness(a: f64, b: f64) -> f64 {
    let integrals = |m: f64| {
        let (mut x, mut y, mut c, mut sum, mut power) = (1.0, (1.0 - m).sqrt(), m.sqrt(), 0.5 * m, 1.0);
        while c > 1e-15 {
            (x, y, c) = (0.5 * (x + y), (x * y).sqrt(), 0.5 * (x - y));
            sum += power * c * c;
            power *= 2.0;
        }
        let first = 0.5 * std::f64::consts::PI / x;
        (first, first * (1.0 - sum))
    };
    let (mut low, mut high) = (1e-9, 1.0 - 1e-12);
    for _ in 0..100 {
        let m = 0.5 * (low + high);
        let (k, e) = integrals(m);
        if (e / (1.0 - m) - k) / (k - e) < b / a { low = m } else { high = m }
    }
    let (k, e) = integrals(low);
    let modulus = 0.5 * STEEL.youngs / (1.0 - STEEL.poisson.powi(2));
    // With the semi-axis c: F = 2 pi E' c^3 m a / (3 (K - E)) and δ = c^2 m a K / (K - E).
    let share = low * a / (k - e);
    2.0 * std::f64::consts::PI * modulus * share / 3.0 * (share * k).powf(-1.5)
}

#[test]
fn crossed_cylinders_press_each_other_as_hertz_says() {
    press_each_other(&[40.0], &[[0, 1]]);
}

#[test]
#[ignore = "second tier: ten seconds"]
fn crossed_cylinders_press_each_other_whichever_is_the_contact_body() {
    press_each_other(&[90.0], &[[0, 1], [1, 0]]);
    press_each_other(&[40.0], &[[1, 0]]);
}

fn press_each_other(angles: &[f64], orders: &[[usize; 2]]) {
    let (radii, speed, end) = ([0.01, 0.05], 0.1, 4e-5);
    for &degrees in angles {
        let angle = degrees.to_radians();
        let bodies = vec![
            lying_cylinder("small", radii[0], angle, (radii[0], -speed)),
            lying_cylinder("big", radii[1], 0.0, (-radii[1], 0.0)),
        ];
        let mass = |r: f64| std::f64::consts::PI * r * r * 0.03_f64.max(2.0 * r) * STEEL.density;
        let mass = 1.0 / radii.map(|r| 1.0 / mass(r)).iter().sum::<f64>();
        // Sum and difference of the relative curvatures (Johnson, Eqs. 4.4 and 4.5).
        let [p, q] = radii.map(|r| 1.0 / r);
        let (sum, difference) =
            (0.5 * (p + q), 0.5 * (p * p + q * q + 2.0 * p * q * (2.0 * angle).cos()).sqrt());
        let stiffness = elliptic_stiffness(0.5 * (sum - difference), 0.5 * (sum + difference));
        let (mut approach, mut velocity, step) = (0.0_f64, speed, 1e-9);
        for _ in 0..(end / step) as usize {
            velocity -= 0.5 * step * stiffness * approach.powf(1.5) / mass;
            approach += step * velocity;
            velocity -= 0.5 * step * stiffness * approach.powf(1.5) / mass;
        }
        let expected = stiffness * approach.powf(1.5);

        for &order in orders {
            let run = spec(bodies.clone(), vec![contact("impact", order[0], Target::Body(order[1]))], end);
            let trace = finished(&with_law(&run, |law| {
                law.interval.elements = Some(8);
                law.search = PenaltySearch::Fixed;
            }));
            let found = trace.last().contacts[0].normal_force;
            println!(
                "{degrees}°, {order:?}: {found:.3} N, Hertz {expected:.3} N, {:+.4}",
                found / expected - 1.0
            );
            // Twice as many elements across move the force by 2 % where they lie oblique to the ellipse, by 0.6 % elsewhere
            // (docs/decisions/0019); cylinders that end make it up to 0.45 a/R larger, another 2 % (`random_impacts`).
            assert!(
                (found / expected - 1.0).abs() < 0.03,
                "{degrees}°, {order:?}: {found} N, Hertz {expected} N"
            );
        }
    }
}

#[test]
fn an_impact_where_the_last_one_was_has_its_contact_zone() {
    // A ball that bounces: the second impact has the speed of the first but for the modes that ring.
    let (speed, gravity) = (0.1, 9.81);
    let ball = sphere("ball", 0.01, STEEL, (0.01 + 1e-6, -speed));
    let mut run = spec(vec![ball], vec![contact("floor", 0, floor())], 2.1 * speed / gravity);
    run.settings.gravity = Vector3::z() * -gravity;
    let trace = finished(&run);
    assert_eq!(trace.impacts.len(), 2, "{:?}", trace.impacts);
    let sites: Vec<_> = trace.transfers.iter().filter_map(|transfer| transfer.site).collect();
    assert!(sites.len() >= 2 && sites.last() == sites.get(sites.len() - 2), "{sites:?}");
    // The speed differs by what rings, less than 1e-3 of it (restitution); forces grow with its power 1.2.
    let ratio = trace.impacts[1].peak_force / trace.impacts[0].peak_force;
    assert!((ratio - 1.0).abs() < 3e-3, "{ratio}");
}

/// The ball of 8 x 4 x 4 elements of the main example.
fn solid_ball(radius: f64) -> ElasticBody {
    let motion = InitialMotion {
        position: Vector3::zeros(),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::zeros(),
        angular_velocity: Vector3::zeros(),
    };
    let BodyKind::Elastic(spec) = ball("ball", radius, STEEL, motion).kind else { panic!("an elastic body") };
    ElasticBody::build("ball", *spec).unwrap()
}

fn n_levels(mesh: &FineMesh) -> usize {
    match &mesh.plan.division {
        Division::Lattice(lattices) => lattices.iter().map(|l| l.lattice.n_levels).max().unwrap(),
        Division::Parts(parts) => parts.len(),
    }
}

#[test]
fn levels_grow_with_the_logarithm_of_the_ratio_of_sizes_and_elements_with_them() {
    let radius = 4.49e-3;
    let axisymmetric = bodies::sphere([8, 8]);
    let solid = solid_ball(radius);
    for (body, place, widest, halvings) in [
        (&axisymmetric, [0.0, -0.01, 0.0], 1e-3, [0, 4, 8, 16]),
        // 1.6e-4 m on this ball wanted ten levels of nine allowed.
        (&solid, [radius, 0.0, 0.0], 3.2e-4, [0, 1, 2, 4]),
    ] {
        let settings = FineSettings { elements: 8, ..FineSettings::default() };
        let sizes = halvings.map(|n| {
            let wanted = wanted_at(body, place, widest * 0.5f64.powi(n));
            let mesh = FineMesh::build(body, &[wanted], &settings).unwrap();
            (n_levels(&mesh), mesh.space.n_elements())
        });
        println!("{sizes:?}");
        let first = sizes[0];
        // A halved width is one more level; every one adds about as many elements.
        let per_level = |k: usize| (sizes[k].1 - first.1) as f64 / f64::from(halvings[k]);
        for (k, n) in halvings.iter().enumerate().skip(1) {
            assert_eq!(sizes[k].0, first.0 + *n as usize, "{sizes:?}");
            assert!((per_level(k) / per_level(3) - 1.0).abs() < 0.35, "{sizes:?}");
        }
    }
}

#[test]
fn what_no_memory_holds_is_refused_before_it_is_built() {
    for (body, place, elements) in
        [(bodies::sphere([8, 8]), [0.0, -0.01, 0.0], 100_000), (solid_ball(0.01), [0.01, 0.0, 0.0], 1000)]
    {
        let wanted = wanted_at(&body, place, 1e-3);
        let settings = FineSettings { elements, ..FineSettings::default() };
        let error = FineMesh::build(&body, &[wanted], &settings).err().unwrap().to_string();
        println!("{error}");
        assert!(
            error.contains("1.000e-3 m") && error.contains("interval.elements") && error.contains("GB"),
            "{error}"
        );
    }
}
