//! From surface points with their shape functions to a body's contact submodel.
//!
//! Which points those are (Greville or Gauss), their tributary areas and whether they stand on the
//! rim of the contact zone is the surface's business; here the shapes of the modes and the
//! compliance of the interface are brought to them: `Φ(X_i) = Σ_A R_A(X_i) Φ_A` and `N_b G N_bᵀ`
//! (docs/theory.md Eq. C.2).

use faer::{Mat, MatRef};
use ffr_dynamics::body::{Dof, RigidMotion};
use ffr_dynamics::data_error::{DataError, check_square};

use crate::ContactError;
use crate::quasistatic::compliance::ZoneCompliance;
use crate::quasistatic::compliance::sparse_rows::SparseRows;
use crate::zone::submodel::ContactSubmodel;

/// Round-off allowance of a sum of shape functions, which is 1.
const UNITY_TOLERANCE: f64 = 1e-10;

/// Over what the pressure at a contact point is a mean (docs/theory.md Eqs. C.49, C.50).
#[derive(Debug, Clone, PartialEq, Default)]
pub enum PressureMean {
    /// The point's own area: points that make a quadrature rule.
    #[default]
    Area,
    /// The function whose Greville point it is.
    Function(u32),
    /// Linear functions of the corners of its side, with their numbers and values here, which sum
    /// to one: points of a rule that are more than the surface has displacements.
    Hats(Vec<(u32, f64)>),
}

/// A point of the surface that may come into contact.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePoint {
    /// Undeformed position in the model's own components, `(x, y, z)`, `(x, y, 0)` or `(r, z, 0)`
    /// \[m\].
    pub position: [f64; 3],
    /// Tributary area; axisymmetric models carry `2πr` \[m²\].
    pub area: f64,
    /// Control points and values of the functions that are not zero here.
    pub functions: Vec<(u32, f64)>,
    /// Whether the point stands on the rim of the contact zone.
    pub on_rim: bool,
    /// Over what the pressure at the point is a mean.
    pub pressure: PressureMean,
    /// Undeformed outward normal of the face that it belongs to, in the model's components, if only
    /// surfaces that this face is turned to can press it (docs/theory.md Eq. C.59): of points on
    /// the edges of a body, where several faces have one each.
    pub facing: Option<[f64; 3]>,
}

/// Number of the unknown of every displacement component of every control point.
#[derive(Debug, Clone)]
pub struct DofLookup {
    numbers: Vec<[Option<usize>; 3]>,
}

impl DofLookup {
    /// Lookup for the unknowns `dofs` of a body ([`ffr_dynamics::body::AssembledBody::dofs`]).
    pub fn new(dofs: &[Dof]) -> Self {
        let n_nodes = dofs.iter().map(|d| d.node as usize + 1).max().unwrap_or(0);
        let mut numbers = vec![[None; 3]; n_nodes];
        for (number, dof) in dofs.iter().enumerate() {
            numbers[dof.node as usize][dof.component as usize] = Some(number);
        }
        Self { numbers }
    }

    /// Number of component `component` of control point `node`, none if it is constrained.
    pub fn number(&self, node: u32, component: usize) -> Option<usize> {
        self.numbers.get(node as usize).and_then(|n| n.get(component).copied().flatten())
    }
}

/// Compliance of the interface degrees of freedom.
#[derive(Debug, Clone, Copy)]
pub struct InterfaceCompliance<'a> {
    /// Unknowns of the interface in the order of `compliance`.
    pub dofs: &'a [usize],
    /// `G`, `n_b × n_b` [m/N].
    pub compliance: MatRef<'a, f64>,
}

