//! Layout of an unreduced body.

use faer::sparse::SparseColMat;
use ffr_dynamics::body::{
    AssembledBody, Dof, MassMatrix, RigidMotion, Triangle, sorted_unknowns, symmetric_matrix,
};
use ffr_dynamics::interchange::FullBody;
use ffr_dynamics::kinematics::MarkerWeights;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::dataset::Extent::{Any, Exactly};
use super::dataset::Node;
use super::fault::BodyFault;

/// Deviation of a quaternion's length from one that a file may have.
const UNIT_LENGTH: f64 = 1e-9;

/// Reads a body whose rigid motions are known.
pub fn read(root: &Node, name: String, motion: RigidMotion) -> Result<FullBody, BodyFault> {
    let (nodes, _) = root.reals("nodes", &[Any("n_nodes"), Exactly(3)])?;
    let nodes: Vec<[f64; 3]> = nodes.as_chunks::<3>().0.to_vec();
    let n_dof = motion.n_components() + motion.n_rotations();
    let largest = nodes.len().saturating_sub(1).max(n_dof);
    let listed = root.indices("dofs", &[Any("n"), Exactly(2)], largest)?;
    let listed: Vec<Dof> = listed
        .as_chunks::<2>()
        .0
        .iter()
        .map(|d| Dof { node: d[0], component: d[1].min(255) as u8 })
        .collect();
    let (dofs, numbers) =
        sorted_unknowns(&listed).map_err(|e| BodyFault::Data { at: "/dofs".into(), source: e })?;
    let anchors = match root.find_reals("anchors", &[Exactly(nodes.len()), Exactly(3)])? {
        Some((anchors, _)) => anchors.as_chunks::<3>().0.to_vec(),
        None => nodes.clone(),
    };
    let stiffness = root.group("stiffness", "the stiffness matrix")?;
    let mass = root.group("mass", "the mass matrix")?;
    let identity: Vec<u32> = (0..nodes.len() as u32).collect();
    let body = AssembledBody {
        name,
        motion,
        stiffness: matrix(&stiffness, "K", &numbers)?,
        mass: match mass.choice("rows_are", &["unknowns", "nodes"])? {
            0 => MassMatrix::General(matrix(&mass, "M", &numbers)?),
            _ => MassMatrix::PerComponent(matrix(&mass, "M", &identity)?),
        },
        dofs,
        nodes,
        anchors,
    };
    let mut markers = Vec::new();
    if let Some(all) = root.find("markers")? {
        for (name, node) in all.groups()? {
            markers.push((name, marker(&node, &body, &numbers)?));
        }
    }
    let mut points = Vec::new();
    if let Some(all) = root.find("points")? {
        for (name, node) in all.groups()? {
            points.push((name, point(&node, &numbers)?));
        }
    }
    FullBody::new(body, markers).and_then(|full| full.with_points(points)).map_err(|e| root.fault(e))
}

/// A point for output; its rotations are zero.
fn point(node: &Node, numbers: &[u32]) -> Result<MarkerWeights, BodyFault> {
    let (x, _) = node.reals("position", &[Exactly(3)])?;
    let unknowns = node.indices("unknowns", &[Any("n")], numbers.len().saturating_sub(1))?;
    let (weights, _) = node.reals("weights", &[Exactly(unknowns.len()), Exactly(3)])?;
    let weights = unknowns.iter().zip(weights.as_chunks::<3>().0);
    let mut entries: Vec<(u32, [f64; 6])> =
        weights.map(|(unknown, &[a, b, c])| (numbers[*unknown as usize], [a, b, c, 0.0, 0.0, 0.0])).collect();
    entries.sort_by_key(|(unknown, _)| *unknown);
    let position = Vector3::from_column_slice(&x);
    MarkerWeights::new(position, UnitQuaternion::identity(), entries).map_err(|e| node.fault(e))
}

