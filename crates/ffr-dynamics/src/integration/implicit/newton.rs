//! The linear systems of an implicit stage, reduced to the velocities (docs/theory.md Eq. T.21).
//!
//! `(1 - d h J) x = r`, where `J` is the derivative of the right-hand side. Positions and
//! quadratures are eliminated with known kinematics; the factorised matrix is that of the unknowns
//! alone.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting as lu;
use faer::perm::PermRef;
use faer::{MatMut, MatRef, Par};
use nalgebra::{Quaternion, Vector3};

use super::jacobian::Structure;
use crate::integration::linearisation::{KinematicBlock, Linearisation};

/// Factors of the iteration matrix for one `d h`, with buffers.
pub(super) struct IterationMatrix {
    n: usize,
    /// `d h` that the factors belong to; 0 without factors \[s\].
    weight: f64,
    factors: Vec<f64>,
    permutation: Vec<usize>,
    inverse: Vec<usize>,
    memory: MemBuffer,
    /// `½ d h ω` of each rotation block.
    turns: Vec<Vector3<f64>>,
    tangent: Vec<f64>,
    reduced: Vec<f64>,
}

impl IterationMatrix {
    pub(super) fn new(structure: &Structure) -> Self {
        let n = structure.unknowns.len();
        let scratch = lu::factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default())
            .or(lu::solve::solve_in_place_scratch::<usize, f64>(n, 1, Par::Seq));
        let is_rotation = |b: &&KinematicBlock| matches!(b, KinematicBlock::Rotation { .. });
        Self {
            n,
            weight: 0.0,
            factors: vec![0.0; n * n],
            permutation: (0..n).collect(),
            inverse: (0..n).collect(),
            memory: MemBuffer::new(scratch),
            turns: vec![Vector3::zeros(); structure.blocks.iter().filter(is_rotation).count()],
            tangent: vec![0.0; n],
            reduced: vec![0.0; n],
        }
    }

    /// Whether the factors belong to the weight `d h` \[s\].
    pub(super) fn is_for(&self, weight: f64) -> bool {
        // A clock's round-off changes `h` in its last digits; the factors may differ by that much
        // and more.
        (self.weight - weight).abs() <= 1e-9 * weight
    }

    /// Forgets the factors.
    pub(super) fn clear(&mut self) {
        self.weight = 0.0;
    }

    /// Factorises `1 - d h A_v - (d h)² A_s L` for the weight `d h` and the angular velocities in
    /// `y` (T.21).
    ///
    /// Returns whether that is possible; the matrix may be singular or not finite.
    pub(super) fn factorise(
        &mut self,
        structure: &Structure,
        derivative: &Linearisation,
        y: &[f64],
        weight: f64,
    ) -> bool {
        self.assemble(structure, derivative, y, weight);
        self.weight = 0.0;
        if self.n == 0 {
            self.weight = weight;
            return true;
        }
        if !self.factors.iter().all(|a| a.is_finite()) {
            return false;
        }
        lu::factor::lu_in_place(
            MatMut::from_column_major_slice_mut(&mut self.factors, self.n, self.n),
            &mut self.permutation,
            &mut self.inverse,
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        let is_regular = (0..self.n).all(|i| self.factors[i * self.n + i].abs() > 0.0);
        if is_regular {
            self.weight = weight;
        }
        is_regular
    }

    fn assemble(&mut self, structure: &Structure, derivative: &Linearisation, y: &[f64], weight: f64) {
        let n = self.n;
        for j in 0..n {
            let column = &mut self.factors[j * n..(j + 1) * n];
            for (a, d) in column.iter_mut().zip(derivative.velocity_column(j)) {
                *a = -weight * d;
            }
            column[j] += 1.0;
        }
        let squared = weight * weight;
        let (mut first, mut turn) = (0, 0);
        for block in &structure.blocks {
            let (_, len) = block.unknowns();
            match *block {
                KinematicBlock::Vector { .. } => {
                    let range = first * n..(first + len) * n;
                    let columns = (first..first + len).flat_map(|j| derivative.position_column(j));
                    for (a, d) in self.factors[range].iter_mut().zip(columns) {
                        *a -= squared * d;
                    }
                }
                KinematicBlock::Rotation { velocity, .. } => {
                    let w = 0.5 * weight * Vector3::from_column_slice(&y[velocity..velocity + 3]);
                    self.turns[turn] = w;
                    turn += 1;
                    for j in 0..3 {
                        let axis = Vector3::ith(j, 1.0);
                        let turned = (axis + axis.cross(&w)) / (1.0 + w.norm_squared());
                        for (i, share) in turned.iter().enumerate() {
                            let d = derivative.position_column(first + i);
                            let column = &mut self.factors[(first + j) * n..(first + j + 1) * n];
                            column.iter_mut().zip(d).for_each(|(a, d)| *a -= squared * share * d);
                        }
                    }
                }
                KinematicBlock::Plain { .. } => {}
            }
            first += len;
        }
    }

    /// Replaces `x` by `(1 - d h J)⁻¹ x`, with the orientations in `y` (T.21).
    pub(super) fn solve(
        &mut self,
        structure: &Structure,
        derivative: &Linearisation,
        y: &[f64],
        x: &mut [f64],
    ) {
        let n = self.n;
        if n == 0 {
            return;
        }
        self.positions_alone(structure, y, x);
        for (r, &i) in self.reduced.iter_mut().zip(&structure.unknowns) {
            *r = x[i];
        }
        for (j, change) in self.tangent.iter().enumerate().filter(|(_, change)| change.abs() > 0.0) {
            let factor = self.weight * change;
            self.reduced.iter_mut().zip(derivative.position_column(j)).for_each(|(r, d)| *r += factor * d);
        }
        lu::solve::solve_in_place(
            MatRef::from_column_major_slice(&self.factors, n, n),
            MatRef::from_column_major_slice(&self.factors, n, n),
            PermRef::new_checked(&self.permutation, &self.inverse, n),
            MatMut::from_column_major_slice_mut(&mut self.reduced, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        for (r, &i) in self.reduced.iter().zip(&structure.unknowns) {
            x[i] = *r;
        }
        self.positions_from_velocities(structure, y, x);
    }

    /// Positions of the right-hand side with velocities at rest; their tangent components are left
    /// in `tangent`.
    fn positions_alone(&mut self, structure: &Structure, y: &[f64], x: &mut [f64]) {
        let (mut first, mut turn) = (0, 0);
        for block in &structure.blocks {
            let (_, len) = block.unknowns();
            let tangent = &mut self.tangent[first..first + len];
            match *block {
                KinematicBlock::Vector { position, .. } => {
                    tangent.copy_from_slice(&x[position..position + len]);
                }
                KinematicBlock::Rotation { quaternion, .. } => {
                    let range = quaternion..quaternion + 4;
                    let (q, r) = (read(&y[range.clone()]), read(&x[range.clone()]));
                    let moved = r * unturned(&self.turns[turn]);
                    turn += 1;
                    x[range].copy_from_slice(&[moved.w, moved.i, moved.j, moved.k]);
                    let relative = q.conjugate() * moved * (2.0 / q.norm_squared());
                    tangent.copy_from_slice(&[relative.i, relative.j, relative.k]);
                }
                KinematicBlock::Plain { .. } => tangent.fill(0.0),
            }
            first += len;
        }
    }

    /// Adds what the velocities bring to the positions.
    fn positions_from_velocities(&self, structure: &Structure, y: &[f64], x: &mut [f64]) {
        let mut turn = 0;
        for block in &structure.blocks {
            match *block {
                KinematicBlock::Vector { position, velocity, len } => {
                    for i in 0..len {
                        x[position + i] += self.weight * x[velocity + i];
                    }
                }
                KinematicBlock::Rotation { quaternion, velocity } => {
                    let omega = Vector3::from_column_slice(&x[velocity..velocity + 3]);
                    let q = read(&y[quaternion..quaternion + 4]);
                    let rate = q * Quaternion::from_imag(0.5 * self.weight * omega);
                    let moved = rate * unturned(&self.turns[turn]);
                    turn += 1;
                    for (o, m) in
                        x[quaternion..quaternion + 4].iter_mut().zip([moved.w, moved.i, moved.j, moved.k])
                    {
                        *o += m;
                    }
                }
                KinematicBlock::Plain { .. } => {}
            }
        }
    }
}

impl std::fmt::Debug for IterationMatrix {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("IterationMatrix").field("n", &self.n).field("weight", &self.weight).finish()
    }
}

fn read(x: &[f64]) -> Quaternion<f64> {
    Quaternion::new(x[0], x[1], x[2], x[3])
}

/// Inverse of the quaternion `(1, -w)`.
fn unturned(w: &Vector3<f64>) -> Quaternion<f64> {
    Quaternion::from_parts(1.0, *w) / (1.0 + w.norm_squared())
}
