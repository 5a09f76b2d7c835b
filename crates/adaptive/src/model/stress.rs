//! Stress requests of a run: the states that they wait for, and their evaluation at its end.

use nalgebra::Vector3;

use super::RunModel;
use super::fine_modes::has_fine_modes;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::impact::stress::{LeftOut, evaluate};
use crate::impact::yielding::stress_yields;
use crate::impact::{FineContact, ZoneModel};
use crate::prepared::Prepared;
use crate::record::{BareForce, StressState, ZoneLoad};
use crate::spec::{LocalField, StressInstant};
use crate::state::observer::Observer;

impl RunModel {
    /// Takes the present state at time `time` as that of the stress requests, `held`, of the instants
    /// `which` that it serves better than the one they hold; the system was evaluated at it last, with the models
    /// `fine` of the contacts that are refined at present and the `bare` forces.
    pub fn update_stress_states<'a>(
        &self,
        held: &mut [Option<StressState>],
        time: f64,
        which: impl Fn(StressInstant) -> bool,
        fine: impl Fn(usize) -> Option<&'a FineContact>,
        bare: &[BareForce],
    ) {
        for (request, held) in self.stress.iter().zip(held).filter(|(request, _)| which(request.at)) {
            let body = request.body;
            let on_body = || self.system.forces().iter().filter(|f| f.acts_on(body));
            let force = on_body().map(|f| f.contact.report().normal_force).sum::<f64>();
            if !is_wanted(request.at, held.as_ref(), time, force) {
                continue;
            }
            let state = held.get_or_insert_with(StressState::default);
            (state.time, state.force) = (time, force);
            state.bare.clear();
            state.bare.extend(bare.iter().filter(|bare| bare.body as usize == body));
            state.elastic.clone_from(&self.system.last_evaluation().0[body].elastic);
            let residual = self.bodies[body].flexible().and_then(|e| e.reduced.residual.as_ref());
            let n = residual.map_or(0, |r| r.interface().len());
            state.interface_forces.clear();
            state.interface_forces.resize(n, 0.0);
            let mut part = vec![0.0; n];
            let forces = self.system.forces().iter().zip(&self.contacts);
            for (contact, _) in forces.filter(|(_, facts)| n > 0 && facts.loads_interface) {
                if contact.contact.interface_force(body, &mut part) {
                    state.interface_forces.iter_mut().zip(&part).for_each(|(sum, f)| *sum += f);
                }
            }
            let mut n_zones = 0;
            for (i, contact) in self.system.forces().iter().enumerate() {
                let Some(fine) = fine(i).filter(|_| !contact.contact.is_idle()) else { continue };
                for zone in fine.zones.iter().filter(|zone| zone.body == body) {
                    if state.zones.len() == n_zones {
                        state.zones.push(ZoneLoad::default());
                    }
                    let load = &mut state.zones[n_zones];
                    (load.contact, load.site) = (i as u32, zone.site);
                    load.forces.resize(zone.n_unknowns, 0.0);
                    n_zones += usize::from(contact.contact.interface_force(body, &mut load.forces));
                }
            }
            state.zones.truncate(n_zones);
        }
    }

    /// Times at which stress is asked for \[s\].
    pub fn stress_times(&self) -> impl Iterator<Item = f64> + '_ {
        self.stress.iter().filter_map(|request| match request.at {
            StressInstant::Time(time) => Some(time),
            StressInstant::PeakForce => None,
        })
    }

    /// Number of stress requests.
    pub fn n_stress_requests(&self) -> usize {
        self.stress.len()
    }

    /// Evaluates the stress requests in the states that they hold and reports them.
    ///
    /// # Errors
    /// [`AdaptiveError`] of the evaluation or the observer.
    pub fn report_stress(
        &self,
        held: &[Option<StressState>],
        observer: &mut dyn Observer,
    ) -> Result<(), AdaptiveError> {
        // Lines in one body mostly ask for the same instant: zones are built once for those that
        // follow each other.
        let mut built: Option<(usize, Vec<ZoneModel>, &[ZoneLoad])> = None;
        for (request, held) in self.stress.iter().zip(held) {
            let body = request.body;
            let (Some(flexible), Some(state)) = (self.bodies[body].flexible(), held) else {
                let (name, body) = (&request.name, &self.bodies[body].name);
                tracing::warn!(
                    "stress \"{name}\" is not stored: {}",
                    match request.at {
                        StressInstant::PeakForce =>
                            format!("no contact pressed on body \"{body}\"; give `at` as a time"),
                        StressInstant::Time(time) => format!("the run ended before {time:e} s"),
                    }
                );
                continue;
            };
            let is_built =
                built.as_ref().is_some_and(|(of, _, loads)| *of == body && same(loads, &state.zones));
            if !is_built {
                built = Some((body, self.zone_models(body, &state.zones)?, &state.zones));
            }
            let zones = built.as_ref().map_or(&[][..], |(_, zones, _)| zones);
            let record = evaluate(request, flexible, zones, state)?;
            observer.stress(&record)?;
            let most = record.von_mises.iter().copied().fold(0.0, f64::max);
            let subject = format!("output.stress.{}", request.name);
            if let Some(warning) = stress_yields(subject, (most, state.time), self.yield_strengths[body]) {
                observer.warning(&warning)?;
            }
            let shown = || record.points.iter().map(|p| Vector3::from(*p)).zip(&record.von_mises);
            let left_out = state.bare.iter().flat_map(|bare| {
                let thickness = flexible.body.model().thickness();
                shown().map(move |(place, shown)| LeftOut::new(bare, thickness, &place, *shown))
            });
            if let Some(worst) = left_out.filter(LeftOut::counts).reduce(LeftOut::or_worse) {
                let subject = format!("output.stress.{}", request.name);
                observer.warning(&worst.warning(subject, self.name_of(&worst), state.time))?;
            }
        }
        Ok(())
    }

    /// Name of the contact whose stress is left out.
    pub fn name_of(&self, left_out: &LeftOut) -> &str {
        &self.contacts[left_out.contact()].name
    }

    /// Whether stress is asked for in body `index`, at a point or along a line.
    pub fn is_stress_asked(&self, index: usize) -> bool {
        let points = self.observed.points.iter().filter(|point| point.gauge.is_some());
        points.map(|point| point.body).chain(self.stress.iter().map(|line| line.body)).any(|b| b == index)
    }

    /// What the stress of observed points, which shows `shown` \[Pa\], leaves out of the force `bare`:
    /// of the one that leaves out most, with its name.
    pub fn left_out_at_points(
        &self,
        bare: &BareForce,
        shown: impl Fn(usize) -> f64,
    ) -> Option<(usize, LeftOut)> {
        let thickness = self.bodies[bare.body as usize].flexible()?.body.model().thickness();
        let points = self.observed.points.iter().enumerate();
        let points = points.filter(|(_, p)| p.gauge.is_some() && p.body == bare.body as usize);
        points
            .map(|(k, p)| (k, LeftOut::new(bare, thickness, &p.point.position, shown(k))))
            .filter(|(_, left_out)| left_out.counts())
            .reduce(|a, b| if a.1.or_worse(b.1) == a.1 { a } else { b })
    }

    /// Fine models of body `index`, which is flexible, for `loads`.
    fn zone_models(&self, index: usize, loads: &[ZoneLoad]) -> Result<Vec<ZoneModel>, AdaptiveError> {
        let Some(body) = self.bodies[index].flexible() else { return Ok(Vec::new()) };
        let model = |load: &ZoneLoad| {
            let contact = self.contacts.get(load.contact as usize).and_then(|c| c.refinement.as_ref());
            let Some(contact) = contact else {
                return Err(AdaptiveError::Unsupported {
                    subject: format!("stress in body \"{}\"", body.name()),
                    what: format!("contact {} has no fine models", load.contact),
                });
            };
            let zone = contact.zone_model(body, &load.site)?;
            let (n, n_forces) = (zone.residual.interface().len(), load.forces.len());
            if n != n_forces {
                let fault =
                    ContactModelFault::Stored(format!("{n_forces} forces for {n} unknowns of an interface"));
                return Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault });
            }
            Ok(zone)
        };
        loads.iter().map(model).collect()
    }
}

