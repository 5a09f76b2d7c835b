//! States of a result: motion of every body at the stored instants.

use adaptive::record::TransferDirection;
use std::path::{Path, PathBuf};

use ffr_dynamics::force::BodyState;
use hdf5::Result;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use result_files::file::fault::FileFault;
use result_files::file::hdf5_integrity;
use result_files::stored::impacts::impacts;
use result_files::stored::members::Members;
use result_files::stored::open::{open, scenario_text};
use result_files::stored::pressure_series::PressureSeries;
use result_files::tables::{ACCEPTED, PhaseRow, TableRow, TransferRow, TrialRow};

use super::zones::Span;
use crate::error::AppError;
use crate::results::rows;
use crate::scenario::{self, Scenario};

/// Motion of a body's reference frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Its origin \[m\].
    pub position: Vector3<f64>,
    /// From the body to space.
    pub rotation: Matrix3<f64>,
    /// Velocity of the origin [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity in space [rad/s].
    pub angular_velocity: Vector3<f64>,
}

/// Motion of a body over time.
#[derive(Debug, Clone, Default)]
pub struct BodyMotion {
    position: Vec<f64>,
    rotation: Vec<f64>,
    velocity: Vec<f64>,
    angular_velocity: Vec<f64>,
    elastic: Vec<f64>,
    rates: Vec<f64>,
    /// Eigenfrequencies of the coordinates \[Hz\].
    pub eigenfrequencies: Vec<f64>,
}

/// A contact over time.
#[derive(Debug, Clone, Default)]
pub struct ContactSeries {
    /// Total normal force \[N\].
    pub normal_force: Vec<f64>,
    /// Penalty factor [N/m³].
    pub penalty: Vec<f64>,
}

/// A result as far as the motion of its bodies needs it.
#[derive(Debug, Clone)]
pub struct States {
    /// The scenario that was run.
    pub scenario: Scenario,
    /// Stored instants \[s\].
    pub time: Vec<f64>,
    bodies: Members,
    file: PathBuf,
}

impl States {
    /// Opens a result.
    ///
    /// # Errors
    /// [`AppError::Io`] if it cannot be read, [`AppError::Scenario`] if its scenario is no longer valid, for instance because a body
    /// file is gone.
    pub fn read(path: &Path) -> std::result::Result<Self, AppError> {
        let file = open(path)?;
        let fail = |e: hdf5::Error| AppError::io(path, FileFault::part(e));
        let text = scenario_text(&file).map_err(fail)?;
        let source: Option<hdf5::types::VarLenUnicode> =
            file.dataset("scenario").and_then(|d| d.attr("file")?.read_scalar()).ok();
        // Body files are sought beside the scenario; where it is gone, as in results that were
        // moved, beside the result.
        let named = source.map(|s| PathBuf::from(s.as_str())).filter(|source| source.exists());
        let source = named.unwrap_or_else(|| path.with_extension("toml"));
        let scenario = scenario::parse(&source, text.as_bytes(), &[])?;
        let time: Vec<f64> = file.dataset("time").and_then(|d| hdf5_integrity::rows(&d)).map_err(fail)?;
        if time.is_empty() {
            return Err(AppError::io(path, "has no stored states"));
        }
        let bodies = Members::of(&file, "bodies").map_err(fail)?;
        Ok(Self { scenario, time, bodies, file: path.to_owned() })
    }

    /// The error of something in the file that HDF5 cannot read.
    fn unreadable(&self, what: String, source: hdf5::Error) -> AppError {
        AppError::io(&self.file, FileFault::Hdf5 { what: format!("has no readable {what}").into(), source })
    }

