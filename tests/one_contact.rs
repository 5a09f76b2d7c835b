//! What is asked of a contact beside its force, of every kind of contact: right, refused, or told.

mod guards;
mod outputs;
mod pressed;
mod rows;

use adaptive::record::ImpactRecord;
use adaptive::record::warning::WarningKind;
use adaptive::run::recording::Recording;
use adaptive::spec::Treatment;
use fbimpact::scenario::keys::Named;
use fbimpact::scenario::tables::ContactModel;
use fbimpact::simulate::simulate;

use crate::support::scenarios::{folder, parse, run, valid};

/// What a run records, or why there is none.
fn tried(text: &str, set: &[&str]) -> Result<Recording, String> {
    let scenario = parse(&folder("one_contact"), text, set).map_err(|faults| format!("{faults:?}"))?;
    let mut recording = Recording::default();
    simulate(&scenario, &mut recording, 1).map(|_| recording).map_err(|error| error.to_string())
}

fn recorded(text: &str, set: &[&str]) -> Recording {
    run(&valid(&folder("one_contact"), text, set))
}

fn is_told(recording: &Recording, kind: WarningKind) -> bool {
    recording.warnings.iter().any(|warning| warning.kind == kind)
}

/// The last record of each impact: that of one that goes on comes again.
fn impacts(recording: &Recording) -> Vec<ImpactRecord> {
    let mut rows: Vec<ImpactRecord> = Vec::new();
    for record in &recording.impacts {
        rows.retain(|row| row.row != record.row);
        rows.push(*record);
    }
    rows
}

/// A ball of 10 mm that meets a floor with 0.1 m/s.
const BALL: &str = r#"
[simulation]
end_time = 1.2e-4
[materials.aluminium]
youngs_modulus = 72.8e9
poissons_ratio = 0.33
density = 2789.0
[bodies.ball]
model = "axisymmetric"
material = "aluminium"
geometry = { shape = "sphere", radius = 10.0e-3 }
position = [0.0, 0.0, 10.000001e-3]
velocity = [0.0, 0.0, -0.1]
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
[contacts.c]
contact_body = "ball"
target_body = "floor"
[output.stress.axis]
body = "ball"
from = [0.0, -10.0e-3]
to = [0.0, -9.5e-3]
samples = 11
at = "peak-force"
[output.points.pole]
body = "ball"
marker = "bottom"
stress = true
"#;

/// Whether zones of a model have vibrations of their own, which cost many times as much.
fn vibrates(model: ContactModel) -> bool {
    model.is(Treatment::is_vibrating)
}

/// The models of a contact that cost little.
fn cheap() -> impl Iterator<Item = ContactModel> {
    ContactModel::VALUES.iter().copied().filter(|&model| !vibrates(model))
}

/// Warnings that tell a user that the force of a contact is not that of the bodies.
const OF_FORCE: &[WarningKind] =
    &[WarningKind::CoarseZone, WarningKind::SoftContact, WarningKind::YieldsTwice];
