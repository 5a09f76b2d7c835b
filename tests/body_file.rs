//! Body files: round trips bit by bit, a beam written by hand, faults that name file and dataset.

use adaptive::body::field::Field;
use adaptive::body::field_body::FieldBody;
use std::path::PathBuf;

use crate::beam_file::{BENDING, LENGTH, LINE_MASS, write_beam};
use crate::oracles::modal_truncation;
use adaptive::body::reduced::Interface;
use adaptive::body::reduced::geometric_stiffening;
use adaptive::body::splines::ElasticBody;
use adaptive::spec::{DampingSpec, DiscretisationSpec, ElasticSpec, Place, ReductionSpec};
use fbimpact::interchange::body_file::{BodyFile, read, write_full, write_reduced};
use ffr_dynamics::body::{ModalDamping, RigidMotion};
use ffr_dynamics::interchange::{BodyFrame, FullBody, ReducedModel, ReducedParts};
use hdf5::types::VarLenUnicode;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{axisymmetric, plane, solid};
use nalgebra::{UnitQuaternion, Vector3};
use ndarray::{Array2, arr1};

/// A directory of its own for each test, removed at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("fbimpact-body-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn body(shape: Shape, model: Model) -> ElasticBody {
    let n = model.dimension();
    let material = Material::new(72.8e9, 0.33, 2789.0).unwrap();
    let discretisation =
        DiscretisationSpec { degrees: vec![2; n], elements: vec![2; n], knots: None, refine: Vec::new() };
    let mut spec =
        ElasticSpec::new(shape, model, material, discretisation, ReductionSpec::Modal { modes: 5 });
    spec.flexible.damping = DampingSpec::Rayleigh { frequencies: [1e3, 1e4], ratio: 0.01 };
    ElasticBody::build("sample", spec).unwrap()
}

fn samples() -> [ElasticBody; 3] {
    [
        body(plane::rectangle(0.3, 0.1).unwrap(), Model::PlaneStress { thickness: 0.02 }),
        body(solid::cuboid([0.3, 0.1, 0.05]).unwrap(), Model::Solid),
        body(axisymmetric::rod(0.02, 0.3).unwrap(), Model::Axisymmetric),
    ]
}

/// A reduced body: of plane and solid ones in the frame of a turned marker at the left end, with stiffening.
fn reduced(body: &ElasticBody) -> ReducedModel {
    let basis = body.reduce(&Interface::default()).unwrap();
    let shapes = basis.basis.shapes.as_ref();
    let is_axial = body.assembled.motion == RigidMotion::Axial;
    let place = if is_axial { [0.0; 3] } else { [-0.15, 0.0, 0.0] };
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.3);
    let hub = body.marker_weights(&Place::Point(place), turn).unwrap();
    let marker = hub.marker("hub", shapes).unwrap();
    let frequencies = basis.basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect();
    let (mut data, mut markers, mut frame) = (basis.data, vec![marker.clone()], BodyFrame::Buckens);
    let mut tip_shapes = shapes.to_owned();
    if !is_axial {
        let tangent = marker.tangent_frame(data.motion);
        tip_shapes = tangent.shifted_shapes(&body.assembled, shapes).unwrap();
        let given = geometric_stiffening(body, &body.assembled, tip_shapes.as_ref(), &hub).unwrap();
        data = data.in_tangent_frame(&tangent).unwrap().with_geometric_stiffening(&given).unwrap();
        markers = vec![marker.in_tangent_frame(&tangent).unwrap()];
        frame = BodyFrame::Tangent { marker: "hub".into() };
    }
    let tip = body.flexible_point(&Place::Point([0.0, 0.02, 0.0]), tip_shapes.as_ref()).unwrap();
    ReducedModel::new(ReducedParts {
        name: "sample".into(),
        frame,
        data: data.to_parts(),
        frequencies,
        markers,
        points: vec![("tip".into(), tip)],
    })
    .unwrap()
}

#[test]
fn reduced_bodies_come_back_bit_by_bit() {
    let scratch = Scratch::new("reduced");
    for (i, body) in samples().iter().enumerate() {
        let mut model = reduced(body);
        if i == 1 {
            let mut parts = model.to_parts();
            let ModalDamping::PerMode(d) = &parts.data.modal_damping else { panic!("Rayleigh") };
            parts.data.modal_damping =
                ModalDamping::Full(faer::Mat::from_fn(5, 5, |i, j| if i == j { d[i] } else { 0.1 }));
            model = ReducedModel::new(parts).unwrap();
        }
        let path = scratch.file("body.h5");
        write_reduced(&path, &model).unwrap();
        let BodyFile::Reduced(again) = read(&path).unwrap() else { panic!("a reduced body was written") };
        // Debug prints shortest numbers that tell all bits apart, signs of zero included.
        assert_eq!(format!("{model:?}"), format!("{again:?}"));
        assert_eq!(model.data().geometric_stiffening().is_some(), i != 2);
    }
}

#[test]
fn full_bodies_come_back_bit_by_bit() {
    let scratch = Scratch::new("full");
    for body in samples() {
        let place = if body.assembled.motion == RigidMotion::Axial { [0.0; 3] } else { [-0.15, 0.0, 0.0] };
        let hub = body
            .marker_weights(&Place::Point(place), UnitQuaternion::from_scaled_axis(Vector3::z() * 0.3))
            .unwrap();
        let full = FullBody::new(body.assembled.clone(), vec![("hub".into(), hub)]).unwrap();
        let path = scratch.file("body.h5");
        write_full(&path, &full).unwrap();
        let BodyFile::Full(again) = read(&path).unwrap() else { panic!("a full body was written") };
        let matrices = |b: &FullBody| {
            let b = b.body();
            let (ffr_dynamics::body::MassMatrix::PerComponent(m)
            | ffr_dynamics::body::MassMatrix::General(m)) = &b.mass;
            format!("{:?} {:?} {:?} {:?}", b.stiffness.val(), b.stiffness.row_idx(), m.val(), m.row_idx())
        };
        assert_eq!(matrices(&full), matrices(&again));
        let rest = |b: &FullBody| {
            let body = b.body();
            format!(
                "{} {:?} {:?} {:?} {:?} {:?}",
                body.name,
                body.motion,
                body.dofs,
                body.nodes,
                body.anchors,
                b.markers()
            )
        };
        assert_eq!(rest(&full), rest(&again));
    }
}

