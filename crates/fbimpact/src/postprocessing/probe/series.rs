//! Motion, strain and stress of points at the stored instants.

use std::ops::Range;

use adaptive::body::point_compliance::PointCompliance;
use adaptive::impact::ZoneModel;
use adaptive::impact::local_deformation::LocalDeformation;
use adaptive::model::RunModel;
use adaptive::record::{PhaseKind, PointSample};
use adaptive::state::simulation::ObservedPoint;
use adaptive::store::ModelCache;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::elasticity::kinematics::PointState;
use nalgebra::Vector3;
use result_files::tables::PhaseRow;

use super::places::WantedPoint;
use crate::error::AppError;
use crate::postprocessing::replay::local::LeftOut;
use crate::postprocessing::replay::rebuilt::Rebuilt;
use crate::postprocessing::replay::states::States;
use crate::scenario::FileBody;

/// A point at a stored instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PointInstant {
    /// Place of the material point \[m\].
    pub position: Vector3<f64>,
    /// From its place at the first stored instant \[m\].
    pub displacement: Vector3<f64>,
    /// Velocity [m/s].
    pub velocity: Vector3<f64>,
    /// Elastic displacement, in the axes of the body's frame \[m\].
    pub deformation: Vector3<f64>,
    /// Strain and stress in the same axes.
    pub state: PointState,
}

/// A point over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointSeries {
    /// What tables call it.
    pub label: String,
    /// Undeformed place in the body's frame \[m\].
    pub place: [f64; 3],
    /// Whether there are strain and stress.
    pub has_gauge: bool,
    /// The instants.
    pub instants: Vec<PointInstant>,
}

/// What makes histories of points from a result.
pub struct Probe<'a> {
    states: &'a States,
    rebuilt: Rebuilt<Vec<PointCompliance>>,
    body: usize,
    labels: Vec<String>,
    lasting: Vec<PointCompliance>,
    phase_of: Vec<u32>,
    phases: Vec<PhaseRow>,
    first: Vec<Vector3<f64>>,
}

impl<'a> Probe<'a> {
    /// The points `wanted` of `body`, with models built again on so many threads.
    ///
    /// # Errors
    /// [`AppError::Command`] for a place that there is not, those of [`Rebuilt::new`].
    pub fn new(
        states: &'a States,
        (body, wanted): (&FileBody, &[WantedPoint]),
        threads: usize,
        cache: &ModelCache,
    ) -> Result<Self, AppError> {
        let rows = |model: &RunModel, body: usize, zone: &ZoneModel| {
            zone.compliances(&model.observed.points, body).map_err(AppError::model)
        };
        let mut rebuilt = Rebuilt::new(states, threads, cache, Box::new(rows))?;
        let number = body.index.unwrap_or_default();
        let points = wanted.iter().map(|point| point.observed(body, (number, &rebuilt.model)));
        rebuilt.model.observed.points = points.collect::<Result<Vec<ObservedPoint>, AppError>>()?;
        let lasting = rebuilt.model.lasting_local_deformation().map_err(AppError::model)?;
        let (phase_of, phases) = states.phases()?;
        let mut probe = Self {
            states,
            rebuilt,
            body: number,
            labels: wanted.iter().map(WantedPoint::label).collect(),
            lasting,
            phase_of,
            phases,
            first: Vec::new(),
        };
        probe.first = probe.samples(0..1)?[0].iter().map(|s| Vector3::from(s.position)).collect();
        Ok(probe)
    }

    /// Motions that body `number` can make.
    pub fn motion(&self, number: usize) -> RigidMotion {
        self.rebuilt.model.bodies[number].data.motion
    }

    /// Contacts of the body whose zones are not solved again.
    pub fn left_out(&self) -> Vec<LeftOut> {
        self.rebuilt.left_out(&[self.body])
    }

    /// Instants at which a contact zone could not be solved again.
    pub fn deviations(&self) -> usize {
        self.rebuilt.contacts.deviations
    }

    /// The points at the instants `range`.
    ///
    /// # Errors
    /// [`AppError::Model`] if a fine model of the run cannot be built again.
    pub fn series(&mut self, range: Range<usize>) -> Result<Vec<PointSeries>, AppError> {
        let rows = self.samples(range.clone())?;
        let motion = &self.rebuilt.motions[self.body];
        let series = |(k, point): (usize, &ObservedPoint)| {
            let instant = |(i, row): (usize, &Vec<PointSample>)| {
                let (sample, state) = (&row[k], motion.state(i));
                let position = Vector3::from(sample.position);
                let in_body = state.rotation.inverse() * (position - state.position);
                PointInstant {
                    position,
                    displacement: position - self.first[k],
                    velocity: Vector3::from(sample.velocity),
                    deformation: in_body - point.point.position,
                    state: sample.state,
                }
            };
            PointSeries {
                label: self.labels[k].clone(),
                place: point.point.position.into(),
                has_gauge: point.gauge.is_some(),
                instants: range.clone().zip(&rows).map(instant).collect(),
            }
        };
        Ok(self.rebuilt.model.observed.points.iter().enumerate().map(series).collect())
    }

    /// What the run would have recorded of the points at the instants `range`. Instants before it
    /// in the same phase tell the velocity of the local deformation (theory Eq. Q.6).
    fn samples(&mut self, range: Range<usize>) -> Result<Vec<Vec<PointSample>>, AppError> {
        let is_of_phase = |i: usize, other: usize| self.phase_of[i] == self.phase_of[other];
        let begin = (range.start.saturating_sub(2)..=range.start).find(|i| is_of_phase(*i, range.start));
        let begin = begin.unwrap_or(range.start);
        let n_points = self.rebuilt.model.observed.points.len();
        let mut deformation = LocalDeformation::default();
        let mut rows = Vec::with_capacity(range.len());
        for i in begin..range.end {
            let time = self.states.time[i];
            let is_first = i == 0 || self.phase_of[i] != self.phase_of[i - 1];
            let phase = self.phases.get(self.phase_of[i] as usize);
            let impact = phase.filter(|phase| phase.kind.as_str() != PhaseKind::Free.identifier());
            match impact {
                // Outside of impacts no contact force acts.
                None => deformation.begin(time, n_points),
                Some(phase) if is_first => deformation.begin(phase.start, n_points),
                Some(_) if i == begin => deformation.begin(time, n_points),
                Some(_) => {}
            }
            let Rebuilt { model, motions, contacts } = &mut self.rebuilt;
            let forces = contacts.forces(model, motions, time, i)?;
            let own = self.lasting.iter().map(|point| (point, &forces.own[point.body][..]));
            let on_zones = forces.zones.iter().flat_map(|load| {
                let zone = &contacts.zones.of_contact(load.contact)[load.zone];
                zone.view.iter().map(|point| (point, &load.forces[..]))
            });
            deformation.take(time, own.chain(on_zones));
            if i == begin && !is_first {
                deformation.restart_differences(time);
            }
            if i >= range.start {
                let states: Vec<BodyState> = motions.iter().map(|m| m.state(i)).collect();
                let points = &model.observed.points;
                let mut row: Vec<PointSample> = points.iter().map(|p| p.sample(&states[p.body])).collect();
                deformation.add_to(&mut row, points, &states);
                rows.push(row);
            }
        }
        Ok(rows)
    }
}
