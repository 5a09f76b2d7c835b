//! The coarse model of a body with its parametrisation turned, for contact where the body's own net
//! is singular (theory section A.3, `docs/decisions/0010-turned-nets.md`).
//!
//! A ball, cylinder or disc stays what it is when its net is turned, an ellipsoid when the ball
//! that it is stretched from is (theory Eq. A.16). So a contact interval can always be laid where
//! the net is regular and smooth: the fine model refines a turned copy of the coarse model, and the
//! coarse modes are carried over by projection.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatMut, MatRef, Side};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, Dof};
use ffr_dynamics::error::MatrixFault;
use iga_core::nurbs::Face;
use iga_core::nurbs::jet::{dot, norm};
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::shape::symmetry::{angle_about, product, rotation_about};
use iga_core::nurbs::{PatchSearch, Shape};
use iga_core::quadrature::GaussRule;
use iga_core::space::Space;
use rayon::prelude::*;

use crate::adaptivity::wanted_interval::WantedInterval;
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;
use crate::surface::turned_net::{nearest, unit};

/// How the net of a coarse model is turned for a contact interval.
#[derive(Debug, Clone, Copy)]
pub struct NetRotation {
    /// The rotation, of an ellipsoid a linear map that leaves it as it is; rows.
    pub rotation: [[f64; 3]; 3],
    /// The interval on the net before it is turned.
    pub wanted: WantedInterval,
}

impl NetRotation {
    /// The rotation of the net of `coarse` by which the interval `wanted` lies where the net is
    /// regular: about the first regular direction of a ball, wherever it is touched, so that all
    /// its intervals of the same widths are one; `None` if it does already, or the body has no
    /// symmetry.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the turned net cannot be built.
    pub fn new(coarse: &ElasticBody, wanted: &WantedInterval) -> Result<Option<Self>, AdaptiveError> {
        let shape = &coarse.spec.shape;
        let Some(symmetry) = &shape.symmetry else { return Ok(None) };
        let place = wanted.face.on_face(&wanted.centre);
        let surface =
            wanted.face.at(&shape.patches[wanted.face.id.patch], &place, &mut PointBasis::default());
        let at = |there: &[f64; 3]| {
            let (face, site) = nearest(&coarse.shape, there);
            (WantedInterval { face, centre: site.xi, widths: wanted.widths }, site)
        };
        let (Some(direction), true) = (symmetry.regular().first(), symmetry.is_ball()) else {
            let map = symmetry.map_to(&surface.point, &surface.normal);
            return Ok(map.map(|rotation| {
                let there = symmetry.inverse(&rotation).map(|row| dot(&row, &surface.point));
                Self { rotation, wanted: at(&there).0 }
            }));
        };
        let normal = surface.point;
        let Some(first) = symmetry.rotation_of_first_to(&normal) else { return Ok(None) };
        // To the last bit the same for all places.
        let (wanted, site) = at(&scaled(direction, norm(&first_point(&coarse.shape))));
        // The directions along the face stay those that widths were asked for, as far as the net
        // allows.
        let along = first.map(|row| dot(&row, &site.tangents[0]));
        let angle = angle_about(&unit(&normal), &along, &surface.tangents[0]);
        Ok(Some(Self { rotation: product(&rotation_about(&unit(&normal), angle), &first), wanted }))
    }
}

/// A point on the surface of a shape, always the same.
fn first_point(shape: &Shape) -> [f64; 3] {
    let faces = Face::outer(&shape.patches, false);
    let face = faces.first().expect("a body has an outer face");
    shape.patches[face.id.patch].point(&face.on_face(&[0.0; 3]))
}

/// The products by which displacements are carried to a turned net.
pub struct RotatedNet {
    /// How it is turned.
    pub turn: NetRotation,
    /// `∫ ρ R_A(rotated) R_B(coarse) dV` \[kg\], a row per rotated function.
    cross: Vec<Vec<(u32, f64)>>,
    mass: Llt<u32, f64>,
}

impl RotatedNet {
    /// The copy of the model `coarse` whose net is turned by `turn`, with its mass matrix
    /// factorised for the transfer of modes.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the turned net cannot be built, [`AdaptiveError::Reduction`] if its mass is singular.
    pub fn new(coarse: &ElasticBody, turn: NetRotation) -> Result<Self, AdaptiveError> {
        let (cross, own) = mass_products(coarse, &turn.rotation);
        let lower = |(a, row): (usize, &Vec<(u32, f64)>)| {
            let entries = row.iter().filter(move |e| e.0 as usize <= a);
            entries.map(move |&(b, m)| Triplet::new(a as u32, b, m)).collect::<Vec<_>>()
        };
        let triplets: Vec<_> = own.iter().enumerate().flat_map(lower).collect();
        let singular = || {
            let (matrix, fault) = ("the mass matrix of a rotated net", MatrixFault::Singular);
            let source = DynamicsError::Factorisation { matrix, fault };
            AdaptiveError::Reduction { body: coarse.name.clone(), source }
        };
        let mass = SparseColMat::<u32, f64>::try_new_from_triplets(own.len(), own.len(), &triplets);
        let mass = mass.map_err(|_| singular())?.sp_cholesky(Side::Lower).map_err(|_| singular())?;
        Ok(Self { turn, cross, mass })
    }

