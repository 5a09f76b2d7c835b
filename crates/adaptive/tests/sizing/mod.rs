//! Meshes that the program chooses: the lowest ten frequencies of every shape of the catalogue, from compact to slender.
//!
//! Solids are set against polynomials over the whole body ([`ritz`]) and against Lamb's ball, plane and axisymmetric shapes against
//! finer meshes. Each prints a row: body, elements, unknowns, time of the choice, the program's estimate, error.

use adaptive::sizing::mesh::first_elements::errors_across;
use adaptive::sizing::mode_count::ModeRange;
use adaptive::sizing::{Candidate, SizeRequest, mesh, mode_count};
use adaptive::spec::{DiscretisationSpec, ElasticSpec, ReductionSpec};
use iga_core::SplineError;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};
use ritz::Revolved;

mod ritz;

/// What a user may count on for the first ten frequencies.
const LIMIT: f64 = 3e-3;
const N_CHECKED: usize = 10;

fn steel() -> Material {
    Material::new(210e9, 0.3, 7850.0).unwrap()
}

fn body(shape: Result<Shape, SplineError>, model: Model) -> ElasticSpec {
    let shape = shape.unwrap();
    let degree = |d: usize| shape.patches.iter().map(|p| p.knots()[d].degree()).max().unwrap().max(3);
    let degrees: Vec<usize> = (0..shape.patches[0].dimension()).map(degree).collect();
    let elements = vec![1; degrees.len()];
    let mesh = DiscretisationSpec { degrees, elements, knots: None, refine: Vec::new() };
    ElasticSpec::new(shape, model, steel(), mesh, ReductionSpec::Modal { modes: 20 })
}

/// Frequencies on a mesh with twice the elements and a degree more in every direction than was chosen, whose own error is a
/// hundredth of the limit or less by the rate of smooth modes: for plane and axisymmetric shapes, where it is cheap.
fn refined(name: &str, elastic: &ElasticSpec, elements: &[usize]) -> Vec<f64> {
    let mut finer = elastic.clone();
    finer.discretisation.degrees.iter_mut().for_each(|p| *p += 1);
    let twice: Vec<usize> = elements.iter().map(|n| 2 * n).collect();
    let candidate = Candidate::new(name, &finer, SizeRequest { elements: true, modes: false });
    candidate.spectrum(&twice, N_CHECKED).unwrap().frequencies
}

/// Error of the first ten frequencies with what the program chooses for a body on which no contact acts; without a
/// reference against [`refined`].
fn error(name: &str, shape: Result<Shape, SplineError>, model: Model, reference: Option<Vec<f64>>) -> f64 {
    let elastic = body(shape, model);
    let n_modes = mode_count::least(adaptive::body::splines::rigid_motion(&model));
    let candidate = Candidate::new(name, &elastic, SizeRequest { elements: true, modes: false });
    let began = std::time::Instant::now();
    let (elements, estimate) = mesh::mesh(&candidate, n_modes, Vec::new()).unwrap();
    let seconds = began.elapsed().as_secs_f64();
    let chosen = candidate.spectrum(&elements, n_modes).unwrap().frequencies;
    let reference = reference.unwrap_or_else(|| refined(name, &elastic, &elements));
    assert_eq!(reference.len(), N_CHECKED, "{name}");
    let error = change(&chosen, &reference);
    let unknowns = candidate.unknowns(&elements);
    println!("| {name} | {elements:?} | {unknowns} | {seconds:.1} s | {estimate:.1e} | {error:.1e} |");
    error
}

