//! A body cut into Bézier elements, and its displacement and stress on them.

use faer::Mat;
use ffr_dynamics::body::RigidMotion;
use iga_core::SplineError;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::Space;
use iga_core::splines::bernstein::apply;
use iga_core::splines::knots::KnotVector;

use rayon::prelude::*;

use super::bernstein::{coefficients, extrapolation, inset_point, values};

/// Part of an element that samples of the stress keep from its ends, about as Gauss points do: on
/// poles and singular lines gradients do not exist, and near them they are wrong.
const INSET: f64 = 0.1;

/// Kind of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cells {
    /// Rational Bézier cells: nodes are control points, fields control values.
    Bezier,
    /// Linear cells: nodes and fields are points and values of the body. Each element is cut into
    /// at least so many in each direction.
    Linear(usize),
}

/// One element.
#[derive(Debug, Clone)]
pub struct Element {
    /// Steps from node to node per direction; the degrees of a Bézier cell.
    pub steps: Vec<usize>,
    /// Nodes of the undeformed element in the model's components \[m\], first direction fastest.
    pub nodes: Vec<[f64; 3]>,
    /// Weights of the nodes; one for linear cells.
    pub weights: Vec<f64>,
    /// Number in the space.
    number: usize,
    /// Parameters of equally spaced points, one per node.
    points: Vec<[f64; 3]>,
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
    /// Stress at points equally spaced in the parameters, one per node, components of the model
    /// \[Pa\]; empty for rigid bodies.
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
    space: Box<dyn Space>,
    elasticity: Option<Elasticity>,
}

/// Buffers for one element.
#[derive(Default)]
struct Workspace {
    basis: PointBasis,
    active: Vec<u32>,
    recovery: RecoveryWorkspace,
}

impl BodyGeometry {
    /// Cuts a body over `patches` into the elements of `space`.
    pub fn new(
        space: Box<dyn Space>,
        patches: &[Patch],
        motion: RigidMotion,
        elasticity: Option<Elasticity>,
        cells: Cells,
    ) -> Self {
        let control: Vec<f64> = space.control_points().iter().flatten().copied().collect();
        let body = Undeformed { space: space.as_ref(), patches, control: &control, cells };
        let one = |workspace: &mut Workspace, e| element(&body, e, workspace);
        let elements = (0..space.n_elements()).into_par_iter().map_init(Workspace::default, one).collect();
        Self { motion, elements, cells, space, elasticity }
    }

    /// Number of control values of a field.
    pub fn n_control_values(&self) -> usize {
        self.space.n_functions() * self.motion.n_components()
    }

    /// Fields of all elements for node-major control values of the displacement \[m\] and its rate
    /// [m/s].
    ///
    /// # Errors
    /// [`SplineError`] where the geometry is folded.
    pub fn fields(&self, displacement: &[f64], rate: &[f64]) -> Result<Vec<ElementFields>, SplineError> {
        let n = self.motion.n_components();
        let one = |workspace: &mut Workspace, element: &Element| {
            let mut at_nodes = |values| {
                let samples =
                    sampled(self.space.as_ref(), element.number, &element.points, (values, n), workspace);
                match self.cells {
                    Cells::Bezier => control_values(&element.steps, &element.weights, &samples),
                    Cells::Linear(_) => samples,
                }
            };
            let (at_rest, moving) = (at_nodes(displacement), at_nodes(rate));
            let stress = match &self.elasticity {
                Some(elasticity) => {
                    self.stress(elasticity, &mut workspace.recovery, element, displacement)?
                }
                None => Vec::new(),
            };
            Ok(ElementFields { displacement: at_rest, rate: moving, stress })
        };
        self.elements.par_iter().map_init(Workspace::default, one).collect()
    }

    /// Displacement and stress at the points `seen` of element `e` by each of `displacements`, control values as in [`Self::fields`]; for linear
    /// cells.
    ///
    /// # Errors
    /// [`SplineError`] where the geometry is folded.
    pub fn shapes(
        &self,
        (e, seen): (usize, &[usize]),
        displacements: &[Vec<f64>],
    ) -> Result<Vec<ElementFields>, SplineError> {
        let (element, n, mut work) = (&self.elements[e], self.motion.n_components(), Workspace::default());
        let mut of_all: Vec<ElementFields> = Vec::with_capacity(displacements.len());
        let Workspace { basis, active, recovery } = &mut work;
        self.space.active_functions(element.number, active);
        of_all.resize_with(displacements.len(), ElementFields::default);
        for &i in seen {
            self.space.evaluate(element.number, &element.points[i], 0, basis);
            for (fields, values) in of_all.iter_mut().zip(displacements) {
                fields.displacement.push(combined(active, &basis.values, (values, n)));
            }
        }
        let Some(Elasticity { model, material }) = &self.elasticity else { return Ok(of_all) };
        let (space, law, samples) = (self.space.as_ref(), (model, material), &element.samples);
        let states = recovery.stresses(space, law, displacements, element.number, samples)?;
        let outwards = outwards(&element.steps);
        let outwards: Vec<&Mat<f64>> = outwards.iter().collect();
        for (fields, states) in of_all.iter_mut().zip(states) {
            let inner: Vec<[f64; 6]> = states.into_iter().map(|state| state.stress).collect();
            let at_points = apply(&outwards, &inner);
            fields.stress = seen.iter().map(|&i| at_points[i]).collect();
        }
        Ok(of_all)
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
        // A body at rest has none.
        if displacement.iter().all(|u| *u == 0.0) {
            return Ok(vec![[0.0; 6]; element.samples.len()]);
        }
        let at =
            |xi| workspace.stress(self.space.as_ref(), model, material, displacement, element.number, xi);
        let inner =
            element.samples.iter().map(at).map(|s| s.map(|s| s.stress)).collect::<Result<Vec<_>, _>>()?;
        Ok(apply(&outwards(&element.steps).iter().collect::<Vec<_>>(), &inner))
    }
}

