//! Places on bodies that have names: points and parts of a shape, and those that the user has
//! added.

use std::collections::BTreeMap;
use std::sync::Arc;

use adaptive::spec::{Area, Coupling, Extent, Place};
use fe_mesh::Mesh;
use fe_mesh::fault::MeshFault;
use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::extent::centroid;
use iga_core::nurbs::Shape;

/// A place as the scenario gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum GivenPlace {
    /// By the name of a point or part of the body.
    Marker(String),
    /// By the components of the body's model: `(x, y, z)`, `(x, y, 0)` or `(r, z, 0)` \[m\].
    Point([f64; 3]),
    /// As a part of the body.
    Part {
        /// Which part.
        extent: Extent,
        /// How it is joined to what holds it.
        coupling: Coupling,
        /// Where its marker is, on a rigid arm; in the middle if not given.
        at: Option<[f64; 3]>,
    },
}

/// Why a place is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlaceError {
    /// The body has nothing of this name.
    #[error("the body has no point \"{marker}\", it has {}", if known.is_empty() { "none".to_owned() } else { known.join(", ") })]
    Unknown {
        /// The name asked for.
        marker: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// The part cannot be measured.
    #[error(transparent)]
    Geometry(#[from] SplineError),
    /// The same of a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
}

/// The places of a body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BodyPlaces {
    kind: PlacesOf,
    /// Points by name of a body without shape, whose shape has them otherwise, in the components of
    /// the body's model \[m\].
    points: BTreeMap<String, [f64; 3]>,
    /// Markers with an extent that the user has added.
    areas: BTreeMap<String, Area>,
}

/// What the places of a body are parts of.
#[derive(Debug, Clone, PartialEq, Default)]
enum PlacesOf {
    /// A flexible body with its kinematics.
    Flexible((Arc<Shape>, Model)),
    /// A body of finite elements.
    Meshed(Arc<Mesh>),
    /// A rigid body, of which a part moves like a point; it may have a shape.
    Rigid(Option<(Arc<Shape>, Model)>),
    /// A body that has only the markers of its file, or none.
    #[default]
    File,
}

impl BodyPlaces {
    /// The places of a flexible body, with `markers` added by the user.
    ///
    /// # Errors
    /// [`PlaceError`] for a face that the shape does not have.
    pub fn flexible(
        shape: Shape,
        model: Model,
        markers: &[(String, GivenPlace)],
    ) -> Result<Self, PlaceError> {
        Self::new(PlacesOf::Flexible((Arc::new(shape), model)), markers)
    }

    /// The places of a rigid body, with `markers` added by the user.
    ///
    /// # Errors
    /// As [`BodyPlaces::flexible`].
    pub fn rigid(
        shape: Option<(Arc<Shape>, Model)>,
        markers: &[(String, GivenPlace)],
    ) -> Result<Self, PlaceError> {
        Self::new(PlacesOf::Rigid(shape), markers)
    }

    /// The places of a body of finite elements, with `markers` added by the user.
    ///
    /// # Errors
    /// [`PlaceError`] for a group that the mesh does not have.
    pub fn meshed(mesh: Arc<Mesh>, markers: &[(String, GivenPlace)]) -> Result<Self, PlaceError> {
        Self::new(PlacesOf::Meshed(mesh), markers)
    }

    fn new(kind: PlacesOf, markers: &[(String, GivenPlace)]) -> Result<Self, PlaceError> {
        let mut places = Self { kind, ..Self::default() };
        let mut points = places.shape().map(|(shape, _)| shape.markers.clone()).unwrap_or_default();
        for (name, at) in markers {
            match at {
                GivenPlace::Point(point) => {
                    points.insert(name.clone(), *point);
                }
                GivenPlace::Part { extent, coupling, at } => {
                    if let Extent::Around { point, .. } = extent {
                        points.insert(name.clone(), *point);
                    }
                    let area = places.area(extent, *coupling, *at)?;
                    places.areas.insert(name.clone(), area);
                }
                GivenPlace::Marker(_) => {}
            }
        }
        match &mut places.kind {
            PlacesOf::Flexible((shape, _)) | PlacesOf::Rigid(Some((shape, _))) => {
                // Bodies without markers of their own share the shape.
                if shape.markers != points {
                    Arc::make_mut(shape).markers = points;
                }
            }
            PlacesOf::Rigid(None) | PlacesOf::File | PlacesOf::Meshed(_) => places.points = points,
        }
        Ok(places)
    }

    /// The exact shape of the body with all named points, and its kinematics, if it has a shape.
    pub fn shape(&self) -> Option<&(Arc<Shape>, Model)> {
        match &self.kind {
            PlacesOf::Flexible(shape) => Some(shape),
            PlacesOf::Rigid(shape) => shape.as_ref(),
            PlacesOf::File | PlacesOf::Meshed(_) => None,
        }
    }

    /// Points by name, in the components of the body's model \[m\].
    pub fn points(&self) -> &BTreeMap<String, [f64; 3]> {
        self.shape().map_or(&self.points, |(shape, _)| &shape.markers)
    }

    /// All parts by name: markers with an extent and those faces of the shape that have an area.
    pub fn areas(&self) -> Vec<(String, Area)> {
        let faces = self.shape().into_iter().flat_map(|(shape, _)| shape.faces.keys().map(String::as_str));
        let faces = faces.chain(self.mesh().into_iter().flat_map(Mesh::face_names));
        let face = |name: &str| {
            let area = self.face(name).ok()?;
            (!self.areas.contains_key(name)).then(|| (name.to_owned(), area))
        };
        let added = self.areas.iter().map(|(name, area)| (name.clone(), area.clone()));
        faces.filter_map(face).chain(added).collect()
    }

