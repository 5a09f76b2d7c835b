//! Layout of a reduced body.

use faer::Mat;
use ffr_dynamics::body::{DataParts, GeometricStiffening, ModalDamping, RigidMotion};
use ffr_dynamics::interchange::{BodyFrame, ReducedModel, ReducedParts};
use ffr_dynamics::kinematics::{FlexiblePoint, Marker};
use nalgebra::{Matrix3, Vector3};

use super::dataset::Extent::{Any, Exactly};
use super::dataset::{Extent, Node};
use super::fault::BodyFault;
use super::full::{pose, write_pose};

/// Reads a body whose rigid motions are known.
pub fn read(root: &Node, name: String, motion: RigidMotion) -> Result<ReducedModel, BodyFault> {
    let (modal_stiffness, _) = root.reals("modal_stiffness", &[Any("n_q")])?;
    let n = modal_stiffness.len();
    let (frequencies, _) = root.reals("eigenfrequencies", &[Exactly(n)])?;
    let frame = match root.choice("frame", &["buckens", "tangent", "other"])? {
        0 => BodyFrame::Buckens,
        1 => BodyFrame::Tangent { marker: root.find_text("frame_marker")?.unwrap_or_default() },
        _ => BodyFrame::Other,
    };
    let mut parts = ReducedParts {
        name,
        frame,
        data: data(root, motion, modal_stiffness)?,
        frequencies,
        markers: Vec::new(),
        points: Vec::new(),
    };
    if let Some(markers) = root.find("markers")? {
        for (name, node) in markers.groups()? {
            let (position, rotation) = pose(&node)?;
            parts.markers.push(if node.group.link_exists("displacements") {
                let (u, turns) = (node.vectors("displacements", n)?, node.vectors("rotations", n)?);
                Marker::flexible(&name, position, rotation, &u, &turns).map_err(|e| node.fault(e))?
            } else {
                Marker::rigid(&name, position, rotation)
            });
        }
    }
    if let Some(points) = root.find("points")? {
        for (name, node) in points.groups()? {
            let (x, _) = node.reals("position", &[Exactly(3)])?;
            let shapes = node.vectors("displacements", n)?;
            parts.points.push((name, FlexiblePoint { position: Vector3::from_column_slice(&x), shapes }));
        }
    }
    ReducedModel::new(parts).map_err(|e| root.fault(e))
}

fn data(root: &Node, motion: RigidMotion, modal_stiffness: Vec<f64>) -> Result<DataParts, BodyFault> {
    let (n, n_c) = (modal_stiffness.len(), motion.n_components());
    let square = [Exactly(n), Exactly(n)];
    let (first, _) = root.reals("mass_moment", &[Exactly(3)])?;
    let (second, _) = root.reals("second_moment", &[Exactly(3), Exactly(3)])?;
    let components = [Exactly(n_c), Exactly(n_c), Exactly(n)];
    let (mut position_shape, mut shape_shape) = (Vec::new(), Vec::new());
    if motion != RigidMotion::Axial {
        position_shape = root.reals("position_shape", &components)?.0;
        let shape: Vec<Extent> = [Exactly(n)].into_iter().chain(components).collect();
        shape_shape = root.reals("shape_shape", &shape)?.0;
    }
    let is_matrix = root.group.dataset("damping").is_ok_and(|d| d.ndim() == 2);
    let modal_damping = if is_matrix {
        root.find_reals("damping", &square)?
            .map_or(ModalDamping::None, |(d, _)| ModalDamping::Full(matrix(n, &d)))
    } else {
        root.find_reals("damping", &[Exactly(n)])?
            .map_or(ModalDamping::None, |(d, _)| ModalDamping::PerMode(d))
    };
    Ok(DataParts {
        motion,
        mass: root.real("mass")?,
        mass_moment: Vector3::from_column_slice(&first),
        second_moment: Matrix3::from_row_slice(&second),
        coupling_translation: root.vectors("coupling_translation", n)?,
        modal_mass: root.find_reals("modal_mass", &square)?.map(|(m, _)| matrix(n, &m)),
        modal_stiffness,
        modal_damping,
        position_shape,
        shape_shape,
        geometric_stiffening: root
            .find("geometric_stiffening")?
            .map(|g| stiffening(&g, n_c, n))
            .transpose()?,
    })
}

fn stiffening(node: &Node, n_c: usize, n: usize) -> Result<GeometricStiffening, BodyFault> {
    let (translation, _) = node.reals("translation", &[Exactly(n_c), Exactly(n), Exactly(n)])?;
    let (position, _) = node.reals("position", &[Exactly(n_c), Exactly(n_c), Exactly(n), Exactly(n)])?;
    let part = |all: &[f64], is_there: bool, at: usize| {
        if is_there { matrix(n, &all[at * n * n..(at + 1) * n * n]) } else { Mat::zeros(0, 0) }
    };
    Ok(GeometricStiffening {
        translation: std::array::from_fn(|b| part(&translation, b < n_c, b)),
        position: std::array::from_fn(|a| {
            std::array::from_fn(|b| part(&position, a.max(b) < n_c, a * n_c + b))
        }),
    })
}

