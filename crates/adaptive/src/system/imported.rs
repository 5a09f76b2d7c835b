//! Bodies from files: reduced ones as they are, matrices of other programs reduced here.

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::StandardInputData;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use ffr_dynamics::reduction::modal::all_modes;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::body::loads::{StaticLoads, load_columns};
use crate::body::reduced::damping::damping;
use crate::body::reduced::free_modes_answering;
use crate::error::AdaptiveError;
use crate::spec::{FrameSpec, ImportedSpec, Place, ReductionSpec};

/// An imported body, reduced.
#[derive(Debug, Clone)]
pub struct ImportedModel {
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// Eigenfrequencies of the free body \[Hz\].
    pub frequencies: Vec<f64>,
    /// How many static answers there are to each marker's loads; the last of the coordinates.
    pub answers: Vec<(String, usize)>,
    markers: Vec<Marker>,
    points: Vec<(String, FlexiblePoint)>,
}

impl ImportedModel {
    /// Reduces the body called `name`, if that is not done yet, with static answers to `loads`.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the name; [`AdaptiveError::Unsupported`] for markers that do not exist.
    pub fn build(name: &str, spec: &ImportedSpec, loads: &StaticLoads) -> Result<Self, AdaptiveError> {
        let fail = |source: DynamicsError| AdaptiveError::Reduction { body: name.to_owned(), source };
        let (body, flexible) = match spec {
            ImportedSpec::Reduced(model) => {
                return Ok(Self {
                    data: model.data().clone(),
                    frequencies: model.frequencies().to_vec(),
                    markers: model.markers().to_vec(),
                    points: model.points().to_vec(),
                    answers: Vec::new(),
                });
            }
            ImportedSpec::Full { body, flexible } => (body, flexible),
        };
        let assembled = body.body();
        let weights = |marker: &str| {
            let known = body.markers().iter().map(|(n, _)| n.as_str());
            let found = body.markers().iter().find(|(n, _)| n == marker);
            found.map(|(_, w)| w).ok_or_else(|| no_marker(name, marker, known))
        };
        let basis = match flexible.reduction {
            ReductionSpec::All => all_modes(assembled),
            ReductionSpec::Modal { modes } | ReductionSpec::CraigBampton { modes, .. } => {
                let at = |place: &Place| weights(marker_name(name, place)?).cloned();
                let columns = load_columns(assembled, loads, at, fail)?;
                free_modes_answering(assembled, modes, &columns)
            }
        };
        let basis = basis.map_err(fail)?;
        let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
        let mut data = StandardInputData::new(assembled, basis.shapes.as_ref(), &stiffness).map_err(fail)?;
        data.modal_damping = damping(&flexible.damping, &stiffness, basis.first_static()).map_err(fail)?;
        let markers = body.markers().iter().map(|(n, w)| w.marker(n, basis.shapes.as_ref()));
        let mut markers = markers.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        let points = body.points().iter().map(|(n, w)| w.marker(n, basis.shapes.as_ref()));
        let mut points = points.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        if let FrameSpec::Tangent(place) = &flexible.frame {
            let marker = marker_name(name, place)?;
            let support = weights(marker)?.marker(marker, basis.shapes.as_ref()).map_err(fail)?;
            let tangent = support.tangent_frame(assembled.motion);
            data = data.in_tangent_frame(&tangent).map_err(fail)?;
            let shifted = markers.iter().map(|m| m.in_tangent_frame(&tangent));
            markers = shifted.collect::<Result<Vec<_>, _>>().map_err(fail)?;
            let shifted = points.iter().map(|m| m.in_tangent_frame(&tangent));
            points = shifted.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        }
        let frequencies = basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect();
        let points = points.iter().map(|m| (m.name.clone(), m.point())).collect();
        let answers = loads.answers(&basis.static_loads);
        Ok(Self { data, frequencies, markers, points, answers })
    }

    /// The body as a rigid one of unit mass with its markers in their places, for poses.
    ///
    /// # Errors
    /// As [`StandardInputData::rigid`].
    pub fn rigid(spec: &ImportedSpec) -> Result<Self, DynamicsError> {
        let data = StandardInputData::rigid(spec.motion(), 1.0, Vector3::zeros(), Matrix3::identity())?;
        let (markers, points) = match spec {
            ImportedSpec::Reduced(model) => {
                let marker = |m: &Marker| Marker::rigid(&m.name, m.position, m.rotation);
                let point = |(n, p): &(String, FlexiblePoint)| (n.clone(), FlexiblePoint::rigid(p.position));
                (model.markers().iter().map(marker).collect(), model.points().iter().map(point).collect())
            }
            ImportedSpec::Full { body, .. } => {
                let marker = |(n, w): &(String, MarkerWeights)| Marker::rigid(n, w.position(), w.rotation());
                let point =
                    |(n, w): &(String, MarkerWeights)| (n.clone(), FlexiblePoint::rigid(w.position()));
                (body.markers().iter().map(marker).collect(), body.points().iter().map(point).collect())
            }
        };
        Ok(Self { data, frequencies: Vec::new(), markers, points, answers: Vec::new() })
    }

    /// The markers, in the order of the file.
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// The point called `name` in the file, of the body called `body`.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if there is none.
    pub fn point(&self, body: &str, place: &Place) -> Result<FlexiblePoint, AdaptiveError> {
        let name = marker_name(body, place)?;
        if let Some((_, point)) = self.points.iter().find(|(n, _)| n == name) {
            return Ok(point.clone());
        }
        self.find(body, name).map(Marker::point)
    }

    /// The marker at `place`, of the body called `body`, with axes turned by `rotation` from the
    /// body's.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if there is none.
    pub fn marker(
        &self,
        body: &str,
        name: &str,
        place: &Place,
        rotation: UnitQuaternion<f64>,
    ) -> Result<Marker, AdaptiveError> {
        let mut found = self.find(body, marker_name(body, place)?)?.clone();
        (found.name, found.rotation) = (name.to_owned(), rotation);
        Ok(found)
    }

    fn find(&self, body: &str, name: &str) -> Result<&Marker, AdaptiveError> {
        let known = self.markers.iter().map(|m| m.name.as_str());
        let known = known.chain(self.points.iter().map(|(n, _)| n.as_str()));
        self.markers.iter().find(|m| m.name == name).ok_or_else(|| no_marker(body, name, known))
    }
}

fn marker_name<'a>(body: &str, place: &'a Place) -> Result<&'a str, AdaptiveError> {
    match place {
        Place::Marker(name) => Ok(name),
        Place::Point(_) | Place::Area(_) => Err(AdaptiveError::unsupported_body(
            body,
            "places on a body from a file are named by markers of the file".into(),
        )),
    }
}

fn no_marker<'a>(body: &str, marker: &str, known: impl Iterator<Item = &'a str>) -> AdaptiveError {
    let known: Vec<&str> = known.collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let marker = marker.to_owned();
    AdaptiveError::unsupported_body(body, AdaptiveError::no_marker("file", &marker, &known))
}
