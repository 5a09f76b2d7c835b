//! Bodies of patches given one by one: any order, sense and range of parameters gives the same body, and what does not fit is named.

use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::joining::fault::JoinFault;
use iga_core::nurbs::joining::{Joined, join};
use iga_core::nurbs::primitives::{SphereNet, solid, sphere};
use iga_core::nurbs::{FaceId, Patch};
use iga_core::space::{PatchSpace, Space};
use iga_core::splines::knots::KnotVector;

/// A box between two corners.
fn cuboid(lower: [f64; 3], upper: [f64; 3]) -> Patch {
    let linear = KnotVector::uniform(1, 1).expect("knots");
    let corner = |i: usize| std::array::from_fn(|d| if i >> d & 1 == 1 { upper[d] } else { lower[d] });
    Patch::new(vec![linear; 3], (0..8).map(corner).collect(), vec![1.0; 8]).expect("a box")
}

fn volume(joined: &Joined) -> f64 {
    MassProperties::of(&joined.shape, &Model::Solid).expect("regular").volume
}

/// The patch with its directions in the order `order`, those with a one in `flips` backwards, parameters from 2 to 2 + `range` and all weights
/// times `scale`.
fn disguised(patch: &Patch, order: [usize; 3], flips: usize, range: f64, scale: f64) -> Patch {
    let sizes = patch.net_size();
    let new: Vec<usize> = order.iter().map(|&d| sizes[d]).collect();
    let mut from = Vec::new();
    for k in 0..new[2] {
        for j in 0..new[1] {
            for i in 0..new[0] {
                let mut index = [0; 3];
                for (d, v) in order.into_iter().zip([i, j, k]) {
                    index[d] = v;
                }
                from.push(index[0] + sizes[0] * (index[1] + sizes[1] * index[2]));
            }
        }
    }
    let stretch = |k: &KnotVector| {
        KnotVector::new(k.degree(), k.knots().iter().map(|u| 2.0 + range * u).collect()).expect("knots")
    };
    let knots = order.iter().map(|&d| stretch(&patch.knots()[d])).collect();
    let points = from.iter().map(|&i| patch.control_points()[i]).collect();
    let weights = from.iter().map(|&i| scale * patch.weights()[i]).collect();
    let mut out = Patch::new(knots, points, weights).expect("a patch");
    for d in (0..3).filter(|d| flips >> d & 1 == 1) {
        out = out.reversed(d).expect("a patch");
    }
    out
}

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];

/// Frequencies need a solver; the trace of the stiffness and the number of unknowns tell tears and turned elements as well.
fn trace_and_size(joined: &Joined, elements: usize) -> (f64, usize) {
    let fine = joined.shape.refined(&[4; 3], &[elements; 3], &[]).expect("matching");
    let space = PatchSpace::new(fine.patches).expect("a space");
    let material = Material::new(210e9, 0.3, 7850.0).expect("steel");
    let matrices = assemble(&space, &Model::Solid, &material).expect("regular");
    let n = space.n_functions();
    let k = &matrices.stiffness;
    let trace = (0..k.ncols()).map(|j| {
        let rows = k.symbolic().row_idx_of_col(j).zip(k.val_of_col(j));
        rows.filter(|(i, _)| *i == j).map(|(_, v)| *v).sum::<f64>()
    });
    (trace.sum(), n)
}

#[test]
fn patches_in_any_order_sense_and_range_are_the_same_body() {
    let ball = sphere::sphere(0.01, SphereNet::Shells).expect("a ball");
    let plain = join(&ball.patches, &[]).expect("a ball");
    let (trace, n) = trace_and_size(&plain, 3);
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    for case in 0..6 {
        let given: Vec<Patch> = (0..7)
            .map(|i| {
                let way = 5 * case + 3 * i;
                disguised(
                    &ball.patches[(i + case) % 7],
                    ORDERS[way % 6],
                    way % 8,
                    1.0 + case as f64,
                    1.0 + 0.3 * i as f64,
                )
            })
            .collect();
        let joined = join(&given, &[]).expect("the same ball");
        // Gauss points integrate rational functions of degree four to some 1e-13.
        assert!((volume(&joined) / exact - 1.0).abs() < 1e-12, "case {case}");
        assert_eq!(joined.shape.faces.len(), 6 + 1, "six outer faces and \"surface\"");
        let (t, m) = trace_and_size(&joined, 3);
        assert_eq!(m, n, "case {case}: functions are tied alike");
        // Sums of 1e5 entries in another order.
        assert!((t / trace - 1.0).abs() < 1e-10, "case {case}: {t} {trace}");
    }
}

