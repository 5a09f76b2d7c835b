//! The force element of a contact zone: its points on a plane, or on the surface of another body's
//! zone.

use contact_qs::surface_pair::{MeetingPoint, SurfacePair, SurfacePairSettings, SurfacePlace, TargetSurface};
use contact_qs::zone::points::{DofLookup, InterfaceCompliance, contact_submodel};
use contact_qs::{
    ActiveContact, ContactError, ContactSubmodel, PlaneContact, PlaneContactSettings, VibratingContact,
    ZoneVibration,
};
use faer::MatRef;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::Active;
use iga_core::nurbs::FaceId;

use crate::body::splines::Discretised;
use crate::body::zone::{ContactZone, ZoneExtent, ZoneRegion};
use crate::record::TargetPlace;
use crate::spec::{SurfaceLaw, Target};

/// Penalty factor of a contact to which none is given, until its compliance has told one [N/m³].
const UNTIL_KNOWN: f64 = 1.0;

/// Overhang of edges that lie on each other, over the size of the body: a third of the strain at
/// which steel yields, on the half of a body.
const OVERHANG: f64 = 3e-4;

/// A body in a contact: the zone that it has there, and how it moves.
#[derive(Clone, Copy)]
pub struct ContactSide<'a> {
    /// Index of the body.
    pub body: usize,
    /// Rigid motions of the body.
    pub motion: RigidMotion,
    /// The number of the unknown of each function and component of the model on which the zone
    /// lies.
    pub lookup: &'a DofLookup,
    /// The spline space that it lies on; none of a mesh.
    pub splines: Option<Discretised<'a>>,
    /// The zone.
    pub zone: &'a ContactZone,
    /// Modes of the dynamic elastic coordinates at the unknowns, `n_dofs × n_q`.
    pub shapes: MatRef<'a, f64>,
    /// Compliance of the interface; none if all modes are dynamic.
    pub compliance: Option<InterfaceCompliance<'a>>,
    /// What a point of the zone meets of the target, if that has an edge or a corner there.
    pub meets: Option<TargetPlace>,
}

impl ContactSide<'_> {
    /// The points with modes and compliance.
    fn submodel(&self) -> Result<ContactSubmodel, ContactError> {
        let submodel =
            contact_submodel(self.motion, &self.zone.points, self.lookup, self.shapes, self.compliance)?;
        Ok(ContactSubmodel { left_out: self.zone.left_out.clone(), ..submodel })
    }

    /// The points of the zone that meet an edge or a corner of `target`, and their plane there;
    /// none if none do, or if an own edge finds its places on the target like other points.
    fn meeting_point(&self, target: &ContactSide<'_>) -> Option<MeetingPoint> {
        let (meets, splines) = (self.meets?, target.splines.as_ref());
        if meets.own_outward().is_some() {
            return None;
        }
        let place = match (&target.zone.region, splines) {
            (ZoneRegion::Pieces(pieces), _) => {
                let (piece, xi) = pieces.place_of(meets.face, [meets.xi[0], meets.xi[1]])?;
                SurfacePlace { face: piece, xi }
            }
            (ZoneRegion::Faces(faces), Some(splines)) => {
                let id = *FaceId::all(splines.patches).get(meets.face as usize)?;
                let number = faces.iter().position(|target| target.face.id == id)?;
                let mut xi = [0.0; 2];
                xi.iter_mut().zip(faces[number].face.directions()).for_each(|(x, d)| *x = meets.xi[d]);
                SurfacePlace { face: number as u32, xi }
            }
            (ZoneRegion::Faces(_), None) => return None,
        };
        let along = target.motion.components(&meets.along[1]);
        Some(MeetingPoint {
            points: self.zone.meeting.iter().map(|(i, share)| (*i, along.map(|c| share * c))).collect(),
            place,
            normal: target.motion.components(&meets.normal),
        })
    }

    /// The surface with modes and compliance. Points beyond the ends of its faces lie over them up
    /// to [`OVERHANG`], but for a touch with its edge or under its face, `is_met`, where no edges lie on each other.
    fn surface(&self, is_met: bool) -> Result<TargetSurface, ContactError> {
        let Self { motion, lookup, shapes, compliance, .. } = *self;
        let surface = match (&self.zone.region, &self.splines) {
            (ZoneRegion::Pieces(surface), _) => {
                TargetSurface::of_pieces(motion, surface, lookup, shapes, compliance)?
            }
            (ZoneRegion::Faces(faces), Some(Discretised { space, patches, .. })) => {
                TargetSurface::flexible(motion, *space, patches, faces, lookup, shapes, compliance)?
            }
            (ZoneRegion::Faces(_), None) => {
                return Err(ContactError::Nothing { what: "a mesh has no face" });
            }
        };
        Ok(match self.zone.extent {
            ZoneExtent::Part => surface,
            ZoneExtent::Faces => surface.complete(),
            ZoneExtent::Whole => {
                let [size, least] = self.zone.widths;
                let overhang = if is_met { 0.0 } else { OVERHANG * size };
                surface.with_edges(overhang, (least > 0.0).then_some(least))
            }
        })
    }
}