    /// Motion of body `name`.
    ///
    /// # Errors
    /// [`AppError::Io`] if it is not stored completely.
    pub fn motion(&self, name: &str) -> std::result::Result<BodyMotion, AppError> {
        let fail = |source| self.unreadable(format!("motion of body \"{name}\""), source);
        let bodies = &self.bodies;
        if bodies.has(name, "eigenfrequencies") && !bodies.has(name, "elastic_coordinates") {
            let reason = format!(
                "is a small copy without the deformation of body \"{name}\", name the result that it was made from"
            );
            return Err(AppError::io(&self.file, reason));
        }
        let motion = motion(bodies, name).map_err(fail)?;
        let n = self.time.len();
        let is_short = |values: &[f64], width: usize| values.len() < n * width;
        let q = motion.eigenfrequencies.len();
        if is_short(&motion.position, 3)
            || is_short(&motion.rotation, 4)
            || is_short(&motion.velocity, 3)
            || is_short(&motion.angular_velocity, 3)
            || is_short(&motion.elastic, q)
            || is_short(&motion.rates, q)
        {
            return Err(AppError::io(
                &self.file,
                format!("has fewer states of body \"{name}\" than instants"),
            ));
        }
        Ok(motion)
    }

    /// Number of the phase of every instant, and the phases as far as they were reported.
    ///
    /// # Errors
    /// [`AppError::Io`] if they cannot be read.
    pub fn phases(&self) -> std::result::Result<(Vec<u32>, Vec<PhaseRow>), AppError> {
        let file = open(&self.file)?;
        let read = || {
            let numbers: Vec<u32> = hdf5_integrity::rows(&file.dataset("phase")?)?;
            Ok((numbers, hdf5_integrity::rows(&file.dataset("phases")?)?))
        };
        let (numbers, phases) = read().map_err(|source| self.unreadable("phases".into(), source))?;
        if numbers.len() < self.time.len() {
            return Err(AppError::io(&self.file, "has no readable phases: there are fewer than instants"));
        }
        Ok((numbers, phases))
    }

    /// Times at which the forces of the impacts are largest, in the order of the impacts \[s\].
    ///
    /// # Errors
    /// [`AppError::Io`] if the table of impacts cannot be read.
    pub fn peaks(&self) -> std::result::Result<Vec<f64>, AppError> {
        let rows =
            impacts(&open(&self.file)?).map_err(|source| self.unreadable("/impacts".into(), source))?;
        Ok(rows.iter().map(|row| row.peak_time).collect())
    }

    /// Unknowns of the models that the contact zones of each impact had in the trial that is the result, in the
    /// order of the impacts; zero where none was refined.
    ///
    /// # Errors
    /// [`AppError::Io`] if the tables of impacts and trials cannot be read.
    pub fn zone_unknowns(&self) -> std::result::Result<Vec<u64>, AppError> {
        let file = open(&self.file)?;
        let read = || {
            let mut all = vec![0; impacts(&file)?.len()];
            if file.link_exists(TrialRow::NAME) {
                let rows: Vec<TrialRow> = hdf5_integrity::rows(&file.dataset(TrialRow::NAME)?)?;
                for row in rows.iter().filter(|row| row.outcome.as_str() == ACCEPTED) {
                    all.get_mut(row.impact as usize).into_iter().for_each(|sum| *sum += row.dofs);
                }
            }
            Ok(all)
        };
        read().map_err(|source| self.unreadable("/tries".into(), source))
    }

    /// Force and penalty factor of contact `name`; none if they are not stored.
    pub fn contact(&self, name: &str) -> Option<ContactSeries> {
        let group = open(&self.file).ok()?.group(&format!("contacts/{name}")).ok()?;
        let read = |dataset: &str| group.dataset(dataset).and_then(|d| hdf5_integrity::rows::<f64>(&d)).ok();
        Some(ContactSeries { normal_force: read("normal_force")?, penalty: read("penalty")? })
            .filter(|c| c.normal_force.len() >= self.time.len() && c.penalty.len() >= self.time.len())
    }

