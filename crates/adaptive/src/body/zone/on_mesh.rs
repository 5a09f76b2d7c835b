//! The contact zone that a contact has on a body of finite elements from the start: sides of its
//! own mesh.

use contact_qs::ContactError;

use crate::body::zone::at_start::{LineOnBody, StartZone, ZoneRequest};
use crate::body::zone::{ContactZone, longest_across};
use crate::error::{AdaptiveError, ContactModelFault};
use crate::spec::RefinementSpec;
use crate::surface::{MeshSurface, Surface, SurfacePlace};

/// Sides of quadratic elements on the half width of a contact along a line, at least: with fewer
/// the contact may lie between the points of a side.
const QUADRATIC: f64 = 1.0;
/// The same of linear elements.
const LINEAR: f64 = 4.0;

/// The zone on the mesh of a body, its name first, about a place.
///
/// Along a line it is the strip of the width given, else of the one predicted, as long as the
/// surface. Elsewhere its width is the one given, else what is predicted; of a contact without a
/// fine zone ([`crate::spec::Treatment::has_fine_zone`]) it is the smooth surface about the place.
///
/// # Errors
/// [`AdaptiveError::ContactModel`] if no width is known, or if sides are longer across a line than its contact needs; [`AdaptiveError::Mesh`] for a side
/// without area.
pub fn zone_on_mesh(
    name: &str,
    surface: &MeshSurface,
    StartZone { request, width, line }: &StartZone<'_>,
) -> Result<ContactZone, AdaptiveError> {
    let ZoneRequest { contact, law, site } = *request;
    let mesh_fault = |source| AdaptiveError::Mesh { body: name.to_owned(), source };
    let is_coarse = !law.treatment.has_fine_zone();
    if let Some(line) = line().filter(|_| !is_coarse) {
        let site = surface.turned_to(&site, &line.outward);
        check_line(name, surface, contact, &site, &line)?;
        let width = law.interval.width.unwrap_or(line.width);
        return ContactZone::along_line(surface, &site, &line.across, 0.5 * width).map_err(mesh_fault);
    }
    let known = law.interval.width.or_else(|| if is_coarse { Some(f64::INFINITY) } else { width() });
    let width = known.ok_or_else(|| AdaptiveError::ContactModel {
        contact: contact.to_owned(),
        fault: ContactModelFault::NoWidthOnMesh { body: name.to_owned() },
    })?;
    // A width that is given begins at an axis of symmetry.
    let reach = match law.interval.width {
        Some(width) => RefinementSpec::half_width(surface.mesh().model(), &site.point, width),
        None => 0.5 * width,
    };
    let zone = ContactZone::about(surface, &site, reach).map_err(mesh_fault)?;
    if zone.points.is_empty() {
        let source = ContactError::Empty { width };
        return Err(AdaptiveError::Contact { contact: contact.to_owned(), source });
    }
    Ok(zone)
}

/// Refuses a line of which the sides of a mesh are too long.
fn check_line(
    name: &str,
    surface: &MeshSurface,
    contact: &str,
    site: &SurfacePlace,
    line: &LineOnBody,
) -> Result<(), AdaptiveError> {
    let is_quadratic = surface.mesh().elements().iter().next().is_some_and(|e| e.kind.is_quadratic());
    let most = line.half_width / if is_quadratic { QUADRATIC } else { LINEAR };
    let length = longest_across(surface, site, &line.across, line.half_width);
    if length <= most {
        return Ok(());
    }
    let fault =
        ContactModelFault::LineOnMesh { body: name.to_owned(), width: 2.0 * line.half_width, length, most };
    Err(AdaptiveError::ContactModel { contact: contact.to_owned(), fault })
}