    /// Displacements of the coarse unknowns (n x k) on those of the turned net, which have the same
    /// numbers: the nearest ones in the mass norm.
    pub fn prolong(&self, coarse: &AssembledBody, shapes: MatRef<'_, f64>) -> Mat<f64> {
        let n_components = coarse.motion.n_components();
        let width = n_components * shapes.ncols();
        let column = |dof: &Dof, j: usize| j * n_components + dof.component as usize;
        // A row a function, for both passes go over the functions.
        let mut values = vec![0.0; coarse.nodes.len() * width];
        for (i, dof) in coarse.dofs.iter().enumerate() {
            let row = &mut values[dof.node as usize * width..][..width];
            (0..shapes.ncols()).for_each(|j| row[column(dof, j)] = shapes[(i, j)]);
        }
        let mut right = vec![0.0; self.cross.len() * width];
        let add_products = |(row, products): (&mut [f64], &Vec<(u32, f64)>)| {
            for &(b, m) in products {
                let values = &values[b as usize * width..][..width];
                row.iter_mut().zip(values).for_each(|(sum, value)| *sum += m * value);
            }
        };
        right.par_chunks_mut(width.max(1)).zip(&self.cross).for_each(add_products);
        let mut right = MatMut::from_row_major_slice_mut(&mut right, self.cross.len(), width);
        self.mass.solve_in_place(right.as_mut());
        let entry = |i: usize, j: usize| {
            let dof = coarse.dofs[i];
            right[(dof.node as usize, column(&dof, j))]
        };
        Mat::from_fn(coarse.dofs.len(), shapes.ncols(), entry)
    }
}

/// Entries of a matrix row by row.
type Rows = Vec<Vec<(u32, f64)>>;

/// Products of the functions of one element with others, summed over its Gauss points before they
/// enter the matrix: there are as many products a point as entries of the element.
struct ElementSums {
    /// The other functions met so far.
    columns: Vec<u32>,
    /// Number of each of the other functions among `columns`, or `NONE`.
    place: Vec<u32>,
    /// Sums, the functions of the element next to each other.
    sums: Vec<f64>,
}

/// No place among the columns.
const NONE: u32 = u32::MAX;

impl ElementSums {
    fn new(n_others: usize) -> Self {
        Self { columns: Vec::new(), place: vec![NONE; n_others], sums: Vec::new() }
    }

    /// Adds `factor * values[a] * other_values[b]` for every function `a` of the element and every
    /// one of `others`.
    fn add(&mut self, (values, factor): (&[f64], f64), (others, other_values): (&[u32], &[f64])) {
        for (other, other_value) in others.iter().zip(other_values) {
            let place = &mut self.place[*other as usize];
            if *place == NONE {
                *place = self.columns.len() as u32;
                self.columns.push(*other);
                self.sums.resize(self.sums.len() + values.len(), 0.0);
            }
            let column = &mut self.sums[*place as usize * values.len()..][..values.len()];
            column.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value * other_value);
        }
    }

    /// The sums of the element; none are left.
    fn take(&mut self) -> ElementProducts {
        self.columns.iter().for_each(|column| self.place[*column as usize] = NONE);
        ElementProducts { columns: std::mem::take(&mut self.columns), sums: std::mem::take(&mut self.sums) }
    }
}

/// Products of the functions of one element with others.
struct ElementProducts {
    columns: Vec<u32>,
    /// The functions of the element next to each other.
    sums: Vec<f64>,
}

impl ElementProducts {
    /// Adds them to the rows of the element's `functions`.
    fn hand_over(&self, functions: &[u32], rows: &mut Rows) {
        for (column, sums) in self.columns.iter().zip(self.sums.chunks_exact(functions.len())) {
            functions.iter().zip(sums).for_each(|(f, sum)| rows[*f as usize].push((*column, *sum)));
        }
    }
}

/// What a thread needs for the products of an element: sums with the functions of the other net and
/// among themselves, values of both, numbers of the others.
type Scratch = (ElementSums, ElementSums, PointBasis, PointBasis, Vec<u32>);

/// Distance of a place from the point looked for, as a share of the body's size, that is round-off:
/// there the search from the neighbouring point has met it.
const MET: f64 = 1e-12;

