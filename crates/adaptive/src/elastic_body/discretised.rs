//! The discretisation of a body, coarse or fine: functions at a place.

use contact_qs::points::DofLookup;
use ffr_dynamics::body::{Dof, RigidMotion};
use iga_core::elasticity::Model;
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::SplineSpace;

use super::rigid_motion;
use crate::error::AdaptiveError;

/// The discretisation of a body, coarse or fine, as points, markers and contact zones see it.
#[derive(Clone, Copy)]
pub struct Discretised<'a> {
    /// Name of the body.
    pub name: &'a str,
    /// Its shape before refinement, which keeps the parameters and is the cheaper one to search.
    pub shape: &'a Shape,
    /// Its patches: those of a plain space, of a hierarchical one the coarsest.
    pub patches: &'a [Patch],
    /// Functions.
    pub space: &'a dyn SplineSpace,
    /// Kinematics.
    pub model: &'a Model,
    /// The unknowns, sorted by node, then component.
    pub dofs: &'a [Dof],
    /// Numbers of the unknowns.
    pub lookup: &'a DofLookup,
}

impl Discretised<'_> {
    /// Rigid motions of the model.
    pub fn motion(&self) -> RigidMotion {
        rigid_motion(self.model)
    }

    /// Functions that are not zero at a point of the undeformed body (the model's components, \[m\]), with their values.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body.
    pub fn functions_at(&self, place: &[f64; 3]) -> Result<Vec<(u32, f64)>, AdaptiveError> {
        let (e, xi) = self.locate(place)?;
        Ok(self.space.functions_at(e, &xi))
    }

    /// Element and parameters of a point of the undeformed body, in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body.
    pub fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        let (patch, xi) = self
            .shape
            .locate(place)
            .map_err(|source| AdaptiveError::Geometry { body: self.name.to_owned(), source })?;
        Ok((self.space.find_element(patch, &xi), xi))
    }

    /// Displacements of the unknowns as node-major control values, with zeros where a component is constrained.
    pub fn control_values(&self, displacement: &[f64]) -> Vec<f64> {
        let n_components = self.motion().n_components();
        let mut values = vec![0.0; self.space.n_functions() * n_components];
        for (dof, u) in self.dofs.iter().zip(displacement) {
            values[dof.node as usize * n_components + dof.component as usize] = *u;
        }
        values
    }
}