#[test]
fn left_handed_patches_are_turned_and_their_faces_keep_names() {
    let right = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
    let left = right.reversed(2).expect("a patch");
    let joined = join(std::slice::from_ref(&left), &[]).expect("turned");
    assert!(
        joined.notes[0].contains("left-handed") && joined.notes[0].contains("patch 0"),
        "{:?}",
        joined.notes
    );
    assert!((volume(&joined) - 6.0).abs() < 1e-13);
    for id in FaceId::all(std::slice::from_ref(&left)) {
        let name = format!("{}{}", ["xi", "eta", "zeta"][id.direction], if id.upper { "+" } else { "-" });
        let found = joined.shape.faces[&name][0];
        let mean = |patch: &Patch, id: FaceId| {
            let mut xi = [0.5; 3];
            xi[id.direction] = if id.upper { 1.0 } else { 0.0 };
            patch.point(&xi)
        };
        let (given, joined) = (mean(&left, id), mean(&joined.shape.patches[0], found));
        assert!(given.iter().zip(&joined).all(|(x, y)| (x - y).abs() < 1e-15), "{name}");
    }
}

#[test]
fn points_of_six_digits_are_made_one() {
    let mut second = cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    let points = second.control_points().iter().map(|p| p.map(|x| x + 3e-7)).collect();
    second = Patch::new(second.knots().to_vec(), points, second.weights().to_vec()).expect("a patch");
    let joined = join(&[cuboid([0.0; 3], [1.0; 3]), second], &[]).expect("welded");
    assert!(joined.notes[0].contains("5.20e-7 m apart"), "{:?}", joined.notes);
    assert_eq!(PatchSpace::new(joined.shape.patches).expect("a space").n_functions(), 12);
}

#[test]
fn directions_that_neighbours_turn_into_one_another_are_divided_alike() {
    // An L of three boxes, the last turned: elements of each direction go around the corner.
    let boxes = [
        cuboid([0.0; 3], [1.0; 3]),
        disguised(&cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]), [1, 2, 0], 0, 1.0, 1.0),
        disguised(&cuboid([0.0, 1.0, 0.0], [1.0, 2.0, 1.0]), [2, 0, 1], 3, 7.0, 1.0),
    ];
    let joined = join(&boxes, &[]).expect("an L");
    let fine = joined.shape.refined(&[1, 2, 3], &[2, 3, 5], &[]).expect("divided");
    let space = PatchSpace::new(fine.patches.clone()).expect("a space");
    let points: std::collections::BTreeSet<[i64; 3]> = fine
        .patches
        .iter()
        .flat_map(|p| p.control_points())
        .map(|p| p.map(|x| (x * 1e6).round() as i64))
        .collect();
    assert_eq!(space.n_functions(), points.len(), "every place has one function");
    assert!((volume(&joined) - 3.0).abs() < 1e-13);
}

