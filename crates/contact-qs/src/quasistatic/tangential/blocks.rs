//! Compliances of the points along and across their tangents.

use faer::Mat;

use crate::quasistatic::members::Members;
use crate::quasistatic::problem::{add_multiples, dot};

/// `A_TT` and `A_TN` of some of the points, its members. Components are ordered `n_t * point + component`; those of members stand
/// together, in the order in which they came: products with few loaded points are short where these came first.
pub(crate) struct Blocks {
    n_t: usize,
    /// Points of which compliances with all members before are to be set when they have been added.
    pub members: Members,
    /// `A_TT` and `A_TN` (tangential rows, normal columns) of members by their places; of no size when all modes are dynamic.
    tangential: Mat<f64>,
    coupling: Mat<f64>,
    /// Forces and displacements by places.
    loads: [Vec<f64>; 2],
    moved: Vec<f64>,
}

impl Blocks {
    /// Room for `n_points` points with `n_t` tangents; `has_compliance`: whether they yield at all.
    pub fn new(n_points: usize, n_t: usize, has_compliance: bool) -> Self {
        let n = n_t * n_points;
        let (rows, columns) = if has_compliance { (n, n_points) } else { (0, 0) };
        Self {
            n_t,
            members: Members::new(n_points),
            tangential: Mat::zeros(rows, rows),
            coupling: Mat::zeros(rows, columns),
            loads: [vec![0.0; n_points], vec![0.0; n]],
            moved: vec![0.0; n],
        }
    }

    /// Whether points yield.
    pub fn yields(&self) -> bool {
        self.coupling.nrows() > 0
    }

    /// Sets the displacement of point `i` along its tangent `a` under a unit normal force on point `j`.
    pub fn set_coupling(&mut self, i: usize, a: usize, j: usize, value: f64) {
        self.coupling[(self.n_t * self.members.place(i) + a, self.members.place(j))] = value;
    }

    /// Sets the displacement of point `i` along its tangent `a` under a unit force on point `j` along tangent `b`, and the opposite entry
    /// with it.
    pub fn set_tangential(&mut self, (i, a): (usize, usize), (j, b): (usize, usize), value: f64) {
        let [row, column] = [(i, a), (j, b)].map(|(i, a)| self.n_t * self.members.place(i) + a);
        self.tangential[(row, column)] = value;
        self.tangential[(column, row)] = value;
    }

    /// The component `row` of the displacement under a unit force along component `column`, both of members.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        let of = |k: usize| self.n_t * self.members.place(k / self.n_t) + k % self.n_t;
        self.tangential[(of(row), of(column))]
    }

    /// Writes `A_TT` of the members `points` to `out`, column by column.
    pub fn gather(&self, points: &[usize], out: &mut [f64]) {
        let (n_t, m) = (self.n_t, self.n_t * points.len());
        for (column, (&i, a)) in points.iter().flat_map(|i| (0..n_t).map(move |a| (i, a))).enumerate() {
            let source = self.tangential.col_as_slice(n_t * self.members.place(i) + a);
            let target = &mut out[column * m..(column + 1) * m];
            for (entries, &j) in target.chunks_exact_mut(n_t).zip(points) {
                entries.copy_from_slice(&source[n_t * self.members.place(j)..][..n_t]);
            }
        }
    }

    /// Adds the displacements of the members along their normals under the tangential forces `forces` to `gaps`.
    pub fn add_to_gaps(&mut self, forces: &[f64], gaps: &mut [f64]) {
        let n_front = self.take_loads(&[], forces);
        let front = &self.loads[1][..self.n_t * n_front];
        for (place, &i) in self.members.list().iter().enumerate() {
            gaps[i] += dot(self.coupling.col_as_slice(place), front);
        }
    }

    /// Adds the displacements along the tangents under the normal forces `forces` to the slips `slips` of the points that these press.
    pub fn add_to_slips(&mut self, forces: &[f64], slips: &mut [f64]) {
        let n_front = self.take_loads(forces, &[]);
        self.move_rows(0, n_front);
        self.add_moved(0..n_front, slips);
    }

    /// Replaces `slips` by the displacements of the members from the place `first` on along their tangents under both forces, zero
    /// of others.
    pub fn displace(&mut self, first: usize, (normal, tangential): (&[f64], &[f64]), slips: &mut [f64]) {
        slips.fill(0.0);
        self.take_loads(normal, tangential);
        self.move_rows(first, self.members.list().len());
        self.add_moved(first..self.members.list().len(), slips);
    }

    /// Takes forces by places; none where a list is empty. Returns the number of members up to the last one under load.
    fn take_loads(&mut self, normal: &[f64], tangential: &[f64]) -> usize {
        let (n_t, mut n_front) = (self.n_t, 0);
        for (place, &i) in self.members.list().iter().enumerate() {
            let force = normal.get(i).copied().unwrap_or(0.0);
            let along = tangential.get(n_t * i..n_t * (i + 1)).unwrap_or(&[]);
            self.loads[0][place] = force;
            self.loads[1][n_t * place..n_t * (place + 1)].fill(0.0);
            self.loads[1][n_t * place..][..along.len()].copy_from_slice(along);
            if force != 0.0 || along.iter().any(|f| *f != 0.0) {
                n_front = place + 1;
            }
        }
        n_front
    }

    /// Leaves the displacements of the members from the place `first` up to `end` along their tangents under the forces taken in
    /// `moved`.
    fn move_rows(&mut self, first: usize, end: usize) {
        let (m, rows) = (self.members.list().len(), self.n_t * first..self.n_t * end);
        let moved = &mut self.moved[rows.clone()];
        moved.fill(0.0);
        for (matrix, forces, n) in
            [(&self.coupling, &self.loads[0], m), (&self.tangential, &self.loads[1], self.n_t * m)]
        {
            let loaded = forces[..n].iter().enumerate().filter(|(_, force)| **force != 0.0);
            add_multiples(loaded.map(|(k, force)| (&matrix.col_as_slice(k)[rows.clone()], *force)), moved);
        }
    }

    fn add_moved(&self, places: std::ops::Range<usize>, slips: &mut [f64]) {
        for (place, &i) in self.members.list().iter().enumerate().take(places.end).skip(places.start) {
            let moved = &self.moved[self.n_t * place..self.n_t * (place + 1)];
            slips[self.n_t * i..self.n_t * (i + 1)].iter_mut().zip(moved).for_each(|(s, u)| *s += u);
        }
    }
}