    /// A single point in the components of the body's model \[m\].
    ///
    /// # Errors
    /// [`PlaceError`] for an unknown marker.
    pub fn point(&self, at: &GivenPlace) -> Result<[f64; 3], PlaceError> {
        match at {
            GivenPlace::Point(point) => Ok(*point),
            GivenPlace::Marker(marker) => {
                self.points().get(marker).copied().ok_or_else(|| self.unknown(marker))
            }
            GivenPlace::Part { extent, coupling, at } => Ok(self.area(extent, *coupling, *at)?.centre),
        }
    }

    /// What is observed: the mean motion of a marker with an extent that the user has added,
    /// otherwise a point.
    ///
    /// # Errors
    /// As [`BodyPlaces::point`].
    pub fn observed(&self, at: &GivenPlace) -> Result<Place, PlaceError> {
        match at {
            GivenPlace::Marker(marker) if self.kind == PlacesOf::File => Ok(Place::Marker(marker.clone())),
            GivenPlace::Marker(marker) if self.areas.contains_key(marker) => {
                Ok(self.part(&self.areas[marker]))
            }
            GivenPlace::Marker(marker) if self.mesh().is_some() && self.has_face(marker) => {
                Ok(self.part(&self.face(marker)?))
            }
            _ => self.inside(at).map(Place::Point),
        }
    }

    /// A single point, of a flexible body with a shape or a mesh one that lies in it, in the
    /// components of the body's model \[m\].
    ///
    /// # Errors
    /// [`PlaceError`] for an unknown marker and for a point outside.
    pub fn inside(&self, at: &GivenPlace) -> Result<[f64; 3], PlaceError> {
        let point = self.point(at)?;
        match &self.kind {
            PlacesOf::Flexible((shape, _)) => {
                shape.locate(&point)?;
            }
            PlacesOf::Meshed(mesh) => {
                mesh.locate(&point)?;
            }
            PlacesOf::Rigid(_) | PlacesOf::File => {}
        }
        Ok(point)
    }

    /// What is held: a part of the body, also under the names of the ends of bars; a point where
    /// the place has no extent.
    ///
    /// # Errors
    /// [`PlaceError`] for an unknown marker or face.
    pub fn held(&self, at: &GivenPlace) -> Result<Place, PlaceError> {
        match at {
            GivenPlace::Part { extent, coupling, at } => Ok(self.part(&self.area(extent, *coupling, *at)?)),
            GivenPlace::Marker(marker) if self.kind == PlacesOf::File => Ok(Place::Marker(marker.clone())),
            GivenPlace::Marker(marker) => match self.areas.get(marker) {
                Some(area) => Ok(self.part(area)),
                None if self.has_face(marker) => Ok(self.part(&self.face(marker)?)),
                None => self.point(at).map(Place::Point),
            },
            GivenPlace::Point(_) => self.point(at).map(Place::Point),
        }
    }

    /// The part `area` of a flexible body, of a rigid one its centre: that is how its mean motion
    /// is.
    fn part(&self, area: &Area) -> Place {
        if matches!(self.kind, PlacesOf::Rigid(_)) {
            Place::Point(area.centre)
        } else {
            Place::Area(area.clone())
        }
    }

    fn has_face(&self, name: &str) -> bool {
        self.shape().is_some_and(|(shape, _)| shape.faces.contains_key(name))
            || self.mesh().is_some_and(|mesh| mesh.face_group(name).is_ok())
    }

    fn mesh(&self) -> Option<&Mesh> {
        match &self.kind {
            PlacesOf::Meshed(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// A whole face, held by its mean motion.
    fn face(&self, name: &str) -> Result<Area, PlaceError> {
        self.area(&Extent::Face(name.to_owned()), Coupling::Average, None)
    }

    /// The part `extent` with its marker in its middle, or `at` a point.
    fn area(&self, extent: &Extent, coupling: Coupling, at: Option<[f64; 3]>) -> Result<Area, PlaceError> {
        let middle = match (self.shape(), extent) {
            (Some((shape, model)), _) => extent.centre(shape, model)?,
            (None, Extent::Face(name)) => {
                let mesh = self.mesh().ok_or_else(|| self.unknown(name))?;
                self.on_axis(centroid(&mesh.face_part(name)?))
            }
            (None, Extent::Around { point, radius }) => {
                if let Some(mesh) = self.mesh() {
                    mesh.around(point, *radius)?;
                }
                self.on_axis(*point)
            }
        };
        let centre = at.map_or(middle, |at| self.on_axis(at));
        Ok(Area { extent: extent.clone(), centre, coupling })
    }

    /// A place of a marker: in axisymmetric bodies that is on the axis.
    fn on_axis(&self, centre: [f64; 3]) -> [f64; 3] {
        let model = self.mesh().map(Mesh::model).or(self.shape().map(|(_, model)| model));
        let is_axial = model.is_some_and(|model| *model == Model::Axisymmetric);
        [if is_axial { 0.0 } else { centre[0] }, centre[1], centre[2]]
    }

    fn unknown(&self, marker: &str) -> PlaceError {
        let known = self.points().keys().chain(self.areas.keys()).cloned().collect();
        PlaceError::Unknown { marker: marker.to_owned(), known }
    }
}
