//! What a model is made from, as bytes.
//!
//! Every struct is taken apart field by field without `..`, so that a new field does not compile
//! before somebody decides whether it belongs to a key. Numbers go in by their bits: neither
//! formatting nor rounding can make two models one. Lists and texts carry their lengths, choices
//! have a number, so that no two definitions have the same bytes.

use faer::{ColRef, Mat};
use fe_mesh::element::rules::MassRule;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use serde::Serialize;

use crate::spec::{Area, DiscretisationSpec, ElasticSpec, Extent, FlexibleSpec, MeshedSpec, RefinementSpec};

/// What a model is made from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelKey {
    /// What it is, a word.
    pub kind: &'static str,
    /// Everything that its numbers depend on, the program excepted.
    pub definition: Vec<u8>,
}

/// What a body's matrices are made from: shape, kinematics, material, spline space, rigid parts.
///
/// Modes, damping, frame and stiffening come after the matrices and are none of it.
pub fn body_definition(spec: &ElasticSpec) -> Vec<u8> {
    let ElasticSpec { shape, model, material, discretisation, flexible } = spec;
    let mut key = Bytes::default();
    key.shape(shape);
    key.model(model);
    key.material(material);
    key.discretisation(discretisation);
    let rigid_areas = of_matrices(flexible);
    key.add(&rigid_areas.len());
    rigid_areas.iter().for_each(|area| key.area(area));
    key.0
}

/// The parts of `flexible` on which the matrices of a body depend: its rigid areas.
fn of_matrices(flexible: &FlexibleSpec) -> &[Area] {
    let FlexibleSpec {
        reduction: _,
        static_answers: _,
        rigid_areas,
        damping: _,
        frame: _,
        geometric_stiffening: _,
    } = flexible;
    rigid_areas
}

/// What the matrices of a body of finite elements are made from: nodes, elements, materials, rule
/// of the mass, rigid parts.
pub fn meshed_definition(spec: &MeshedSpec) -> Vec<u8> {
    let MeshedSpec { mesh, material, groups, mass_rule, flexible } = spec;
    let mut key = Bytes::default();
    // No definition of a body of splines begins like this.
    key.add("mesh");
    key.model(mesh.model());
    key.add(mesh.nodes());
    key.add(&mesh.elements().len());
    for element in mesh.elements().iter() {
        key.add(&(element.kind.name(), element.nodes));
    }
    key.add(&(material.is_some(), groups.len(), *mass_rule == MassRule::Exact));
    material.iter().for_each(|m| key.material(m));
    for (name, material) in groups {
        key.add(&mesh.volume_group(name).unwrap_or_default());
        key.material(material);
    }
    let rigid_areas = of_matrices(flexible);
    key.add(&rigid_areas.len());
    for area in rigid_areas {
        key.area(area);
        if let Extent::Face(name) = &area.extent {
            // A name means the faces that the file gives it.
            let faces = mesh.face_group(name).unwrap_or_default();
            key.add(&faces.iter().map(|f| (f.element, f.side)).collect::<Vec<_>>());
        }
    }
    key.0
}

/// Bytes of a definition: values in the order in which they come, in the encoding of postcard.
#[derive(Debug, Default)]
pub struct Bytes(pub Vec<u8>);

impl Bytes {
    /// A value; lists and texts carry their lengths, numbers every bit.
    ///
    /// # Panics
    /// Never for counts, numbers, texts and lists of them.
    pub fn add<T: Serialize + ?Sized>(&mut self, value: &T) {
        let bytes = std::mem::take(&mut self.0);
        self.0 =
            postcard::to_extend(value, bytes).expect("lists know their lengths, and memory does not end");
    }

    /// The entries of a matrix that are not zero, column by column.
    pub fn sparse(&mut self, matrix: &Mat<f64>) {
        self.add(&matrix.nrows());
        let entries = |column: ColRef<'_, f64>| -> Vec<(usize, f64)> {
            column.iter().copied().enumerate().filter(|(_, v)| v.abs() > 0.0).collect()
        };
        self.add(&matrix.col_iter().map(entries).collect::<Vec<_>>());
    }

    fn shape(&mut self, shape: &Shape) {
        // Markers and faces are names of places, spelled out where a model depends on them;
        // singular sets follow from the patches and only say what is refused; parts are in the
        // patches.
        let Shape { patches, markers: _, faces: _, singular: _, symmetry, parts: _ } = shape;
        self.add(&patches.len());
        for patch in patches {
            self.add(&patch.knots().len());
            for knots in patch.knots() {
                self.add(&(knots.degree(), knots.knots()));
            }
            self.add(&(patch.control_points(), patch.weights()));
        }
        self.add(
            &symmetry.as_ref().map(|symmetry| (symmetry.axis(), symmetry.regular(), symmetry.stretch())),
        );
    }

    fn area(&mut self, area: &Area) {
        let Area { extent, centre, coupling: _ } = area;
        match extent {
            Extent::Face(name) => self.add(&(0, name)),
            Extent::Around { point, radius } => self.add(&(1, point, radius)),
        }
        self.add(centre);
    }

    fn model(&mut self, model: &Model) {
        match model {
            Model::PlaneStrain { thickness } => self.add(&(0, thickness)),
            Model::PlaneStress { thickness } => self.add(&(1, thickness)),
            Model::Axisymmetric => self.add(&2),
            Model::Solid => self.add(&3),
        }
    }

    fn material(&mut self, material: &Material) {
        self.add(&[material.youngs_modulus(), material.poissons_ratio(), material.density()]);
    }

    fn discretisation(&mut self, spec: &DiscretisationSpec) {
        let DiscretisationSpec { degrees, elements, knots, refine } = spec;
        self.add(&(degrees, elements, knots));
        self.add(&refine.len());
        for RefinementSpec { centre, width, elements, ratio } in refine {
            self.add(&(centre, width, ratio, elements));
        }
    }
}