#[test]
fn what_does_not_fit_is_named() {
    let unit = cuboid([0.0; 3], [1.0; 3]);
    let beside = cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    let text = |patches: &[Patch]| join(patches, &[]).expect_err("refused").to_string();
    let elevated = |p: &Patch| {
        let finer = p.knots()[1].elevated(1).expect("degree 2");
        p.refine_to(1, &finer).expect("the same geometry")
    };
    let cut = |p: &Patch, u: f64| p.insert_knots(1, &[u]).expect("the same geometry");
    let weighted = {
        let mut weights = vec![1.0; 8];
        weights[2] = 2.0;
        Patch::new(beside.knots().to_vec(), beside.control_points().to_vec(), weights).expect("a patch")
    };
    let folded = {
        let mut points = unit.control_points().to_vec();
        points.swap(0, 1);
        Patch::new(unit.knots().to_vec(), points, vec![1.0; 8]).expect("a patch")
    };
    for (what, patches, words) in [
        (
            "degrees",
            vec![unit.clone(), elevated(&beside)],
            &["0:xi+", "1:xi-", "degrees are 1 and 2 along eta and eta"][..],
        ),
        (
            "knots",
            vec![unit.clone(), cut(&beside, 0.5)],
            &["0:xi+", "1:xi-", "interior knots are [] and [0.5]"],
        ),
        ("both", vec![cut(&unit, 0.25), cut(&beside, 0.5)], &["[0.25] and [0.5]", "insert knots"]),
        ("weights", vec![unit.clone(), weighted], &["0:xi+", "1:xi-", "weights"]),
        (
            "part",
            vec![unit.clone(), cuboid([1.0, 0.5, 0.0], [2.0, 2.0, 1.0])],
            &["meet only partly", "0:xi+", "1:xi-"],
        ),
        ("small part", vec![unit.clone(), cuboid([1.0, 0.2, 0.2], [2.0, 0.3, 0.3])], &["meet only partly"]),
        (
            "gap",
            vec![unit.clone(), cuboid([1.00003, 0.0, 0.0], [2.0, 1.0, 1.0])],
            &["0:xi+", "1:xi-", "3.00e-5 m apart"],
        ),
        ("apart", vec![unit.clone(), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])], &["patch 1 shares no face"]),
        ("edge", vec![unit.clone(), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])], &["patch 1 shares no face"]),
        ("twice", vec![unit.clone(), unit.clone()], &["patches 0 and 1 overlap"]),
        (
            "inside",
            vec![unit.clone(), beside.clone(), cuboid([0.6, 0.2, 0.2], [1.4, 0.8, 0.8])],
            &["patches 0 and 2 overlap"],
        ),
        (
            "on the same side",
            vec![unit.clone(), cuboid([0.5, 0.0, 0.0], [1.0, 1.0, 1.0])],
            &["patches 0 and 1 overlap"],
        ),
        (
            "three",
            vec![unit.clone(), beside.clone(), cuboid([1.0, 0.0, 0.0], [1.5, 1.0, 1.0])],
            &["one and the same", "2:xi-"],
        ),
        ("folded", vec![unit.clone(), beside.clone(), folded], &["patch 2", "folded"]),
        ("none", vec![], &["no patch"]),
    ] {
        let text = text(&patches);
        assert!(words.iter().all(|w| text.contains(w)), "{what}: {text}");
    }
    let faces =
        [(0, 1, true), (1, 1, false)].map(|(patch, direction, upper)| FaceId { patch, direction, upper });
    let fault = join(&[unit, beside], &[faces]).expect_err("not joined there");
    assert!(matches!(&fault, JoinFault::NotJoined { faces } if faces == &["0:eta+", "1:eta-"]), "{fault}");
}

#[test]
fn seams_and_collapsed_faces_are_no_faults() {
    let tube = solid::hollow_cylinder(0.5, 1.0, 2.0).expect("a tube");
    let joined = join(&tube.patches, &[]).expect("a tube");
    assert_eq!(joined.shape.faces.len(), 4, "{:?}", joined.shape.faces.keys());
    let ball = sphere::sphere(1.0, SphereNet::Spindle).expect("a ball");
    let joined = join(&ball.patches, &[]).expect("a ball");
    assert_eq!(
        joined.shape.singular.len(),
        sphere::sphere(1.0, SphereNet::Spindle).expect("a ball").singular.len()
    );
}

#[test]
fn uneven_knots_are_divided_alike_from_either_end() {
    // An interior knot at a quarter of a shared direction, which the second patch runs through backwards over another range.
    let cut = |p: &Patch| p.insert_knots(1, &[0.25]).expect("the same geometry");
    let boxes = [
        cut(&cuboid([0.0; 3], [1.0; 3])),
        disguised(&cut(&cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0])), [0, 1, 2], 6, 3.0, 1.0),
    ];
    let joined = join(&boxes, &[]).expect("one body");
    let fine = joined.shape.refined(&[2; 3], &[1, 6, 1], &[]).expect("divided alike");
    let [one, other] = [0, 1].map(|p| fine.patches[p].knots()[1].breaks());
    assert_eq!(one.len(), 7, "{one:?}");
    for (u, v) in one.iter().zip(other.iter().rev()) {
        assert!((u + v - 1.0).abs() < 1e-15, "{one:?} {other:?}");
    }
    assert!((one[1] - one[0] - (one[6] - one[5])).abs() > 1e-3, "uneven: {one:?}");
}
