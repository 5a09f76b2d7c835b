//! Small bodies made by hand: blocks of nodes with consistent mass, held together by bars.

use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion, StandardInputData};
use ffr_dynamics::force::{BodyState, Findings, ForceEnergies};
use ffr_dynamics::integration::{Integrator, Method, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{ErrorScale, Multibody};
use nalgebra::{DMatrix, Matrix3, UnitQuaternion, Vector3};

/// What a force of a test found: its resultant and its energy.
#[derive(Default)]
pub struct Push {
    pub resultant: Vector3<f64>,
    pub energy: f64,
}

impl Findings for Push {
    fn energies(&self) -> ForceEnergies {
        ForceEnergies { penalty: self.energy, ..ForceEnergies::default() }
    }

    fn resultant(&self) -> Vector3<f64> {
        self.resultant
    }
}

/// Rotation of a material point: half the curl of a displacement with this gradient (entry `(a, b)`: derivative of component `a` along
/// `b`).
pub fn rotation_of_gradient(gradient: &Matrix3<f64>) -> Vector3<f64> {
    0.5 * Vector3::new(
        gradient[(2, 1)] - gradient[(1, 2)],
        gradient[(0, 2)] - gradient[(2, 0)],
        gradient[(1, 0)] - gradient[(0, 1)],
    )
}

/// A body before and after reduction.
pub struct Sample {
    pub body: AssembledBody,
    /// Node by node mass matrix, dense.
    pub mass: DMatrix<f64>,
    pub shapes: Mat<f64>,
    pub data: StandardInputData,
}

/// Elements of the block by direction.
const ELEMENTS: [usize; 3] = [2, 1, 1];
/// Edge lengths of the block \[m\]; no two alike, and the frame's origin is not the centre of mass.
const EDGES: [f64; 3] = [0.2, 0.11, 0.07];
const ORIGIN: [f64; 3] = [0.03, -0.02, 0.05];
const DENSITY: f64 = 2700.0;
/// Stiffness of a bar of unit length \[N\].
const BAR_STIFFNESS: f64 = 1e6;

/// A block of trilinear (bilinear) elements with consistent mass, with bars along all edges and diagonals of each element.
pub fn block(motion: RigidMotion, n_modes: usize) -> Sample {
    let n_c = motion.n_components();
    let elements: Vec<usize> = ELEMENTS[..n_c].to_vec();
    let counts: Vec<usize> = elements.iter().map(|n| n + 1).collect();
    let nodes: Vec<[f64; 3]> = (0..counts.iter().product())
        .map(|node| {
            let mut x = [0.0; 3];
            for (c, i) in split(node, &counts).into_iter().enumerate() {
                // Skewed a little, so that no symmetry hides a mistake.
                x[c] = EDGES[c] * i as f64 / elements[c] as f64 + ORIGIN[c];
            }
            if motion != RigidMotion::Axial {
                x[1] += 0.2 * x[0];
            }
            x
        })
        .collect();
    let mut mass = DMatrix::zeros(nodes.len(), nodes.len());
    let mut pairs = Vec::new();
    for element in 0..elements.iter().product() {
        let base = split(element, &elements);
        let corners: Vec<(usize, Vec<usize>)> = (0..1 << n_c)
            .map(|corner| {
                let bits: Vec<usize> = (0..n_c).map(|c| (corner >> c) & 1).collect();
                let index: Vec<usize> = bits.iter().zip(&base).map(|(b, i)| b + i).collect();
                (join(&index, &counts), bits)
            })
            .collect();
        let volume: f64 = (0..n_c).map(|c| EDGES[c] / elements[c] as f64).product();
        for (a, bits_a) in &corners {
            for (b, bits_b) in &corners {
                // Linear hat functions on [0, 1]: ∫ N² = 1/3, ∫ N_0 N_1 = 1/6.
                let overlap: f64 = bits_a
                    .iter()
                    .zip(bits_b)
                    .map(|(x, y)| if x == y { 1.0 / 3.0 } else { 1.0 / 6.0 })
                    .product();
                mass[(*a, *b)] += DENSITY * volume * overlap;
                if a < b {
                    pairs.push((*a, *b));
                }
            }
        }
    }
    reduce(motion, nodes, mass, &pairs, n_modes)
}

fn split(index: usize, counts: &[usize]) -> Vec<usize> {
    let mut rest = index;
    counts
        .iter()
        .map(|n| {
            let i = rest % n;
            rest /= n;
            i
        })
        .collect()
}

fn join(index: &[usize], counts: &[usize]) -> usize {
    index.iter().zip(counts).rev().fold(0, |sum, (i, n)| sum * n + i)
}

fn reduce(
    motion: RigidMotion,
    nodes: Vec<[f64; 3]>,
    mass: DMatrix<f64>,
    pairs: &[(usize, usize)],
    n_modes: usize,
) -> Sample {
    let (n_c, n) = (motion.n_components(), nodes.len() * motion.n_components());
    let dofs: Vec<Dof> = (0..n).map(|i| Dof { node: (i / n_c) as u32, component: (i % n_c) as u8 }).collect();
    let mut stiffness = DMatrix::<f64>::zeros(n, n);
    for &(a, b) in pairs {
        let d: Vec<f64> = (0..n_c).map(|c| nodes[b][c] - nodes[a][c]).collect();
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (c, e) in (0..n_c).flat_map(|c| (0..n_c).map(move |e| (c, e))) {
            let k = BAR_STIFFNESS / length * d[c] * d[e] / (length * length);
            for (p, q, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                stiffness[(p * n_c + c, q * n_c + e)] += sign * k;
            }
        }
    }
    if motion == RigidMotion::Axial {
        // Hoop stiffness: radial displacements and the rotation in the (r, z) plane are not free.
        (0..nodes.len()).for_each(|a| stiffness[(a * n_c, a * n_c)] += 10.0 * BAR_STIFFNESS);
    }
    let full_mass =
        DMatrix::from_fn(n, n, |i, j| if i % n_c == j % n_c { mass[(i / n_c, j / n_c)] } else { 0.0 });
    let (shapes, eigenvalues) = elastic_modes(&full_mass, &stiffness, motion.count(), n_modes);
    let body = AssembledBody {
        name: "block".to_string(),
        motion,
        stiffness: lower(&stiffness),
        mass: MassMatrix::PerComponent(lower(&mass)),
        dofs,
        anchors: nodes.clone(),
        nodes,
    };
    let data = StandardInputData::new(&body, shapes.as_ref(), &eigenvalues).unwrap();
    Sample { body, mass, shapes, data }
}

/// Dense generalised eigenproblem; drops the rigid modes.
fn elastic_modes(
    mass: &DMatrix<f64>,
    stiffness: &DMatrix<f64>,
    n_rigid: usize,
    n_modes: usize,
) -> (Mat<f64>, Vec<f64>) {
    let factor = mass.clone().cholesky().unwrap().l();
    let half = factor.solve_lower_triangular(stiffness).unwrap();
    let whitened = factor.solve_lower_triangular(&half.transpose()).unwrap();
    let eigen = (0.5 * (&whitened + whitened.transpose())).symmetric_eigen();
    let mut order: Vec<usize> = (0..mass.nrows()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let kept = &order[n_rigid..n_rigid + n_modes];
    let largest_rigid = eigen.eigenvalues[order[n_rigid - 1]].abs();
    assert!(
        largest_rigid < 1e-9 * eigen.eigenvalues[order[n_rigid]],
        "one more zero mode than rigid motions"
    );
    let modes = factor.transpose().solve_upper_triangular(&eigen.eigenvectors).unwrap();
    let shapes = Mat::from_fn(mass.nrows(), n_modes, |i, j| modes[(i, kept[j])]);
    (shapes, kept.iter().map(|i| eigen.eigenvalues[*i]).collect())
}

fn lower(matrix: &DMatrix<f64>) -> SparseColMat<u32, f64> {
    let n = matrix.nrows();
    let entries: Vec<_> = (0..n)
        .flat_map(|j| (j..n).map(move |i| (i, j)))
        .map(|(i, j)| Triplet::new(i as u32, j as u32, matrix[(i, j)]))
        .collect();
    SparseColMat::try_new_from_triplets(n, n, &entries).unwrap()
}

impl Sample {
    /// Displacement of node `a` in the body's frame by the elastic coordinates.
    pub fn displacement(&self, a: usize, coordinates: &[f64]) -> Vector3<f64> {
        let n_c = self.body.motion.n_components();
        let mut u = Vector3::zeros();
        for c in 0..n_c {
            u[self.body.motion.direction(c)] =
                coordinates.iter().enumerate().map(|(j, q)| self.shapes[(a * n_c + c, j)] * q).sum();
        }
        u
    }

    /// Undeformed position of node `a` in the body's frame, as a point in space.
    pub fn node(&self, a: usize) -> Vector3<f64> {
        let mut x = Vector3::zeros();
        for c in 0..self.body.motion.n_components() {
            x[self.body.motion.direction(c)] = self.body.nodes[a][c];
        }
        x
    }

    /// Positions and velocities of all nodes in the inertial frame.
    pub fn node_motion(&self, state: &BodyState) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        (0..self.body.nodes.len())
            .map(|a| {
                let arm = self.node(a) + self.displacement(a, &state.elastic);
                let local =
                    state.angular_velocity_in_body.cross(&arm) + self.displacement(a, &state.elastic_rates);
                (state.position + state.rotation * arm, state.velocity + state.rotation * local)
            })
            .collect()
    }
}

/// Reproducible numbers in (-1, 1).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        // Knuth's MMIX generator, upper bits.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }

    /// A motion within the model's rigid motions: displacements up to a tenth of the block, large rotations.
    pub fn state(&mut self, data: &StandardInputData) -> BodyState {
        let n = data.n_modes();
        let mut state = BodyState::at_rest(n);
        state.position = self.vector();
        state.elastic = (0..n).map(|_| 5e-3 * self.next()).collect();
        state.elastic_rates = (0..n).map(|_| self.next()).collect();
        match data.motion {
            RigidMotion::Axial => state.velocity.z = self.next(),
            RigidMotion::Planar => {
                state.velocity = Vector3::new(self.next(), self.next(), 0.0);
                state.rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * 3.0 * self.next());
                state.angular_velocity_in_body.z = 20.0 * self.next();
            }
            RigidMotion::Spatial => {
                state.velocity = self.vector();
                state.rotation = UnitQuaternion::from_scaled_axis(3.0 * self.vector());
                state.angular_velocity_in_body = 20.0 * self.vector();
            }
        }
        state
    }
}

