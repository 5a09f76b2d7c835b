//! Geometric stiffening of plane-stress strips and solid bars: tension under a spin, identities, the spin-up manoeuvre.

use adaptive::body::field::Field;
use adaptive::body::field_body::FieldBody;
use std::f64::consts::TAU;

use adaptive::body::loads::MarkerLoads;
use adaptive::body::reduced::geometric_stiffening;
use adaptive::body::reduced::{Interface, ReducedBody};
use adaptive::body::splines::ElasticBody;
use adaptive::spec::{DiscretisationSpec, ElasticSpec, Place, ReductionSpec};
use faer::Mat;
use ffr_dynamics::body::{GeometricStiffening, StandardInputData};
use ffr_dynamics::integration::{DenseOutput, Integrator, Method, StepSettings};
use ffr_dynamics::kinematics::{FlexiblePoint, Marker, MarkerWeights};
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, ErrorScale, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
    TimeFunction,
};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{plane, solid};
use iga_core::space::Space;
use nalgebra::{UnitQuaternion, Vector3};

/// Simo & Vu-Quoc (1986): EA = 2.8e7 N, GA = 1e7 N, EI = 1.4e4 N m², ρA = 1.2 kg/m, ρI = 6e-4 kg m.
///
/// A square section of height² = 12 EI/EA has ρI by itself, and GA with the shear coefficient 5/6 at ν = 1/6.
const LENGTH: f64 = 10.0;
const AXIAL: f64 = 2.8e7;
const LINE_MASS: f64 = 1.2;
const SPEED: f64 = 6.0;
const SPIN_UP: f64 = 15.0;

fn height() -> f64 {
    (12.0 * 1.4e4 / AXIAL).sqrt()
}

fn body(shape: Shape, model: Model, degrees: Vec<usize>, elements: Vec<usize>, modes: usize) -> ElasticBody {
    let area = height() * height();
    let material = Material::new(AXIAL / area, 1.0 / 6.0, LINE_MASS / area).unwrap();
    let discretisation = DiscretisationSpec { degrees, elements, knots: None, refine: Vec::new() };
    let reduction = ReductionSpec::CraigBampton { modes, fixed_interface_modes: Some(modes) };
    let spec = ElasticSpec::new(shape, model, material, discretisation, reduction);
    ElasticBody::build("beam", spec).unwrap()
}

fn strip(elements: usize, modes: usize) -> ElasticBody {
    let model = Model::PlaneStress { thickness: height() };
    body(plane::rectangle(LENGTH, height()).unwrap(), model, vec![3, 2], vec![elements, 1], modes)
}

/// A body in the tangent frame of the marker at its left end.
struct Held {
    body: ElasticBody,
    support: MarkerWeights,
    shapes: Mat<f64>,
    data: StandardInputData,
    hub: Marker,
    tip: FlexiblePoint,
}

fn held(body: ElasticBody) -> Held {
    let place = [-0.5 * LENGTH, 0.0, 0.0];
    let support = body.marker_weights(&Place::Point(place), UnitQuaternion::identity()).unwrap();
    let direction = |c: usize| std::array::from_fn(|k| if k == c { 1.0 } else { 0.0 });
    let load = MarkerLoads {
        name: "hub".into(),
        place: Place::Point(place),
        directions: body.assembled.motion.directions().iter().map(|c| direction(*c)).collect(),
    };
    let ReducedBody { basis, data, .. } =
        body.reduce(&Interface { loads: vec![load].into(), ..Interface::default() }).unwrap();
    let hub = support.marker("hub", basis.shapes.as_ref()).unwrap();
    let frame = hub.tangent_frame(data.motion);
    let shapes = frame.shifted_shapes(&body.assembled, basis.shapes.as_ref()).unwrap();
    let data = data.in_tangent_frame(&frame).unwrap();
    let hub = hub.in_tangent_frame(&frame).unwrap();
    let tip = body.flexible_point(&Place::Point([0.5 * LENGTH, 0.0, 0.0]), shapes.as_ref()).unwrap();
    Held { body, support, shapes, data, hub, tip }
}

fn largest(m: &Mat<f64>) -> f64 {
    m.norm_max()
}

#[test]
fn shapes_of_the_tangent_frame_vanish_at_its_marker_and_agree_with_the_data() {
    let held = held(strip(12, 6));
    let again = held.support.marker("hub", held.shapes.as_ref()).unwrap();
    for c in 0..3 {
        for row in [again.displacement_row(c), again.rotation_row(c)] {
            assert!(row.iter().all(|v| v.abs() < 1e-11)); // round-off of shapes of size one
        }
    }
    let integrals =
        ffr_dynamics::body::ShapeIntegrals::new(&held.body.assembled, held.shapes.as_ref()).unwrap();
    let n = held.data.n_modes();
    let difference = integrals.modal_mass - held.data.modal_mass.to_matrix(n);
    assert!(largest(&difference) < 1e-9 * largest(&held.data.modal_mass.to_matrix(n)));
}

