//! Joints for what a deck ties: faces of its parts that move together, as text of a scenario.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use fe_mesh::Mesh;
use fe_mesh::mesh::tie::{Joined, Tie};
use iga_core::elasticity::Model;
use iga_core::extent::{centroid, measure};

/// Ties of which joints are made.
const MOST: usize = 500;

/// A part of a deck as a body.
pub struct PartBody<'a> {
    /// Name of the body.
    pub name: String,
    /// Name of the part in the deck, empty if it is all of it.
    pub part: &'a str,
    /// Its mesh, in the axes of the deck.
    pub mesh: &'a Mesh,
}

/// A face that is tied.
struct TiedFace<'a> {
    body: usize,
    face: &'a str,
    is_rigid: bool,
    area: f64,
    middle: [f64; 3],
}

/// The joints of a deck.
#[derive(Default)]
pub struct Joints {
    /// Tables of joints, with what they are made from as remarks.
    pub text: String,
    /// Whether a body is the child of a joint.
    pub is_child: Vec<bool>,
    /// What the deck ties, in words.
    pub told: Vec<String>,
}

/// The joints for all ties of `bodies`: fixed ones that hold the tied faces where the deck has them, in trees that begin with the
/// first body of each; one that closes a loop where bodies hang together already. Where one body alone is tied to a node, how it is held is
/// to be chosen: a remark.
pub fn joints(bodies: &[PartBody<'_>]) -> Joints {
    let mut found = Joints { is_child: vec![false; bodies.len()], ..Joints::default() };
    let ties: &[Tie] = bodies.first().map_or(&[], |body| body.mesh.ties());
    if ties.len() > MOST {
        found
            .told
            .push(format!("the first {MOST} of {} ties; write those of the others yourself", ties.len()));
    }
    let ties = &ties[..ties.len().min(MOST)];
    let mut pairs: Vec<(String, [TiedFace<'_>; 2])> = Vec::new();
    let mut held: Vec<(String, TiedFace<'_>)> = Vec::new();
    for (cards, ties) in clusters(ties) {
        let mut faces = faces(bodies, &ties);
        let Some(hub) = faces.pop() else {
            let _ =
                writeln!(found.text, "\n# {cards}: no faces of the parts above, which alone can be joined.");
            found.told.push(format!("{cards}: left out, no faces of parts"));
            continue;
        };
        let others: Vec<TiedFace<'_>> = faces.into_iter().filter(|face| face.body != hub.body).collect();
        let has_node = ties.iter().any(|tie| tie.joined.iter().any(|of| matches!(of, Joined::Node(_))));
        if others.is_empty() && !has_node {
            found.told.push(format!("{cards}: left out, within body \"{}\"", bodies[hub.body].name));
            continue;
        }
        if others.is_empty() {
            found.told.push(format!("{cards}: a support of body \"{}\" to choose", bodies[hub.body].name));
            held.push((cards, hub));
            continue;
        }
        for face in others {
            let [a, b] = [face.body, hub.body].map(|i| bodies[i].name.as_str());
            found.told.push(format!("{cards}: body \"{a}\" fixed to body \"{b}\""));
            pairs.push((cards.clone(), [face, TiedFace { ..hub }]));
        }
    }
    let mut is_reached = vec![false; bodies.len()];
    let mut is_written = vec![false; pairs.len()];
    while let Some(root) = is_reached.iter().position(|reached| !reached) {
        is_reached[root] = true;
        let inward = |(_, pair): &(String, [TiedFace<'_>; 2]), is_reached: &[bool]| {
            let [a, b] = pair.each_ref().map(|face| is_reached[face.body]);
            (a != b).then_some(usize::from(b))
        };
        while let Some((i, parent)) =
            pairs.iter().enumerate().find_map(|(i, pair)| Some((i, inward(pair, &is_reached)?)))
        {
            let child = pairs[i].1[1 - parent].body;
            (is_reached[child], found.is_child[child], is_written[i]) = (true, true, true);
            write_joint(&mut found.text, bodies, (i + 1, &pairs[i]), parent, false);
        }
    }
    for (i, pair) in pairs.iter().enumerate().filter(|(i, _)| !is_written[*i]) {
        write_joint(&mut found.text, bodies, (i + 1, pair), 1, true);
    }
    for (i, (cards, face)) in held.iter().enumerate() {
        let number = i + 1;
        let _ = writeln!(
            found.text,
            "\n# {cards}: nothing else of the deck hangs there. Held: take out position and velocity of the body, and the marks below.\n\
             #[joints.hold-{number}]\n#type = \"fixed\"\n#parent = {{ body = \"ground\", point = {:?} }}\n#child = {}",
            face.middle,
            side(bodies, face, &face.middle)
        );
    }
    found
}

/// The ties that hang together by the nodes they name, each by itself otherwise, with their cards.
fn clusters(ties: &[Tie]) -> Vec<(String, Vec<&Tie>)> {
    let nodes = |tie: &Tie| -> BTreeSet<String> {
        tie.joined.iter().filter(|of| matches!(of, Joined::Node(_))).map(Joined::to_string).collect()
    };
    let mut all: Vec<(BTreeSet<String>, Vec<&Tie>)> = Vec::new();
    for tie in ties {
        let (mut names, mut members) = (nodes(tie), vec![tie]);
        all.retain_mut(|(known, of)| {
            let is_apart = known.is_disjoint(&names);
            if !is_apart {
                names.append(known);
                members.append(of);
            }
            is_apart
        });
        members.sort_by_key(|tie| std::ptr::from_ref::<Tie>(tie));
        all.push((names, members));
    }
    let words = |ties: &[&Tie]| ties.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    all.into_iter().map(|(_, ties)| (words(&ties), ties)).collect()
}

/// All faces that `ties` join, each once.
fn faces<'a>(bodies: &[PartBody<'a>], ties: &[&Tie]) -> Vec<TiedFace<'a>> {
    let mut faces: Vec<TiedFace<'a>> = Vec::new();
    for tie in ties {
        for joined in &tie.joined {
            for (body, PartBody { part, mesh, .. }) in bodies.iter().enumerate() {
                let Some(face) = mesh.joined_face(part, joined) else { continue };
                if faces.iter().any(|known| known.body == body && known.face == face) {
                    continue;
                }
                let Ok(points) = mesh.face_part(face) else { continue };
                // Without round-off of the centroid.
                let digits = (9.0 - mesh.size().log10().floor()).clamp(0.0, 18.0) as usize;
                let rounded = |x: f64| format!("{x:.digits$}").parse().map_or(x, |x: f64| x + 0.0);
                let mut middle = centroid(&points).map(rounded);
                if *mesh.model() == Model::Axisymmetric {
                    middle[0] = 0.0;
                }
                let (is_rigid, area) = (tie.is_rigid, measure(&points));
                faces.push(TiedFace { body, face, is_rigid, area, middle });
            }
        }
    }
    faces
}

fn write_joint(
    text: &mut String,
    bodies: &[PartBody<'_>],
    (number, (cards, pair)): (usize, &(String, [TiedFace<'_>; 2])),
    parent: usize,
    closes_loop: bool,
) {
    // Of two faces that lie on each other the smaller is where they touch.
    let [a, b] = pair;
    let at = if a.area < b.area { a.middle } else { b.middle };
    let _ = writeln!(
        text,
        "\n# {cards}\n[joints.tie-{number}]\ntype = \"fixed\"\n{}parent = {}\nchild = {}",
        if closes_loop { "closes_loop = true\n" } else { "" },
        side(bodies, &pair[parent], &at),
        side(bodies, &pair[1 - parent], &at)
    );
}

/// A side of a joint at the point `at` of the deck.
fn side(bodies: &[PartBody<'_>], face: &TiedFace<'_>, at: &[f64; 3]) -> String {
    let PartBody { name, mesh, .. } = &bodies[face.body];
    let coupling = if face.is_rigid { ", coupling = \"rigid\"" } else { "" };
    let quoted = toml::Value::String(face.face.to_owned());
    let components = if mesh.model().dimension() == 2 { &at[..2] } else { &at[..] };
    format!("{{ body = \"{name}\", face = {quoted}, point = {components:?}{coupling} }}")
}
