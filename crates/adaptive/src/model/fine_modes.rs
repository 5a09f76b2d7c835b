//! Bodies that change to a fine model with modes of its own for an impact, and back.

use std::sync::Arc;

use contact_qs::search::SurfaceModel;
use ffr_dynamics::body::RigidMotion;
use tracing::warn;

use super::{BodyModel, FlexibleModel, RunModel, held_damping, observed_points};
use crate::error::AdaptiveError;
use crate::impact::FineBasis;
use crate::paper::fine_modes::{FineModes, check_fine_modes};
use crate::prepared::Prepared;
use crate::spec::LowModes;
use crate::spec::{ContactSpec, RunSpec};
use crate::system::body::FineState;
use crate::system::joints;

/// Whether fine models of `contact` have modes of their own.
pub fn has_fine_modes(contact: &ContactSpec) -> bool {
    contact.law.surface().is_some_and(|law| law.transfer.modes == LowModes::Fine)
}

/// Refuses modes of their own in fine models of meshes, of contacts that have none, and of bodies on
/// which contacts without fine models act.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] with the name of the contact.
pub fn check(run: &Prepared<'_>) -> Result<(), AdaptiveError> {
    let body = |body: usize| &run.spec().bodies[body];
    for contact in run.contacts().filter(|contact| has_fine_modes(contact.spec)) {
        let refuse = |what| Err(AdaptiveError::unsupported_contact(&contact.spec.name, what));
        if contact.at_touch().is_none() {
            return refuse(
                "modes = \"own\" is for contacts that the program refines in the run, leave it out".into(),
            );
        }
        if contact.spec.bodies().any(|index| body(index).kind.meshed().is_some()) {
            return refuse("a body of model \"mesh\" has no fine models with modes = \"own\"; choose modes = \"prolonged\" for its contacts".into());
        }
        for index in contact.spec.bodies() {
            let mut others = run.contacts().filter(|other| other.at_touch().is_none());
            if let Some(other) = others.find(|other| other.spec.acts_on(index)) {
                let (body, other) = (body(index).name.clone(), other.spec.name.clone());
                return refuse(format!(
                    "body \"{body}\" takes part in contact \"{other}\" too, which keeps one model for the whole run; choose modes = \"prolonged\""
                ));
            }
        }
    }
    Ok(())
}

/// Whether bodies will change their modes.
///
/// # Errors
/// As [`check_fine_modes`].
pub fn needs_fine_modes(spec: &RunSpec, bodies: &[BodyModel]) -> Result<bool, AdaptiveError> {
    let changing = || spec.contacts.iter().filter(|contact| has_fine_modes(contact));
    for flexible in changing().flat_map(ContactSpec::bodies).filter_map(|body| bodies[body].flexible()) {
        check_fine_modes(flexible.body.as_ref(), &flexible.reduced)?;
        warn_of_cut_group(flexible);
    }
    Ok(changing().next().is_some())
}

/// Modes of equal frequency span a space, of which coarse and fine model have another part each if
/// the count cuts it.
fn warn_of_cut_group(flexible: &FlexibleModel) {
    let (basis, motion) = (&flexible.reduced.basis, flexible.motion());
    // Twist-free modes about an axis are simple: frequencies that happen to lie close together are
    // no group.
    let Some((fewer, more)) = basis.multiplet.filter(|_| motion != RigidMotion::Axial) else { return };
    warn!(
        body = flexible.name(),
        "{} modes cut through a group of equal frequencies, which loses energy when models change; {fewer} or {more} modes do not",
        basis.n_low
    );
}

impl RunModel {
    /// Whether bodies change their modes during the run: what was built with some does not serve
    /// with others.
    pub fn changes_modes(&self) -> bool {
        self.source.is_some()
    }

