//! Bodies that come from elsewhere or go elsewhere, as plain checked values (docs/body-file.md).
//!
//! No file format: whoever reads or writes files fills or empties these. Values taken out and put
//! in again are the same bit by bit.

use std::collections::HashSet;

use crate::DynamicsError;
use crate::body::{AssembledBody, DataParts, StandardInputData};
use crate::data_error::DataError;
use crate::kinematics::{FlexiblePoint, Marker, MarkerWeights};
use crate::reduction::{Pencil, RigidModes};

/// An unreduced body with its markers.
#[derive(Debug, Clone)]
pub struct FullBody {
    body: AssembledBody,
    markers: Vec<(String, MarkerWeights)>,
    points: Vec<(String, MarkerWeights)>,
}

impl FullBody {
    /// Checks matrices, unknowns, rigid motions and markers.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] with what does not fit, [`DynamicsError::DuplicateName`] for markers.
    pub fn new(body: AssembledBody, markers: Vec<(String, MarkerWeights)>) -> Result<Self, DynamicsError> {
        Pencil::new(&body, &[])?;
        RigidModes::new(&body)?;
        check_names(markers.iter().map(|(name, _)| name.as_str()))?;
        for (name, marker) in &markers {
            marker.check_rigid_motions(&body).map_err(|e| e.in_part(format!("marker \"{name}\"")))?;
        }
        Ok(Self { body, markers, points: Vec::new() })
    }

    /// The same with points for output, whose rotations do not count.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] for a point that does not follow rigid motions, [`DynamicsError::DuplicateName`].
    pub fn with_points(self, points: Vec<(String, MarkerWeights)>) -> Result<Self, DynamicsError> {
        check_names(points.iter().map(|(name, _)| name.as_str()))?;
        for (name, point) in &points {
            point
                .check_rigid_displacements(&self.body)
                .map_err(|e| e.in_part(format!("point \"{name}\"")))?;
        }
        Ok(Self { points, ..self })
    }

    /// The body.
    pub fn body(&self) -> &AssembledBody {
        &self.body
    }

    /// Its markers by name.
    pub fn markers(&self) -> &[(String, MarkerWeights)] {
        &self.markers
    }

    /// Its points for output by name.
    pub fn points(&self) -> &[(String, MarkerWeights)] {
        &self.points
    }
}

/// Reference frame of a reduced body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BodyFrame {
    /// Mean axes: the modes carry no momentum.
    Buckens,
    /// The frame follows the marker of this name.
    Tangent {
        /// Name of the marker.
        marker: String,
    },
    /// Another one, or not known.
    Other,
}

/// A reduced body with all that the equations of motion need.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedModel {
    name: String,
    frame: BodyFrame,
    data: StandardInputData,
    frequencies: Vec<f64>,
    markers: Vec<Marker>,
    points: Vec<(String, FlexiblePoint)>,
}

/// The parts of a [`ReducedModel`].
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedParts {
    /// Name for messages.
    pub name: String,
    /// Reference frame of modes, markers and points.
    pub frame: BodyFrame,
    /// Standard input data.
    pub data: DataParts,
    /// Eigenfrequencies of the free body, one per mode \[Hz\].
    pub frequencies: Vec<f64>,
    /// Markers.
    pub markers: Vec<Marker>,
    /// Points for output and contact, by name.
    pub points: Vec<(String, FlexiblePoint)>,
}

impl ReducedModel {
    /// Checks everything.
    ///
    /// # Errors
    /// As [`StandardInputData::from_parts`]; [`DynamicsError::Data`] if markers, points or
    /// frequencies do not fit the modes, or the frame's marker is missing or moves;
    /// [`DynamicsError::DuplicateName`].
    pub fn new(parts: ReducedParts) -> Result<Self, DynamicsError> {
        let ReducedParts { name, frame, data, frequencies, markers, points } = parts;
        let data = StandardInputData::from_parts(data)?;
        let n = data.n_modes();
        if frequencies.len() != n {
            let (what, found) = ("eigenfrequencies of the modes".into(), frequencies.len());
            return Err(DataError::Count { what, found, expected: n }.into());
        }
        if let Some(&value) = frequencies.iter().find(|f| !(**f > 0.0 && f.is_finite())) {
            let what = "an eigenfrequency [Hz]".into();
            return Err(DataError::OutOfRange { what, value, range: "> 0 and finite" }.into());
        }
        check_names(markers.iter().map(|m| m.name.as_str()))?;
        check_names(points.iter().map(|(name, _)| name.as_str()))?;
        let sizes = markers
            .iter()
            .map(|m| ("marker", &m.name, m.n_modes()))
            .chain(points.iter().map(|(name, p)| ("point", name, p.shapes.len())));
        for (kind, name, found) in sizes {
            if found != n && found != 0 {
                let what = format!("modes of {kind} \"{name}\"");
                return Err(DataError::Count { what, found, expected: n }.into());
            }
        }
        let is_finite =
            |p: &FlexiblePoint| p.shapes.iter().chain([&p.position]).flatten().all(|v| v.is_finite());
        if let Some((name, _)) = points.iter().find(|(_, p)| !is_finite(p)) {
            let what = format!("position or mode shape of point \"{name}\"");
            return Err(DataError::NotFinite { what }.into());
        }
        if let BodyFrame::Tangent { marker } = &frame {
            let limit = STILL / data.mass.sqrt() * (1.0 + n as f64).sqrt();
            let fault = match markers.iter().find(|m| m.name == *marker) {
                None => Some("which the body does not have"),
                Some(m) if !m.is_still_within(limit) => Some("which the modes move"),
                Some(_) => None,
            };
            if let Some(fault) = fault {
                return Err(DataError::FrameMarker { marker: marker.clone(), fault }.into());
            }
        }
        Ok(Self { name, frame, data, frequencies, markers, points })
    }

    /// The parts, of which [`ReducedModel::new`] makes the same again.
    pub fn to_parts(&self) -> ReducedParts {
        ReducedParts {
            name: self.name.clone(),
            frame: self.frame.clone(),
            data: self.data.to_parts(),
            frequencies: self.frequencies.clone(),
            markers: self.markers.clone(),
            points: self.points.clone(),
        }
    }

    /// Name for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reference frame.
    pub fn frame(&self) -> &BodyFrame {
        &self.frame
    }

    /// Standard input data.
    pub fn data(&self) -> &StandardInputData {
        &self.data
    }

    /// Eigenfrequencies of the free body \[Hz\].
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    /// Markers.
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// Points by name.
    pub fn points(&self) -> &[(String, FlexiblePoint)] {
        &self.points
    }
}

/// Share of the size of a mode, `1/√mass`, by which the marker of a tangent frame may move:
/// round-off of the shift.
const STILL: f64 = 1e-9;

fn check_names<'a>(names: impl Iterator<Item = &'a str>) -> Result<(), DynamicsError> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(DynamicsError::DuplicateName {
                what: "markers or points of a body",
                name: name.to_string(),
            });
        }
    }
    Ok(())
}