/// `∫ ρ R_A R_B dV` of the functions, an integral over the area in plane models, whose thickness
/// drops out, on the turned net with those of the coarse one, and among themselves. Both by the
/// same Gauss points, so that what both nets hold is carried over exactly: near collapsed faces
/// integrals depend on the points.
fn mass_products(coarse: &ElasticBody, rotation: &[[f64; 3]; 3]) -> (Rows, Rows) {
    let patch = &coarse.shape.patches[0];
    let space = &coarse.space;
    // Parameters do not change under refinement, and the shape of the scenario is the cheapest to
    // search.
    let (own, searched) = (&coarse.spec.shape.patches[0], &coarse.shape.patches[0]);
    let search = PatchSearch::new(own, [None; 3]);
    let size = coarse.size();
    let density = coarse.spec.material.density();
    let n_functions = space.n_functions();
    let scratch = || {
        let sums = || ElementSums::new(n_functions);
        (sums(), sums(), PointBasis::default(), PointBasis::default(), Vec::new())
    };
    let of_element = |(sums, mass_sums, a, b, on_coarse): &mut Scratch, e: usize| {
        let (lower, upper) = patch.element(e);
        let mut functions = Vec::new();
        space.active_functions(e, &mut functions);
        let mut last = None;
        for (xi, weight) in gauss(coarse, lower, upper) {
            let jet = patch.jet_on(e, &xi, 1, b);
            let mass = density * weight * jet.determinant(patch.dimension());
            space.evaluate(e, &xi, 0, a);
            let target = rotation.map(|row| dot(&row, &jet.point));
            let near = last.and_then(|start| search.inverse_from(own, &target, (&start, MET * size), b));
            let there = near.unwrap_or_else(|| search.closest(own, &target).xi);
            last = Some(there);
            let element = searched.find_element(&there);
            space.active_functions(element, on_coarse);
            space.evaluate(element, &there, 0, b);
            sums.add((&a.values, mass), (on_coarse, &b.values));
            mass_sums.add((&a.values, mass), (&functions, &a.values));
        }
        (functions, sums.take(), mass_sums.take())
    };
    let of_elements: Vec<_> = (0..space.n_elements()).into_par_iter().map_init(scratch, of_element).collect();
    let mut rows: Rows = vec![Vec::new(); n_functions];
    let mut mass_rows = rows.clone();
    for (functions, products, masses) in of_elements {
        products.hand_over(&functions, &mut rows);
        masses.hand_over(&functions, &mut mass_rows);
    }
    for row in rows.iter_mut().chain(&mut mass_rows) {
        row.sort_by_key(|e: &(u32, f64)| e.0);
        row.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
    }
    (rows, mass_rows)
}

/// Gauss points of an element with their weights in the parameters.
fn gauss(body: &ElasticBody, lower: [f64; 3], upper: [f64; 3]) -> Vec<([f64; 3], f64)> {
    let knots = body.shape.patches[0].knots();
    let rules: [Vec<(f64, f64)>; 3] = std::array::from_fn(|d| {
        let Some(knots) = knots.get(d) else { return vec![(0.0, 1.0)] };
        let rule = GaussRule::new(knots.degree() + 1);
        let mut points = Vec::new();
        rule.points_on(lower[d], upper[d], &mut points);
        let half = 0.5 * (upper[d] - lower[d]);
        points.into_iter().zip(rule.weights.iter().map(|w| w * half)).collect()
    });
    let mut all = Vec::with_capacity(rules.iter().map(Vec::len).product());
    for &(z, wz) in &rules[2] {
        for &(y, wy) in &rules[1] {
            all.extend(rules[0].iter().map(|&(x, wx)| ([x, y, z], wx * wy * wz)));
        }
    }
    all
}

fn scaled(v: &[f64; 3], factor: f64) -> [f64; 3] {
    v.map(|c| factor * c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_element_has_one_entry_for_a_pair_of_functions_whatever_its_points() {
        let (functions, mut rows) = ([3, 1], vec![Vec::new(); 4]);
        let mut sums = ElementSums::new(6);
        for _ in 0..2 {
            // 1000 points in one element of the other net, 10 in its neighbour; exact in binary
            // arithmetic.
            (0..1000).for_each(|_| sums.add((&[1.0, 0.5], 2.0), (&[4, 2], &[0.25, 4.0])));
            (0..10).for_each(|_| sums.add((&[1.0, 0.5], 1.0), (&[2, 5], &[1.0, 2.0])));
            sums.take().hand_over(&functions, &mut rows);
        }
        let row = |factor: f64| {
            let element = [(4, 500.0), (2, 8010.0), (5, 20.0)].map(|(other, sum)| (other, factor * sum));
            element.repeat(2)
        };
        assert_eq!(rows, [Vec::new(), row(0.5), Vec::new(), row(1.0)]);
    }
}
