//! The models of a result, built again from its scenario.

use adaptive::model::RunModel;
use adaptive::spec::RunSpec;
use adaptive::store::ModelCache;

use super::local::{LeftOut, LocalContacts};
use super::states::{BodyMotion, States};
use super::zones::{MakeView, RefinedZones};
use crate::error::AppError;
use crate::simulate::build;

/// Relative deviation of eigenfrequencies between the run and the model built again that rounding
/// explains.
const SAME_FREQUENCY: f64 = 1e-6;

/// Models of a result with the motion of its bodies and its contacts; `View` is what is made of
/// each fine model.
pub struct Rebuilt<View> {
    /// The models.
    pub model: RunModel,
    /// Motions of the bodies, in the order of the model's.
    pub motions: Vec<BodyMotion>,
    /// Contacts whose zones can be solved again.
    pub contacts: LocalContacts<View>,
}

impl<View> Rebuilt<View> {
    /// Builds the models of `states` on so many threads, with those that `cache` has.
    ///
    /// # Errors
    /// [`AppError::Model`] if a body cannot be built, [`AppError::OtherModes`] if it is not that of the run, [`AppError::Io`].
    pub fn new(
        states: &States,
        threads: usize,
        cache: &ModelCache,
        view: MakeView<View>,
    ) -> Result<Self, AppError> {
        // What the run observed is in its result, and what stiffened its bodies is in their motion.
        let mut spec = RunSpec { points: Vec::new(), stress: Vec::new(), ..states.scenario.run.clone() };
        spec.bodies
            .iter_mut()
            .filter_map(|body| body.kind.flexible_mut())
            .for_each(|settings| settings.geometric_stiffening = false);
        let model = build(&spec, threads, cache)?;
        let motions =
            model.bodies.iter().map(|b| states.motion(&b.name)).collect::<Result<Vec<_>, AppError>>()?;
        check_frequencies(&model, &motions)?;
        let has_friction = |name: &str| {
            let contact = spec.contacts.iter().find(|c| c.name == name);
            contact.and_then(|c| c.law.surface()).is_some_and(|law| law.friction.is_some())
        };
        let zones = RefinedZones::new(states.spans()?, view);
        let contacts = LocalContacts::new(&model, |name| states.contact(name), has_friction, zones);
        Ok(Self { model, motions, contacts })
    }

    /// Contacts of the bodies with these numbers whose zones are not solved again.
    pub fn left_out(&self, bodies: &[usize]) -> Vec<LeftOut> {
        let forces = self.model.system.forces();
        let acts = |one: &&LeftOut| bodies.iter().any(|body| forces[one.contact].acts_on(*body));
        self.contacts.left_out.iter().filter(acts).cloned().collect()
    }
}

/// Coordinates mean nothing on other modes than those of the run.
fn check_frequencies(model: &RunModel, motions: &[BodyMotion]) -> Result<(), AppError> {
    for (body, motion) in model.bodies.iter().zip(motions) {
        let (built, stored) = (body.frequencies(), &motion.eigenfrequencies);
        let close = |a: f64, b: f64| (a - b).abs() <= SAME_FREQUENCY * b.abs();
        if built.len() != stored.len() || !built.iter().zip(stored).all(|(a, b)| close(*a, *b)) {
            return Err(AppError::OtherModes { body: body.name.clone() });
        }
    }
    Ok(())
}