/// A symmetric matrix; row `k` of the file has the number `numbers[k]`.
fn matrix(node: &Node, name: &str, numbers: &[u32]) -> Result<SparseColMat<u32, f64>, BodyFault> {
    let n = numbers.len();
    let triangle = [Triangle::Lower, Triangle::Full][node.choice("triangle", &["lower", "full"])?];
    let last = n.saturating_sub(1);
    let (values, shape) = node.reals("values", &[Any("n_entries")])?;
    let rows = node.indices("rows", &[Exactly(shape[0])], last)?;
    let columns = match node.choice("layout", &["coo", "csc"])? {
        0 => node.indices("columns", &[Exactly(shape[0])], last)?,
        _ => {
            let starts = node.indices("column_starts", &[Exactly(n + 1)], values.len())?;
            let is_sound = starts.is_sorted() && starts[0] == 0 && starts[n] as usize == values.len();
            if !is_sound {
                return Err(BodyFault::Shape {
                    path: node.child("column_starts"),
                    expected: format!("numbers that rise from 0 to {}", values.len()),
                    found: vec![starts.len()],
                });
            }
            (0..n as u32)
                .flat_map(|j| std::iter::repeat_n(j, (starts[j as usize + 1] - starts[j as usize]) as usize))
                .collect()
        }
    };
    let entries = rows.iter().zip(&columns).zip(&values).map(|((i, j), value)| {
        let (i, j) = (numbers[*i as usize], numbers[*j as usize]);
        // Renumbering may move an entry of a lower triangle above the diagonal.
        if triangle == Triangle::Lower { (i.max(j), i.min(j), *value) } else { (i, j, *value) }
    });
    if triangle == Triangle::Lower
        && let Some(k) = (0..rows.len()).find(|k| rows[*k] < columns[*k])
    {
        let last = i64::from(columns[k]) - 1;
        return Err(BodyFault::index(node.child("rows"), k, i64::from(rows[k]), last));
    }
    symmetric_matrix(name, n, entries, triangle).map_err(|e| node.fault(e))
}

fn marker(node: &Node, body: &AssembledBody, numbers: &[u32]) -> Result<MarkerWeights, BodyFault> {
    let (position, rotation) = pose(node)?;
    let is_set = node.group.link_exists("nodes");
    let marker = if is_set {
        let nodes = node.indices("nodes", &[Any("n")], body.nodes.len().saturating_sub(1))?;
        MarkerWeights::of_nodes(body, position, rotation, &nodes)
    } else {
        let unknowns = node.indices("unknowns", &[Any("n")], numbers.len().saturating_sub(1))?;
        let (weights, _) = node.reals("weights", &[Exactly(unknowns.len()), Exactly(6)])?;
        let mut entries: Vec<(u32, [f64; 6])> = unknowns
            .iter()
            .zip(weights.as_chunks::<6>().0)
            .map(|(unknown, w)| (numbers[*unknown as usize], *w))
            .collect();
        entries.sort_by_key(|(unknown, _)| *unknown);
        MarkerWeights::new(position, rotation, entries)
    };
    marker.map_err(|e| node.fault(e))
}

/// Position and rotation of a marker; without a rotation its axes are those of the body.
pub fn pose(node: &Node) -> Result<(Vector3<f64>, UnitQuaternion<f64>), BodyFault> {
    let (x, _) = node.reals("position", &[Exactly(3)])?;
    let position = Vector3::from_column_slice(&x);
    let Some((q, _)) = node.find_reals("rotation", &[Exactly(4)])? else {
        return Ok((position, UnitQuaternion::identity()));
    };
    let quaternion = Quaternion::new(q[0], q[1], q[2], q[3]);
    if (quaternion.norm() - 1.0).abs() > UNIT_LENGTH {
        return Err(BodyFault::Attribute {
            at: node.child("rotation"),
            name: "length".into(),
            expected: "1 (w, x, y, z of a unit quaternion)".into(),
            found: quaternion.norm().to_string(),
        });
    }
    // Not normalised again, so that a body comes back bit by bit.
    Ok((position, UnitQuaternion::new_unchecked(quaternion)))
}

