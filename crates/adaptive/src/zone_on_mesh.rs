//! The contact zone that a contact has on a body of finite elements: sides of its own mesh.

use contact_qs::ContactError;
use nalgebra::Vector3;

use crate::contact_zone::ContactZone;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::mesh_surface::{MeshSurface, SideSite};
use crate::sizing::zone::PredictedLine;
use crate::spec::{ContactSpec, MeshedSpec, SurfaceLaw, Treatment};

/// The zone of `contact` on the mesh of a body, its name first, about `site`.
///
/// Its width is the one given, else what `predicted` says; of a contact without a quasistatic part ([`Treatment::Coarse`]) the smooth surface
/// about the site.
///
/// # Errors
/// [`AdaptiveError::ContactModel`] if no width is known, [`AdaptiveError::Mesh`] for a side without area.
pub fn zone_on_mesh(
    (name, body): (&str, &MeshedSpec),
    (contact, law): (&ContactSpec, &SurfaceLaw),
    site: &SideSite,
    predicted: impl FnOnce() -> Option<f64>,
) -> Result<ContactZone, AdaptiveError> {
    let width = match (law.interval.width, law.treatment) {
        (Some(width), _) => Some(width),
        (None, Treatment::Coarse) => Some(f64::INFINITY),
        (None, _) => predicted(),
    };
    let width = width.ok_or_else(|| {
        let (contact, body) = (contact.name.clone(), name.to_owned());
        AdaptiveError::ContactModel { contact, fault: ContactModelFault::NoWidthOnMesh { body } }
    })?;
    let zone = MeshSurface::of(&body.mesh).zone(site, 0.5 * width);
    let zone = zone.map_err(|source| AdaptiveError::Mesh { body: name.to_owned(), source })?;
    if zone.points.is_empty() {
        let source = ContactError::Empty { width };
        return Err(AdaptiveError::Contact { contact: contact.name.clone(), source });
    }
    Ok(zone)
}

/// Sides of quadratic elements on the half width of a contact along a line, at least: with fewer the contact may lie between the points of a side.
const QUADRATIC: f64 = 1.0;
/// The same of linear elements.
const LINEAR: f64 = 4.0;

/// The zone of `contact` on the mesh of a body, its name first, along a line through `site`, which is the strip of the width given, else of the one predicted,
/// as long as the surface. `across`: unit vector in the body, across the line.
///
/// # Errors
/// [`AdaptiveError::ContactModel`] if sides are longer across the line than its contact needs, [`AdaptiveError::Mesh`] for a side without area.
pub fn zone_along_line(
    (name, body): (&str, &MeshedSpec),
    (contact, law): (&ContactSpec, &SurfaceLaw),
    site: &SideSite,
    (line, across): (&PredictedLine, &Vector3<f64>),
) -> Result<ContactZone, AdaptiveError> {
    check_line((name, body), contact, site, (line, across))?;
    let width = law.interval.width.unwrap_or(line.width);
    let zone = MeshSurface::of(&body.mesh).zone_along(site, across, 0.5 * width);
    zone.map_err(|source| AdaptiveError::Mesh { body: name.to_owned(), source })
}

/// Refuses a line of which the sides of a mesh are too long.
fn check_line(
    (name, body): (&str, &MeshedSpec),
    contact: &ContactSpec,
    site: &SideSite,
    (line, across): (&PredictedLine, &Vector3<f64>),
) -> Result<(), AdaptiveError> {
    let is_quadratic = body.mesh.elements().iter().next().is_some_and(|e| e.kind.is_quadratic());
    let most = line.half_width / if is_quadratic { QUADRATIC } else { LINEAR };
    let length = MeshSurface::of(&body.mesh).longest_across(site, across, line.half_width);
    if length <= most {
        return Ok(());
    }
    let fault =
        ContactModelFault::LineOnMesh { body: name.to_owned(), width: 2.0 * line.half_width, length, most };
    Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault })
}

/// Refuses a line on a mesh in a contact that is refined at the touch, whose zones are as long as they are wide.
pub fn refined_line(name: &str, contact: &ContactSpec, line: &PredictedLine) -> AdaptiveError {
    let fault = ContactModelFault::RefinedLine { body: name.to_owned(), width: 2.0 * line.half_width };
    AdaptiveError::ContactModel { contact: contact.name.clone(), fault }
}
