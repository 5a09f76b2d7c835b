//! Rigid-body modes of a discretised body and its mass properties (Eqs. R.8, R.9).
//!
//! A rigid displacement of a spline or Lagrange discretisation has the displacement of the control
//! points as coefficients, so the modes are exact; everything is integrated with the consistent
//! mass matrix.

use faer::{Mat, MatRef};

use super::blocks::dense;
use crate::DynamicsError;
use crate::body::{AssembledBody, RigidMotion};
use crate::data_error::DataError;

/// A rigid motion may strain the body by at most this part of its stiffest entry.
const STRAIN_LIMIT: f64 = 1e-6;

/// Mass, centre of mass and inertia from the consistent mass matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass; per unit of thickness in plane models \[kg\].
    pub mass: f64,
    /// Centre of mass in space: `(x, y, z)`, `(x, y, 0)` or `(0, 0, z)` of an axisymmetric model
    /// \[m\].
    pub centre: [f64; 3],
    /// Inertia tensor about the centre of mass in space; plane models count as flat [kg m²].
    pub inertia: [[f64; 3]; 3],
}

/// Mass-orthonormal rigid modes `R`: `R^T M R = 1`, `K R = 0`.
#[derive(Debug, Clone)]
pub struct RigidModes {
    /// Modes, n x r with r = 1 (axial), 3 (planar) or 6 (spatial); translations first [1/sqrt(kg)].
    pub modes: Mat<f64>,
    /// `M R`, n x r.
    pub mass_modes: Mat<f64>,
    /// Mass, centre, inertia.
    pub mass_properties: MassProperties,
}

impl RigidModes {
    /// Rigid modes of a free body.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the mass is not positive, the body has no extent, or the stiffness matrix resists a
    /// rigid motion (unknowns are missing, or the matrix belongs to another geometry).
    pub fn new(body: &AssembledBody) -> Result<Self, DynamicsError> {
        let mass_properties = mass_properties(body)?;
        let mut modes = motions(body, &mass_properties);
        // Twice: the second pass removes what round-off left of the first.
        for _ in 0..2 {
            let gram = dense::product(modes.transpose(), body.mass_product(modes.as_ref()).as_ref());
            let factor = dense::cholesky(gram, "the rigid mass matrix").map_err(|_| DataError::NoExtent)?;
            let mut transposed = modes.transpose().to_owned();
            dense::solve_lower(factor.as_ref(), transposed.as_mut());
            modes = transposed.transpose().to_owned();
        }
        check_strain(body, modes.as_ref())?;
        let mass_modes = body.mass_product(modes.as_ref());
        Ok(Self { modes, mass_modes, mass_properties })
    }

    /// Number of rigid modes.
    pub fn count(&self) -> usize {
        self.modes.ncols()
    }
}

/// Field with `value(node position)` in one component and zero in the others.
fn field(body: &AssembledBody, component: usize, value: impl Fn(&[f64; 3]) -> f64) -> Mat<f64> {
    Mat::from_fn(body.dofs.len(), 1, |i, _| {
        let dof = body.dofs[i];
        if dof.component as usize == component { value(&body.nodes[dof.node as usize]) } else { 0.0 }
    })
}

