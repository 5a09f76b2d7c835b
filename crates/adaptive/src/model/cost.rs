//! What the models of a run take to be built, estimated before anything is factorised.

use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::Pencil;
use ffr_dynamics::system::force::BodyState;
use iga_core::elasticity::Model;
use iga_core::space::Space;
use iga_core::surface::Face;

use super::contacts::{interfaces, takes_part, zones};
use super::plan::{self, ContactPlan};
use super::{full_models, resolution, start};
use crate::body_model::FullModel;
use crate::contact_zone::ContactZone;
use crate::elastic_body::ElasticBody;
use crate::error::AdaptiveError;
use crate::fine_elements::{FineElements, WantedZone};
use crate::fine_model::{ELEMENTS, FineMesh, FineSettings};
use crate::sizing::zone::predicted_zone;
use crate::spec::{ContactLaw, ContactSpec, ImportedSpec, MeshedSpec, RunSpec, SurfaceLaw, Target};
use crate::touch_sites::TouchSite;
use crate::wanted_interval::WantedInterval;

/// Bytes of an entry of a sparse matrix with its index.
const SPARSE_ENTRY: f64 = 12.0;
/// Matrices with the pattern of the stiffness that live at the same time: stiffness, mass, their sum.
const MATRICES: f64 = 3.0;
/// Dense matrices of the size of the interface that live at the same time: flexibility, compliance, the contact's own.
const DENSE: f64 = 3.0;

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
    /// Those of them at the contact's interface.
    pub n_interface: usize,
    /// Memory for matrices, factor and compliance \[bytes\].
    pub bytes: f64,
    /// Multiplications and additions of a factorisation of the stiffness, and of the compliance of the interface.
    pub work: f64,
}

