//! The validated scenario: the specification of a run, and what belongs to the file that it came
//! from.

use std::path::PathBuf;

use adaptive::sizing::SizeRequest;
use adaptive::spec::{Area, RunSpec};

use super::body_places::BodyPlaces;

/// A scenario that has passed every check.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Title for reports; may be empty.
    pub title: String,
    /// What is simulated. Of sizes that the program has yet to choose it has some that do.
    pub run: RunSpec,
    /// Sizes that the program has yet to choose, one entry per body of the run (see
    /// [`crate::simulate::sizing`]).
    pub wishes: Vec<SizeRequest>,
    /// Bodies in the order of the file, planes at rest among them.
    pub bodies: Vec<FileBody>,
    /// Factor on the permitted errors of steps, which is in force in the settings of the run
    /// already.
    pub tolerance_factor: f64,
    /// Compression of the result file.
    pub compression: Compression,
    /// Whether the motion of all bodies is stored in datasets that they share; none where their number decides.
    pub arrays: Option<bool>,
    /// What may be meant otherwise than it is read, a sentence each.
    pub doubts: Vec<String>,
    /// Where the scenario comes from.
    pub source: Source,
    /// Files that it names, each with what it is.
    pub files: Vec<(PathBuf, String)>,
}

impl Scenario {
    /// The body called `name`, if there is one.
    pub fn body(&self, name: &str) -> Option<&FileBody> {
        self.bodies.iter().find(|body| body.name == name)
    }

    /// Parts of body `name` that can be held, by name: markers with an extent and the faces of the
    /// shape; none of an unknown body.
    pub fn areas(&self, name: &str) -> Vec<(String, Area)> {
        self.body(name).map(|body| body.places.areas()).unwrap_or_default()
    }

    /// Named points of the body `name`, in the components of its model \[m\].
    pub fn points(&self, name: &str) -> Vec<(String, [f64; 3])> {
        let points = self.body(name).map(|body| body.places.points());
        points.into_iter().flatten().map(|(name, at)| (name.clone(), *at)).collect()
    }
}

/// A body of the scenario file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileBody {
    /// Name.
    pub name: String,
    /// Number among the bodies of the run; none of a plane at rest, which is no body there.
    pub index: Option<usize>,
    /// Its named places.
    pub places: BodyPlaces,
    /// The body file that it comes from, if it does.
    pub file: Option<FileOfBody>,
}

/// A body file as a scenario names it.
#[derive(Debug, Clone, PartialEq)]
pub struct FileOfBody {
    /// The file, found from the directory of the scenario.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Unit of length of a mesh \[m\], 1 of a body file.
    pub unit: f64,
}

/// Origin of a scenario, stored in the result.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// The file as named on the command line.
    pub path: PathBuf,
    /// SHA-256 of the file as read, in hexadecimal.
    pub sha256: String,
    /// SHA-256 of what the result follows from, in hexadecimal: the scenario with overrides and defaults, before sizes are chosen,
    /// with numbers or checksums of the files that it names, and the program.
    pub inputs_sha256: String,
    /// The scenario with overrides applied and defaults filled in, as TOML that reads back to the
    /// same scenario.
    pub resolved: String,
}

/// Compression of datasets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compression {
    /// None.
    None,
    /// Shuffle and gzip level 1.
    Gzip,
}
