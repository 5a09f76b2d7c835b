//! Places on bodies that have names: points and parts of a shape, and those that the user has added.

use std::collections::BTreeMap;

use adaptive::spec::{Area, Coupling, Extent, Place as PlaceSpec};
use iga_core::elasticity::Model;
use iga_core::nurbs::Shape;

use crate::error::AppError;
use crate::scenario::{self, Place};

/// The places of a body.
pub struct Markers {
    /// Name of the body.
    body: String,
    /// Shape and kinematics; none of bodies from files and of those with a given mass.
    shape: Option<(Shape, Model)>,
    /// Whether a part of the body moves like a point of it.
    is_rigid: bool,
    /// Points by name, in the components of the body's model \[m\].
    points: BTreeMap<String, [f64; 3]>,
    /// Markers with an extent that the user has added.
    areas: BTreeMap<String, Area>,
}

impl Markers {
    /// Those of `body`, which has the given shape if it has one.
    ///
    /// # Errors
    /// [`AppError::Model`] for a face that the shape does not have.
    pub fn new(
        body: &scenario::Body,
        shape: Option<(Shape, Model)>,
        is_rigid: bool,
    ) -> Result<Self, AppError> {
        let points = shape.as_ref().map(|(shape, _)| shape.markers.clone()).unwrap_or_default();
        let mut markers = Self { body: body.name.clone(), shape, is_rigid, points, areas: BTreeMap::new() };
        for marker in &body.markers {
            let name = marker.name.clone();
            match &marker.at {
                Place::Point(point) => {
                    markers.points.insert(name, *point);
                }
                Place::Area { extent, coupling } => {
                    if let Extent::Around { point, .. } = extent {
                        markers.points.insert(name.clone(), *point);
                    }
                    let area = markers.area(extent, *coupling)?;
                    markers.areas.insert(name, area);
                }
                Place::Marker(_) => {}
            }
        }
        Ok(markers)
    }

    /// Points by name, in the components of the body's model \[m\].
    pub fn points(&self) -> &BTreeMap<String, [f64; 3]> {
        &self.points
    }

    /// All parts by name: markers with an extent and those faces of the shape that have an area.
    pub fn areas(&self) -> Vec<(String, Area)> {
        let faces = self.shape.iter().flat_map(|(shape, _)| shape.faces.keys());
        let face = |name: &String| {
            let area = self.area(&Extent::Face(name.clone()), Coupling::Average).ok()?;
            (!self.areas.contains_key(name)).then(|| (name.clone(), area))
        };
        let added = self.areas.iter().map(|(name, area)| (name.clone(), area.clone()));
        faces.filter_map(face).chain(added).collect()
    }

    /// A single point in the components of the body's model \[m\].
    ///
    /// # Errors
    /// [`AppError::Model`] for an unknown marker.
    pub fn point(&self, at: &Place) -> Result<[f64; 3], AppError> {
        match at {
            Place::Point(point) => Ok(*point),
            Place::Marker(marker) => self.points.get(marker).copied().ok_or_else(|| self.unknown(marker)),
            Place::Area { extent, coupling } => Ok(self.area(extent, *coupling)?.centre),
        }
    }

    /// What is observed: the mean motion of a marker with an extent that the user has added, otherwise a point.
    ///
    /// # Errors
    /// As [`Markers::point`].
    pub fn observed(&self, at: &Place) -> Result<PlaceSpec, AppError> {
        match at {
            Place::Marker(marker) if self.areas.contains_key(marker) => Ok(self.of(&self.areas[marker])),
            _ => self.point(at).map(PlaceSpec::Point),
        }
    }

    /// What is held: a part of the body, also under the names of the ends of bars; a point where the place has no extent.
    ///
    /// # Errors
    /// [`AppError::Model`] for an unknown marker or face.
    pub fn held(&self, at: &Place) -> Result<PlaceSpec, AppError> {
        match at {
            Place::Area { extent, coupling } => Ok(self.of(&self.area(extent, *coupling)?)),
            Place::Marker(marker) => match self.areas.get(marker) {
                Some(area) => Ok(self.of(area)),
                None if self.has_face(marker) => {
                    Ok(self.of(&self.area(&Extent::Face(marker.clone()), Coupling::Average)?))
                }
                None => self.point(at).map(PlaceSpec::Point),
            },
            Place::Point(_) => self.point(at).map(PlaceSpec::Point),
        }
    }

    /// The part `area` of a flexible body, of a rigid one its centre: that is how its mean motion is.
    fn of(&self, area: &Area) -> PlaceSpec {
        if self.is_rigid { PlaceSpec::Point(area.centre) } else { PlaceSpec::Area(area.clone()) }
    }

    fn has_face(&self, name: &str) -> bool {
        self.shape.as_ref().is_some_and(|(shape, _)| shape.faces.contains_key(name))
    }

    fn area(&self, extent: &Extent, coupling: Coupling) -> Result<Area, AppError> {
        match (&self.shape, extent) {
            (Some((shape, model)), _) => Area::new(extent.clone(), coupling, shape, model)
                .map_err(|source| AppError::Model(format!("body \"{}\": {source}", self.body))),
            (None, Extent::Around { point, .. }) => {
                Ok(Area { extent: extent.clone(), centre: *point, coupling })
            }
            (None, Extent::Face(name)) => Err(AppError::Model(format!(
                "body \"{}\": the body has no shape with a face \"{name}\", give a point",
                self.body
            ))),
        }
    }

    fn unknown(&self, marker: &str) -> AppError {
        let known: Vec<&str> = self.points.keys().chain(self.areas.keys()).map(String::as_str).collect();
        AppError::Model(format!(
            "body \"{}\" has no point \"{marker}\", it has {}",
            self.body,
            known.join(", ")
        ))
    }
}
