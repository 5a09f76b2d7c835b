//! Solid bodies drawn at random out of the catalogue: every shape and net whose smooth faces are refined.

use std::f64::consts::{PI, TAU};
use std::fmt;

use adaptive::spec::{BodyKind, BodySpec, DiscretisationSpec, ElasticSpec, InitialMotion, ReductionSpec};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::solid;
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere};
use iga_core::nurbs::{Patch, Shape};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::impacts::{Numbers, Solid};

/// Largest volume of a first body over the cube of its radius: a cylinder eight times as long as its radius.
pub const LARGEST: f64 = 8.0 * PI;
/// Distance of contacts from edges, in contact radii: intervals reach 1.5 of them, the graded elements about it as far again.
const CLEAR: f64 = 6.0;

/// What a body is, with its sizes \[m\].
#[derive(Debug, Clone, Copy)]
enum Kind {
    Ball {
        net: SphereNet,
        radius: f64,
    },
    Ellipsoid {
        axes: [f64; 3],
    },
    /// Touched on its jacket.
    Cylinder {
        radius: f64,
        length: f64,
    },
    /// Touched on an end.
    CylinderEnd {
        radius: f64,
        length: f64,
    },
    /// Touched on its outer face.
    HollowCylinder {
        inner: f64,
        outer: f64,
        length: f64,
    },
    /// Touched on its upper face.
    Box {
        size: [f64; 3],
    },
}

/// A body, its mesh and where it is touched.
#[derive(Debug, Clone)]
pub struct Form {
    kind: Kind,
    degrees: [usize; 3],
    elements: [usize; 3],
    modes: usize,
    /// The point touched, outward normal and a tangent there, in the body's frame.
    place: Vector3<f64>,
    outward: Vector3<f64>,
    tangent: Vector3<f64>,
    /// Angle of the tangent about the line of impact.
    angle: f64,
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.3?} degrees {:?} elements {:?} modes {}",
            self.kind, self.degrees, self.elements, self.modes
        )
    }
}

/// Both bodies of a pair of given radii and, for balls, rotations; contacts stay `clear` of edges by a multiple of the contact
/// radius `contact`.
pub fn draw_two(
    random: &mut Numbers,
    (radii, rotations): ([f64; 2], [UnitQuaternion<f64>; 2]),
    has_plane: bool,
    contact: f64,
) -> [Form; 2] {
    let choice = random.next();
    let first = match choice {
        ..0.6 => ball(random, radii[0]),
        ..0.8 => ellipsoid(random, radii[0]),
        _ if has_plane => ball(random, radii[0]),
        _ => Kind::Cylinder {
            radius: radii[0],
            length: (radii[0] * random.between(2.0, 8.0)).max(4.0 * CLEAR * contact),
        },
    };
    let side = radii[1].max(CLEAR * contact);
    let second = match (random.next(), first) {
        (..0.3, _) => ball(random, radii[1]),
        (..0.4, _) => ellipsoid(random, radii[1]),
        (..0.6, _) | (_, Kind::Cylinder { .. }) => Kind::Cylinder {
            radius: radii[1],
            length: (radii[1] * random.between(2.0, 8.0)).max(4.0 * CLEAR * contact),
        },
        (..0.7, _) => Kind::HollowCylinder {
            inner: radii[1] * random.between(0.3, 0.8),
            outer: radii[1],
            length: (radii[1] * random.between(2.0, 8.0)).max(4.0 * CLEAR * contact),
        },
        (..0.85, _) => Kind::CylinderEnd { radius: side, length: side * random.between(0.5, 6.0) },
        _ => Kind::Box {
            size: [2.0, 2.0 * random.between(1.0, 2.0), random.between(0.5, 6.0)].map(|s| s * side),
        },
    };
    let angle = random.between(0.0, TAU);
    // Crossed cylinders: side by side they would touch along a line.
    let other = angle + random.between(PI / 6.0, 5.0 * PI / 6.0);
    [Form::new(random, first, rotations[0], angle), Form::new(random, second, rotations[1], other)]
}

fn ball(random: &mut Numbers, radius: f64) -> Kind {
    let net = if random.next() < 0.75 { SphereNet::Spindle } else { SphereNet::Cube };
    Kind::Ball { net, radius }
}

fn ellipsoid(random: &mut Numbers, radius: f64) -> Kind {
    Kind::Ellipsoid { axes: [0; 3].map(|_| radius * random.between(1.0, 1.6)) }
}

fn whole(random: &mut Numbers, least: usize, most: usize) -> usize {
    least + (random.next() * (most + 1 - least) as f64) as usize
}

impl Form {
    fn new(random: &mut Numbers, kind: Kind, rotation: UnitQuaternion<f64>, angle: f64) -> Self {
        let p = whole(random, 2, 3);
        let mut of =
            |least: [usize; 3], most: [usize; 3]| [0, 1, 2].map(|d| whole(random, least[d], most[d]));
        let (degrees, elements) = match kind {
            Kind::Ball { net: SphereNet::Cube, .. } => ([4; 3], of([2; 3], [4; 3])),
            Kind::Ball { .. } | Kind::Ellipsoid { .. } => ([p, p, 3], of([4, 3, 3], [10, 6, 6])),
            Kind::Cylinder { .. } | Kind::CylinderEnd { .. } => ([p; 3], of([3; 3], [6, 6, 12])),
            Kind::HollowCylinder { .. } => ([p; 3], of([2, 8, 3], [4, 16, 8])),
            Kind::Box { .. } => ([p; 3], of([3; 3], [8; 3])),
        };
        let modes = whole(random, 6, 20);
        let (place, outward, tangent) = touched(random, kind, rotation);
        Self { kind, degrees, elements, modes, place, outward, tangent, angle }
    }

