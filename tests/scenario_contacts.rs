//! Contacts in the scenario: what is assumed where nothing is said, what reaches the run, and settings that exclude each other.

use std::path::Path;

use adaptive::adaptivity::interval::least_utilisation;
use adaptive::spec::{
    Accuracy, ContactLaw, DivisionRule, IntervalSpec, LowModes, PenaltySearch, SurfaceLaw, Target,
    TransferMethod, TransferSpec, Treatment,
};
use contact_qs::quasistatic::Method;
use fbimpact::scenario::{self, Fault, Override, Scenario};

const PAIRS: &str = include_str!("../scenarios/sphere_rod_sphere.toml");
const SPHERE: &str = include_str!("../scenarios/sphere_on_plane.toml");
const BEAM: &str = include_str!("../scenarios/spinning_beam.toml");

fn parse(text: &str, set: &[&str]) -> Result<Scenario, Vec<Fault>> {
    let set: Vec<Override> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(Path::new("case.toml"), text.as_bytes(), &set).map_err(|f| f.list().to_vec())
}

fn valid(text: &str, set: &[&str]) -> Scenario {
    parse(text, set).unwrap_or_else(|f| panic!("{set:?}: {f:#?}"))
}

/// The law of contact `index`.
fn law(scenario: &Scenario, index: usize) -> &SurfaceLaw {
    match &scenario.run.contacts[index].law {
        ContactLaw::Surface(law) => law,
        ContactLaw::Hertz(_) => panic!("a contact of surfaces"),
    }
}

/// The first contact of a valid scenario.
fn surface(text: &str, set: &[&str]) -> SurfaceLaw {
    law(&valid(text, set), 0).clone()
}

#[track_caller]
fn assert_fault(text: &str, set: &[&str], key: &str, words: &str) {
    let list = parse(text, set).expect_err(&format!("{set:?} is at fault"));
    let fault =
        list.iter().find(|f| f.key == key).unwrap_or_else(|| panic!("{key} for {set:?} in {list:#?}"));
    assert!(fault.to_string().contains(words), "{set:?}: {fault}");
}

#[test]
fn a_pair_of_names_is_enough_and_is_adaptive() {
    let scenario = valid(PAIRS, &[]);
    // An empty line ends the table after the two names.
    assert!(PAIRS.contains("[contacts.first]\ncontact_body = \"left\"\ntarget_body = \"rod\"\n\n"));
    for index in 0..scenario.run.contacts.len() {
        let law = law(&scenario, index);
        assert_eq!((law.treatment, law.penalty), (Treatment::Adaptive, None));
        assert_eq!(law.method, Method::ActiveSet);
        assert_eq!(law.search, PenaltySearch::UntilConverged { tolerance: 2e-3 });
        assert_eq!(law.search, PenaltySearch::CONVERGED);
        assert_eq!((law.interval, law.transfer), (IntervalSpec::default(), TransferSpec::default()));
        assert_eq!((law.interval.width, law.interval.elements), (None, None));
    }
    let second = &scenario.run.contacts[1];
    assert_eq!((second.body, second.target), (2, Target::Body(1)));
}

#[test]
fn other_models_keep_a_fixed_factor() {
    for (name, model) in [
        ("quasistatic", Treatment::Quasistatic),
        ("damped", Treatment::Damped),
        ("dynamic", Treatment::Dynamic),
        ("coarse", Treatment::Coarse),
    ] {
        for text in [PAIRS, SPHERE] {
            let contact = if text == PAIRS { "first" } else { "impact" };
            let set =
                [format!("contacts.{contact}.model={name}"), format!("contacts.{contact}.penalty={{}}")];
            let law = surface(text, &set.each_ref().map(String::as_str));
            assert_eq!(law.treatment, model);
            assert_eq!((law.penalty, law.search), (None, PenaltySearch::Fixed), "{name}");
        }
    }
}

