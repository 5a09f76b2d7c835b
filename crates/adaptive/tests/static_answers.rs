//! Joints on faces of bars: frequencies, sag and prescribed motions of bodies whose bases have static answers.

use crate::impacts;
use adaptive::body::field::Field;
use adaptive::body::field_body::FieldBody;
use std::f64::consts::TAU;
use std::sync::Arc;

use crate::impacts::finished;
use adaptive::body::loads::MarkerLoads;
use adaptive::body::reduced::Interface;
use adaptive::body::splines::ElasticBody;
use adaptive::model::RunModel;
use adaptive::spec::GaugeRequest;
use adaptive::spec::ImportedSpec;
use adaptive::spec::{
    Attachment, BodyKind, BodySpec, CoordinateSpec, DiscretisationSpec, ElasticSpec, FlexibleSpec, FrameSpec,
    InitialMotion, JointSpec, Place, PointSpec, ReductionSpec, RunSpec, TimeCurve,
};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::integration::Method;
use ffr_dynamics::interchange::FullBody;
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::{ElasticProblem, ReducedBasis, TakenLoads, with_static_answers};
use ffr_dynamics::system::JointKind;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Face;
use iga_core::nurbs::FaceId;
use iga_core::nurbs::primitives::{plane, solid};
use iga_core::space::Space;
use iga_core::surface::gauss_points;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Aluminium bar \[m\].
const SIZE: [f64; 3] = [0.3, 0.03, 0.01];

fn aluminium() -> Material {
    Material::new(70e9, 0.33, 2700.0).unwrap()
}

fn built(shape: iga_core::nurbs::Shape, model: Model, degrees: &[usize], elements: &[usize]) -> ElasticBody {
    let discretisation = DiscretisationSpec {
        degrees: degrees.to_vec(),
        elements: elements.to_vec(),
        knots: None,
        refine: Vec::new(),
    };
    let reduction = ReductionSpec::Modal { modes: 20 };
    ElasticBody::build("bar", ElasticSpec::new(shape, model, aluminium(), discretisation, reduction)).unwrap()
}

fn solid_bar(elements: [usize; 3]) -> ElasticBody {
    built(solid::cuboid(SIZE).unwrap(), Model::Solid, &[3, 2, 2], &elements)
}

/// The bar as a plane-stress strip that bends in its plane.
fn strip() -> ElasticBody {
    let shape = plane::rectangle(SIZE[0], SIZE[2]).unwrap();
    built(shape, Model::PlaneStress { thickness: SIZE[1] }, &[2, 2], &[10, 2])
}

/// The marker that follows the mean motion of an end face, by quadrature over it.
fn end_face(body: &ElasticBody, upper: bool) -> MarkerWeights {
    let motion = body.assembled.motion;
    let patches = &body.shape.patches;
    let face = Face::new(patches, FaceId { patch: 0, direction: 0, upper }, false);
    let points = gauss_points(&body.space, patches, &[face], None);
    let area: f64 = points.iter().map(|p| p.area).sum();
    let centre = points.iter().map(|p| Vector3::from(p.point) * p.area).sum::<Vector3<f64>>() / area;
    let mut moment = Matrix3::zeros();
    for p in &points {
        let r = Vector3::from(p.point) - centre;
        moment += (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * p.area;
    }
    if motion == RigidMotion::Planar {
        moment = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, moment[(2, 2)]));
    }
    let inverse = moment.try_inverse().unwrap();
    let mut weights = std::collections::BTreeMap::<u32, [f64; 6]>::new();
    for p in &points {
        let r = Vector3::from(p.point) - centre;
        for (function, value) in body.space.functions_at(p.element, &p.xi) {
            for c in 0..motion.n_components() {
                let unknown = body.lookup.number(function, c).unwrap() as u32;
                let direction = Vector3::ith(c, value * p.area);
                let turn = inverse * r.cross(&direction);
                let entry = weights.entry(unknown).or_default();
                for k in 0..3 {
                    entry[k] += direction[k] / area;
                    entry[3 + k] += turn[k];
                }
            }
        }
    }
    MarkerWeights::new(centre, UnitQuaternion::identity(), weights.into_iter().collect()).unwrap()
}

/// The `n` lowest modes of `body` with all static answers to `marker`, or none.
fn basis(body: &ElasticBody, marker: &MarkerWeights, n: usize, has_answers: bool) -> ReducedBasis {
    let problem = ElasticProblem::free(&body.assembled, &[]).unwrap();
    let modes = problem.lowest_modes(n).unwrap();
    let basis = ReducedBasis::from_modes(modes, problem.rigid().unwrap().clone());
    if !has_answers {
        return basis;
    }
    let loads = marker.forces(body.assembled.motion, body.n_unknowns()).unwrap();
    with_static_answers(&problem, basis, loads.as_ref(), TakenLoads::ByRank).unwrap()
}