/// Largest relative difference of frequencies.
fn change(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

fn check(name: &str, shape: Result<Shape, SplineError>, model: Model) {
    let error = error(name, shape, model, None);
    assert!(error < LIMIT, "{name}: {error:.2e}");
}

/// Length over thickness.
const PROPORTIONS: [f64; 4] = [1.0, 5.0, 30.0, 200.0];

#[test]
fn axisymmetric_shapes() {
    check("sphere", axisymmetric::sphere(0.01), Model::Axisymmetric);
    axisymmetric_of(&PROPORTIONS[2..3]);
}

#[test]
#[ignore = "second tier: ten seconds"]
fn axisymmetric_shapes_of_other_proportions() {
    axisymmetric_of(&[PROPORTIONS[0], PROPORTIONS[1], PROPORTIONS[3]]);
}

fn axisymmetric_of(proportions: &[f64]) {
    for &p in proportions {
        check(&format!("rod 1:{p}"), axisymmetric::rod(0.01, 0.02 * p), Model::Axisymmetric);
        check(&format!("plate {p}:1"), axisymmetric::rod(0.01 * p, 0.02), Model::Axisymmetric);
        let end = axisymmetric::rod_spherical_end(0.01, 0.02 * p);
        check(&format!("spherical end 1:{p}"), end, Model::Axisymmetric);
        let tube = axisymmetric::hollow_cylinder(0.01, 0.015, 0.03 * p);
        check(&format!("tube 1:{p}"), tube, Model::Axisymmetric);
        let wall = axisymmetric::hollow_cylinder(0.1, 0.1 + 0.1 / p, 0.1);
        check(&format!("wall 1:{p}"), wall, Model::Axisymmetric);
    }
}

#[test]
fn plane_shapes() {
    let stress = Model::PlaneStress { thickness: 0.01 };
    check("disc", plane::disc(0.01), stress);
    check("disc, plane strain", plane::disc(0.01), Model::PlaneStrain { thickness: 1.0 });
    for p in PROPORTIONS {
        check(&format!("rectangle 1:{p}"), plane::rectangle(0.01 * p, 0.01), stress);
        check(&format!("rectangle {p}:1"), plane::rectangle(0.01, 0.01 * p), stress);
    }
}

#[test]
fn slender_bars_vibrate_as_bernoulli_says() {
    let (size, length) = (0.01, 2.0);
    let bar = body(solid::cuboid([size, size, length]), Model::Solid);
    let candidate = Candidate::new("bar", &bar, SizeRequest { elements: true, modes: false });
    let (elements, _) = mesh::mesh(&candidate, 20, Vec::new()).unwrap();
    assert!(elements[0] <= 4 && elements[1] <= 4 && elements[2] <= 100, "few across: {elements:?}");
    let found = candidate.spectrum(&elements, 4).unwrap().frequencies;
    // Shear and rotary inertia lower the second pair by some (7.85 h / L)^2 / 12 (1 + E / (0.85 G)) / 2 = 3e-4, the first by a
    // third of it; the mesh may raise them by 1e-3 at most.
    let wave_speed = (210e9_f64 / 7850.0).sqrt();
    for (i, root) in [(0, 4.730_041), (1, 4.730_041), (2, 7.853_205), (3, 7.853_205_f64)] {
        let exact =
            root * root * wave_speed * size / 12f64.sqrt() / (std::f64::consts::TAU * length * length);
        assert!((found[i] / exact - 1.0).abs() < 1e-3, "mode {i}: {} and {exact}", found[i]);
    }
}

/// What doubling the one element across a wall changes is no more than what is taken for its error (Eq. N.12).
#[test]
fn one_element_across_a_wall_errs_by_less_than_is_said() {
    for (thickness, along) in [(1.0 / 15.0, 8), (1.0 / 30.0, 10)] {
        let plate = body(solid::cuboid([thickness, 1.0, 1.0]), Model::Solid);
        let known = errors_across(&plate, 20);
        let said = known[0].unwrap();
        assert!(known[1].is_none() && known[2].is_none() && said < 1e-3, "{known:?}");
        let candidate = Candidate::new("plate", &plate, SizeRequest { elements: true, modes: false });
        let of = |across: usize| candidate.spectrum(&[across, along, along], 20).unwrap().frequencies;
        let found = change(&of(1), &of(2));
        assert!(found > 0.05 * said && found < said, "{thickness}: {found:.1e}, {said:.1e}");
    }
}

/// The number of modes up to a limit is found from the frequencies next to it; more than are ever taken are known from any mesh.
#[test]
fn modes_are_counted_as_if_all_were_known() {
    let plate = body(plane::rectangle(0.03, 0.02), Model::PlaneStress { thickness: 0.01 });
    let mut given = plate.clone();
    given.discretisation.elements = vec![24, 16];
    let candidate = Candidate::new("plate", &given, SizeRequest { elements: false, modes: true });
    let all = candidate.spectrum(&[24, 16], 120).unwrap().frequencies;
    // Counts of one mesh err as frequencies without modes do, 1e-6.
    let same = |(n, highest): (usize, Option<f64>), expected: usize| {
        assert_eq!(n, expected);
        let highest = highest.unwrap();
        assert!((highest / all[n - 1] - 1.0).abs() < 1e-5, "{n}: {highest} and {}", all[n - 1]);
    };
    let up_to = |limit: f64, most: usize| ModeRange { limit, least: 20, most };
    for n in [25, 60, 110] {
        let limit = 0.5 * (all[n - 1] + all[n]);
        same(mode_count::count(&candidate, up_to(limit, 300), &mut Vec::new()).unwrap(), n);
        let cut = mode_count::count(&candidate, up_to(3.0 * limit, n), &mut Vec::new()).unwrap();
        assert_eq!(cut, (n, None));
    }
    // With elements of the program's own, the mesh is another one, on which the shortest waves are right to a per cent.
    let candidate = Candidate::new("plate", &plate, SizeRequest { elements: true, modes: true });
    let (n, highest) = mode_count::count(&candidate, up_to(all[79], 300), &mut Vec::new()).unwrap();
    let highest = highest.unwrap();
    assert!((78..=81).contains(&n) && (highest / all[n - 1] - 1.0).abs() < 0.01, "{n}: {highest}");
}

/// What two polynomials more in every direction give, and by how much they lower the frequencies: what the reference is itself off
/// by counts as an error.
fn settled(reference: impl Fn(usize) -> Vec<f64>) -> (Vec<f64>, f64) {
    let (few, more) = (reference(0), reference(2));
    let change = change(&few, &more);
    println!("reference settled to {change:.1e}");
    (more, change)
}

/// Errors of bodies by name.
type Errors = Vec<(String, f64)>;

fn assert_right(errors: Errors) {
    let wrong: Errors = errors.into_iter().filter(|(_, error)| error.is_nan() || *error >= LIMIT).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A box and the number of its polynomials.
fn of_box((size, orders): ([f64; 3], [usize; 3])) -> (String, f64) {
    let (reference, change) =
        settled(|more| ritz::cuboid(size, &steel(), orders.map(|n| n + more), N_CHECKED));
    let name = format!("box {} x {} x {}", size[0], size[1], size[2]);
    let error = error(&name, solid::cuboid(size), Model::Solid, Some(reference));
    (name, error + change)
}

fn of_revolved(body: Revolved) -> (String, f64) {
    let of_orders = |more| Revolved { orders: body.orders.map(|n| n + more), ..body };
    let (reference, change) = settled(|more| of_orders(more).solid(&steel(), N_CHECKED));
    let Revolved { inner, outer, length, .. } = body;
    let (name, shape) = if inner > 0.0 {
        (
            format!("tube, radii {inner:.4}, {outer:.4}, x {length}"),
            solid::hollow_cylinder(inner, outer, length),
        )
    } else {
        (format!("cylinder, radius {outer} x {length}"), solid::cylinder(outer, length))
    };
    let error = error(&name, shape, Model::Solid, Some(reference));
    (name, error + change)
}

fn cylinder(outer: f64, length: f64, orders: [usize; 2]) -> Revolved {
    Revolved { inner: 0.0, outer, length, orders }
}

fn tube(inner: f64, wall: f64, length: f64, orders: [usize; 2]) -> Revolved {
    Revolved { inner, outer: inner + wall, length, orders }
}

#[test]
#[ignore = "second tier: a minute"]
fn solid_bars() {
    let bars =
        [([1.0, 1.0, 30.0], [8, 8, 20]), ([1.0, 1.0, 200.0], [8, 8, 20]), ([1.0, 5.0, 200.0], [6, 8, 22])];
    let round = [
        cylinder(0.5, 30.0, [5, 20]),
        cylinder(0.5, 200.0, [5, 22]),
        tube(0.3, 0.2, 30.0, [5, 20]),
        tube(0.3, 0.2, 200.0, [5, 22]),
    ];
    assert_right(bars.into_iter().map(of_box).chain(round.into_iter().map(of_revolved)).collect());
}

#[test]
#[ignore = "second tier: a minute"]
fn compact_solids() {
    let boxes = [([1.0, 1.0, 1.0], [8, 8, 8]), ([1.0, 1.0, 5.0], [8, 8, 14]), ([1.0, 5.0, 5.0], [6, 12, 12])];
    let round = [
        cylinder(0.5, 1.0, [7, 12]),
        cylinder(0.5, 5.0, [5, 14]),
        cylinder(2.5, 1.0, [9, 7]),
        tube(0.3, 0.2, 1.0, [6, 12]),
        tube(0.3, 0.2, 5.0, [5, 14]),
        tube(1.0, 1.0, 1.0, [8, 12]),
    ];
    assert_right(boxes.into_iter().map(of_box).chain(round.into_iter().map(of_revolved)).collect());
}

#[test]
#[ignore = "second tier: minutes"]
fn plates() {
    let boxes = [
        ([1.0, 5.0, 30.0], [6, 8, 18]),
        ([1.0, 30.0, 30.0], [4, 16, 16]),
        ([1.0, 30.0, 200.0], [4, 14, 22]),
        ([1.0, 200.0, 200.0], [4, 18, 18]),
    ];
    assert_right(boxes.into_iter().map(of_box).collect());
}

#[test]
#[ignore = "second tier: minutes"]
fn round_plates() {
    let round = [
        cylinder(15.0, 1.0, [13, 5]),
        cylinder(100.0, 1.0, [16, 4]),
        tube(1.0, 1.0, 1.0 / 30.0, [12, 5]),
        tube(1.0, 1.0, 1.0 / 200.0, [14, 4]),
    ];
    assert_right(round.into_iter().map(of_revolved).collect());
}

#[test]
#[ignore = "second tier: minutes"]
fn rings() {
    let round = [
        tube(1.0, 0.2, 0.2, [6, 6]),
        tube(1.0, 1.0 / 30.0, 1.0 / 30.0, [5, 5]),
        tube(1.0, 1.0 / 200.0, 1.0 / 200.0, [4, 4]),
        tube(1.0, 0.005, 0.1, [4, 12]),
    ];
    assert_right(round.into_iter().map(of_revolved).collect());
}

#[test]
#[ignore = "second tier: minutes"]
fn shells() {
    let round = [
        tube(1.0, 0.2, 1.0, [6, 14]),
        tube(0.05, 0.005, 1.0, [5, 20]),
        tube(10.0 / 30.0, 1.0 / 30.0, 10.0, [5, 18]),
        tube(1.0, 0.005, 1.0, [4, 16]),
        tube(1.0, 1.0 / 30.0, 1.0, [5, 14]),
    ];
    assert_right(round.into_iter().map(of_revolved).collect());
}

/// Lamb's frequencies of the steel ball of 10 mm, with their copies \[Hz\].
fn lamb() -> Vec<f64> {
    let text = include_str!("../../../../tests/reference/lamb_sphere_steel.csv");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let copies = rows.flat_map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        std::iter::repeat_n(cells[2].parse::<f64>().unwrap(), cells[3].parse().unwrap())
    });
    copies.take(N_CHECKED).collect()
}

#[test]
#[ignore = "second tier: half a minute"]
fn balls() {
    let of_net = |net: SphereNet| {
        let name = format!("ball {net:?}");
        let error = error(&name, sphere::sphere(0.01, net), Model::Solid, Some(lamb()));
        (name, error)
    };
    assert_right(SphereNet::ALL.into_iter().map(of_net).collect());
}