/// Submodel of the contact points `points`.
///
/// `shapes`: modes of the dynamic elastic coordinates at the unknowns, `n_dofs × n_q`; `interface`:
/// compliance of the interface, none when all modes are dynamic.
///
/// # Errors
/// [`ContactError::Data`] if sizes differ, functions do not sum to one, or a function that is not zero at a point
/// has unknowns outside the interface.
pub fn contact_submodel(
    motion: RigidMotion,
    points: &[SurfacePoint],
    lookup: &DofLookup,
    shapes: MatRef<'_, f64>,
    interface: Option<InterfaceCompliance<'_>>,
) -> Result<ContactSubmodel, ContactError> {
    check_functions(points)?;
    let rows = dof_rows(motion, points, lookup, shapes.nrows())?;
    let mut low = Mat::zeros(rows.n_rows(), shapes.ncols());
    for k in 0..shapes.ncols() {
        for i in 0..rows.n_rows() {
            low[(i, k)] = rows.row(i).iter().map(|&(dof, value)| value * shapes[(dof, k)]).sum();
        }
    }
    let (functions, compliance) = match interface {
        None => (SparseRows::new(0), ZoneCompliance::none()),
        Some(interface) => {
            let compliance = ZoneCompliance::Interface(interface.compliance.to_owned());
            (interface_rows(&rows, interface)?, compliance)
        }
    };
    let submodel = ContactSubmodel {
        motion,
        points: points.iter().map(|p| motion.in_space(&p.position).into()).collect(),
        areas: points.iter().map(|p| p.area).collect(),
        low,
        compliance,
        interface: functions,
        rim: points.iter().enumerate().filter(|(_, p)| p.on_rim).map(|(i, _)| i).collect(),
        facing: facing(motion, points),
        left_out: Vec::new(),
    };
    submodel.validate()?;
    Ok(submodel)
}

/// Normals of the points in the body's frame; empty unless every point has one.
fn facing(motion: RigidMotion, points: &[SurfacePoint]) -> Vec<[f64; 3]> {
    let normal = |p: &SurfacePoint| p.facing.map(|n| motion.in_space(&n).into());
    points.iter().map(normal).collect::<Option<Vec<_>>>().unwrap_or_default()
}

fn check_functions(points: &[SurfacePoint]) -> Result<(), ContactError> {
    for (i, point) in points.iter().enumerate() {
        let sum: f64 = point.functions.iter().map(|f| f.1).sum();
        // Asked this way round, a NaN does not slip through.
        let is_unity = (sum - 1.0).abs() <= UNITY_TOLERANCE;
        if !is_unity {
            let what = format!("the sum of the functions at contact point {i}");
            return Err(DataError::OutOfRange { what, value: sum, range: "1" }.into());
        }
    }
    Ok(())
}

/// Shape functions of the points in terms of all unknowns; constrained components have none.
fn dof_rows(
    motion: RigidMotion,
    points: &[SurfacePoint],
    lookup: &DofLookup,
    n_dofs: usize,
) -> Result<SparseRows, ContactError> {
    let mut rows = SparseRows::new(n_dofs);
    for point in points {
        for c in 0..motion.n_components() {
            let entries = || {
                let known = |&(node, value): &(u32, f64)| lookup.number(node, c).map(|dof| (dof, value));
                point.functions.iter().filter_map(known)
            };
            if let Some((dof, _)) = entries().find(|e| e.0 >= n_dofs) {
                let what = "rows of the mode shapes".into();
                return Err(DataError::Index { what, number: dof, count: n_dofs }.into());
            }
            rows.push(entries());
        }
    }
    Ok(rows)
}

/// The same rows in terms of the interface degrees of freedom.
fn interface_rows(rows: &SparseRows, interface: InterfaceCompliance<'_>) -> Result<SparseRows, ContactError> {
    let n_b = interface.dofs.len();
    check_square("the compliance of the interface", interface.compliance, n_b)?;
    let mut place = vec![None; rows.n_columns()];
    for (b, &dof) in interface.dofs.iter().enumerate() {
        match place.get_mut(dof) {
            Some(entry) => *entry = Some(b),
            None => {
                let (what, count) = ("unknowns of the interface".into(), rows.n_columns());
                return Err(DataError::Index { what, number: dof, count }.into());
            }
        }
    }
    let mut functions = SparseRows::new(n_b);
    for i in 0..rows.n_rows() {
        if let Some((dof, value)) = rows.row(i).iter().find(|e| place[e.0].is_none() && e.1 != 0.0) {
            return Err(ContactError::OutsideInterface { value: *value, unknown: *dof });
        }
        functions.push(rows.row(i).iter().filter_map(|e| place[e.0].map(|b| (b, e.1))));
    }
    Ok(functions)
}