    /// Gives `body` a fine model with its modes and maps its part of the state `y` at time `t`.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the system cannot be built with it.
    pub fn enter_fine_modes(
        &mut self,
        body: usize,
        FineBasis { body: fine, modes }: FineBasis,
        (t, y): (f64, &mut [f64]),
    ) -> Result<(), AdaptiveError> {
        self.map_to_fine_modes(body, &modes, y)?;
        let model = &mut self.bodies[body];
        let Some(elastic) = model.flexible_mut() else { return Ok(()) };
        let mut state = FineState { fine, modes, surface: None };
        std::mem::swap(&mut elastic.reduced, &mut state.modes.view);
        let Some(seen) = model.flexible().map(|flexible| flexible.surface()).transpose()? else {
            return Ok(());
        };
        model.data = state.modes.reduced.data.clone();
        state.surface = self.watch(body, &seen);
        self.set_fine_state(body, Some(Box::new(state)));
        self.rebuild(t, y)
    }

    /// Gives `body` its coarse model again and maps its part of the state `y` at time `t`.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the system cannot be built with it.
    pub fn leave_fine_modes(&mut self, body: usize, (t, y): (f64, &mut [f64])) -> Result<(), AdaptiveError> {
        let Some(mut state) = self.take_fine_state(body) else { return Ok(()) };
        let map = |x: &[f64]| state.modes.transfer.coarse(x);
        self.map_elastic(body, map, y)?;
        if let Some(elastic) = self.bodies[body].flexible_mut() {
            std::mem::swap(&mut elastic.reduced, &mut state.modes.view);
            let data = elastic.reduced.data.clone();
            self.bodies[body].data = data;
        }
        if let Some(coarse) = state.surface {
            self.watch(body, &coarse);
        }
        self.rebuild(t, y)
    }

    /// Maps the coarse state `y` at time `t` to the modes that bodies have at present.
    ///
    /// # Errors
    /// [`AdaptiveError::Dynamics`] if the state is not finite.
    pub fn to_present_modes(&mut self, t: f64, y: &mut [f64]) -> Result<(), AdaptiveError> {
        for body in 0..self.bodies.len() {
            if let Some(state) = self.take_fine_state(body) {
                let outcome = self.map_to_fine_modes(body, &state.modes, y);
                self.set_fine_state(body, Some(state));
                outcome?;
            }
        }
        self.close_loops(t, y)
    }

    fn take_fine_state(&mut self, body: usize) -> Option<Box<FineState>> {
        self.bodies[body].flexible_mut()?.fine.take()
    }

    fn set_fine_state(&mut self, body: usize, state: Option<Box<FineState>>) {
        if let Some(elastic) = self.bodies[body].flexible_mut() {
            elastic.fine = state;
        }
    }

    fn map_to_fine_modes(
        &mut self,
        body: usize,
        modes: &FineModes,
        y: &mut [f64],
    ) -> Result<(), AdaptiveError> {
        self.map_elastic(body, |x| modes.transfer.fine(x), y)
    }

    fn map_elastic(
        &mut self,
        body: usize,
        map: impl Fn(&[f64]) -> Vec<f64>,
        y: &mut [f64],
    ) -> Result<(), AdaptiveError> {
        let layout = self.system.model().bodies[body].layout;
        let (q, rates) = (map(&y[layout.elastic()]), map(&y[layout.elastic_rates()]));
        self.system.set_elastic(y, body, &q, &rates).map_err(AdaptiveError::Dynamics)
    }

    fn watch(&mut self, body: usize, surface: &Arc<SurfaceModel>) -> Option<Arc<SurfaceModel>> {
        let refinements = self.contacts.iter_mut().filter_map(|contact| contact.refinement.as_mut());
        refinements.filter_map(|refinement| refinement.detector.replace_surface(body, surface)).last()
    }

    /// The system with the models that bodies have at present.
    fn rebuild(&mut self, t: f64, y: &mut [f64]) -> Result<(), AdaptiveError> {
        let Some(spec) = &self.source else { return Ok(()) };
        let description = joints::system_spec(spec, &self.bodies)?;
        self.observed.points = observed_points(spec, &self.bodies)?;
        self.system.replace_model(description).map_err(AdaptiveError::Model)?;
        held_damping::hold(spec, &mut self.bodies, &mut self.system, (0.0, &self.initial))?;
        self.close_loops(t, y)
    }

    /// Loops are closed between markers, which moved with the modes.
    fn close_loops(&mut self, t: f64, y: &mut [f64]) -> Result<(), AdaptiveError> {
        if !self.system.model().has_constraints() {
            return Ok(());
        }
        self.system.assemble(t, y).map_err(AdaptiveError::Model)
    }
}
