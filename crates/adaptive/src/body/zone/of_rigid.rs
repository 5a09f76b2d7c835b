//! Contact points of a rigid body: all over its surface (docs/theory.md section C.18).

use contact_qs::ContactError;
use contact_qs::zone::points::DofLookup;
use iga_core::elasticity::Model;
use iga_core::nurbs::Shape;
use iga_core::nurbs::shape::lengths::lengths;
use iga_core::space::PatchSpace;

use crate::body::splines::Discretised;
use crate::body::zone::ContactZone;

/// Parts of the longest way through a body, along which points stand: a corner of a cube bears a 144th of what its face does at the
/// same depth, the rim of a cylinder has 48 points and cuts its circle by 0.2 % of the radius.
const PARTS: f64 = 6.0;
/// Parts of any other way at least: points between its ends hold a narrow partner.
const LEAST: f64 = 2.0;

/// The whole surface of a rigid body of this `shape` and kinematics, with the points of Eq. C.56 on faces divided into parts of
/// about one length.
///
/// # Errors
/// [`ContactError`] if the shape cannot be divided or has no outer face.
pub fn zone_of_rigid(shape: &Shape, model: &Model) -> Result<ContactZone, ContactError> {
    let lengths = lengths(shape);
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let parts = |length: &f64| (PARTS * length / longest).ceil().clamp(LEAST, PARTS) as usize;
    let degree = |d: usize| shape.patches.iter().map(|patch| patch.knots()[d].degree()).max().unwrap_or(1);
    let degrees: Vec<usize> = (0..lengths.len()).map(degree).collect();
    let divided = shape.refined(&degrees, &lengths.iter().map(parts).collect::<Vec<_>>(), &[])?;
    let space = PatchSpace::new(divided.patches.clone())?;
    let lookup = DofLookup::new(&[]);
    ContactZone::whole(
        &Discretised { patches: &divided.patches, space: &space, model, lookup: &lookup },
        None,
    )
}