/// Models of all elastic bodies of `spec`, with the zones that contacts have from the start, and the fine models that the first touch of each contact is predicted to need.
///
/// Hertz's theory and the motions at the start predict zone and place of a touch, as in [`predicted_zone`]; a contact that it has no
/// answer for is left out. Meshes and matrices are made, nothing is factorised.
///
/// # Errors
/// [`AdaptiveError`] with the body's name if a mesh cannot be made, no memory holds a factor, or the motions at the start are not known.
pub fn costs(spec: &RunSpec) -> Result<Vec<ModelCost>, AdaptiveError> {
    let poses = start::poses(spec)?;
    let plans = plan::plans(spec, &poses)?;
    let refined = resolution::refined(spec, &plans);
    let spec = refined.as_ref();
    let full = full_models(spec, &plans)?;
    let interfaces = interfaces(spec, &zones(spec, (&plans, &poses), &full)?)?;
    let mut costs = Vec::new();
    for (index, ((body, full), interface)) in spec.bodies.iter().zip(&full).zip(&interfaces).enumerate() {
        let contacts = spec.contacts.iter().zip(&plans).filter(|(_, plan)| **plan == ContactPlan::AtTouch);
        let (whole, smooth): (Vec<_>, Vec<_>) = contacts
            .map(|(contact, _)| contact)
            .filter(|contact| takes_part(contact, index))
            .partition(|contact| plan::is_whole(spec, contact, &poses));
        let touches = smooth.into_iter().filter_map(|contact| touch(spec, &poses, contact, index));
        match full {
            FullModel::Elastic(coarse) => {
                costs.push(cost(&coarse.assembled, coarse.space.n_elements(), &interface.unknowns)?);
                for contact in whole {
                    costs.push(whole_surface(coarse, contact)?);
                }
                for touch in touches {
                    costs.extend(fine_splines(coarse, &touch)?);
                }
            }
            FullModel::Meshed(meshed) => {
                let n_elements = meshed.mesh.elements().len();
                costs.push(cost(&meshed.assembled(&body.name)?, n_elements, &interface.unknowns)?);
                for touch in touches {
                    costs.extend(fine_elements(&body.name, meshed, &touch)?);
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

/// The first touch of a contact on one of its bodies.
struct Touch<'a> {
    contact: &'a ContactSpec,
    law: &'a SurfaceLaw,
    site: TouchSite,
    width: f64,
}

/// The first touch of `contact`, which gets fine models then, on body `index`; none if Hertz's theory has no answer.
fn touch<'a>(
    spec: &RunSpec,
    poses: &[BodyState],
    contact: &'a ContactSpec,
    index: usize,
) -> Option<Touch<'a>> {
    let ContactLaw::Surface(law) = &contact.law else { return None };
    let zone = predicted_zone(spec, poses, contact)?;
    let side = match contact.target {
        _ if contact.body == index => 0,
        Target::Body(other) if other == index => 1,
        _ => return None,
    };
    Some(Touch { contact, law, site: zone.sites[side]?, width: law.interval.width.unwrap_or(zone.width) })
}

/// The model of a body of splines with its whole surface as interface.
fn whole_surface(body: &ElasticBody, contact: &ContactSpec) -> Result<ModelCost, AdaptiveError> {
    let fail = |source| AdaptiveError::Contact { contact: contact.name.clone(), source };
    let zone = ContactZone::whole(&body.discretised(), None).map_err(fail)?;
    let whole = cost(&body.assembled, body.space.n_elements(), &zone.unknowns)?;
    Ok(ModelCost { contact: Some(contact.name.clone()), ..whole })
}

/// The fine model of a body of splines.
fn fine_splines(coarse: &ElasticBody, touch: &Touch<'_>) -> Result<Option<ModelCost>, AdaptiveError> {
    let (TouchSite::Face(site), interval) = (touch.site, &touch.law.interval) else { return Ok(None) };
    let face = Face::new(&coarse.shape.patches, site.face, coarse.spec.model == Model::Axisymmetric);
    let wanted = WantedInterval { face, centre: site.xi, widths: [touch.width; 2] };
    let elements = interval.elements.unwrap_or(ELEMENTS);
    let settings = FineSettings { division: interval.division, elements, growth: None };
    let mesh = FineMesh::build(coarse, &[wanted], &settings)?;
    let fail = |source| AdaptiveError::Contact { contact: touch.contact.name.clone(), source };
    let zone = mesh.zone(0, touch.law.points).map_err(fail)?;
    let fine = cost(&mesh.assemble(coarse)?, mesh.space.n_elements(), &zone.unknowns)?;
    Ok(Some(ModelCost { contact: Some(touch.contact.name.clone()), ..fine }))
}

/// The fine model of a body from a mesh.
fn fine_elements(
    name: &str,
    spec: &MeshedSpec,
    touch: &Touch<'_>,
) -> Result<Option<ModelCost>, AdaptiveError> {
    let TouchSite::Side(site) = touch.site else { return Ok(None) };
    let wanted = WantedZone { site, widths: [touch.width; 2], elements: touch.law.interval.elements };
    let mesh = FineElements::build(name, spec, &wanted)?;
    let fine = cost(&mesh.assemble()?, mesh.n_elements(), &mesh.zone()?.unknowns)?;
    Ok(Some(ModelCost { contact: Some(touch.contact.name.clone()), ..fine }))
}

/// A model from its matrices, the unknowns `interface` being eliminated last.
fn cost(body: &AssembledBody, n_elements: usize, interface: &[usize]) -> Result<ModelCost, AdaptiveError> {
    let pencil = Pencil::new(body, interface)
        .map_err(|source| AdaptiveError::Reduction { body: body.name.clone(), source })?;
    let symbolic = pencil.symbolic();
    let (entries, n) = (symbolic.n_entries() as f64, interface.len() as f64);
    let matrices = MATRICES * SPARSE_ENTRY * body.stiffness.compute_nnz() as f64;
    Ok(ModelCost {
        body: body.name.clone(),
        contact: None,
        n_elements,
        n_dofs: body.n_unknowns(),
        n_interface: interface.len(),
        bytes: matrices + 8.0 * (entries + DENSE * n * n),
        // The compliance of the last unknowns is the inverse of their part of the factor.
        work: symbolic.work() + n.powi(3),
    })
}
