//! The contact zone that a contact has on a body of finite elements: sides of its own mesh.

use contact_qs::ContactError;

use crate::contact_zone::ContactZone;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::mesh_surface::{MeshSurface, SideSite};
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
