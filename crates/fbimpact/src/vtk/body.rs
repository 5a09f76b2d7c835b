//! A body cut into Bézier elements, and its displacement and stress on them.

use ffr_dynamics::body::RigidMotion;
use iga_core::SplineError;
use iga_core::elasticity::{Material, Model};
use iga_core::knots::KnotVector;
use iga_core::nurbs::Patch;
use iga_core::recovery::RecoveryWorkspace;
use iga_core::space::{PatchSpace, Space};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::bernstein::{apply, coefficients, extrapolation, inset_point, values};

/// Part of an element that samples of the stress keep from its ends, about as Gauss points do: on poles and singular lines
/// gradients do not exist, and near them they are wrong.
const INSET: f64 = 0.1;

/// Kind of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cells {
    /// Rational Bézier cells: nodes are control points, fields control values.
    Bezier,
    /// Linear cells: nodes and fields are points and values of the body. Each element is cut into so many a direction, at least.
    Linear(usize),
}

/// One element.
#[derive(Debug, Clone)]
pub struct Element {
    /// Steps from node to node a direction; the degrees of a Bézier cell.
    pub steps: Vec<usize>,
    /// Nodes of the undeformed element in the model's components \[m\], first direction fastest.
    pub nodes: Vec<[f64; 3]>,
    /// Weights of the nodes; one for linear cells.
    pub weights: Vec<f64>,
    /// Number in the space.
    number: usize,
    patch: usize,
    /// Entries of the Bézier net of the patch.
    net: Vec<usize>,
    degrees: Vec<usize>,
    /// Parameters of the points at which the stress is sampled.
    samples: Vec<[f64; 3]>,
}

/// Displacement, velocity relative to the frame, and stress of an element.
#[derive(Debug, Clone, Default)]
pub struct ElementFields {
    /// Displacement of the nodes \[m\].
    pub displacement: Vec<[f64; 3]>,
    /// Its rate [m/s].
    pub rate: Vec<[f64; 3]>,
    /// Stress at points equally spaced in the parameters, one a node, components of the model \[Pa\]; empty for rigid bodies.
    pub stress: Vec<[f64; 6]>,
}

/// What a rigid body lacks.
#[derive(Debug, Clone)]
pub struct Elasticity {
    /// Kinematics.
    pub model: Model,
    /// Material.
    pub material: Material,
}

/// Geometry of a body, element by element.
pub struct BodyGeometry {
    /// Rigid motions of its model.
    pub motion: RigidMotion,
    /// Elements.
    pub elements: Vec<Element>,
    /// Kind of its cells.
    pub cells: Cells,
    space: PatchSpace,
    bezier: Vec<Patch>,
    elasticity: Option<Elasticity>,
}

impl BodyGeometry {
    /// Cuts the patches of `space` into elements.
    ///
    /// # Errors
    /// [`SplineError`] of knot vectors that cannot be refined.
    pub fn new(
        space: PatchSpace,
        motion: RigidMotion,
        elasticity: Option<Elasticity>,
        cells: Cells,
    ) -> Result<Self, SplineError> {
        let bezier = space.patches().iter().map(bezier).collect::<Result<Vec<_>, _>>()?;
        let mut elements = Vec::with_capacity(space.n_elements());
        for (p, patch) in bezier.iter().enumerate() {
            for e in 0..patch.n_elements() {
                elements.push(element(&space, (p, patch), e, cells));
            }
        }
        Ok(Self { motion, elements, cells, space, bezier, elasticity })
    }

    /// Number of control values of a field.
    pub fn n_control_values(&self) -> usize {
        self.space.n_functions() * self.motion.n_components()
    }

    /// Fields of all elements for node-major control values of the displacement \[m\] and its rate [m/s].
    ///
    /// # Errors
    /// [`SplineError`] where the geometry is folded.
    pub fn fields(&self, displacement: &[f64], rate: &[f64]) -> Result<Vec<ElementFields>, SplineError> {
        let displacements = self.prolonged(displacement)?;
        let rates = self.prolonged(rate)?;
        let one = |workspace: &mut RecoveryWorkspace, element: &Element| {
            let field = |nets: &[Vec<[f64; 3]>]| self.at_nodes(element, &nets[element.patch]);
            let stress = match &self.elasticity {
                Some(elasticity) => self.stress(elasticity, workspace, element, displacement)?,
                None => Vec::new(),
            };
            Ok(ElementFields { displacement: field(&displacements), rate: field(&rates), stress })
        };
        self.elements.par_iter().map_init(RecoveryWorkspace::default, one).collect()
    }

    /// Stress at the equally spaced points of an element, from points inside.
    fn stress(
        &self,
        elasticity: &Elasticity,
        workspace: &mut RecoveryWorkspace,
        element: &Element,
        displacement: &[f64],
    ) -> Result<Vec<[f64; 6]>, SplineError> {
        let Elasticity { model, material } = elasticity;
        let at = |xi| workspace.stress(&self.space, model, material, displacement, element.number, xi);
        let inner =
            element.samples.iter().map(at).map(|s| s.map(|s| s.stress)).collect::<Result<Vec<_>, _>>()?;
        let outwards: Vec<DMatrix<f64>> = element.steps.iter().map(|&n| extrapolation(n, INSET)).collect();
        Ok(apply(&outwards.iter().collect::<Vec<_>>(), &inner))
    }