    pub fn is_ball(&self) -> bool {
        matches!(self.kind, Kind::Ball { .. })
    }

    /// Volume \[m³\].
    pub fn volume(&self) -> f64 {
        match self.kind {
            Kind::Ball { radius, .. } => 4.0 / 3.0 * PI * radius.powi(3),
            Kind::Ellipsoid { axes } => 4.0 / 3.0 * PI * axes.iter().product::<f64>(),
            Kind::Cylinder { radius, length } | Kind::CylinderEnd { radius, length } => {
                PI * radius * radius * length
            }
            Kind::HollowCylinder { inner, outer, length } => PI * (outer * outer - inner * inner) * length,
            Kind::Box { size } => size.iter().product(),
        }
    }

    /// Mean curvature where it is touched \[1/m\].
    pub fn curvature(&self) -> f64 {
        match self.kind {
            Kind::Ball { radius, .. } => 1.0 / radius,
            Kind::Ellipsoid { axes } => {
                let along = (0..3).max_by(|a, b| self.place[*a].abs().total_cmp(&self.place[*b].abs()));
                let along = along.unwrap_or_default();
                let across = (0..3).filter(|d| *d != along);
                across.map(|d| 0.5 * axes[along] / (axes[d] * axes[d])).sum()
            }
            Kind::Cylinder { radius, .. } => 0.5 / radius,
            Kind::HollowCylinder { outer, .. } => 0.5 / outer,
            Kind::CylinderEnd { .. } | Kind::Box { .. } => 0.0,
        }
    }

    fn shape(&self) -> Shape {
        let shape = match self.kind {
            Kind::Ball { net, radius } => sphere(radius, net),
            Kind::Ellipsoid { axes } => sphere(1.0, SphereNet::Spindle).and_then(|unit| {
                let patch = &unit.patches[0];
                let stretch = |p: &[f64; 3]| [0, 1, 2].map(|d| axes[d] * p[d]);
                let points = patch.control_points().iter().map(stretch).collect();
                Shape::from_patches(vec![Patch::new(
                    patch.knots().to_vec(),
                    points,
                    patch.weights().to_vec(),
                )?])
            }),
            Kind::Cylinder { radius, length } | Kind::CylinderEnd { radius, length } => {
                solid::cylinder(radius, length)
            }
            Kind::HollowCylinder { inner, outer, length } => solid::hollow_cylinder(inner, outer, length),
            Kind::Box { size } => solid::cuboid(size),
        };
        shape.expect("a shape of the catalogue")
    }

    /// The body with its touched point at height `height` and its outward normal there along `sign` times z.
    pub fn body(
        &self,
        name: &str,
        solid: Solid,
        height: f64,
        sign: f64,
        motion: &dyn Fn(Vector3<f64>, UnitQuaternion<f64>) -> InitialMotion,
    ) -> BodySpec {
        let own = Matrix3::from_columns(&[self.tangent, self.outward.cross(&self.tangent), self.outward]);
        let (along, up) = (Vector3::new(self.angle.cos(), self.angle.sin(), 0.0), Vector3::z() * sign);
        let there = Matrix3::from_columns(&[along, up.cross(&along), up]);
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(there * own.transpose()));
        let position = Vector3::z() * height - rotation * self.place;
        let material = Material::new(solid.youngs, solid.poisson, solid.density).expect("a material");
        let discretisation = DiscretisationSpec {
            degrees: self.degrees.to_vec(),
            elements: self.elements.to_vec(),
            knots: None,
            refine: Vec::new(),
        };
        let reduction = ReductionSpec::CraigBampton { modes: self.modes, fixed_interface_modes: None };
        let elastic = ElasticSpec::new(self.shape(), Model::Solid, material, discretisation, reduction);
        BodySpec {
            name: name.into(),
            kind: BodyKind::Elastic(Box::new(elastic)),
            motion: motion(position, rotation),
        }
    }
}

/// The point touched, the outward normal and a tangent there: along the axis on jackets.
fn touched(
    random: &mut Numbers,
    kind: Kind,
    rotation: UnitQuaternion<f64>,
) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let jacket = |random: &mut Numbers, radius: f64, length: f64| {
        let angle = random.between(0.0, TAU);
        let outward = Vector3::new(angle.cos(), angle.sin(), 0.0);
        (outward * radius + Vector3::z() * (length * random.between(0.4, 0.6)), outward, Vector3::z())
    };
    match kind {
        Kind::Ball { radius, .. } => {
            let outward = rotation * Vector3::z();
            (outward * radius, outward, rotation * Vector3::x())
        }
        Kind::Ellipsoid { axes } => {
            // Regular points of its net.
            let (d, sign) = ([0, 2][whole(random, 0, 1)], [-1.0, 1.0][whole(random, 0, 1)]);
            let outward = Vector3::ith(d, sign);
            (outward * axes[d], outward, Vector3::ith(2 - d, 1.0))
        }
        Kind::Cylinder { radius, length } => jacket(random, radius, length),
        Kind::HollowCylinder { outer, length, .. } => jacket(random, outer, length),
        Kind::CylinderEnd { radius, length } => {
            let [x, y] = [0; 2].map(|_| radius * random.between(-0.2, 0.2));
            (Vector3::new(x, y, length), Vector3::z(), Vector3::x())
        }
        Kind::Box { size } => {
            let [x, y] = [0, 1].map(|d| size[d] * random.between(-0.1, 0.1));
            (Vector3::new(x, y, 0.5 * size[2]), Vector3::z(), Vector3::x())
        }
    }
}