/// Mass, centre of mass and inertia of the discretised body.
///
/// # Errors
/// [`DynamicsError::Data`] if the mass is not positive.
pub fn mass_properties(body: &AssembledBody) -> Result<MassProperties, DynamicsError> {
    if body.has_rotations() {
        return general_mass_properties(body);
    }
    let axial = body.motion == RigidMotion::Axial;
    // The axial component carries all nodes; the radial one lacks those on the axis, where r = 0
    // anyway.
    let carrier = usize::from(axial);
    let one = body.mass_product(field(body, carrier, |_| 1.0).as_ref());
    let against_one = |x: &Mat<f64>| dense::product(x.transpose(), one.as_ref())[(0, 0)];
    let mass = against_one(&field(body, carrier, |_| 1.0));
    if !(mass.is_finite() && mass > 0.0) {
        return Err(DataError::OutOfRange { what: "the mass [kg]".into(), value: mass, range: "> 0" }.into());
    }
    let n_c = body.motion.n_components();
    let mut model_centre = [0.0; 3];
    for (c, x) in model_centre.iter_mut().enumerate().take(n_c) {
        *x = if axial && c == 0 { 0.0 } else { against_one(&field(body, carrier, |p| p[c])) / mass };
    }
    let lever = |c: usize| {
        let component = if axial { c } else { 0 };
        field(body, component, |p| p[c] - model_centre[c])
    };
    let mut second = [[0.0; 3]; 3];
    if axial {
        let moment = |c: usize| {
            let x = lever(c);
            dense::product(x.transpose(), body.mass_product(x.as_ref()).as_ref())[(0, 0)]
        };
        let (radial, along) = (moment(0), moment(1));
        second = [[0.5 * radial, 0.0, 0.0], [0.0, 0.5 * radial, 0.0], [0.0, 0.0, along]];
    } else {
        for (c, row) in second.iter_mut().enumerate().take(n_c) {
            let product = body.mass_product(lever(c).as_ref());
            for (d, entry) in row.iter_mut().enumerate().take(n_c) {
                *entry = dense::product(lever(d).transpose(), product.as_ref())[(0, 0)];
            }
        }
    }
    let trace = second[0][0] + second[1][1] + second[2][2];
    let inertia = std::array::from_fn(|c| {
        std::array::from_fn(|d| if c == d { trace - second[c][d] } else { -second[c][d] })
    });
    let centre = if axial { [0.0, 0.0, model_centre[1]] } else { model_centre };
    Ok(MassProperties { mass, centre, inertia })
}

/// Mass properties of a body with rotations among its unknowns.
fn general_mass_properties(body: &AssembledBody) -> Result<MassProperties, DynamicsError> {
    let (mass, first, second) = body.rigid_integrals();
    if !(mass.is_finite() && mass > 0.0) {
        return Err(DataError::OutOfRange { what: "the mass [kg]".into(), value: mass, range: "> 0" }.into());
    }
    let centre = first / mass;
    let central = second - centre * centre.transpose() * mass;
    let inertia = nalgebra::Matrix3::identity() * central.trace() - central;
    let rows = std::array::from_fn(|c| std::array::from_fn(|d| inertia[(c, d)]));
    Ok(MassProperties { mass, centre: centre.into(), inertia: rows })
}

/// Translations, then rotations about the centre of mass, not yet normalised.
fn motions(body: &AssembledBody, properties: &MassProperties) -> Mat<f64> {
    let n = body.dofs.len();
    let c = properties.centre;
    let arm = |i: usize| {
        let x = body.nodes[body.dofs[i].node as usize];
        [x[0] - c[0], x[1] - c[1], x[2] - c[2]]
    };
    let translation = |i: usize, axis: usize| {
        let is_along = body.dofs[i].component as usize == axis && axis < body.motion.n_components();
        if is_along { 1.0 } else { 0.0 }
    };
    // (e_a x arm)_component
    let rotation = |i: usize, a: usize| {
        let (b, d, component) = ((a + 1) % 3, (a + 2) % 3, body.dofs[i].component as usize);
        if let Some(axis) = body.motion.rotation_axis(body.dofs[i].component) {
            if axis == a { 1.0 } else { 0.0 }
        } else if component == b {
            -arm(i)[d]
        } else if component == d {
            arm(i)[b]
        } else {
            0.0
        }
    };
    match body.motion {
        RigidMotion::Axial => Mat::from_fn(n, 1, |i, _| translation(i, 1)),
        RigidMotion::Planar => {
            Mat::from_fn(n, 3, |i, j| if j < 2 { translation(i, j) } else { rotation(i, 2) })
        }
        RigidMotion::Spatial => {
            Mat::from_fn(n, 6, |i, j| if j < 3 { translation(i, j) } else { rotation(i, j - 3) })
        }
    }
}

/// Rigid motions must not strain the body.
fn check_strain(body: &AssembledBody, modes: MatRef<'_, f64>) -> Result<(), DynamicsError> {
    let forces = body.stiffness_product(modes);
    let diagonal =
        |j: usize| body.stiffness.val_of_col(j).iter().copied().fold(0.0, |a: f64, b| a.max(b.abs()));
    let stiffest = (0..body.dofs.len()).map(diagonal).fold(0.0, f64::max);
    for j in 0..modes.ncols() {
        let limit = stiffest * modes.col(j).norm_max() * STRAIN_LIMIT;
        let worst = forces.col(j).norm_max();
        if worst > limit {
            return Err(DataError::RigidMotionResisted { motion: j, force: worst, limit }.into());
        }
    }
    Ok(())
}
