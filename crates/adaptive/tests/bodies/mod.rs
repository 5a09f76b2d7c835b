//! Bodies of [A] section 5.

use adaptive::adaptivity::wanted_interval::WantedInterval;
use adaptive::body::splines::ElasticBody;
use adaptive::spec::{DiscretisationSpec, ElasticSpec, ReductionSpec};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, solid};
use iga_core::surface::BodySurface;

pub fn body(name: &str, shape: Shape, material: Material, elements: [usize; 2], modes: usize) -> ElasticBody {
    ElasticBody::build(name, specification(shape, material, elements, modes)).unwrap()
}

/// Steel block of 20 mm, 6 modes.
pub fn block(elements: usize) -> ElasticBody {
    block_of(elements, 2)
}

/// The same of splines of degree `degree`.
pub fn block_of(elements: usize, degree: usize) -> ElasticBody {
    let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
    let mut spec = specification(solid::cuboid([0.02; 3]).unwrap(), steel, [1, 1], 6);
    spec.model = Model::Solid;
    spec.discretisation.degrees = vec![degree; 3];
    spec.discretisation.elements = vec![elements; 3];
    ElasticBody::build("block", spec).unwrap()
}

/// Solid steel ball, radius 10 mm, of the net with poles at `y = ±r`.
pub fn ball() -> ElasticBody {
    let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
    let shape = iga_core::nurbs::primitives::sphere::sphere(0.01, SphereNet::Spindle).unwrap();
    let mut spec = specification(shape, steel, [1, 1], 6);
    spec.model = Model::Solid;
    spec.discretisation.degrees = vec![2, 2, 3];
    spec.discretisation.elements = vec![8, 4, 4];
    ElasticBody::build("ball", spec).unwrap()
}

fn specification(shape: Shape, material: Material, elements: [usize; 2], modes: usize) -> ElasticSpec {
    let discretisation = DiscretisationSpec {
        degrees: vec![3, 3],
        elements: elements.to_vec(),
        knots: None,
        refine: Vec::new(),
    };
    ElasticSpec::new(shape, Model::Axisymmetric, material, discretisation, ReductionSpec::Modal { modes })
}

/// Steel sphere, radius 10 mm, 10 modes.
pub fn sphere(elements: [usize; 2]) -> ElasticBody {
    let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
    body("sphere", axisymmetric::sphere(0.01).unwrap(), steel, elements, 10)
}

/// Aluminium rod, radius 10 mm, 1 m, 20 modes.
pub fn rod(elements: [usize; 2]) -> ElasticBody {
    let aluminium = Material::new(72.8e9, 0.33, 2789.0).unwrap();
    body("rod", axisymmetric::rod(0.01, 1.0).unwrap(), aluminium, elements, 20)
}

/// The interval around the surface point at `place`.
pub fn wanted_at(body: &ElasticBody, place: [f64; 3], width: f64) -> WantedInterval {
    let patches = &body.shape.patches;
    let surface = BodySurface::new(patches, body.spec.model == Model::Axisymmetric);
    let at = surface.closest(patches, &place).unwrap();
    WantedInterval { face: surface.faces()[at.face], centre: at.xi, widths: [width; 2] }
}