#[test]
fn factors_searches_and_intervals_reach_the_run() {
    let set = [
        "contacts.first.penalty={initial=1e15,search=\"until-error\"}",
        "contacts.first.solver=broyden",
        "contacts.first.interval={width=1e-3,elements=24,target_utilisation=0.8,division=\"printed\"}",
        "contacts.second.penalty={tolerance=1e-3}",
    ];
    let scenario = valid(PAIRS, &set);
    let law = |i: usize| law(&scenario, i);
    assert_eq!((law(0).penalty, law(0).search), (Some(1e15), PenaltySearch::UntilError));
    assert!(matches!(law(0).method, Method::Broyden(_)));
    let interval = IntervalSpec {
        width: Some(1e-3),
        elements: Some(24),
        target_utilisation: 0.8,
        min_utilisation: least_utilisation(0.8),
        division: DivisionRule::Printed,
        accuracy: Accuracy::Normal,
    };
    assert_eq!(law(0).interval, interval);
    assert_eq!(law(1).search, PenaltySearch::UntilConverged { tolerance: 1e-3 });
    // An exact constraint has no factor to search for.
    let fixed = surface(PAIRS, &["contacts.first.penalty={initial=1e17,search=\"fixed\"}"]);
    assert_eq!((fixed.penalty, fixed.search), (Some(1e17), PenaltySearch::Fixed));
    let exact = surface(PAIRS, &["contacts.first.constraint=exact"]);
    assert_eq!((exact.penalty, exact.search), (Some(f64::INFINITY), PenaltySearch::Fixed));
    // A boundary without mass is the compliance of the zone with that constraint.
    let exact = surface(PAIRS, &["contacts.first.model=quasistatic", "contacts.first.constraint=exact"]);
    assert_eq!(surface(PAIRS, &["contacts.first.model=massless"]), exact);
}

#[test]
fn resolved_contacts_read_back_to_themselves() {
    let set = |contact: &str, keys: &[&str]| -> Vec<String> {
        keys.iter().map(|key| format!("contacts.{contact}.{key}")).collect()
    };
    let broyden = &["solver=broyden", "penalty.search=until-error"][..];
    for keys in [
        &[][..],
        &["model=adaptive", "penalty={}"],
        &["model=adaptive", "penalty={initial=1e17,search=\"fixed\"}"],
        &["model=adaptive", "penalty={search=\"fixed\"}"],
        &["model=adaptive", "constraint=exact", "penalty={}"],
        &["model=quasistatic", "penalty={}"],
        &["model=damped"],
        &["model=dynamic"],
        &["model=coarse"],
        broyden,
    ] {
        for (text, contact) in [(PAIRS, "first"), (SPHERE, "impact")] {
            let mut keys = set(contact, keys);
            if keys.len() == broyden.len() && contact == "impact" && keys[0].ends_with("broyden") {
                keys.push("contacts.impact.model=adaptive".into());
            }
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            let first = valid(text, &keys);
            let again = valid(&first.source.resolved, &[]);
            assert_eq!(first.run.contacts, again.run.contacts, "{keys:?}");
            assert_eq!(first.source.resolved, again.source.resolved, "{keys:?}");
        }
    }
}

#[test]
fn a_massless_boundary_reads_back_without_a_factor() {
    let alone = SPHERE
        .replace("constraint = \"penalty\"\n", "")
        .replace("penalty = { initial = 1.0e18, search = \"fixed\" }\n", "");
    for (text, contact) in [(PAIRS, "first"), (alone.as_str(), "impact")] {
        let first = valid(text, &[&format!("contacts.{contact}.model=massless")]);
        let section =
            first.source.resolved.split(&format!("[contacts.{contact}]")).nth(1).expect("the contact");
        let section = section.split("\n[").next().expect("its keys");
        assert!(!section.contains("constraint") && !section.contains("penalty"), "{section}");
        let again = valid(&first.source.resolved, &[]);
        assert_eq!(first.run.contacts, again.run.contacts);
    }
}

