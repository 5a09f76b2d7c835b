//! Points and markers on an elastic body.

use faer::{Mat, MatRef};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use iga_core::space::Space;
use nalgebra::UnitQuaternion;

use super::ElasticBody;
use super::areas::Functions;
use super::discretised::{Discretised, point_in_space};
use super::point_markers::weights_on;
use crate::error::AdaptiveError;
use crate::marker_loads::{MarkerLoads, load_columns};
use crate::spec::{Area, Place};

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
                AdaptiveError::Unsupported {
                    subject: format!("body \"{}\"", self.name),
                    reason: format!("the shape has no marker \"{name}\", it has {}", known.join(", ")),
                }
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
        let (e, xi) = self.locate(&place)?;
        let functions = self.functions_at(e, &xi);
        let n_components = self.assembled.motion.n_components();
        let mut rows = Mat::zeros(n_components, shapes.ncols());
        for j in 0..shapes.ncols() {
            for c in 0..n_components {
                rows[(c, j)] = functions
                    .iter()
                    .filter_map(|&(node, value)| Some(value * shapes[(self.lookup.number(node, c)?, j)]))
                    .sum();
            }
        }
        let motion = self.assembled.motion;
        Ok(FlexiblePoint::from_rows(motion, point_in_space(motion, &place), rows.as_ref(), 0))
    }

    /// The marker `name` at `place` with axes turned by `rotation` from the body's, moving with the modes `shapes`. At a point it
    /// turns with half the curl of the displacement, on a part of the body it has its mean motion (theory Eq. M.36).
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
            Place::Area(area) => self.functions().mean_motion(area, rotation),
            Place::Point(_) | Place::Marker(_) => weights_on(self, &self.coordinates(place)?, rotation),
        }
    }

    /// What quadrature over a part of the body needs.
    fn functions(&self) -> Functions<'_> {
        let Self { name, shape, space, model, lookup, .. } = *self;
        Functions { name, shape, space, model, lookup }
    }

    /// Forces on the unknowns under `loads`, a column each, see [`load_columns`].
    ///
    /// # Errors
    /// As [`Discretised::marker_weights`].
    pub fn load_columns(&self, loads: &[MarkerLoads]) -> Result<Mat<f64>, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name.to_owned(), source };
        load_columns(
            self.assembled,
            loads,
            |place| self.marker_weights(place, UnitQuaternion::identity()),
            fail,
        )
    }
}

impl ElasticBody {
    /// The material point at `place` in terms of the unknowns, without its rotation.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body, [`AdaptiveError::Reduction`] if it is not finite.
    pub fn point_weights(&self, place: &[f64; 3]) -> Result<MarkerWeights, AdaptiveError> {
        let (e, xi) = self.locate(place)?;
        let motion = self.assembled.motion;
        let mut entries = Vec::new();
        for (node, value) in self.functions_at(e, &xi) {
            for c in 0..motion.n_components() {
                let mut w = [0.0; 6];
                w[motion.direction(c)] = value;
                entries.extend(self.lookup.number(node, c).map(|unknown| (unknown as u32, w)));
            }
        }
        entries.sort_unstable_by_key(|e| e.0);
        MarkerWeights::new(point_in_space(motion, place), UnitQuaternion::identity(), entries)
            .map_err(|source| AdaptiveError::Reduction { body: self.name.clone(), source })
    }

    /// What points and markers need.
    pub fn discretised(&self) -> Discretised<'_> {
        Discretised {
            name: &self.name,
            shape: &self.spec.shape,
            space: &self.space,
            model: &self.spec.model,
            assembled: &self.assembled,
            lookup: &self.lookup,
        }
    }

    /// Functions that are not zero at parameters `xi` of element `e`, with their values.
    pub fn functions_at(&self, e: usize, xi: &[f64; 3]) -> Vec<(u32, f64)> {
        self.discretised().functions_at(e, xi)
    }

    /// As [`Discretised::locate`].
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body.
    pub fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        self.discretised().locate(place)
    }

    /// As [`Discretised::flexible_point`].
    ///
    /// # Errors
    /// As there.
    pub fn flexible_point(
        &self,
        place: &Place,
        shapes: MatRef<'_, f64>,
    ) -> Result<FlexiblePoint, AdaptiveError> {
        self.discretised().flexible_point(place, shapes)
    }

    /// As [`Discretised::marker_weights`].
    ///
    /// # Errors
    /// As there.
    pub fn marker_weights(
        &self,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<MarkerWeights, AdaptiveError> {
        self.discretised().marker_weights(place, rotation)
    }

    /// Displacements of the unknowns as node-major control values, with zeros where a component is constrained.
    pub fn control_values(&self, displacement: &[f64]) -> Vec<f64> {
        let n_components = self.assembled.motion.n_components();
        let mut values = vec![0.0; self.space.n_functions() * n_components];
        for (dof, u) in self.assembled.dofs.iter().zip(displacement) {
            values[dof.node as usize * n_components + dof.component as usize] = *u;
        }
        values
    }
}
