//! A body from matrices, nodes and the order of unknowns, in SI units.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use faer::sparse::SparseColMat;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion, Triangle, symmetric_matrix};
use ffr_dynamics::interchange::FullBody;
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::rigid::{MassProperties, RigidModes};
use nalgebra::{UnitQuaternion, Vector3};

use super::matrix::{Matrix, Row, Unknown};
use super::nodes::NodeTable;

/// What a body is made from.
#[derive(Debug)]
pub struct Parts<'a> {
    /// Name of the body.
    pub name: &'a str,
    /// Stiffness.
    pub stiffness: &'a Matrix,
    /// Mass.
    pub mass: &'a Matrix,
    /// Nodes; those without unknowns are left out.
    pub nodes: &'a NodeTable,
    /// Unknown of each row, where rows have numbers; without it the rows are x, y and z of each
    /// node, the nodes rising.
    pub map: Option<&'a [Unknown]>,
    /// Length of the unit of length \[m\]; forces are in newtons, times in seconds, so that
    /// millimetres go with tonnes.
    pub unit: f64,
    /// Markers with the nodes that they follow.
    pub markers: &'a [(String, Vec<u64>)],
}

/// What was found of the body.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Number of nodes with unknowns.
    pub n_nodes: usize,
    /// Number of unknowns.
    pub n_unknowns: usize,
    /// Mass, centre, inertia.
    pub mass: MassProperties,
    /// Largest force against a rigid motion, over that of the stiffest entry.
    pub resistance: f64,
}

/// Why no body comes of it.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyFault {
    /// Matrices, unknowns, nodes and markers that do not go together: what is wrong, and what to
    /// change.
    #[error("{0}")]
    Parts(String),
    /// Numbers that make no body.
    #[error(transparent)]
    Numbers(#[from] DynamicsError),
}

impl AssemblyFault {
    /// A row or a number of rows of `matrix` that the `n` unknowns `source_of` some data do not
    /// have.
    fn rows(matrix: &str, what: impl Display, n: usize, source_of: &str) -> Self {
        Self::Parts(format!(
            "{matrix}: {what} {n} unknowns {source_of}; give the order of unknowns with --dof-map"
        ))
    }

    /// A node without position that `user` names.
    fn node(user: impl Display, node: u64) -> Self {
        Self::Parts(format!("{user} names node {node}, which the list of nodes does not have"))
    }

    /// What is wrong with the marker called `name`.
    fn marker(name: &str, what: impl Display) -> Self {
        Self::Parts(format!("marker \"{name}\"{what}"))
    }
}

/// Makes the body, with its checks: symmetry (1e-6), no force against rigid motions, positive mass.
///
/// # Errors
/// [`AssemblyFault`].
pub fn assemble(parts: &Parts<'_>) -> Result<(FullBody, Report), AssemblyFault> {
    let (unknowns, source_of) = unknowns(parts);
    if u32::try_from(unknowns.len()).is_err() {
        let n = unknowns.len();
        return Err(AssemblyFault::Parts(format!("{n} unknowns, at most 4294967295 are possible")));
    }
    // Sorted by node, then component, as bodies have them.
    let sorted: BTreeSet<Unknown> = unknowns.iter().copied().collect();
    let numbers: BTreeMap<Unknown, u32> = sorted.iter().zip(0..).map(|(u, i)| (*u, i)).collect();
    let nodes: BTreeSet<u64> = sorted.iter().map(|u| u.node).collect();
    let places: BTreeMap<u64, u32> = nodes.iter().zip(0..).map(|(n, i)| (*n, i)).collect();
    let position = |node: u64, user: &dyn Display| match parts.nodes.get(&node) {
        Some(x) => Ok(x.map(|c| parts.unit * c)),
        None => Err(AssemblyFault::node(user, node)),
    };
    let points: Vec<[f64; 3]> =
        nodes.iter().map(|n| position(*n, &"the order of unknowns")).collect::<Result<_, _>>()?;
    let matrix = |matrix: &Matrix, name: &'static str| {
        sparse(matrix, name, &unknowns, source_of, &numbers, parts.unit)
    };
    let body = AssembledBody {
        name: parts.name.to_owned(),
        motion: RigidMotion::Spatial,
        stiffness: matrix(parts.stiffness, "stiffness")?,
        mass: MassMatrix::General(matrix(parts.mass, "mass")?),
        dofs: sorted.iter().map(|u| Dof { node: places[&u.node], component: u.component }).collect(),
        anchors: points.clone(),
        nodes: points,
    };
    let mut markers = Vec::with_capacity(parts.markers.len());
    for (name, own) in parts.markers {
        let find = |node: &u64| match places.get(node) {
            Some(place) => Ok(*place),
            None => {
                position(*node, &format!("marker \"{name}\""))?;
                let what = format!(" names node {node}, which has no unknown in the matrices");
                Err(AssemblyFault::marker(name, what))
            }
        };
        let own: Vec<u32> = own.iter().map(find).collect::<Result<_, _>>()?;
        let sum = own.iter().map(|n| Vector3::from(body.nodes[*n as usize])).sum::<Vector3<f64>>();
        let centre = sum / own.len().max(1) as f64;
        let weights = MarkerWeights::of_nodes(&body, centre, UnitQuaternion::identity(), &own)
            .map_err(|source| AssemblyFault::marker(name, format_args!(": {source}")))?;
        markers.push((name.clone(), weights));
    }
    let rigid = RigidModes::new(&body).map_err(|source| refused(parts, &sorted, source))?;
    let report = Report {
        n_nodes: body.nodes.len(),
        n_unknowns: body.dofs.len(),
        resistance: resistance(&body, &rigid),
        mass: rigid.mass_properties,
    };
    let body = FullBody::new(body, markers).map_err(|source| refused(parts, &sorted, source))?;
    Ok((body, report))
}