/// A rigid body with three different inertias.
pub fn rigid_rotor() -> StandardInputData {
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    StandardInputData::rigid(RigidMotion::Spatial, 3.0, Vector3::zeros(), inertia).unwrap()
}

impl Sample {
    /// A marker at node `a` with the displacement of the modes there, and rotations by the modes as given.
    pub fn marker(
        &self,
        name: &str,
        a: usize,
        rotation: UnitQuaternion<f64>,
        mut turn: impl FnMut(usize) -> Vector3<f64>,
    ) -> Marker {
        let n = self.data.n_modes();
        if n == 0 {
            return Marker::rigid(name, self.node(a), rotation);
        }
        let unit = |j: usize| (0..n).map(|i| f64::from(u8::from(i == j))).collect::<Vec<_>>();
        let displacements: Vec<_> = (0..n).map(|j| self.displacement(a, &unit(j))).collect();
        let rotations: Vec<_> = (0..n).map(&mut turn).collect();
        Marker::flexible(name, self.node(a), rotation, &displacements, &rotations).unwrap()
    }

    /// Rotation of the modes at node `a`: that of the displacements of its neighbours along the edges of the block.
    pub fn nodal_rotation(&self, a: usize, j: usize) -> Vector3<f64> {
        // Least squares fit of a gradient to all nodes, weighted towards the near ones.
        let (mut moment, mut product) = (Matrix3::zeros(), Matrix3::zeros());
        let unit: Vec<f64> = (0..self.data.n_modes()).map(|i| f64::from(u8::from(i == j))).collect();
        for b in 0..self.body.nodes.len() {
            let d = self.node(b) - self.node(a);
            let weight = (-d.norm_squared() / 0.01).exp();
            moment += d * d.transpose() * weight;
            product += (self.displacement(b, &unit) - self.displacement(a, &unit)) * d.transpose() * weight;
        }
        rotation_of_gradient(&(product * moment.try_inverse().unwrap()))
    }
}

/// Tolerance of each step of an integration [`with_tolerance`].
pub const RELATIVE: f64 = 1e-9;

pub fn with_tolerance(mut system: Multibody) -> Multibody {
    system.set_error_scale(ErrorScale { relative: RELATIVE, ..ErrorScale::default() }).unwrap();
    system
}

/// The state at time `to`, and what all the steps may err together, as a share of the speed: `RELATIVE` each.
pub fn run(system: &mut Multibody, method: Method, y: &[f64], to: f64) -> (Vec<f64>, f64) {
    let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, y, system).unwrap();
    let mut steps = 0;
    integrator
        .run(system, to, |_, _| {
            steps += 1;
            true
        })
        .unwrap();
    (integrator.state().to_vec(), f64::from(steps) * RELATIVE)
}
