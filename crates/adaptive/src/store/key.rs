//! What a model is made from, as bytes.
//!
//! Every struct is taken apart field by field without `..`, so that a new field does not compile before somebody decides
//! whether it belongs to a key. Numbers go in by their bits: neither formatting nor rounding can make two models one. Lists and
//! texts carry their lengths, choices a number, so that no two definitions have the same bytes.

use faer::Mat;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;

use crate::spec::{Area, DiscretisationSpec, ElasticSpec, Extent, RefinementSpec};

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
    let ElasticSpec {
        shape,
        model,
        material,
        discretisation,
        reduction: _,
        static_answers: _,
        rigid_areas,
        damping: _,
        frame: _,
        geometric_stiffening: _,
    } = spec;
    let mut key = Bytes::default();
    key.shape(shape);
    key.model(model);
    key.material(material);
    key.discretisation(discretisation);
    key.count(rigid_areas.len());
    rigid_areas.iter().for_each(|area| key.area(area));
    key.0
}

/// Bytes of a definition.
#[derive(Debug, Default)]
pub struct Bytes(pub Vec<u8>);

impl Bytes {
    /// A count or choice.
    pub fn count(&mut self, n: usize) {
        self.0.extend((n as u64).to_le_bytes());
    }

    /// A number by its bits.
    pub fn number(&mut self, x: f64) {
        self.0.extend(x.to_bits().to_le_bytes());
    }

    /// A list of counts with its length.
    pub fn counts(&mut self, list: &[usize]) {
        self.count(list.len());
        list.iter().for_each(|n| self.count(*n));
    }

    /// A list of numbers with its length.
    pub fn numbers(&mut self, list: &[f64]) {
        self.count(list.len());
        list.iter().for_each(|x| self.number(*x));
    }

    /// A list of points with its length.
    pub fn points(&mut self, list: &[[f64; 3]]) {
        self.count(list.len());
        list.iter().flatten().for_each(|x| self.number(*x));
    }

    /// The entries of a matrix that are not zero.
    pub fn sparse(&mut self, matrix: &Mat<f64>) {
        self.counts(&[matrix.nrows(), matrix.ncols()]);
        for column in matrix.col_iter() {
            let entries: Vec<(usize, f64)> =
                column.iter().copied().enumerate().filter(|(_, v)| v.abs() > 0.0).collect();
            self.count(entries.len());
            for (row, value) in entries {
                self.count(row);
                self.number(value);
            }
        }
    }

    fn shape(&mut self, shape: &Shape) {
        // Markers and faces are names of places, spelled out where a model depends on them; singular sets follow from the patches and only say what is refused.
        let Shape { patches, markers: _, faces: _, singular: _, symmetry } = shape;
        self.count(patches.len());
        for patch in patches {
            self.count(patch.knots().len());
            for knots in patch.knots() {
                self.count(knots.degree());
                self.numbers(knots.knots());
            }
            self.points(patch.control_points());
            self.numbers(patch.weights());
        }
        self.count(usize::from(symmetry.is_some()));
        if let Some(symmetry) = symmetry {
            self.points(symmetry.axis().map(std::slice::from_ref).unwrap_or_default());
            self.points(symmetry.regular());
        }
    }

    fn area(&mut self, area: &Area) {
        let Area { extent, centre, coupling: _ } = area;
        match extent {
            Extent::Face(name) => {
                self.count(0);
                self.count(name.len());
                self.0.extend(name.as_bytes());
            }
            Extent::Around { point, radius } => {
                self.count(1);
                self.numbers(point);
                self.number(*radius);
            }
        }
        self.numbers(centre);
    }

    fn model(&mut self, model: &Model) {
        match model {
            Model::PlaneStrain { thickness } => {
                self.count(0);
                self.number(*thickness);
            }
            Model::PlaneStress { thickness } => {
                self.count(1);
                self.number(*thickness);
            }
            Model::Axisymmetric => self.count(2),
            Model::Solid => self.count(3),
        }
    }

    fn material(&mut self, material: &Material) {
        self.numbers(&[material.youngs_modulus(), material.poissons_ratio(), material.density()]);
    }

    fn discretisation(&mut self, spec: &DiscretisationSpec) {
        let DiscretisationSpec { degrees, elements, knots, refine } = spec;
        self.counts(degrees);
        self.counts(elements);
        self.count(knots.as_ref().map_or(0, |k| k.len() + 1));
        knots.iter().flatten().for_each(|k| self.numbers(k));
        self.count(refine.len());
        for RefinementSpec { centre, width, elements, ratio } in refine {
            self.numbers(centre);
            self.numbers(&[*width, *ratio]);
            self.count(*elements);
        }
    }
}