/// Why numbers make no body: supports, if nodes of the list lack displacements.
fn refused(parts: &Parts<'_>, unknowns: &BTreeSet<Unknown>, source: DynamicsError) -> AssemblyFault {
    let lacks = |node: u64, component: u8| !unknowns.contains(&Unknown { node, component });
    let mut lacking = parts.nodes.keys().filter(|node| (0..3).any(|c| lacks(**node, c)));
    let Some(&node) = lacking.next() else { return source.into() };
    let axes = ["x", "y", "z"].into_iter().zip(0..).filter(|(_, c)| lacks(node, *c));
    let axes = axes.map(|(axis, _)| axis).collect::<Vec<_>>().join(", ");
    let (count, n_nodes) = (1 + lacking.count(), parts.nodes.len());
    AssemblyFault::Parts(format!(
        "{source}; {count} of {n_nodes} nodes have no displacement along {axes}, the first is node {node}: CalculiX leaves supported degrees of \
         freedom out. Write the matrices without supports (*BOUNDARY), and hold the body by joints of the scenario"
    ))
}

/// The unknowns in the order of rows, and where they are from.
fn unknowns(parts: &Parts<'_>) -> (Vec<Unknown>, &'static str) {
    if let Some(map) = parts.map {
        return (map.to_vec(), "of the map");
    }
    let named =
        [parts.stiffness, parts.mass].into_iter().flat_map(|m| &m.entries).flat_map(|(i, j, _)| [i, j]);
    let named = named.filter_map(|row| match *row {
        Row::Unknown { node, component } => Some(Unknown { node, component }),
        Row::Number(_) => None,
    });
    let named: BTreeSet<Unknown> = named.collect();
    if !named.is_empty() {
        return (named.into_iter().collect(), "of the matrices");
    }
    let all = parts.nodes.keys().flat_map(|&node| (0..3).map(move |component| Unknown { node, component }));
    (all.collect(), "of the nodes, three each")
}

/// A matrix in SI units, its lower triangle.
fn sparse(
    matrix: &Matrix,
    name: &'static str,
    unknowns: &[Unknown],
    source_of: &'static str,
    numbers: &BTreeMap<Unknown, u32>,
    unit: f64,
) -> Result<SparseColMat<u32, f64>, AssemblyFault> {
    let n = unknowns.len();
    if let Some(rows) = matrix.n_rows.filter(|rows| usize::try_from(*rows).ok() != Some(n)) {
        return Err(AssemblyFault::rows(name, format_args!("{rows} rows, and"), n, source_of));
    }
    let find = |row: &Row| match row {
        Row::Number(row) => {
            usize::try_from(row - 1).ok().and_then(|i| unknowns.get(i)).copied().ok_or_else(|| {
                AssemblyFault::rows(name, format_args!("row {row} is beyond the"), n, source_of)
            })
        }
        Row::Unknown { node, component } => Ok(Unknown { node: *node, component: *component }),
    };
    // Energies are u K u: a displacement in the file's unit is 1/unit of one in metres, forces in
    // newtons make newtons times units.
    let factor = |u: Unknown| if u.component < 3 { 1.0 / unit } else { 1.0 };
    let mut entries = Vec::with_capacity(matrix.entries.len());
    for (i, j, value) in &matrix.entries {
        let (a, b) = (find(i)?, find(j)?);
        let number = |u: Unknown| {
            let found = numbers.get(&u).copied();
            found.ok_or_else(|| AssemblyFault::node(format_args!("the {name} matrix"), u.node))
        };
        entries.push((number(a)?, number(b)?, unit * factor(a) * factor(b) * value));
    }
    // Both triangles, or one of them, whichever.
    let has_lower = entries.iter().any(|(i, j, v)| i > j && v.abs() > 0.0);
    let mut is_given: BTreeSet<(u32, u32)> = BTreeSet::new();
    let is_full = has_lower && {
        is_given.extend(entries.iter().filter(|(i, j, v)| i < j && v.abs() > 0.0).map(|(i, j, _)| (*j, *i)));
        entries.iter().any(|(i, j, v)| i > j && v.abs() > 0.0 && is_given.contains(&(*i, *j)))
    };
    let triangle = if is_full { Triangle::Full } else { Triangle::Lower };
    if !is_full {
        entries.iter_mut().for_each(|(i, j, _)| (*i, *j) = ((*i).max(*j), (*i).min(*j)));
    }
    Ok(symmetric_matrix(name, n, entries.into_iter(), triangle)?)
}

/// Largest force against a rigid motion over what the stiffest entry would make of it.
fn resistance(body: &AssembledBody, rigid: &RigidModes) -> f64 {
    let k = &body.stiffness;
    let stiffest = k.val().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut worst = 0.0_f64;
    for mode in 0..rigid.modes.ncols() {
        let r = rigid.modes.col(mode);
        let mut force = vec![0.0; body.dofs.len()];
        for j in 0..k.ncols() {
            for (i, v) in k.symbolic().row_idx_of_col(j).zip(k.val_of_col(j)) {
                force[i] += v * r[j];
                if i != j {
                    force[j] += v * r[i];
                }
            }
        }
        let largest = force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        worst = worst.max(largest / (stiffest * r.norm_max()));
    }
    worst
}