    /// When contacts had fine models, and where; none in results of versions that did not store it.
    ///
    /// # Errors
    /// [`AppError::Io`] if the table of model changes cannot be read.
    pub fn spans(&self) -> std::result::Result<Vec<Span>, AppError> {
        let file = open(&self.file)?;
        if !file.link_exists("transfers") {
            return Ok(Vec::new());
        }
        let rows: Vec<TransferRow> = file
            .dataset("transfers")
            .and_then(|d| hdf5_integrity::rows(&d))
            .map_err(|source| self.unreadable("/transfers".into(), source))?;
        let mut spans: Vec<Span> = Vec::new();
        for row in &rows {
            let (contact, sites) = (row.contact.as_str(), rows::sites(row));
            if sites[0].is_some() {
                let contact = contact.to_owned();
                let (offset, from) = (row.offset, row.time);
                spans.push(Span { contact, sites, offset, from, to: f64::INFINITY });
            } else if row.direction.as_str() == TransferDirection::FineToCoarse.identifier()
                && let Some(span) = spans.iter_mut().rfind(|s| s.contact == contact)
            {
                span.to = row.time;
            }
        }
        Ok(spans)
    }

    /// Pressures of contact `name`; none if there are none, as in contacts that know no points.
    ///
    /// # Errors
    /// [`AppError::Io`] if they cannot be read or do not fit together.
    pub fn pressures(&self, name: &str) -> std::result::Result<Option<PressureSeries>, AppError> {
        let file = open(&self.file)?;
        let stored = PressureSeries::read(&file, name)
            .map_err(|source| self.unreadable(format!("pressures of contact \"{name}\""), source))?;
        if stored.as_ref().is_some_and(|series| !series.is_whole(self.time.len())) {
            let reason =
                format!("has no readable pressures of contact \"{name}\": their lengths do not fit together");
            return Err(AppError::io(&self.file, reason));
        }
        Ok(stored.filter(|series| !series.point.is_empty()))
    }
}

fn motion(bodies: &Members, body: &str) -> Result<BodyMotion> {
    let read = |series: &str| bodies.rows(body, series);
    // Rigid bodies have no coordinates.
    let elastic = |series: &str| if bodies.has(body, series) { read(series) } else { Ok(Vec::new()) };
    Ok(BodyMotion {
        position: read("position")?,
        rotation: read("rotation")?,
        velocity: read("velocity")?,
        angular_velocity: read("angular_velocity")?,
        elastic: elastic("elastic_coordinates")?,
        rates: elastic("elastic_velocities")?,
        eigenfrequencies: elastic("eigenfrequencies")?,
    })
}

impl BodyMotion {
    /// Rotation at instant `i`.
    pub fn rotation(&self, i: usize) -> UnitQuaternion<f64> {
        let q = &self.rotation[4 * i..4 * i + 4];
        UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]))
    }

    /// Motion of the frame at instant `i`.
    pub fn pose(&self, i: usize) -> Pose {
        let vector = |values: &[f64]| Vector3::from_column_slice(&values[3 * i..3 * i + 3]);
        Pose {
            position: vector(&self.position),
            rotation: self.rotation(i).to_rotation_matrix().into_inner(),
            velocity: vector(&self.velocity),
            angular_velocity: vector(&self.angular_velocity),
        }
    }

    /// State of the body at instant `i`.
    pub fn state(&self, i: usize) -> BodyState {
        let (pose, rotation) = (self.pose(i), self.rotation(i));
        BodyState {
            position: pose.position,
            rotation,
            velocity: pose.velocity,
            angular_velocity_in_body: rotation.inverse() * pose.angular_velocity,
            elastic: self.elastic(i).to_vec(),
            elastic_rates: self.rates(i).to_vec(),
        }
    }

    /// Elastic coordinates at instant `i`.
    pub fn elastic(&self, i: usize) -> &[f64] {
        let n = self.eigenfrequencies.len();
        &self.elastic[n * i..n * (i + 1)]
    }

    /// Their rates.
    pub fn rates(&self, i: usize) -> &[f64] {
        let n = self.eigenfrequencies.len();
        &self.rates[n * i..n * (i + 1)]
    }
}
