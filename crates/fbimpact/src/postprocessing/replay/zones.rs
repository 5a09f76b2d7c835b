//! Fine models that a run had during its impacts, built again.

use adaptive::impact::{AdaptiveContact, ZoneModel};
use adaptive::model::RunModel;
use adaptive::record::ZoneSite;
use adaptive::state::simulation::RunContact;

use crate::error::AppError;

/// The time in which a contact had fine models.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Name of the contact.
    pub contact: String,
    /// Where they lay: on the contact body, on the target.
    pub sites: [Option<ZoneSite>; 2],
    /// How far a zone on a smooth surface in place of the sides of a mesh was moved along its
    /// normal \[m\].
    pub offset: f64,
    /// When they came \[s\].
    pub from: f64,
    /// When they went \[s\].
    pub to: f64,
}

/// Makes a view of a fine model: from the model of the run, the number of the body, and the fine
/// model.
pub type MakeView<View> = Box<dyn Fn(&RunModel, usize, &ZoneModel) -> Result<View, AppError>>;

/// A fine model of a body, with the view that was made of it.
pub struct ZoneOfBody<View> {
    /// Number of the body.
    pub body: usize,
    /// The model.
    pub model: ZoneModel,
    /// What was made of it.
    pub view: View,
}

/// Fine models of one contact.
struct Present<View> {
    /// Number of the contact in the model.
    contact: usize,
    span: usize,
    zones: Vec<ZoneOfBody<View>>,
}

/// The fine models of a run; those of one impact a contact are held at a time.
pub struct RefinedZones<View> {
    spans: Vec<Span>,
    make: MakeView<View>,
    present: Vec<Present<View>>,
}

impl<View> RefinedZones<View> {
    /// Fine models in the time of `spans`, of each of which `make` makes something.
    pub fn new(spans: Vec<Span>, make: MakeView<View>) -> Self {
        Self { spans, make, present: Vec::new() }
    }

    /// Puts the fine models that contact `contact` had at time `time` into `model`; false if it had
    /// none, or none that can be built again.
    ///
    /// # Errors
    /// [`AppError::Model`] if they cannot be built.
    pub fn enter(&mut self, model: &mut RunModel, contact: usize, time: f64) -> Result<bool, AppError> {
        let name = &model.contacts[contact].name;
        let is_there = |s: &Span| s.contact == *name && s.from <= time && time <= s.to;
        let Some(span) = self.spans.iter().position(is_there) else { return Ok(false) };
        if self.present.iter().any(|p| p.contact == contact && p.span == span) {
            return Ok(true);
        }
        let refinement = model.contacts[contact].refinement.as_ref();
        let Some(adaptive) = refinement.filter(|r| AdaptiveContact::is_rebuildable(r)) else {
            return Ok(false);
        };
        let Span { sites, offset, .. } = &self.spans[span];
        let built = adaptive.rebuilt(&model.bodies, (sites, *offset)).map_err(AppError::model)?;
        let zones = built.models.into_iter().map(|(body, zone)| {
            let view = (self.make)(model, body, &zone)?;
            Ok(ZoneOfBody { body, model: zone, view })
        });
        let zones = zones.collect::<Result<Vec<_>, AppError>>()?;
        let present = Present { contact, span, zones };
        model.system.forces_mut()[contact] = RunContact::new(built.element);
        self.present.retain(|p| p.contact != contact);
        self.present.push(present);
        Ok(true)
    }

    /// The fine models of contact `contact` that are in the model.
    pub fn of_contact(&self, contact: usize) -> &[ZoneOfBody<View>] {
        self.present.iter().find(|p| p.contact == contact).map_or(&[], |p| &p.zones)
    }

    /// What tells the present fine models of contact `contact` from those of other impacts.
    pub fn number(&self, contact: usize) -> Option<usize> {
        self.present.iter().find(|p| p.contact == contact).map(|p| p.span)
    }
}
