//! Contact pressures of a stored result.

use std::ops::Range;

use hdf5::{File, Result};

use crate::file::hdf5_integrity;

/// Declaration of a dataset: name, unit, one sentence.
type Declaration = (&'static str, &'static str, &'static str);

/// Undeformed points.
pub const POSITION: Declaration = (
    "position",
    "m",
    "Undeformed contact points that were under pressure at a stored instant, in the frame of the contact body.",
);
/// Their areas.
pub const AREA: Declaration =
    ("area", "m²", "Tributary area of each of these points; of the whole ring in axisymmetric models.");
/// Which of them.
pub const POINT: Declaration = (
    "point",
    "–",
    "Index into `position` of each loaded point; instant after instant, `pressure_points` of /contacts/NAME each.",
);
/// What it carries.
pub const PRESSURE: Declaration = (
    "pressure",
    "Pa",
    "Mean contact pressure about the point (theory C.49, C.50): times area and summed over an instant, the normal force.",
);

/// Name in its group of the number of loaded points per instant.
pub const COUNT: &str = "pressure_points";

/// Contact pressures over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PressureSeries {
    /// First entry of each instant, and the end of the last one.
    first: Vec<usize>,
    /// Undeformed points in the frame of the contact body \[m\].
    pub position: Vec<[f64; 3]>,
    /// Their areas \[m²\].
    pub area: Vec<f64>,
    /// Entries: index of a point.
    pub point: Vec<u32>,
    /// Entries: its pressure \[Pa\].
    pub pressure: Vec<f64>,
}

impl PressureSeries {
    /// Reads the pressures of contact `name`; none where none are stored, as in contacts that know
    /// no points.
    ///
    /// # Errors
    /// Those of HDF5.
    pub fn read(file: &File, name: &str) -> Result<Option<Self>> {
        if !file.link_exists("pressure") || !file.group("pressure").is_ok_and(|g| g.link_exists(name)) {
            return Ok(None);
        }
        let group = file.group(&format!("pressure/{name}"))?;
        let counts: Vec<u32> = hdf5_integrity::rows(&file.dataset(&format!("contacts/{name}/{COUNT}"))?)?;
        let mut first = vec![0];
        let mut end = 0_usize;
        for n in counts {
            end = end.saturating_add(n as usize);
            first.push(end);
        }
        let position: Vec<f64> = hdf5_integrity::rows(&group.dataset(POSITION.0)?)?;
        Ok(Some(Self {
            first,
            position: position.as_chunks::<3>().0.to_vec(),
            area: hdf5_integrity::rows(&group.dataset(AREA.0)?)?,
            point: hdf5_integrity::rows(&group.dataset(POINT.0)?)?,
            pressure: hdf5_integrity::rows(&group.dataset(PRESSURE.0)?)?,
        }))
    }

    /// Entries of instant `i`.
    pub fn range(&self, i: usize) -> Range<usize> {
        self.first[i]..self.first[i + 1]
    }

    /// Leaves the instants `instants`.
    pub fn cut(&mut self, instants: Range<usize>) {
        self.first.truncate(instants.end + 1);
        self.first.drain(..instants.start.min(self.first.len()));
    }

    /// Whether `n` instants and all indices are there.
    pub fn is_whole(&self, n: usize) -> bool {
        let n_points = self.position.len();
        self.first.len() > n
            && self.first.last().is_some_and(|end| *end <= self.point.len())
            && self.point.len() <= self.pressure.len()
            && n_points <= self.area.len()
            && self.point.iter().all(|p| (*p as usize) < n_points)
    }
}
