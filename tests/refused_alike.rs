//! What a build refuses, `check` refuses with the same words, whatever model of a contact, kind of body and partner.

use adaptive::model::{RunModel, check_unbuilt};
use adaptive::prepared::Prepared;
use adaptive::spec::Treatment;
use fbimpact::scenario::keys::Named;
use fbimpact::scenario::tables::{BodyModel, ContactModel};
use fe_mesh::ElementKind;

use crate::blocks::block;
use crate::support::scenarios::{folder, parse};
use crate::writers::inp;

/// What a contact body may meet.
#[derive(Debug, Clone, Copy)]
pub enum Partner {
    Plane,
    Rigid,
    Alike,
}

/// A contact body of a model with the partner `partner` 1 µm below; none of models that come from a file of reduced matrices.
pub fn pair(model: BodyModel, partner: Partner, contact: &str) -> Option<String> {
    let (axis, shape) = match model {
        BodyModel::Solid | BodyModel::Axisymmetric | BodyModel::Mesh | BodyModel::Rigid => (2, "sphere"),
        BodyModel::PlaneStrain | BodyModel::PlaneStress => (1, "disc"),
        BodyModel::Imported => return None,
    };
    let at = |height: f64| {
        let mut place = [0.0; 3];
        place[axis] = height;
        format!("{place:?}")
    };
    let geometry = format!("geometry = {{ shape = \"{shape}\", radius = 0.01 }}\n");
    let thick = if axis == 1 { "thickness = 0.01\n" } else { "" };
    let own = |height: f64| {
        let reduced = "reduction = { modes = 3 }\n";
        let what = match model {
            BodyModel::Mesh => format!("file = \"block.inp\"\nunits = \"m\"\n{reduced}"),
            BodyModel::Rigid | BodyModel::Imported => geometry.clone(),
            BodyModel::Solid => {
                format!("{geometry}discretisation = {{ elements = [2, 2, 2], degree = 2 }}\n{reduced}")
            }
            BodyModel::Axisymmetric | BodyModel::PlaneStrain | BodyModel::PlaneStress => {
                format!("{geometry}{thick}discretisation = {{ elements = [2, 2], degree = 2 }}\n{reduced}")
            }
        };
        let name = model.name();
        format!("model = \"{name}\"\nmaterial = \"steel\"\n{what}position = {}\n", at(height))
    };
    let target = match partner {
        Partner::Plane => {
            format!("model = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = {}\n", at(1.0))
        }
        Partner::Rigid => {
            let motion = match model {
                BodyModel::Axisymmetric => "motion = \"axial\"\n",
                BodyModel::PlaneStrain | BodyModel::PlaneStress => "motion = \"planar\"\n",
                _ => "",
            };
            format!(
                "model = \"rigid\"\nmaterial = \"steel\"\n{geometry}{motion}{thick}position = {}\n",
                at(-0.01)
            )
        }
        Partner::Alike => own(-0.01),
    };
    let centre = match model {
        BodyModel::Rigid | BodyModel::Imported => None,
        BodyModel::Solid | BodyModel::Mesh => Some("[0.0, 0.0, 0.0]"),
        BodyModel::Axisymmetric | BodyModel::PlaneStrain | BodyModel::PlaneStress => Some("[0.0, 0.0]"),
    };
    let observed =
        centre.map(|at| format!("[output.points.pole]\nbody = \"own\"\npoint = {at}\nstress = true\n"));
    let observed = observed.unwrap_or_default();
    Some(format!(
        "[simulation]\nend_time = 1e-9\n[bodies.own]\n{}[bodies.other]\n{target}\
         [contacts.c]\ncontact_body = \"own\"\ntarget_body = \"other\"\n{contact}\
         {observed}",
        own(0.010001)
    ))
}

/// Whether a table over bodies of the model costs less than a few seconds.
fn is_cheap(body: BodyModel) -> bool {
    matches!(body, BodyModel::Axisymmetric | BodyModel::Rigid)
}

#[test]
fn check_refuses_what_a_build_refuses() {
    refuses_alike(is_cheap);
}

#[test]
#[ignore = "second tier: half a minute"]
fn check_refuses_what_a_build_of_other_bodies_refuses() {
    refuses_alike(|body| !is_cheap(body));
}