fn matrix(n: usize, rows: &[f64]) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| rows[i * n + j])
}

fn by_rows(m: &Mat<f64>) -> Vec<f64> {
    (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| m[(i, j)])).collect()
}

fn flat(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

/// Writes a body.
pub fn write(root: &Node, model: &ReducedModel) -> Result<(), BodyFault> {
    let parts = model.to_parts();
    match &parts.frame {
        BodyFrame::Buckens => root.text("frame", "buckens")?,
        BodyFrame::Other => root.text("frame", "other")?,
        BodyFrame::Tangent { marker } => {
            root.text("frame", "tangent")?;
            root.text("frame_marker", marker)?;
        }
    }
    let n = parts.data.modal_stiffness.len();
    root.write(
        "eigenfrequencies",
        &[n],
        parts.frequencies.clone(),
        "Hz",
        "eigenfrequencies of the free body",
    )?;
    write_data(root, &parts.data)?;
    let markers = root.create("markers")?;
    for marker in &parts.markers {
        let node = markers.create(&marker.name)?;
        write_pose(&node, &marker.position, &marker.rotation)?;
        if marker.n_modes() > 0 {
            let vectors = |row: &dyn Fn(usize) -> Vec<f64>| {
                let rows = [row(0), row(1), row(2)];
                (0..n).flat_map(|j| [rows[0][j], rows[1][j], rows[2][j]]).collect::<Vec<f64>>()
            };
            let u = vectors(&|c| marker.displacement_row(c).to_vec());
            let turns = vectors(&|c| marker.rotation_row(c).to_vec());
            node.write("displacements", &[n, 3], u, "m", "displacement of each mode")?;
            node.write("rotations", &[n, 3], turns, "rad", "rotation of each mode")?;
        }
    }
    let points = root.create("points")?;
    for (name, point) in &parts.points {
        let node = points.create(name)?;
        node.write("position", &[3], point.position.as_slice().to_vec(), "m", "undeformed position")?;
        let shapes = if point.shapes.is_empty() { vec![Vector3::zeros(); n] } else { point.shapes.clone() };
        node.write("displacements", &[n, 3], flat(&shapes), "m", "displacement of each mode")?;
    }
    Ok(())
}

fn write_data(root: &Node, data: &DataParts) -> Result<(), BodyFault> {
    let (n, n_c) = (data.modal_stiffness.len(), data.motion.n_components());
    root.write("mass", &[], vec![data.mass], "kg", "mass")?;
    root.write(
        "mass_moment",
        &[3],
        data.mass_moment.as_slice().to_vec(),
        "kg m",
        "first moment of the mass",
    )?;
    let second = data.second_moment.transpose().as_slice().to_vec();
    root.write("second_moment", &[3, 3], second, "kg m^2", "second moment of the mass")?;
    let coupling = flat(&data.coupling_translation);
    root.write("coupling_translation", &[n, 3], coupling, "kg m", "momentum of each mode")?;
    root.write(
        "modal_stiffness",
        &[n],
        data.modal_stiffness.clone(),
        "N m",
        "diagonal of the modal stiffness",
    )?;
    if let Some(mass) = &data.modal_mass {
        root.write("modal_mass", &[n, n], by_rows(mass), "kg m^2", "modal mass")?;
    }
    match &data.modal_damping {
        ModalDamping::None => {}
        ModalDamping::PerMode(d) => {
            root.write("damping", &[n], d.clone(), "N m s", "modal damping, diagonal")?
        }
        ModalDamping::Full(d) => root.write("damping", &[n, n], by_rows(d), "N m s", "modal damping")?,
    }
    if data.motion != RigidMotion::Axial {
        let about = "integral of density, position and mode";
        root.write("position_shape", &[n_c, n_c, n], data.position_shape.clone(), "kg m^2", about)?;
        let about = "integral of density and two modes";
        root.write("shape_shape", &[n, n_c, n_c, n], data.shape_shape.clone(), "kg m^2", about)?;
    }
    let Some(given) = &data.geometric_stiffening else { return Ok(()) };
    let node = root.create("geometric_stiffening")?;
    let translation = given.translation[..n_c].iter().flat_map(by_rows).collect();
    node.write("translation", &[n_c, n, n], translation, "kg m", "for unit accelerations")?;
    let position = given.position[..n_c].iter().flat_map(|row| row[..n_c].iter().flat_map(by_rows)).collect();
    node.write("position", &[n_c, n_c, n, n], position, "kg m^2", "for loads that grow with a coordinate")
}
