//! Points and markers on an elastic body.

use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use nalgebra::UnitQuaternion;

use super::ElasticBody;
use super::discretised::Discretised;
use super::point_markers::weights_on;
use crate::error::AdaptiveError;
use crate::marker_loads::{MarkerLoads, load_columns};
use crate::spec::{Area, Place};
use crate::unsupported::Unsupported;

impl Discretised<'_> {
    /// Coordinates of a place in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if the shape has no marker of that name.
    fn coordinates(&self, place: &Place) -> Result<[f64; 3], AdaptiveError> {
        match place {
            Place::Point(point) | Place::Area(Area { centre: point, .. }) => Ok(*point),
            Place::Marker(name) => self.shape.markers.get(name).copied().ok_or_else(|| {
                let known: Vec<&str> = self.shape.markers.keys().map(String::as_str).collect();
                let (marker, known) = (name.clone(), known.join(", "));
                let what = Unsupported::UnknownMarker { holder: "shape", marker, known };
                AdaptiveError::unsupported_body(self.name, what)
            }),
        }
    }

    /// The material point at `place`, moving with the modes `shapes`; of a part of the body its mean motion.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] or [`AdaptiveError::Unsupported`] if there is no such place.
    pub fn flexible_point(
        &self,
        place: &Place,
        shapes: MatRef<'_, f64>,
    ) -> Result<FlexiblePoint, AdaptiveError> {
        if matches!(place, Place::Area(_)) {
            return Ok(self.marker("point", place, UnitQuaternion::identity(), shapes)?.point());
        }
        let place = self.coordinates(place)?;
        let functions = self.functions_at(&place)?;
        let motion = self.motion();
        let n_components = motion.n_components();
        let mut rows = Mat::zeros(n_components, shapes.ncols());
        for j in 0..shapes.ncols() {
            for c in 0..n_components {
                rows[(c, j)] = functions
                    .iter()
                    .filter_map(|&(node, value)| Some(value * shapes[(self.lookup.number(node, c)?, j)]))
                    .sum();
            }
        }
        Ok(FlexiblePoint::from_rows(motion, motion.in_space(&place), rows.as_ref(), 0))
    }

    /// The marker `name` at `place` with axes turned by `rotation` from the body's, moving with the modes `shapes`. At a point it
    /// turns with half the curl of the displacement, on a part of the body it has its mean motion (theory Eq. M.44).
    ///
    /// # Errors
    /// As [`Discretised::flexible_point`]; [`AdaptiveError::Reduction`] if a mode is not finite there.
    pub fn marker(
        &self,
        name: &str,
        place: &Place,
        rotation: UnitQuaternion<f64>,
        shapes: MatRef<'_, f64>,
    ) -> Result<Marker, AdaptiveError> {
        self.marker_weights(place, rotation)?
            .marker(name, shapes)
            .map_err(|source| AdaptiveError::Reduction { body: self.name.to_owned(), source })
    }

    /// The marker at `place` with axes turned by `rotation`, in terms of the unknowns.
    ///
    /// # Errors
    /// As [`Discretised::flexible_point`]; [`AdaptiveError::Reduction`] if a function is not finite there.
    pub fn marker_weights(
        &self,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        match place {
            Place::Area(area) => self.mean_motion(area, rotation),
            Place::Point(_) | Place::Marker(_) => weights_on(self, &self.coordinates(place)?, rotation),
        }
    }

    /// Forces on the unknowns of `assembled`, the matrices of this discretisation, under `loads`, a column each, see [`load_columns`].
    ///
    /// # Errors
    /// As [`Discretised::marker_weights`].
    pub fn load_columns(
        &self,
        assembled: &AssembledBody,
        loads: &[MarkerLoads],
    ) -> Result<Mat<f64>, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name.to_owned(), source };
        load_columns(assembled, loads, |place| self.marker_weights(place, UnitQuaternion::identity()), fail)
    }

    /// The material point at `place` in terms of the unknowns, without its rotation.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body, [`AdaptiveError::Reduction`] if it is not finite.
    pub fn point_weights(&self, place: &[f64; 3]) -> Result<MarkerWeights, AdaptiveError> {
        let motion = self.motion();
        let mut entries = Vec::new();
        for (node, value) in self.functions_at(place)? {
            for c in 0..motion.n_components() {
                let mut w = [0.0; 6];
                w[motion.direction(c)] = value;
                entries.extend(self.lookup.number(node, c).map(|unknown| (unknown as u32, w)));
            }
        }
        entries.sort_unstable_by_key(|e| e.0);
        MarkerWeights::new(motion.in_space(place), UnitQuaternion::identity(), entries)
            .map_err(|source| AdaptiveError::Reduction { body: self.name.to_owned(), source })
    }
}

impl ElasticBody {
    /// What points, markers and contact zones need.
    pub fn discretised(&self) -> Discretised<'_> {
        Discretised {
            name: &self.name,
            shape: &self.spec.shape,
            patches: &self.shape.patches,
            space: &self.space,
            model: &self.spec.model,
            dofs: &self.assembled.dofs,
            lookup: &self.lookup,
        }
    }
}