/// Whether a state at time `time` with contact force `force` \[N\] on the body is to be kept in
/// place of `held`.
fn is_wanted(at: StressInstant, held: Option<&StressState>, time: f64, force: f64) -> bool {
    match at {
        StressInstant::PeakForce => force > held.map_or(0.0, |held| held.force),
        StressInstant::Time(wanted) => {
            held.is_none_or(|held| (time - wanted).abs() < (held.time - wanted).abs())
        }
    }
}

/// Whether two lists of loads ask for the same models.
fn same(a: &[ZoneLoad], b: &[ZoneLoad]) -> bool {
    let model = |load: &ZoneLoad| (load.contact, load.site, load.forces.len());
    a.iter().map(model).eq(b.iter().map(model))
}

/// Refuses stress in bodies whose zones, refined during the run, move by more than quasistatic
/// displacements; that of lines, which is evaluated at the end of the run, on modes of the zones'
/// own, too.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] with the names of request and contact.
pub fn check(run: &Prepared<'_>) -> Result<(), AdaptiveError> {
    let spec = run.spec();
    let lines = spec.stress.iter().map(|line| (format!("output.stress.{}", line.name), line.body, true));
    let points = spec.points.iter().filter(|point| point.gauge.is_any());
    let points = points.map(|point| (format!("output.points.{}", point.name), point.body, false));
    for (subject, body, is_line) in lines.chain(points) {
        let refined = run.contacts().filter(|contact| contact.at_touch().is_some());
        for contact in refined.map(|contact| contact.spec).filter(|contact| contact.acts_on(body)) {
            let has_own_modes = has_fine_modes(contact);
            let remedy = match contact.law.local_field() {
                _ if is_line && has_own_modes => "modes = \"prolonged\"",
                LocalField::Vibrating => "model \"adaptive\" or \"quasistatic\"",
                LocalField::Static | LocalField::ModesAlone => continue,
            };
            let what = format!(
                "contact \"{}\" refines the body during the run in a way that stress is not supported for; choose {remedy} for the contact",
                contact.name
            );
            return Err(AdaptiveError::Unsupported { subject, what });
        }
    }
    Ok(())
}