#[test]
fn settings_without_meaning_are_faults() {
    for (set, key, words) in [
        (&["penalty.search=until-error"][..], "penalty.search", "choose solver = \"broyden\""),
        (&["model=quasistatic", "penalty.search=until-converged"], "penalty.search", "must be \"fixed\""),
        (&["model=dynamic", "penalty.search=until-error"], "penalty.search", "must be \"fixed\""),
        (&["constraint=exact", "penalty.search=until-converged"], "penalty.search", "exact"),
        (&["penalty.value=1e17"], "penalty.value", "write initial, with search = \"fixed\""),
        (&["friction_stiffness_ratio=0.5"], "friction_stiffness_ratio", "leave it out"),
        (&["penalty={search=\"fixed\",tolerance=1e-3}"], "penalty.tolerance", "until-converged"),
        (&["penalty.tolerance=0.0"], "penalty.tolerance", "> 0"),
        (&["solver=broyden", "model=damped"], "solver", "no effect"),
        (&["solver=broyden", "model=coarse"], "solver", "no effect"),
        (&["solver=broyden", "constraint=exact"], "solver", "active-set"),
        (&["constraint=exact", "model=damped"], "model", "\"adaptive\" or \"quasistatic\""),
        (&["constraint=exact", "points=gauss"], "points", "greville"),
        (&["model=massless", "points=gauss"], "points", "must be \"greville\" with model \"massless\""),
        (&["model=massless", "solver=broyden"], "solver", "must be \"active-set\" with model \"massless\""),
        (&["model=massless", "constraint=exact"], "constraint", "no penetration and no penalty factor"),
        (&["model=massless", "penalty={initial=1e17}"], "penalty", "no penetration and no penalty factor"),
        (&["model=coarse", "interval.elements=8"], "interval.elements", "refines nothing"),
        (
            &["model=quasistatic", "interval.target_utilisation=0.8"],
            "interval.target_utilisation",
            "adaptive",
        ),
        (&["model=coarse", "interval.division=printed"], "interval.division", "adaptive"),
        (&["interval.max_levels=20"], "interval.max_levels", "as many levels are made as the interval needs"),
        (&["interval.max_knots_per_level=3"], "interval.max_knots_per_level", "levels halve the elements"),
        (&["interval.min_utilisation=0.4"], "interval.min_utilisation", "five sevenths"),
        (&["interval.target_utilisation=1.0"], "interval.target_utilisation", "< 1"),
        (&["target_body=left"], "target_body", "itself"),
    ] {
        let set: Vec<String> = set.iter().map(|s| format!("contacts.first.{s}")).collect();
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        assert_fault(PAIRS, &set, &format!("contacts.first.{key}"), words);
    }
    let on_plane = ["contacts.impact.interval.division=graded"];
    assert_fault(SPHERE, &on_plane, "contacts.impact.interval.division", "refines the contact zone only");
    let adaptive = ["contacts.impact.model=adaptive", "contacts.impact.interval.division=graded"];
    valid(SPHERE, &adaptive);
    valid(SPHERE, &["contacts.impact.model=adaptive", "contacts.impact.friction=0.1"]);
    valid(PAIRS, &["contacts.first.friction=0.1"]);
}

#[test]
fn bodies_of_a_pair_must_be_flexible_and_of_one_kind() {
    assert_fault(PAIRS, &["bodies.right.model=solid"], "contacts.second.target_body", "\"solid\"");
    let rigid = "bodies.puck={model=\"rigid\",motion=\"axial\",mass=1}";
    assert_fault(
        PAIRS,
        &[rigid, "contacts.first.target_body=puck"],
        "contacts.first.target_body",
        "no shape",
    );
    let own = "contacts.first.contact_body=puck";
    assert_fault(
        PAIRS,
        &[rigid, own],
        "contacts.first.contact_body",
        "exchange contact_body and target_body",
    );
    // The same pair the other way round would be counted twice.
    let twice = ["contacts.second.contact_body=rod", "contacts.second.target_body=left"];
    assert_fault(PAIRS, &twice, "contacts.second.contact_body", "already");
    let modal = ["bodies.left.reduction.method=modal", "contacts.first.model=damped"];
    assert_fault(PAIRS, &modal, "contacts.first.model", "craig-bampton");
    valid(PAIRS, &["bodies.left.reduction.method=modal"]);
}

#[test]
fn targets_are_rigid_bodies_with_a_shape_and_the_motion_of_the_contact_body() {
    let rigid = |motion: &str, shape: &str| {
        format!("bodies.puck={{model=\"rigid\",motion=\"{motion}\",material=\"steel\",geometry={shape}}}")
    };
    let target = "contacts.first.target_body=puck";
    let axial = rigid("axial", "{shape=\"rod\",radius=0.01,length=0.1}");
    let scenario = valid(PAIRS, &[&axial, target]);
    let Target::Body(puck) = scenario.run.contacts[0].target else { panic!("a body") };
    assert!(scenario.run.bodies[puck].geometry().is_some());
    // It is refined like other pairs.
    valid(PAIRS, &[&axial, target, "contacts.first.interval.division=printed"]);
    let spatial = rigid("spatial", "{shape=\"box\",size=[0.1,0.1,0.1]}");
    assert_fault(PAIRS, &[&spatial, target], "contacts.first.target_body", "motion = \"axial\"");
    let [own, other] = ["contacts.first.contact_body=puck", "contacts.first.target_body=block"];
    let second = axial.replace("puck", "block");
    let rigid = [&*axial, &second, own, other];
    assert_fault(PAIRS, &rigid, "contacts.first.model", "\"coarse\" between rigid bodies");
}