/// Lowest frequency with the end face held \[Hz\].
fn clamped_frequency(elements: [usize; 3], n: usize, has_answers: bool) -> f64 {
    let body = solid_bar(elements);
    let marker = end_face(&body, false);
    let basis = basis(&body, &marker, n, has_answers);
    let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
    let data = StandardInputData::new(&body.assembled, basis.shapes.as_ref(), &stiffness).unwrap();
    let held = marker.marker("clamp", basis.shapes.as_ref()).unwrap();
    let data = data.in_tangent_frame(&held.tangent_frame(body.assembled.motion)).unwrap();
    // Ω⁻¹ M Ω⁻¹ x = ω⁻² x: the largest eigenvalue, by powers.
    let n = basis.n_modes();
    let mass = data.modal_mass.to_matrix(n);
    let scaled = faer::Mat::from_fn(n, n, |i, j| mass[(i, j)] / (basis.omega[i] * basis.omega[j]));
    let (values, _) = ffr_dynamics::reduction::blocks::dense::symmetric_eigen(scaled.as_ref()).unwrap();
    1.0 / (values[n - 1].sqrt() * TAU)
}

#[test]
fn cantilever_held_by_its_face_has_the_frequency_of_the_beam() {
    let default = clamped_frequency([20, 3, 2], 20, true);
    // Beam theory; an averaged clamp lets the section warp, as if the beam were some tenths of its height longer, and shear
    // adds as much: (h/L) of 1/30.
    let beam = 1.875_104_f64.powi(2) / TAU * (70e9_f64 / 2700.0 / 12.0).sqrt() * SIZE[2] / SIZE[0].powi(2);
    assert!((default / beam - 1.0).abs() < 0.015, "{default} {beam}");
    let doubled = clamped_frequency([20, 3, 2], 40, true);
    assert!((doubled / default - 1.0).abs() < 1e-3, "{default} {doubled}");
    let finer = clamped_frequency([60, 6, 4], 20, true);
    assert!((finer / default - 1.0).abs() < 1e-3, "{default} {finer}");
    // Twenty free modes alone hold the bar too stiffly.
    let without = clamped_frequency([20, 3, 2], 20, false);
    assert!(without / default - 1.0 > 5e-3, "{default} {without}");
}

/// The strip from a file with its foot on a joint.
fn on_joint(
    kind: JointKind,
    motion: Option<TimeCurve>,
    reduction: ReductionSpec,
    static_answers: bool,
    frame: Option<&str>,
) -> RunSpec {
    let body = strip();
    let markers =
        vec![("foot".to_owned(), end_face(&body, false)), ("tip".to_owned(), end_face(&body, true))];
    let full = Arc::new(FullBody::new(body.assembled, markers).unwrap());
    let frame = frame.map_or(FrameSpec::Buckens, |marker| FrameSpec::Tangent(Place::Marker(marker.into())));
    let flexible = FlexibleSpec { static_answers, frame, ..FlexibleSpec::new(reduction) };
    let imported = ImportedSpec::Full { body: full, flexible: Box::new(flexible) };
    let at = |body, place| Attachment { body, place, rotation: UnitQuaternion::identity() };
    let coordinates =
        motion.into_iter().map(|m| CoordinateSpec { motion: Some(m), ..CoordinateSpec::default() });
    let joint = JointSpec {
        name: "foot".into(),
        kind,
        parent: at(None, Place::Point([-0.5 * SIZE[0], 0.0, 0.0])),
        child: at(Some(0), Place::Marker("foot".into())),
        positions: vec![0.0; kind.n_positions()],
        velocities: vec![0.0; kind.n_velocities()],
        has_velocities: true,
        coordinates: coordinates.collect(),
        bearing: None,
    };
    let rest = InitialMotion {
        position: Vector3::zeros(),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::zeros(),
        angular_velocity: Vector3::zeros(),
    };
    let body = BodySpec { name: "bar".into(), kind: BodyKind::Imported(imported), motion: rest };
    let mut spec = impacts::spec(vec![body], Vec::new(), 0.04);
    spec.joints.push(joint);
    let (place, gauge) = (Place::Marker("tip".into()), GaugeRequest::default());
    spec.points.push(PointSpec { name: "tip".into(), body: 0, place, gauge });
    spec.settings.free.method = Some(Method::Esdirk4);
    spec.settings.free_interval = Some(5e-4);
    spec
}

/// Deflections of the tip against the line of the foot, which turns by `angle`, at the stored instants.
fn deflections(spec: &RunSpec, angle: impl Fn(f64) -> f64) -> Vec<f64> {
    let trace = finished(spec);
    let deflection = |sample: &adaptive::record::Sample| {
        let p = sample.points[0].position;
        let (x, y) = (p[0] + 0.5 * SIZE[0], p[1]);
        let (sin, cos) = angle(sample.time).sin_cos();
        cos * y - sin * x
    };
    trace.samples.iter().map(deflection).collect()
}