/// Axial and lateral linear shapes, and bending shapes `x^k`, as displacements of the unknowns.
fn trial_shapes(body: &ElasticBody, n: usize) -> Mat<f64> {
    // Powers of x up to the degree 3 are splines; the section turns with them, as in Bernoulli's beam.
    let powers: Vec<Vec<f64>> = (0..n).map(|k| control_values_of_power(body, k + 2)).collect();
    Mat::from_fn(body.assembled.dofs.len(), n, |i, k| {
        let dof = body.assembled.dofs[i];
        if dof.component == 1 { powers[k][dof.node as usize] } else { 0.0 }
    })
}

/// Control values of `(x + L/2)^k`, k <= 3, in a net whose first direction is along x, of degree 3.
fn control_values_of_power(body: &ElasticBody, k: usize) -> Vec<f64> {
    let knots = &body.shape.patches[0].knots()[0];
    let breaks = knots.breaks();
    let full: Vec<f64> = std::iter::repeat_n(breaks[0], 3)
        .chain(breaks.iter().copied())
        .chain(std::iter::repeat_n(breaks[breaks.len() - 1], 3))
        .collect();
    let n = full.len() - 4;
    // Blossom of t^k at three neighbouring knots.
    let value = |i: usize| {
        let t = [full[i + 1], full[i + 2], full[i + 3]].map(|t| LENGTH * t);
        match k {
            2 => (t[0] * t[1] + t[1] * t[2] + t[2] * t[0]) / 3.0,
            _ => t[0] * t[1] * t[2],
        }
    };
    (0..body.space.n_functions()).map(|a| value(a % n)).collect()
}

#[test]
fn spinning_bars_are_stiffened_by_their_tension() {
    // ∫ P w'_i w'_j with P = ρA (L² - x²)/2 from the hub, at 1 rad/s: closed forms for w = x², x³.
    let integral = |i: i32, j: i32| {
        let m = i + j - 2;
        let (l, half) = (LENGTH, 0.5 * LINE_MASS * f64::from(i * j));
        half * (l.powi(m + 3) / f64::from(m + 1) - l.powi(m + 3) / f64::from(m + 3))
    };
    let bar = |elements: Vec<usize>| {
        let shape = solid::cuboid([LENGTH, height(), height()]).unwrap();
        body(shape, Model::Solid, vec![3, 2, 2], elements, 6)
    };
    for body in [strip(24, 6), bar(vec![24, 1, 1])] {
        let support = body
            .marker_weights(&Place::Point([-0.5 * LENGTH, 0.0, 0.0]), UnitQuaternion::identity())
            .unwrap();
        let shapes = trial_shapes(&body, 2);
        let given = geometric_stiffening(&body, &body.assembled, shapes.as_ref(), &support).unwrap();
        // The frame's origin is the middle: X_x = x - L/2, the load of a spin about the hub is that of X_x + L/2.
        let spin = &given.position[0][0] + faer::Scale(0.5 * LENGTH) * &given.translation[0];
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let expected = integral(i as i32 + 2, j as i32 + 2);
            let found = spin[(i, j)];
            // A point support concentrates the stress over the height of the section, where w' is small.
            assert!((found - expected).abs() < 1e-5 * expected.abs(), "{i} {j}: {found} {expected}");
        }
        // Pressed by a load towards the hub it buckles: gravity along -x has the opposite sign of a pull along +x.
        assert!(given.translation[0][(0, 0)] > 0.0);
        // Loads across cause bending, whose tension and pressure cancel over the section, and shear.
        let across = largest(&given.translation[1]).max(largest(&given.position[0][1]));
        assert!(across < 1e-6 * largest(&given.position[0][0]), "{across:e}");
    }
}

#[test]
fn shapes_that_do_not_deform_gain_nothing_and_axisymmetric_bodies_are_refused() {
    let body = strip(8, 4);
    let support =
        body.marker_weights(&Place::Point([-0.5 * LENGTH, 0.0, 0.0]), UnitQuaternion::identity()).unwrap();
    let dofs = &body.assembled.dofs;
    let moved = Mat::from_fn(dofs.len(), 3, |i, j| match j {
        2 => {
            if dofs[i].component == 1 {
                body.assembled.nodes[dofs[i].node as usize][0]
            } else {
                0.0
            }
        }
        c => f64::from(dofs[i].component as usize == c),
    });
    let given = geometric_stiffening(&body, &body.assembled, moved.as_ref(), &support).unwrap();
    for matrix in given.translation[..2].iter().chain(given.position[..2].iter().flat_map(|p| &p[..2])) {
        for (i, j) in [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2)] {
            assert!(matrix[(i, j)].abs() < 1e-10 * matrix.norm_max().max(LINE_MASS), "{i} {j}");
        }
        assert!((matrix[(0, 2)] - matrix[(2, 0)]).abs() < 1e-9);
    }
    let rod = iga_core::nurbs::primitives::axisymmetric::rod(0.1, LENGTH).unwrap();
    let axial = crate::geometric_stiffening::body(rod, Model::Axisymmetric, vec![2, 2], vec![1, 2], 2);
    let marker = axial.marker_weights(&Place::Point([0.0, 0.0, 0.0]), UnitQuaternion::identity()).unwrap();
    let none = Mat::<f64>::zeros(axial.assembled.dofs.len(), 0);
    assert!(geometric_stiffening(&axial, &axial.assembled, none.as_ref(), &marker).is_err());
}