#[test]
fn static_answers_are_the_default_and_can_be_left_out() {
    let has_answers = |set: &[&str]| {
        valid(BEAM, set).run.bodies[0].elastic().expect("flexible").flexible.has_static_answers()
    };
    assert!(has_answers(&[]));
    assert!(has_answers(&["bodies.beam.reduction={method=\"modal\",modes=6}"]));
    assert!(!has_answers(&["bodies.beam.reduction.static_answers=false"]));
    assert!(!has_answers(&["bodies.beam.reduction={method=\"all\"}"]));
    let key = "bodies.beam.reduction.static_answers";
    assert_fault(
        BEAM,
        &["bodies.beam.reduction={method=\"all\",static_answers=false}"],
        key,
        "other than \"all\" only",
    );
}

#[test]
fn key_of_an_earlier_version_is_a_fault_with_its_remedy() {
    let key = "bodies.beam.reduction.joint_interface";
    assert_fault(BEAM, &["bodies.beam.reduction.joint_interface=true"], key, "static answers");
}

#[test]
fn modes_of_fine_models_and_their_transfer_reach_the_run() {
    assert_eq!(surface(PAIRS, &[]).transfer, TransferSpec::default());
    let own = |method| TransferSpec { modes: LowModes::Fine, method };
    let set = ["contacts.first.modes=own"];
    assert_eq!(surface(PAIRS, &set).transfer, own(TransferMethod::MassOrthogonal));
    let set = ["contacts.first.modes=own", "contacts.first.transfer=printed"];
    assert_eq!(surface(PAIRS, &set).transfer, own(TransferMethod::Printed));
    let coarse = ["contacts.first.model=coarse", "contacts.first.modes=own"];
    assert_fault(PAIRS, &coarse, "contacts.first.modes", "must be \"prolonged\"");
    assert_fault(SPHERE, &["contacts.impact.modes=own"], "contacts.impact.modes", "must be \"prolonged\"");
    let transfer = ["contacts.first.transfer=printed"];
    assert_fault(PAIRS, &transfer, "contacts.first.transfer", "modes = \"own\" only");
}

#[test]
fn accuracy_scales_what_the_program_chooses() {
    let usual = valid(PAIRS, &[]);
    let named = valid(PAIRS, &["accuracy=normal"]);
    assert_eq!(named.run, usual.run);
    assert_eq!(named.source.resolved, usual.source.resolved);
    for (level, elements, tolerance, ratio, error) in [
        (Accuracy::Fast, 10, 1e-2, 1.0, 10.0),
        (Accuracy::Normal, 16, 2e-3, 1.0, 1.0),
        (Accuracy::Fine, 24, 5e-4, 4.0, 0.1),
    ] {
        let scenario = valid(PAIRS, &[&format!("accuracy={}", level.name())]);
        assert_eq!(scenario.run.accuracy, level);
        let (law, before) = (law(&scenario, 0), law(&usual, 0));
        assert_eq!(law.interval.elements_or(16), elements);
        assert_eq!(law.search, PenaltySearch::UntilConverged { tolerance });
        assert_eq!(law.stiffness_ratio.to_bits(), (ratio * before.stiffness_ratio).to_bits());
        // The width of a zone is tried until it fits the contact, whatever the level.
        let shares = [law, before].map(|law| law.interval.target_utilisation.to_bits());
        assert_eq!(shares[0], shares[1]);
        assert_eq!(scenario.run.settings.free.tolerance_factor.to_bits(), f64::to_bits(error));
        let again = valid(&scenario.source.resolved, &[]);
        assert_eq!((&again.run.contacts, again.run.accuracy), (&scenario.run.contacts, level));
        assert_eq!(again.run.settings, scenario.run.settings);
        assert_eq!(again.source.resolved, scenario.source.resolved);
    }
}

