//! Bodies from files: reduced ones as they are, matrices of other programs reduced here.

use std::sync::Arc;

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::interchange::{FullBody, ReducedModel};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use ffr_dynamics::reduction::craig_bampton::{FixedInterfaceModes, craig_bampton};
use ffr_dynamics::reduction::modal::{all_modes, modal_truncation};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::elastic_body::damping;
use crate::error::AdaptiveError;
use crate::spec::{DampingSpec, Place, ReductionSpec};

/// A body from a file.
#[derive(Debug, Clone)]
pub enum ImportedSpec {
    /// Reduced already.
    Reduced(Arc<ReducedModel>),
    /// Matrices, to be reduced.
    Full {
        /// Matrices and markers.
        body: Arc<FullBody>,
        /// Reduced basis.
        reduction: ReductionSpec,
        /// Markers of joints whose forces a Craig-Bampton basis answers statically right.
        interface: Vec<String>,
        /// Damping of the elastic coordinates.
        damping: DampingSpec,
        /// Marker that a tangent frame follows; a Buckens frame without one.
        frame: Option<String>,
    },
}

impl PartialEq for ImportedSpec {
    /// Whether both are the same body in memory, reduced alike.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Reduced(a), Self::Reduced(b)) => Arc::ptr_eq(a, b),
            (
                Self::Full { body: a, reduction: r, interface: i, damping: d, frame: f },
                Self::Full { body, reduction, interface, damping, frame },
            ) => Arc::ptr_eq(a, body) && (r, i, d, f) == (reduction, interface, damping, frame),
            _ => false,
        }
    }
}

impl ImportedSpec {
    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Reduced(model) => model.data().motion,
            Self::Full { body, .. } => body.body().motion,
        }
    }
}

/// An imported body, reduced.
#[derive(Debug, Clone)]
pub struct ImportedModel {
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// Eigenfrequencies of the free body \[Hz\].
    pub frequencies: Vec<f64>,
    markers: Vec<Marker>,
    points: Vec<(String, FlexiblePoint)>,
}

impl ImportedModel {
    /// Reduces the body called `name`, if that is not done yet.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the name; [`AdaptiveError::Unsupported`] for markers that do not exist.
    pub fn build(name: &str, spec: &ImportedSpec) -> Result<Self, AdaptiveError> {
        let fail = |source: DynamicsError| AdaptiveError::Reduction { body: name.to_owned(), source };
        let (body, reduction, interface, damped, frame) = match spec {
            ImportedSpec::Reduced(model) => {
                return Ok(Self {
                    data: model.data().clone(),
                    frequencies: model.frequencies().to_vec(),
                    markers: model.markers().to_vec(),
                    points: model.points().to_vec(),
                });
            }
            ImportedSpec::Full { body, reduction, interface, damping, frame } => {
                (body, *reduction, interface, damping, frame)
            }
        };
        let assembled = body.body();
        let weights = |marker: &str| {
            let known = body.markers().iter().map(|(n, _)| n.as_str());
            let found = body.markers().iter().find(|(n, _)| n == marker);
            found.map(|(_, w)| w).ok_or_else(|| no_marker(name, marker, known))
        };
        let mut unknowns = Vec::new();
        for marker in interface {
            unknowns.extend(weights(marker)?.entries().iter().map(|(unknown, _)| *unknown as usize));
        }
        unknowns.sort_unstable();
        unknowns.dedup();
        let basis = match reduction {
            ReductionSpec::All => all_modes(assembled),
            ReductionSpec::CraigBampton { modes, fixed_interface_modes } if !unknowns.is_empty() => {
                let count =
                    fixed_interface_modes.map_or(FixedInterfaceModes::Checked, FixedInterfaceModes::Exactly);
                craig_bampton(assembled, &unknowns, modes, count).map(|cb| cb.basis)
            }
            ReductionSpec::Modal { modes } | ReductionSpec::CraigBampton { modes, .. } => {
                modal_truncation(assembled, modes)
            }
        };
        let basis = basis.map_err(fail)?;
        let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
        let mut data = StandardInputData::new(assembled, basis.shapes.as_ref(), &stiffness).map_err(fail)?;
        data.modal_damping = damping(damped, &stiffness).map_err(fail)?;
        let markers = body.markers().iter().map(|(n, w)| w.marker(n, basis.shapes.as_ref()));
        let mut markers = markers.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        let points = body.points().iter().map(|(n, w)| w.marker(n, basis.shapes.as_ref()));
        let mut points = points.collect::<Result<Vec<_>, _>>().map_err(fail)?;
        if let Some(marker) = frame {
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
        Ok(Self { data, frequencies, markers, points })
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
        Ok(Self { data, frequencies: Vec::new(), markers, points })
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

    /// The marker at `place`, of the body called `body`, with axes turned by `rotation` from the body's.
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
        Place::Point(_) | Place::Area(_) => Err(AdaptiveError::Unsupported {
            subject: format!("body \"{body}\""),
            reason: "places on a body from a file are named by markers of the file".into(),
        }),
    }
}

fn no_marker<'a>(body: &str, marker: &str, known: impl Iterator<Item = &'a str>) -> AdaptiveError {
    let known: Vec<&str> = known.collect();
    let list = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    AdaptiveError::Unsupported {
        subject: format!("body \"{body}\""),
        reason: format!("the file has no marker \"{marker}\", it has {list}"),
    }
}
