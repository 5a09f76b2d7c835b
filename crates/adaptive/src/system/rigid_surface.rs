//! The surface of a rigid body that others touch: that of its exact shape, without elastic
//! coordinates.

use contact_qs::ContactError;
use contact_qs::surface_pair::TargetFace;
use contact_qs::zone::points::DofLookup;
use faer::Mat;
use iga_core::elasticity::Model;
use iga_core::nurbs::Face;
use iga_core::nurbs::Shape;
use iga_core::nurbs::jet::diagonal;
use iga_core::space::{PatchSpace, Space};
use std::collections::HashMap;
use std::sync::Arc;

use crate::body::splines::Discretised;
use crate::body::zone::contact::ContactSide;
use crate::body::zone::{ContactZone, ZoneExtent, ZoneRegion};
use crate::spec::Geometry;
use crate::surface::{SplineSurface, Surface};

/// The surface of a rigid body with a shape.
pub struct RigidSurface {
    shape: Arc<Shape>,
    model: Model,
    undeformed: Arc<SplineSurface>,
    /// The functions of the shape, not refined.
    space: PatchSpace,
    /// All its faces, without contact points.
    faces: ContactZone,
    /// All its faces with the edges between them.
    whole: ContactZone,
    /// Unknowns of the shape: none.
    lookup: DofLookup,
    shapes: Mat<f64>,
}

/// Surfaces that have been made: bodies that share a shape share its surface.
#[derive(Default)]
pub struct KnownSurfaces(HashMap<*const Shape, Arc<RigidSurface>>);

impl KnownSurfaces {
    /// The surface of `shape`.
    ///
    /// # Errors
    /// As [`RigidSurface::new`].
    pub fn of(&mut self, shape: &Arc<Shape>, model: Model) -> Result<Arc<RigidSurface>, ContactError> {
        // The surface holds the shape, so that no other one gets its place.
        if let Some(known) = self.0.get(&Arc::as_ptr(shape)).filter(|known| known.model == model) {
            return Ok(Arc::clone(known));
        }
        let surface = Arc::new(RigidSurface::new(shape, model)?);
        self.0.insert(Arc::as_ptr(shape), Arc::clone(&surface));
        Ok(surface)
    }
}

impl RigidSurface {
    /// The surface of `shape`.
    ///
    /// # Errors
    /// [`ContactError`] if the patches make no space.
    pub fn new(shape: &Arc<Shape>, model: Model) -> Result<Self, ContactError> {
        let space = PatchSpace::new(shape.patches.clone())?;
        let faces = Face::outer(&shape.patches, model == Model::Axisymmetric);
        let zone = |extent: ZoneExtent| ContactZone {
            points: Vec::new(),
            parameters: Vec::new(),
            faces: Vec::new(),
            unknowns: Vec::new(),
            widths: [diagonal(space.control_points()), 0.0],
            region: ZoneRegion::Faces(
                faces.iter().map(|face| TargetFace::whole(*face, &shape.patches)).collect(),
            ),
            extent,
            meeting: Vec::new(),
            left_out: Vec::new(),
        };
        Ok(Self {
            faces: zone(ZoneExtent::Faces),
            whole: zone(ZoneExtent::Whole),
            shape: Arc::clone(shape),
            undeformed: SplineSurface::of(shape, &model),
            model,
            space,
            lookup: DofLookup::new(&[]),
            shapes: Mat::zeros(0, 0),
        })
    }

    /// The shape.
    pub fn geometry(&self) -> Geometry<'_> {
        Geometry { shape: &self.shape, model: &self.model }
    }

    /// The undeformed surface, for questions about touches and zones.
    pub fn undeformed(&self) -> &dyn Surface {
        self.undeformed.as_ref()
    }

    /// The side of a contact that body `body` with this surface is, by smooth parts of its faces
    /// or, with `has_edges`, edges included (theory Eq. C.76).
    pub fn side(&self, body: usize, has_edges: bool) -> ContactSide<'_> {
        let (patches, space, model, lookup) = (&self.shape.patches, &self.space, &self.model, &self.lookup);
        ContactSide {
            body,
            motion: self.geometry().motion(),
            lookup: &self.lookup,
            splines: Some(Discretised { patches, space, model, lookup }),
            zone: if has_edges { &self.whole } else { &self.faces },
            shapes: self.shapes.as_ref(),
            compliance: None,
            meets: None,
        }
    }
}