    /// Control values on the Bézier nets of all patches.
    fn prolonged(&self, field: &[f64]) -> Result<Vec<Vec<[f64; 3]>>, SplineError> {
        let n = self.motion.n_components();
        let patches = self.space.patches().iter().zip(&self.bezier).enumerate();
        let net = |(p, (coarse, fine)): (usize, (&Patch, &Patch))| {
            let entry = |&function: &u32| {
                let mut value = [0.0; 3];
                let at = function as usize * n;
                value[..n].copy_from_slice(&field[at..at + n]);
                value
            };
            let entries: Vec<[f64; 3]> = self.space.functions(p).iter().map(entry).collect();
            coarse.prolong_field(fine, &entries)
        };
        patches.map(net).collect()
    }

    /// A field at the nodes of an element, from its control values on the Bézier net.
    fn at_nodes(&self, element: &Element, net: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let local: Vec<[f64; 3]> = element.net.iter().map(|&i| net[i]).collect();
        if self.cells == Cells::Bezier {
            return local;
        }
        let weights: Vec<f64> =
            element.net.iter().map(|&i| self.bezier[element.patch].weights()[i]).collect();
        sampled(&element.degrees, &element.steps, &local, &weights)
    }
}

/// Values at the equally spaced points of a rational field with the control values `net`.
fn sampled(degrees: &[usize], steps: &[usize], net: &[[f64; 3]], weights: &[f64]) -> Vec<[f64; 3]> {
    let matrices: Vec<DMatrix<f64>> = degrees.iter().zip(steps).map(|(&p, &n)| values(p, n)).collect();
    let homogeneous: Vec<[f64; 4]> =
        net.iter().zip(weights).map(|(v, w)| [v[0] * w, v[1] * w, v[2] * w, *w]).collect();
    let values = apply(&matrices.iter().collect::<Vec<_>>(), &homogeneous);
    values.iter().map(|v| [v[0] / v[3], v[1] / v[3], v[2] / v[3]]).collect()
}

/// Control values of a rational field on a cell with `weights` from its values at equally spaced points.
pub fn control_values<const N: usize>(
    degrees: &[usize],
    weights: &[f64],
    samples: &[[f64; N]],
) -> Vec<[f64; N]> {
    let evaluate: Vec<DMatrix<f64>> = degrees.iter().map(|&p| values(p, p)).collect();
    let invert: Vec<DMatrix<f64>> = degrees.iter().map(|&p| coefficients(p)).collect();
    let lifted: Vec<[f64; 1]> = weights.iter().map(|w| [*w]).collect();
    let w = apply(&evaluate.iter().collect::<Vec<_>>(), &lifted);
    let weighted: Vec<[f64; N]> = samples.iter().zip(&w).map(|(s, w)| s.map(|c| c * w[0])).collect();
    let net = apply(&invert.iter().collect::<Vec<_>>(), &weighted);
    net.iter().zip(weights).map(|(v, w)| v.map(|c| c / w)).collect()
}

/// The patch with every interior knot repeated as often as its degree: each element has its own block of control points.
fn bezier(patch: &Patch) -> Result<Patch, SplineError> {
    let mut fine = patch.clone();
    for (d, knots) in patch.knots().iter().enumerate() {
        let (p, breaks) = (knots.degree(), knots.breaks());
        let last = breaks.len() - 1;
        let repeat = |(i, &u): (usize, &f64)| vec![u; if i == 0 || i == last { p + 1 } else { p }];
        let full = breaks.iter().enumerate().flat_map(repeat).collect();
        fine = fine.refine_to(d, &KnotVector::new(p, full)?)?;
    }
    Ok(fine)
}

fn element(space: &PatchSpace, (index, patch): (usize, &Patch), e: usize, cells: Cells) -> Element {
    let degrees: Vec<usize> = patch.knots().iter().map(KnotVector::degree).collect();
    let (counts, sizes) = (patch.element_counts(), patch.net_size());
    let mut rest = e;
    let place: Vec<usize> = counts
        .iter()
        .map(|n| {
            let i = rest % n;
            rest /= n;
            i
        })
        .collect();
    let net = indices(&degrees, |local| {
        let entry = |d: usize| place[d] * degrees[d] + local[d];
        (0..degrees.len()).rev().fold(0, |flat, d| flat * sizes[d] + entry(d))
    });
    let steps: Vec<usize> = match cells {
        Cells::Bezier => degrees.clone(),
        Cells::Linear(least) => degrees.iter().map(|&p| p.max(least)).collect(),
    };
    let (lower, upper) = patch.element(e);
    let samples = indices(&steps, |local| {
        let mut xi = [0.0; 3];
        for (d, &i) in local.iter().enumerate().take(steps.len()) {
            xi[d] = lower[d] + (upper[d] - lower[d]) * inset_point(i, steps[d], INSET);
        }
        xi
    });
    let points: Vec<[f64; 3]> = net.iter().map(|&i| patch.control_points()[i]).collect();
    let weights: Vec<f64> = net.iter().map(|&i| patch.weights()[i]).collect();
    let number = space.element_of_patch(index, e);
    let (nodes, weights) = match cells {
        Cells::Bezier => (points, weights),
        Cells::Linear(_) => (sampled(&degrees, &steps, &points, &weights), vec![1.0; samples.len()]),
    };
    Element { steps, nodes, weights, number, patch: index, net, degrees, samples }
}

/// `f` of all indices `0..=steps` a direction, first direction fastest.
fn indices<T>(steps: &[usize], f: impl Fn([usize; 3]) -> T) -> Vec<T> {
    let n = |d: usize| steps.get(d).copied().unwrap_or(0);
    let mut all = Vec::new();
    for k in 0..=n(2) {
        for j in 0..=n(1) {
            for i in 0..=n(0) {
                all.push(f([i, j, k]));
            }
        }
    }
    all
}
