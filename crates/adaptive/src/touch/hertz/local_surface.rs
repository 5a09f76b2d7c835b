//! The shape of a body's surface about a place in space, as Hertz's theory wants it.

use iga_core::elasticity::Material;
use nalgebra::{UnitQuaternion, Vector3};

use crate::surface::{Surface, SurfacePlace};
use crate::touch::hertz::LocalSurface;

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
    /// The surface of a body that yields by `compliance` [1/Pa], whose frame is turned by
    /// `rotation`, at `place`; `None` if it has no curvatures there.
    pub fn new(
        surface: &dyn Surface,
        compliance: f64,
        rotation: &UnitQuaternion<f64>,
        place: &SurfacePlace,
    ) -> Option<Self> {
        let shape = surface.shape_at(place)?;
        let in_space = |v: &Vector3<f64>| rotation * surface.motion().in_space(v.as_ref());
        Some(Self {
            surface: LocalSurface {
                curvatures: shape.curvatures,
                direction: in_space(&shape.direction),
                compliance,
            },
            tangents: shape.tangents.each_ref().map(in_space),
            outward: in_space(&shape.normal),
            point: place.point,
        })
    }
}