/// Contact of the points of a zone.
pub enum ZoneContact {
    /// With a plane.
    Plane(Box<PlaneContact>),
    /// With the surface of another body.
    Pair(Box<SurfacePair>),
}

impl ZoneContact {
    /// Contact of `own` with `target`, on which `other` is the zone if it is a body, by `law`; a penalty
    /// factor that it does not give is to be set before the first evaluation.
    ///
    /// # Errors
    /// [`ContactError`] if points, surfaces and settings do not fit each other.
    pub fn new(
        law: &SurfaceLaw,
        target: Target,
        own: &ContactSide<'_>,
        other: Option<&ContactSide<'_>>,
    ) -> Result<Self, ContactError> {
        let (body, method, penalty) = (own.body, law.method, law.penalty.unwrap_or(UNTIL_KNOWN));
        let submodel = own.submodel()?;
        match (target, other) {
            (Target::Plane(plane), _) => {
                let settings = PlaneContactSettings { body, plane, penalty, method };
                let contact = PlaneContact::new(submodel, settings)?;
                Ok(Self::Plane(Box::new(match law.friction {
                    Some(friction) => contact.with_friction(friction)?,
                    None => contact,
                })))
            }
            (Target::Body(target), Some(other)) => {
                let settings =
                    SurfacePairSettings { contact_body: body, target_body: Some(target), penalty, method };
                let meeting = own.meeting_point(other);
                let is_inside = own.zone.extent == ZoneExtent::Part && own.zone.is_under_edges();
                let surface = other.surface(meeting.is_some() || is_inside)?;
                let mut pair = SurfacePair::new(submodel, surface, settings)?;
                if let Some(meeting) = meeting {
                    pair = pair.with_meeting_point(meeting)?;
                }
                Ok(Self::Pair(Box::new(match law.friction {
                    Some(friction) => pair.with_friction(friction)?,
                    None => pair,
                })))
            }
            (Target::Body(_), None) => Err(ContactError::Nothing { what: "a body has no contact zone" }),
        }
    }

    /// The contact for a system.
    pub fn active(self) -> Box<dyn ActiveContact> {
        match self {
            Self::Plane(contact) => Box::new(Active::new(*contact)),
            Self::Pair(contact) => Box::new(Active::new(*contact)),
        }
    }

    /// The contact with zones that vibrate, in a system of `n_bodies` bodies.
    ///
    /// # Errors
    /// [`ContactError`] if the zones do not fit the contact.
    pub fn vibrating(
        self,
        zones: Vec<ZoneVibration>,
        n_bodies: usize,
    ) -> Result<Box<dyn ActiveContact>, ContactError> {
        Ok(match self {
            Self::Plane(contact) => Box::new(Active::new(VibratingContact::new(*contact, zones, n_bodies)?)),
            Self::Pair(contact) => Box::new(Active::new(VibratingContact::new(*contact, zones, n_bodies)?)),
        })
    }
}
