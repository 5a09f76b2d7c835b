//! The shape of a body's surface about a place, as Hertz's theory wants it.

use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::FaceId;
use iga_core::nurbs::patch::PointBasis;
use iga_core::surface::Face;
use nalgebra::{UnitQuaternion, Vector3};

use crate::mesh_surface::{MeshSurface, SideSite};
use crate::predict::LocalSurface;
use crate::rotated_net::regular_view;
use crate::spec::{BodyKind, BodySpec, Geometry, MeshedSpec};
use crate::touch_sites::TouchSite;

/// Surface of the undeformed body about a place of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceView {
    /// Curvatures and compliance.
    pub surface: LocalSurface,
    /// Directions in space of the two parameters of the face, not of unit length.
    pub tangents: [Vector3<f64>; 2],
    /// Outward unit normal in space.
    pub outward: Vector3<f64>,
    /// The place in the model's components \[m\].
    pub point: [f64; 3],
}

/// `(1 - ν²)/E` [1/Pa].
pub fn plane_compliance(material: &Material) -> f64 {
    (1.0 - material.poissons_ratio().powi(2)) / material.youngs_modulus()
}

impl SurfaceView {
    /// The surface of `body`, whose frame is turned by `rotation`, at `site`; `None` if it has no curvatures there, or `body` no surface.
    pub fn at(body: &BodySpec, rotation: &UnitQuaternion<f64>, site: &TouchSite) -> Option<Self> {
        match (&body.kind, site) {
            (BodyKind::Elastic(elastic), TouchSite::Face(site)) => {
                let body = (elastic.geometry(), plane_compliance(&elastic.material));
                Self::new(body, rotation, site.face, &site.xi)
            }
            (BodyKind::Rigid(rigid), TouchSite::Face(site)) => {
                Self::new((rigid.geometry()?, 0.0), rotation, site.face, &site.xi)
            }
            (BodyKind::Meshed(meshed), TouchSite::Side(site)) => Self::of_mesh(meshed, rotation, site),
            _ => None,
        }
    }

    /// The surface of a body of finite elements, whose frame is turned by `rotation`; `None` where it has no normal.
    pub fn of_mesh(body: &MeshedSpec, rotation: &UnitQuaternion<f64>, site: &SideSite) -> Option<Self> {
        let shape = MeshSurface::of(&body.mesh).shape_at(site)?;
        let compliance = plane_compliance(body.slowest_material()?);
        let direction = rotation * shape.direction;
        Some(Self {
            surface: LocalSurface { curvatures: shape.curvatures, direction, compliance },
            tangents: shape.tangents.map(|t| rotation * t),
            outward: rotation * shape.normal,
            point: site.point,
        })
    }

    /// The surface of `body`, which yields by `compliance` [1/Pa] and whose frame is turned by `rotation`, at parameters `xi` of `face`; `None` if it
    /// has no curvatures there.
    pub fn new(
        (body, compliance): (Geometry<'_>, f64),
        rotation: &UnitQuaternion<f64>,
        face: FaceId,
        xi: &[f64; 3],
    ) -> Option<Self> {
        let (shape, motion) = (body.shape, body.motion());
        let own = Face::new(&shape.patches, face, body.is_axisymmetric());
        let place = own.on_face(xi);
        // Where the net is singular, it has no curvatures to show.
        let turned = if *body.model == Model::Solid { regular_view(shape, &own, &place).ok()? } else { None };
        let (patch, view, at) = match &turned {
            Some((shape, face, xi)) => (&shape.patches[face.id.patch], *face, *xi),
            None => (&shape.patches[face.patch], own, place),
        };
        let jet = patch.jet(&view.on_face(&at), 2, &mut PointBasis::default());
        let geometry = view.geometry(&jet);
        let in_space = |v: &[f64; 3]| rotation * motion.in_space(v);
        let tangents = geometry.tangents.each_ref().map(in_space);
        let direction = view.first_direction(&jet).map_or_else(Vector3::zeros, |v| in_space(&v));
        Some(Self {
            surface: LocalSurface { curvatures: view.curvatures(&jet)?, direction, compliance },
            tangents,
            outward: in_space(&geometry.normal),
            point: shape.patches[face.patch].point(&place),
        })
    }
}