/// Largest distance of `a` from `b` over the largest of `b`.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, x| m.max(x.abs()));
    largest(&mut a.iter().zip(b).map(|(a, b)| a - b)) / largest(&mut b.iter().copied())
}

#[test]
fn prescribed_hinge_bends_the_bar_as_the_full_model() {
    const RATE: f64 = 20.0;
    let motion = || Some(TimeCurve::Polynomial { coefficients: vec![0.0, 0.0, 0.5 * RATE] });
    let angle = |t: f64| 0.5 * RATE * t * t;
    let run = |reduction, answers, frame| {
        deflections(&on_joint(JointKind::Revolute, motion(), reduction, answers, frame), angle)
    };
    let full = run(ReductionSpec::All, true, Some("foot"));
    let few = ReductionSpec::Modal { modes: 6 };
    for frame in [None, Some("foot")] {
        let (with, without) = (run(few, true, frame), run(few, false, frame));
        let (with, without) = (distance(&with, &full), distance(&without, &full));
        assert!(with < 0.01 && without > 0.02, "{frame:?}: {with} {without}");
    }
}

#[test]
fn clamped_bar_sags_as_the_full_model() {
    let sag = |reduction, answers, frame| {
        let mut spec = on_joint(JointKind::Fixed, None, reduction, answers, frame);
        spec.settings.gravity = Vector3::new(0.0, -9.81, 0.0);
        spec.settings.start = adaptive::spec::Start::Elastic;
        spec.settings.end_time = 1e-5;
        deflections(&spec, |_| 0.0)[0]
    };
    let full = sag(ReductionSpec::All, true, Some("foot"));
    // Uniform load: ρ g A L⁴ / 8 EI; shear and the soft clamp as in the frequency.
    let beam = 2700.0 * 9.81 * SIZE[0].powi(4) * 12.0 / (8.0 * 70e9 * SIZE[2].powi(2));
    assert!((full / -beam - 1.0).abs() < 0.02, "{full:e} {beam:e}");
    for frame in [None, Some("foot")] {
        let with = sag(ReductionSpec::Modal { modes: 3 }, true, frame);
        // Second-order terms of the equilibrium, deflection over length: 46 µm of 0.3 m, squared.
        assert!((with / full - 1.0).abs() < 1e-6, "{frame:?}: {with:e} {full:e}");
    }
}

#[test]
fn coordinates_are_counted_by_what_they_answer() {
    let few = ReductionSpec::Modal { modes: 6 };
    let motion = TimeCurve::Polynomial { coefficients: vec![0.0] };
    let count = |spec: &RunSpec| RunModel::build(spec).unwrap().bodies[0].coordinates();
    let driven = count(&on_joint(JointKind::Revolute, Some(motion), few, true, None));
    assert_eq!((driven.free, driven.interface), (6, 0));
    assert_eq!(driven.answers, [("foot (child)".to_owned(), 3)]);
    // A free hinge exerts no moment in the plane.
    let free = count(&on_joint(JointKind::Revolute, None, few, true, None));
    assert_eq!(free.answers, [("foot (child)".to_owned(), 2)]);
    // A second joint on the same face brings nothing.
    let mut twice = on_joint(JointKind::Fixed, None, few, true, None);
    twice.loops.push(JointSpec { name: "again".into(), ..twice.joints[0].clone() });
    let loads = MarkerLoads::on_body(&twice, 0);
    assert_eq!(loads.len(), 2);
    let twice = count(&twice);
    assert_eq!(twice.answers.iter().map(|(_, n)| n).sum::<usize>(), 3);
    let without = count(&on_joint(JointKind::Fixed, None, few, false, None));
    assert_eq!((without.free, without.answers.len()), (6, 0));
    let all = count(&on_joint(JointKind::Fixed, None, ReductionSpec::All, true, None));
    assert!(all.answers.is_empty() && all.free > 80);
}

#[test]
fn fine_meshes_with_many_points_on_a_face_are_reduced() {
    // Constraint modes of every unknown of the face, 5 x 4 x 3 of them, were refused by an absolute test.
    let body = solid_bar([30, 5, 4]);
    let loads = MarkerLoads::on_body(&on_joint(JointKind::Fixed, None, ReductionSpec::All, true, None), 0);
    let place = Place::Point([-0.5 * SIZE[0], 0.0, 0.0]);
    let loads: Vec<_> = loads.into_iter().map(|l| MarkerLoads { place: place.clone(), ..l }).collect();
    let loads = loads.into();
    let reduced = body.reduce(&Interface { loads, ..Interface::default() }).unwrap();
    assert_eq!(reduced.basis.n_modes(), 26);
}
