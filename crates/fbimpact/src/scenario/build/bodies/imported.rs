//! Bodies from files.

use std::sync::Arc;

use adaptive::sizing::SizeRequest;
use adaptive::spec::{BodyKind, FlexibleSpec, FrameSpec, ImportedSpec, Place};
use ffr_dynamics::body::{AssembledBody, RigidMotion};

use super::discretisation::{Basis, reduction};
use super::parts::{GivenFrame, damping, frame};
use crate::interchange::body_file::BodyFile;
use crate::scenario::body_places::GivenPlace;
use crate::scenario::build::built_bodies::MovingFacts;
use crate::scenario::section::Section;
use crate::scenario::types::FileOfBody;

/// A body from a file, called `name`.
pub fn imported(root: &Section, section: &Section, name: &str) -> Option<(BodyKind, MovingFacts)> {
    let source = section.body_file()?;
    let file = FileOfBody { path: source.path.clone(), sha256: source.sha256.clone(), unit: 1.0 };
    let mut facts = MovingFacts { file: Some(file), ..MovingFacts::default() };
    let spec = match &source.body {
        BodyFile::Reduced(model) => ImportedSpec::Reduced(Arc::clone(model)),
        BodyFile::Full(body) => {
            let basis = section.table("reduction").and_then(|table| {
                let basis = reduction(table)?;
                check_modes(table, &basis, body.body());
                Some(basis)
            });
            let damping = damping(section);
            let frame = match frame(root, section, name)? {
                GivenFrame::Buckens => FrameSpec::Buckens,
                GivenFrame::AtJoint => {
                    facts.follows_joint = true;
                    FrameSpec::Buckens
                }
                GivenFrame::Tangent(GivenPlace::Marker(marker)) => FrameSpec::Tangent(Place::Marker(marker)),
                GivenFrame::Tangent(_) => return None, // other places on this body are faults
            };
            let Basis { spec: reduction, static_answers, wants_modes } = basis?;
            facts.wish = SizeRequest { elements: false, modes: wants_modes };
            let body = Arc::clone(body);
            let flexible =
                FlexibleSpec { static_answers, damping: damping?, frame, ..FlexibleSpec::new(reduction) };
            ImportedSpec::Full { body, flexible: Box::new(flexible) }
        }
    };
    Some((BodyKind::Imported(spec), facts))
}

/// Reports more modes than the matrices have unknowns beside rigid motions.
fn check_modes(section: &Section, basis: &Basis, body: &AssembledBody) {
    let n_rigid = match body.motion {
        RigidMotion::Spatial => 6,
        RigidMotion::Planar => 3,
        RigidMotion::Axial => 1,
    };
    let most = body.dofs.len().saturating_sub(n_rigid);
    if !basis.wants_modes && basis.spec.modes().is_some_and(|modes| modes > most) {
        let message = format!("must be at most {most}, the elastic modes of body \"{}\"", body.name);
        section.fault("modes", message);
    }
}