/// From the points inside an element, at which stress is sampled, to its equally spaced ones, for each direction.
fn outwards(steps: &[usize]) -> Vec<Mat<f64>> {
    steps.iter().map(|&n| extrapolation(n, INSET)).collect()
}

/// The value of a field with node-major control values, `n` a function, by the functions `active` and their values.
fn combined(active: &[u32], values: &[f64], (control, n): (&[f64], usize)) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (&function, weight) in active.iter().zip(values) {
        let control = &control[function as usize * n..][..n];
        sum.iter_mut().zip(control).for_each(|(s, v)| *s += weight * v);
    }
    sum
}

/// A field with node-major control values, `n` a function, at parameters `points` of element `e`.
fn sampled(
    space: &dyn Space,
    e: usize,
    points: &[[f64; 3]],
    (values, n): (&[f64], usize),
    workspace: &mut Workspace,
) -> Vec<[f64; 3]> {
    let Workspace { basis, active, .. } = workspace;
    space.active_functions(e, active);
    let mut at = |xi| {
        space.evaluate(e, xi, 0, basis);
        combined(active, &basis.values, (values, n))
    };
    points.iter().map(&mut at).collect()
}

/// Control values of a rational field on a cell with `weights` from its values at equally spaced
/// points.
pub fn control_values<const N: usize>(
    degrees: &[usize],
    weights: &[f64],
    samples: &[[f64; N]],
) -> Vec<[f64; N]> {
    let evaluate: Vec<Mat<f64>> = degrees.iter().map(|&p| values(p, p)).collect();
    let invert: Vec<Mat<f64>> = degrees.iter().map(|&p| coefficients(p)).collect();
    let lifted: Vec<[f64; 1]> = weights.iter().map(|w| [*w]).collect();
    let w = apply(&evaluate.iter().collect::<Vec<_>>(), &lifted);
    let weighted: Vec<[f64; N]> = samples.iter().zip(&w).map(|(s, w)| s.map(|c| c * w[0])).collect();
    let net = apply(&invert.iter().collect::<Vec<_>>(), &weighted);
    net.iter().zip(weights).map(|(v, w)| v.map(|c| c / w)).collect()
}

/// A body before its motion.
struct Undeformed<'a> {
    space: &'a dyn Space,
    patches: &'a [Patch],
    /// Three coordinates a control point \[m\].
    control: &'a [f64],
    cells: Cells,
}

/// Element `e` of a body: nodes and weights go through its points, for on one element all functions
/// are rational of the degrees of its patch, with the weight function of the patch.
fn element(body: &Undeformed<'_>, e: usize, workspace: &mut Workspace) -> Element {
    let place = body.space.element(e);
    let patch = &body.patches[place.patch];
    let degrees: Vec<usize> = patch.knots().iter().map(KnotVector::degree).collect();
    let steps: Vec<usize> = match body.cells {
        Cells::Bezier => degrees,
        Cells::Linear(least) => degrees.iter().map(|&p| p.max(least)).collect(),
    };
    let spaced = |inset| {
        indices(&steps, |local| {
            let mut xi = [0.0; 3];
            for (d, &i) in local.iter().enumerate().take(steps.len()) {
                let (lower, upper) = (place.lower[d], place.upper[d]);
                xi[d] = lower + (upper - lower) * inset_point(i, steps[d], inset);
            }
            xi
        })
    };
    let (points, samples) = (spaced(0.0), spaced(INSET));
    let positions = sampled(body.space, e, &points, (body.control, 3), workspace);
    let (nodes, weights) = match body.cells {
        Cells::Bezier => {
            let weights: Vec<[f64; 1]> = points.iter().map(|xi| [patch.weight_function(xi)]).collect();
            let invert: Vec<Mat<f64>> = steps.iter().map(|&p| coefficients(p)).collect();
            let weights = apply(&invert.iter().collect::<Vec<_>>(), &weights);
            let weights: Vec<f64> = weights.iter().map(|w| w[0]).collect();
            (control_values(&steps, &weights, &positions), weights)
        }
        Cells::Linear(_) => (positions, vec![1.0; samples.len()]),
    };
    Element { steps, nodes, weights, number: e, points, samples }
}

/// `f` of all indices `0..=steps` in each direction, the first direction fastest.
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