#[test]
fn beam_of_another_program_has_the_frequencies_of_a_beam() {
    let scratch = Scratch::new("beam");
    let path = scratch.file("beam.h5");
    write_beam(&path);
    let BodyFile::Full(beam) = read(&path).unwrap() else { panic!("a full body was written") };
    assert_eq!(beam.body().name, "beam");
    let basis = modal_truncation(beam.body(), 3).unwrap();
    // Free-free beam: (βL)² sqrt(EI/ρA)/L² with βL = 4.7300, 7.8532, 10.9956 (Blevins 1979, table 8-1).
    for (found, root) in
        basis.omega.iter().zip([4.730_040_744_862_704, 7.853_204_624_095_838, 10.995_607_838_001_671])
    {
        let expected = (root / LENGTH).powi(2) * (BENDING / LINE_MASS).sqrt();
        // Cubic elements: (βh)⁴/720 of the squared frequency, 1e-4 for the third one.
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    }
    let tip = beam.markers()[1].1.marker("tip", basis.shapes.as_ref()).unwrap();
    // The tip of a free-free mode of unit modal mass moves by 2/sqrt(m) and turns by the slope.
    let expected = 2.0 / (LINE_MASS * LENGTH).sqrt();
    assert!((tip.displacement_row(1)[0].abs() / expected - 1.0).abs() < 1e-3);
    let ratio = tip.rotation_row(2)[0] / tip.displacement_row(1)[0] * LENGTH;
    assert!((ratio.abs() - 4.730_04 * 0.982_502).abs() < 1e-3, "{ratio}");
}

/// The message for the beam's file after a change.
fn message(scratch: &Scratch, change: impl Fn(&hdf5::File)) -> String {
    let path = scratch.file("beam.h5");
    write_beam(&path);
    let file = hdf5::File::open_rw(&path).unwrap();
    change(&file);
    file.close().unwrap();
    let text = read(&path).unwrap_err().to_string();
    assert!(text.contains("beam.h5: "), "{text}");
    text
}

#[test]
fn faults_name_the_file_and_the_dataset() {
    let scratch = Scratch::new("faults");
    let text = scratch.file("text.h5");
    std::fs::write(&text, "no HDF5").unwrap();
    assert!(read(&text).unwrap_err().to_string().contains("text.h5: cannot be opened as an HDF5 file"));
    assert!(read(&scratch.file("none.h5")).unwrap_err().to_string().contains("No such file"));

    let found = message(&scratch, |f| f.unlink("nodes").unwrap());
    assert!(found.contains("dataset /nodes is missing, expected shape [n_nodes, 3]"), "{found}");
    let found = message(&scratch, |f| {
        f.unlink("nodes").unwrap();
        f.new_dataset_builder().with_data(&Array2::<f64>::zeros((21, 2))).create("nodes").unwrap();
    });
    assert!(found.contains("dataset /nodes has the shape [21, 2], expected [n_nodes, 3]"), "{found}");
    let found = message(&scratch, |f| {
        let rows = f.dataset("stiffness/rows").unwrap().read_raw::<f64>().unwrap();
        f.unlink("stiffness/rows").unwrap();
        f.group("stiffness").unwrap().new_dataset_builder().with_data(&arr1(&rows)).create("rows").unwrap();
    });
    assert!(found.contains("dataset /stiffness/rows holds float64, expected integers"), "{found}");
    let replaced = |at: usize, value: f64| {
        message(&scratch, |f| {
            let dataset = f.dataset("mass/values").unwrap();
            let mut values = dataset.read_1d::<f64>().unwrap();
            values[at] = value;
            dataset.write(&values).unwrap();
        })
    };
    let found = replaced(3, f64::NAN);
    assert!(found.contains("dataset /mass/values holds NaN at position [3]"), "{found}");
    let found = replaced(1, 100.0);
    assert!(found.contains("/mass: ") && found.contains("M is not symmetric"), "{found}");
    let found = message(&scratch, |f| {
        f.attr("model").unwrap().write_scalar(&"shell".parse::<VarLenUnicode>().unwrap()).unwrap()
    });
    assert!(
        found.contains(
            "attribute model of / is \"shell\", expected \"axisymmetric\" or \"plane\" or \"solid\""
        ),
        "{found}"
    );
    let found = message(&scratch, |f| f.attr("format_version").unwrap().write_scalar(&9i64).unwrap());
    assert!(found.contains("format_version of / is 9"), "{found}");
    let found = message(&scratch, |f| {
        let dataset = f.dataset("markers/tip/position").unwrap();
        dataset.write(&arr1(&[f64::INFINITY, 0.0, 0.0])).unwrap();
    });
    assert!(found.contains("/markers/tip/position holds inf"), "{found}");
    let found =
        message(&scratch, |f| f.dataset("dofs").unwrap().write(&Array2::<i64>::zeros((63, 2))).unwrap());
    assert!(found.contains("/dofs: ") && found.contains("named twice"), "{found}");
}