/// Angle of the spin-up manoeuvre and its derivatives.
fn spin_up(t: f64) -> [f64; 3] {
    let w = TAU / SPIN_UP;
    if t >= SPIN_UP {
        return [SPEED * (t - SPIN_UP / 2.0), SPEED, 0.0];
    }
    let angle = SPEED / SPIN_UP * (0.5 * t * t + ((w * t).cos() - 1.0) / (w * w));
    [angle, SPEED / SPIN_UP * (t - (w * t).sin() / w), SPEED / SPIN_UP * (1.0 - (w * t).cos())]
}

/// Axial and lateral displacement of the tip at the times of a table.
fn tip_motion(held: &Held, given: Option<&GeometricStiffening>, times: &[f64]) -> Vec<[f64; 3]> {
    let mut data = held.data.clone();
    if let Some(given) = given {
        data = data.with_geometric_stiffening(given).unwrap();
    }
    let at = |body: &str| Attachment::new(body, "hub");
    let mut joint = JointSpec::new("hub", JointKind::Revolute, at(GROUND), at("beam"));
    joint.coordinates =
        vec![CoordinateForce { motion: Some(TimeFunction::new(spin_up)), ..CoordinateForce::default() }];
    let body = BodySpec { name: "beam".to_string(), data, markers: vec![held.hub.clone()] };
    let ground = vec![Marker::rigid("hub", Vector3::zeros(), UnitQuaternion::identity())];
    let spec = SystemSpec { bodies: vec![body], ground, joints: vec![joint], ..SystemSpec::default() };
    let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    system.set_error_scale(ErrorScale { relative: 1e-5, ..ErrorScale::default() }).unwrap();
    let y = system.rest();
    let layout = system.model().bodies[0].layout;
    let settings = StepSettings { max_step: 0.05, ..StepSettings::default() };
    let mut integrator = Integrator::new(Method::TrBdf2, settings, 0.0, &y, &system).unwrap();
    let (mut curve, mut next, mut state) = (Vec::new(), 0, vec![0.0; y.len()]);
    integrator
        .run(&mut system, times[times.len() - 1], |_, at| {
            while next < times.len() && times[next] <= at.time() {
                at.interpolate(times[next], &mut state);
                let moved = held.tip.local_position(&state[layout.elastic()]) - held.tip.position;
                curve.push([times[next], moved.x, moved.y]);
                next += 1;
            }
            curve.last().is_none_or(|p| p[2].abs() < 2.0 * LENGTH)
        })
        .unwrap();
    curve
}

fn reference() -> Vec<[f64; 3]> {
    include_str!("../../ffr-dynamics/tests/data/spinning_beam.csv")
        .lines()
        .filter(|l| !l.starts_with(['#', 't']))
        .map(|l| {
            let row: Vec<f64> = l.split(',').map(|x| x.parse().unwrap()).collect();
            [row[0], row[2], row[3]]
        })
        .collect()
}

#[test]
fn strip_follows_the_spin_up_reference_and_diverges_without_stiffening() {
    let held = held(strip(20, 20));
    let given =
        geometric_stiffening(&held.body, &held.body.assembled, held.shapes.as_ref(), &held.support).unwrap();
    let reference = reference();
    let times: Vec<f64> = reference.iter().map(|r| r[0]).collect();
    let curve = tip_motion(&held, Some(&given), &times);
    let off = curve.iter().zip(&reference).map(|(a, b)| (a[2] - b[2]).abs()).fold(0.0, f64::max);
    let extreme = curve.iter().map(|p| p[2]).fold(0.0, f64::min);
    let last: Vec<f64> = curve.iter().filter(|p| p[0] > 16.0).map(|p| p[1]).collect();
    let extension = last.iter().sum::<f64>() / last.len() as f64;
    // Demanded are 2 %; found are -0.5758 m, 2.1e-3 m off at most, 5.146e-4 m.
    assert_eq!(curve.len(), reference.len());
    assert!((extreme + 0.574).abs() < 0.02 * 0.574, "{extreme}");
    assert!(off < 0.02 * 0.574, "{off}");
    assert!((extension - 5.14e-4).abs() < 0.02 * 5.14e-4, "{extension:e}");
    // Centrifugal forces of 6 rad/s exceed what the first mode of 3.8 rad/s bears.
    let curve = tip_motion(&held, None, &times);
    let leaves = curve.iter().find(|p| p[2].abs() > LENGTH).map(|p| p[0]);
    assert!(leaves.is_some_and(|t| (t - 9.17).abs() < 0.2), "{leaves:?}");
}