/// Writes position and rotation of a marker.
pub fn write_pose(node: &Node, x: &Vector3<f64>, rotation: &UnitQuaternion<f64>) -> Result<(), BodyFault> {
    node.write("position", &[3], x.as_slice().to_vec(), "m", "undeformed position in the body's frame")?;
    let q = vec![rotation.w, rotation.i, rotation.j, rotation.k];
    node.write("rotation", &[4], q, "1", "unit quaternion w x y z from the marker's axes to the body's")
}

/// Writes a body.
pub fn write(root: &Node, full: &FullBody) -> Result<(), BodyFault> {
    let body = full.body();
    let points = |p: &[[f64; 3]]| p.iter().flatten().copied().collect::<Vec<f64>>();
    root.write("nodes", &[body.nodes.len(), 3], points(&body.nodes), "m", "node positions")?;
    root.write(
        "anchors",
        &[body.nodes.len(), 3],
        points(&body.anchors),
        "m",
        "places that guide the elimination order",
    )?;
    let dofs: Vec<u32> = body.dofs.iter().flat_map(|d| [d.node, u32::from(d.component)]).collect();
    root.write("dofs", &[body.dofs.len(), 2], dofs, "1", "node and component of every unknown")?;
    write_matrix(&root.create("stiffness")?, &body.stiffness, "N/m", "stiffness matrix")?;
    let mass = root.create("mass")?;
    match &body.mass {
        MassMatrix::General(m) => {
            mass.text("rows_are", "unknowns")?;
            write_matrix(&mass, m, "kg", "mass matrix")?;
        }
        MassMatrix::PerComponent(m) => {
            mass.text("rows_are", "nodes")?;
            write_matrix(&mass, m, "kg", "mass matrix of each displacement component")?;
        }
    }
    let markers = root.create("markers")?;
    for (name, marker) in full.markers() {
        let node = markers.create(name)?;
        write_pose(&node, &marker.position(), &marker.rotation())?;
        let unknowns: Vec<u32> = marker.entries().iter().map(|e| e.0).collect();
        let n = unknowns.len();
        let weights = marker.entries().iter().flat_map(|e| e.1).collect::<Vec<f64>>();
        node.write("unknowns", &[n], unknowns, "1", "unknowns that move the marker")?;
        node.write("weights", &[n, 6], weights, "1", "displacement and rotation by a unit of each unknown")?;
    }
    let points = root.create("points")?;
    for (name, point) in full.points() {
        let node = points.create(name)?;
        node.write("position", &[3], point.position().as_slice().to_vec(), "m", "undeformed position")?;
        let unknowns: Vec<u32> = point.entries().iter().map(|e| e.0).collect();
        let n = unknowns.len();
        let weights = point.entries().iter().flat_map(|e| [e.1[0], e.1[1], e.1[2]]).collect::<Vec<f64>>();
        node.write("unknowns", &[n], unknowns, "1", "unknowns that move the point")?;
        node.write("weights", &[n, 3], weights, "1", "displacement by a unit of each unknown")?;
    }
    Ok(())
}

fn write_matrix(node: &Node, m: &SparseColMat<u32, f64>, unit: &str, what: &str) -> Result<(), BodyFault> {
    node.text("triangle", "lower")?;
    node.text("layout", "csc")?;
    let starts = m.symbolic().col_ptr().to_vec();
    node.write(
        "column_starts",
        &[starts.len()],
        starts,
        "1",
        "first entry of each column, then their number",
    )?;
    node.write("rows", &[m.row_idx().len()], m.row_idx().to_vec(), "1", "row of each entry")?;
    node.write("values", &[m.val().len()], m.val().to_vec(), unit, what)
}
