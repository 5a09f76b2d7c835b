//! Markers with an extent on a spline body: the quadrature points of a part of it (docs/theory.md Eq. M.44, M.45;
//! docs/decisions/0016-markers-with-extent.md).

use faer::sparse::SparseColMat;
use ffr_dynamics::kinematics::MarkerWeights;
use iga_core::elasticity::Material;
use iga_core::extent::Extent;
use iga_core::nurbs::patch::PointBasis;
use nalgebra::UnitQuaternion;

use super::discretised::Discretised;
use crate::error::AdaptiveError;
use crate::part_motion::PartPoints;
use crate::spec::Area;
use crate::unsupported::{MOST_RIGID_UNKNOWNS, Unsupported};

impl Discretised<'_> {
    fn part_points(&self, extent: &Extent) -> Result<PartPoints, AdaptiveError> {
        let points = extent.points(self.shape, self.space, self.model);
        let points =
            points.map_err(|source| AdaptiveError::Geometry { body: self.name.to_owned(), source })?;
        let mut part = PartPoints::new(self.motion(), self.space.n_functions());
        let (mut basis, mut active, mut found) = (PointBasis::default(), Vec::new(), Vec::new());
        for point in &points {
            self.space.evaluate(point.element, &point.xi, 0, &mut basis);
            self.space.active_functions(point.element, &mut active);
            found.clear();
            let values = active.iter().copied().zip(basis.values.iter().copied());
            found.extend(values.filter(|(_, value)| value.abs() > 0.0));
            // Where the functions put a point, not where the search wanted it to the last digits but one: rigid motions are then followed to
            // round-off.
            let mut place = [0.0; 3];
            for &(number, value) in &found {
                let control_point = self.space.control_points()[number as usize];
                place.iter_mut().zip(control_point).for_each(|(sum, p)| *sum += value * p);
            }
            part.push(place, point.weight, &found);
        }
        Ok(part)
    }

    /// The marker that follows the mean motion of `area`: displacement and rotation of its centre by the rigid motion nearest to
    /// the displacements of the part, every point with its area (theory Eq. M.44).
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if there is no such part, [`AdaptiveError::Reduction`] if it defines no rotation.
    pub fn mean_motion(
        &self,
        area: &Area,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        let part = self.part_points(&area.extent)?;
        part.mean_motion(&area.centre, rotation, |function, c| self.lookup.number(function, c))
            .map_err(|source| AdaptiveError::Reduction { body: self.name.to_owned(), source })
    }

    /// The lower triangle `stiffness` with that of the rigid parts `areas` added: `α ∫ |u - u_rigid|² dA` with the rigid motion
    /// `u_rigid` nearest to `u` (theory Eq. M.45). Rigid motions of the body stay free of forces, masses stay as they are.
    ///
    /// # Errors
    /// As [`Discretised::mean_motion`]; [`AdaptiveError::Unsupported`] for parts with thousands of unknowns.
    pub fn stiffened(
        &self,
        stiffness: SparseColMat<u32, f64>,
        areas: &[Area],
        material: &Material,
    ) -> Result<SparseColMat<u32, f64>, AdaptiveError> {
        areas.iter().try_fold(stiffness, |sum, area| {
            let part = self.part_points(&area.extent)?;
            let number = |function, c| self.lookup.number(function, c);
            let (young, thickness) = (material.youngs_modulus(), self.model.thickness());
            let block = part
                .rigid_block(young, thickness, number, MOST_RIGID_UNKNOWNS)
                .map_err(|source| AdaptiveError::Reduction { body: self.name.to_owned(), source })?;
            let block = block.map_err(|unknowns| {
                let part = area.extent.name();
                let what = Unsupported::RigidPart { part, unknowns, most: MOST_RIGID_UNKNOWNS };
                AdaptiveError::unsupported_body(self.name, what)
            })?;
            Ok(block.added_to(&sum))
        })
    }
}
