//! What the models of a run take to be built, estimated before anything is factorised.

use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::{Cost, Pencil};

use super::contacts::{interfaces, zones};
use super::{full_models, resolution};
use crate::body::FullModel;
use crate::body::whole::fine_model;
use crate::error::AdaptiveError;
use crate::prepared::{Prepared, is_whole};
use crate::record::{TouchedPart, ZoneSite, ZoneSize};
use crate::sizing::zone::predicted_zone;
use crate::spec::{ContactSpec, ImportedSpec, SurfaceLaw};
use crate::system::start;
use crate::touch::first::FirstTouches;

/// One model of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelCost {
    /// Name of the body.
    pub body: String,
    /// Name of the contact whose fine model it is; none for the body's own model.
    pub contact: Option<String>,
    /// Number of elements; zero of a body from matrices.
    pub n_elements: usize,
    /// Number of degrees of freedom.
    pub n_dofs: usize,
    /// Number of degrees of freedom at the interface of the contact.
    pub n_interface: usize,
    /// Memory and work of a factorisation of the stiffness, and of the compliance of the interface.
    pub cost: Cost,
}

/// Models of all elastic bodies of a run, with the zones that contacts have from the start, and
/// the fine models that the first touch of each contact is predicted to need.
///
/// Hertz's theory and the first touch in free flight predict zone and place of a touch, as in
/// [`predicted_zone`]; a contact that it has no answer for is left out. Meshes and matrices are
/// made, nothing is factorised.
///
/// # Errors
/// [`AdaptiveError`] with the body's name if a mesh cannot be made, no memory holds a factor, or the motions at the start are not known.
pub fn costs(run: Prepared<'_>) -> Result<Vec<ModelCost>, AdaptiveError> {
    let refined = resolution::refined(&run);
    let run = run.refined(refined.as_ref());
    let full = full_models(&run)?;
    let interfaces = interfaces(&run, &zones(&run, &full)?, &start::turns(run.spec())?)?;
    let mut costs = Vec::new();
    for (index, (full, interface)) in full.iter().zip(&interfaces).enumerate() {
        let (whole, smooth): (Vec<_>, Vec<_>) = run
            .contacts()
            .filter_map(|contact| Some((contact.spec, contact.at_touch()?)))
            .filter(|(contact, _)| contact.acts_on(index))
            .partition(|(contact, law)| is_whole(&run.touches, contact, law));
        let touches = smooth.into_iter().filter_map(|contact| touch(&run.touches, contact, index));
        match full {
            FullModel::Flexible(coarse) => {
                let n_elements = coarse.space().n_elements();
                costs.push(cost(coarse.assembled(), n_elements, &interface.unknowns)?);
                let whole = whole.into_iter().map(|(contact, law)| {
                    let part = part(&run.touches, contact, index);
                    (contact, law, ZoneSite { part, ..ZoneSite::WHOLE })
                });
                for (contact, law, site) in whole.chain(touches) {
                    let fine = fine_model(coarse, &site, &law.interval)?;
                    let zone = fine.zone(law.points, &contact.name)?;
                    let n_elements = fine.field().space().n_elements();
                    let fine = cost(&*fine.assemble()?, n_elements, &zone.unknowns)?;
                    costs.push(ModelCost { contact: Some(contact.name.clone()), ..fine });
                }
            }
            FullModel::Imported(ImportedSpec::Full { body, .. }) => {
                costs.push(cost(body.body(), 0, &interface.unknowns)?);
            }
            FullModel::Rigid(_) | FullModel::Imported(ImportedSpec::Reduced(_)) => {}
        }
    }
    Ok(costs)
}

/// The zone of a contact, which gets fine models at its first touch, on body `index`; none if Hertz's
/// theory has no answer.
fn touch<'a>(
    first: &FirstTouches<'_>,
    (contact, law): (&'a ContactSpec, &'a SurfaceLaw),
    index: usize,
) -> Option<(&'a ContactSpec, &'a SurfaceLaw, ZoneSite)> {
    let zone = predicted_zone(first, contact)?;
    let site = zone.sites[contact.bodies().position(|body| body == index)?]?;
    let width = law.interval.width.unwrap_or(zone.width);
    Some((contact, law, ZoneSite::about((site.face, site.xi), ZoneSize::usual([width; 2]))))
}

/// The part of the surface of body `index` that may press at the first touch of a contact.
fn part(first: &FirstTouches<'_>, contact: &ContactSpec, index: usize) -> Option<TouchedPart> {
    first.of(contact)?.parts[contact.bodies().position(|body| body == index)?]
}

/// A model from its matrices, the unknowns `interface` being eliminated last.
fn cost(body: &AssembledBody, n_elements: usize, interface: &[usize]) -> Result<ModelCost, AdaptiveError> {
    let pencil = Pencil::new(body, interface)
        .map_err(|source| AdaptiveError::Reduction { body: body.name.clone(), source })?;
    Ok(ModelCost {
        body: body.name.clone(),
        contact: None,
        n_elements,
        n_dofs: body.n_unknowns(),
        n_interface: interface.len(),
        cost: pencil.cost(interface.len()),
    })
}
