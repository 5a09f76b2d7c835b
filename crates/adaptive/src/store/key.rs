//! What a model is made from, as bytes.
//!
//! Every struct is taken apart field by field without `..`, so that a new field does not compile before somebody decides
//! whether it belongs to a key. Numbers go in by their bits: neither formatting nor rounding can make two models one. Lists and
//! texts carry their lengths, choices a number, so that no two definitions have the same bytes.

use faer::Mat;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Shape;
use iga_core::nurbs::interface::FaceId;
use iga_core::surface::Face;

use crate::elastic_body::{ElasticBody, Interface, InterfaceModes, ReducedBody};
use crate::fine_model::{DivisionRule, FineSettings, WantedInterval};
use crate::sizing::SizeWish;
use crate::spec::{Area, DiscretisationSpec, ElasticSpec, Extent, ReductionSpec, RefinementSpec};

/// What a model is made from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelKey {
    /// What it is, a word.
    pub kind: &'static str,
    /// Everything that its numbers depend on, the program excepted.
    pub definition: Vec<u8>,
}

/// Key of the modes that `reduction` and `interface` make of a body with the `definition` of [`body_definition`]; `loads`: the columns of
/// the loads to which it has static answers.
pub fn modes_key(
    definition: &[u8],
    reduction: ReductionSpec,
    interface: &Interface,
    loads: &Mat<f64>,
) -> ModelKey {
    // Places and directions of loads are in their columns.
    let Interface { unknowns, modes, loads: _ } = interface;
    let mut key = Bytes(definition.to_vec());
    let is_static = *modes == InterfaceModes::Quasistatic;
    match reduction {
        ReductionSpec::Modal { modes } => {
            key.count(0);
            key.count(modes);
        }
        // Nothing is held, so these are the free modes.
        ReductionSpec::CraigBampton { modes, .. } if unknowns.is_empty() && !is_static => {
            key.count(0);
            key.count(modes);
        }
        ReductionSpec::CraigBampton { modes, fixed_interface_modes } => {
            key.count(1);
            key.count(modes);
            key.counts(fixed_interface_modes.as_slice());
        }
        ReductionSpec::All => key.count(2),
    }
    // Damping comes afterwards.
    key.count(usize::from(is_static));
    key.counts(unknowns);
    key.sparse(loads);
    ModelKey { kind: "modes", definition: key.0 }
}

/// Key of the compliance that the fine model of a body with modes prolonged from `coarse` has at the interface `unknowns`, and to
/// `points` of the body.
pub fn compliance_key(
    (body, reduced): (&ElasticBody, &ReducedBody),
    wanted: &WantedInterval,
    settings: &FineSettings,
    (unknowns, points): (&[usize], &[[f64; 3]]),
) -> ModelKey {
    let mut key = Bytes(body_definition(&body.spec));
    let basis = &reduced.basis;
    key.count(basis.n_low);
    key.numbers(&basis.omega);
    key.count(basis.shapes.nrows());
    for j in 0..basis.shapes.ncols() {
        basis.shapes.col(j).iter().for_each(|v| key.number(*v));
    }
    let WantedInterval { face, centre, widths } = wanted;
    let Face { id: FaceId { patch, direction, upper }, parameter, dimension, axisymmetric } = face;
    key.counts(&[*patch, *direction, usize::from(*upper), *dimension, usize::from(*axisymmetric)]);
    key.number(*parameter);
    key.numbers(centre);
    key.numbers(widths);
    let FineSettings { division, elements, growth } = settings;
    let division = match division {
        DivisionRule::Graded => 0,
        DivisionRule::Printed => 1,
    };
    key.counts(&[division, *elements]);
    key.counts(growth.as_slice());
    // They say as well by which points the contact is watched.
    key.counts(unknowns);
    key.points(points);
    ModelKey { kind: "compliance", definition: key.0 }
}

/// Key of the sizes that the program chooses for the body `trial`, on which sizes that are to be chosen are one, up to the frequency `limit` \[Hz\].
pub fn sizes_key(trial: &ElasticSpec, wish: SizeWish, limit: f64) -> ModelKey {
    let SizeWish { elements, modes } = wish;
    let mut key = Bytes(body_definition(trial));
    key.count(usize::from(elements));
    key.count(usize::from(modes));
    key.number(limit);
    match trial.reduction {
        ReductionSpec::Modal { modes: n } => key.counts(&[0, if modes { 0 } else { n }]),
        ReductionSpec::CraigBampton { modes: n, fixed_interface_modes } => {
            key.counts(&[1, if modes { 0 } else { n }]);
            key.counts(fixed_interface_modes.as_slice());
        }
        ReductionSpec::All => key.counts(&[2]),
    }
    ModelKey { kind: "sizes", definition: key.0 }
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
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn count(&mut self, n: usize) {
        self.0.extend((n as u64).to_le_bytes());
    }

    fn number(&mut self, x: f64) {
        self.0.extend(x.to_bits().to_le_bytes());
    }

    fn counts(&mut self, list: &[usize]) {
        self.count(list.len());
        list.iter().for_each(|n| self.count(*n));
    }

    fn numbers(&mut self, list: &[f64]) {
        self.count(list.len());
        list.iter().for_each(|x| self.number(*x));
    }

    fn points(&mut self, list: &[[f64; 3]]) {
        self.count(list.len());
        list.iter().flatten().for_each(|x| self.number(*x));
    }

    /// The entries of a matrix that are not zero.
    fn sparse(&mut self, matrix: &Mat<f64>) {
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