/// Elements that several patches do not have, and places without regular functions.
#[test]
fn check_refuses_zones_that_a_net_does_not_have() {
    let zone = "model = \"quasistatic\"\ninterval = { width = 2e-3, elements = 4 }\n";
    let text = |body, from: &[(&str, &str)]| {
        let text = pair(body, Partner::Plane, zone).expect("a pair");
        from.iter().fold(text, |text, (from, to)| text.replace(from, to))
    };
    let shells = [("radius = 0.01 }", "radius = 0.01, net = \"shells\" }"), ("degree = 2", "degree = 4")];
    let turned = [("thickness", "orientation_deg = [0.0, 0.0, 45.0]\nthickness")];
    for (body, changes, words) in [
        (BodyModel::Solid, &shells[..], "need a shape of one patch; leave them out"),
        (BodyModel::PlaneStrain, &turned[..], "surface functions are singular; turn the body"),
    ] {
        let scenario = parse(&folder("refused_alike"), &text(body, changes), &[]).expect("a scenario");
        let checked = Prepared::new(&scenario.run).and_then(|run| check_unbuilt(&run, &scenario.wishes));
        let checked = checked.err().map(|error| error.to_string()).unwrap_or_default();
        let built = RunModel::build(&scenario.run).err().map(|error| error.to_string());
        assert!(checked.contains(words) && built == Some(checked.clone()), "{body:?}: {checked}, {built:?}");
    }
}

/// What a build refuses, whatever model of a contact, kind of body, if it is `chosen`, and partner, `check` refuses with the
/// same words.
fn refuses_alike(chosen: impl Fn(BodyModel) -> bool) {
    let folder = folder("refused_alike");
    let raw = block(ElementKind::Hex8, [2, 2, 2], |x| x.map(|x| 0.02 * (x - 0.5)));
    std::fs::write(folder.join("block.inp"), inp(&raw)).expect("written");
    let more =
        ["", "interval = { width = 2e-3, elements = 4 }\n", "modes = \"own\"\n", "constraint = \"exact\"\n"];
    let (mut built, mut refused) = (Vec::new(), 0);
    for &kind in ContactModel::VALUES {
        let bodies = BodyModel::VALUES.iter().copied().filter(|body| chosen(*body));
        let partners = [Partner::Plane, Partner::Rigid, Partner::Alike];
        for (body, partner) in bodies.flat_map(|body| partners.map(|partner| (body, partner))) {
            // A rigid body has no zone to say more of.
            let n = if body == BodyModel::Rigid { 1 } else { more.len() };
            for more in &more[..n] {
                let contact = format!("model = \"{}\"\n{more}", kind.name());
                let Some(text) = pair(body, partner, &contact) else { continue };
                // Faults of the scenario are told by both.
                let Ok(scenario) = parse(&folder, &text, &[]) else { continue };
                let checked =
                    Prepared::new(&scenario.run).and_then(|run| check_unbuilt(&run, &scenario.wishes));
                match RunModel::build(&scenario.run) {
                    Ok(_) => built.push((kind, body)),
                    Err(error) => {
                        refused += 1;
                        let checked = checked.err().map(|error| error.to_string());
                        assert_eq!(
                            checked,
                            Some(error.to_string()),
                            "{kind:?}, {body:?}, {partner:?}, {more}"
                        );
                    }
                }
            }
        }
    }
    println!("{} built, {refused} refused", built.len());
    for body in BodyModel::VALUES.iter().copied().filter(|body| chosen(*body)) {
        for &kind in ContactModel::VALUES {
            // Surfaces carry points on flexible bodies, of rigid ones without zones; Hertz' law knows curved ones in space.
            let is_of_points = kind.treatment().is_some();
            let is_possible = match body {
                BodyModel::Rigid => !kind.is(Treatment::has_fine_zone),
                BodyModel::Solid | BodyModel::Axisymmetric => true,
                BodyModel::PlaneStrain | BodyModel::PlaneStress => is_of_points,
                BodyModel::Mesh => is_of_points && !kind.is_massless(),
                BodyModel::Imported => false,
            };
            assert_eq!(built.contains(&(kind, body)), is_possible, "{kind:?}, {body:?}");
        }
    }
    assert!(refused > 10, "{refused}");
}