#[test]
fn what_is_given_wins_over_accuracy() {
    let set = [
        "accuracy=fine",
        "contacts.first.penalty={tolerance=3e-3}",
        "contacts.first.interval={elements=7}",
        "simulation.free.rtol=1e-6",
        "simulation.impact={rtol=1e-7, max_step=1e-7}",
    ];
    let scenario = valid(PAIRS, &set);
    let law = law(&scenario, 0);
    assert_eq!(law.interval.elements_or(16), 7);
    assert_eq!(law.search, PenaltySearch::UntilConverged { tolerance: 3e-3 });
    let settings = &scenario.run.settings;
    let errors = [&settings.free, &settings.impact].map(|phase| (phase.tolerance, phase.tolerance_factor));
    assert_eq!(errors, [(Some(1e-6), 1.0), (Some(1e-7), 1.0)]);
    assert_eq!(settings.impact.max_step.to_bits(), 1e-7f64.to_bits());
    let fixed = surface(PAIRS, &["accuracy=fine", "contacts.first.penalty={initial=1e17,search=\"fixed\"}"]);
    assert_eq!((fixed.penalty, fixed.search), (Some(1e17), PenaltySearch::Fixed));
    assert_fault(PAIRS, &["accuracy=high"], "accuracy", "\"fine\"");
}

/// Two bodies of plane models in different planes, and of axisymmetric ones on different axes, do
/// not meet; a plane is met wherever the body lies.
#[test]
fn bodies_in_contact_share_their_plane_or_their_axis() {
    let text = |model: &str, shape: &str, target: &str| {
        format!(
            "simulation = {{ end_time = 1e-4 }}\n[bodies.a]\nmodel = \"{model}\"\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"{shape}\", radius = 0.01 }}\n[bodies.b]\n{target}\n\
             [contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\n"
        )
    };
    let like = |model: &str, shape: &str| {
        format!(
            "model = \"{model}\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"{shape}\", radius = 0.02 }}"
        )
    };
    let rigid = |motion: &str, shape: &str| {
        format!(
            "model = \"rigid\"\nmotion = \"{motion}\"\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"{shape}\", radius = 0.02 }}"
        )
    };
    let floor = "model = \"rigid\"\ngeometry = { shape = \"plane\" }".to_owned();
    for (model, shape, motion, way, aside, within) in [
        ("plane-strain", "disc", "planar", "[0,-0.031,0]", "[0,-0.031,1e-6]", "in z"),
        ("plane-stress", "disc", "planar", "[0,-0.031,0.3]", "[0,-0.031,-2e-9]", "in z"),
        ("axisymmetric", "sphere", "axial", "[0,0,-0.031]", "[1e-3,0,-0.031]", "in x and y"),
        ("axisymmetric", "sphere", "axial", "[0.1,0.2,-0.031]", "[0.1,-0.2,-0.031]", "in x and y"),
    ] {
        let place = |at: &str| format!("bodies.b.position={at}");
        let shared = if way.contains("0.3]") { "[0,0,0.3]" } else { "[0,0,0]" };
        let own = format!("bodies.a.position={}", if way.contains("0.2,") { "[0.1,0.2,0]" } else { shared });
        for target in [like(model, shape), rigid(motion, shape)] {
            let text = text(model, shape, &target);
            valid(&text, &[&own, &place(way)]);
            assert_fault(&text, &[&own, &place(aside)], "contacts.c.target_body", within);
        }
        let text = text(model, shape, &floor);
        let normal = if motion == "planar" { "bodies.b.normal=[0,1,0]" } else { "bodies.b.normal=[0,0,1]" };
        valid(&text, &[&own, &place(aside), normal]);
    }
}

#[test]
fn interface_modes_without_an_interface_are_a_fault() {
    let set = "bodies.ball.reduction.fixed_interface_modes=40";
    let key = "bodies.ball.reduction.fixed_interface_modes";
    for model in ["quasistatic", "damped", "dynamic"] {
        valid(SPHERE, &[set, &format!("contacts.impact.model={model}")]);
    }
    assert_fault(SPHERE, &[set, "contacts.impact.model=adaptive"], key, "nothing depends on it");
}
