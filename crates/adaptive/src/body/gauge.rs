//! Strain and stress at a point of a body, as sums over the displacements of its unknowns
//! (docs/theory.md Eq. Q.7).

use contact_qs::zone::points::DofLookup;
use faer::{Mat, MatMut, MatRef};
use iga_core::elasticity::kinematics::PointState;

/// Numbers of a state: six strains, then six stresses.
pub const N_NUMBERS: usize = 12;

/// Strain and stress at a point by a unit of the displacement of each function that they depend on,
/// a component at a time [1/m].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gauge {
    entries: Vec<(u32, usize, PointState)>,
}

impl Gauge {
    /// The gauge of the states `states` by a unit of each function, a component at a time.
    pub fn of(states: Vec<(u32, Vec<PointState>)>) -> Self {
        let entries = states.into_iter().flat_map(|(function, states)| {
            states.into_iter().enumerate().map(move |(c, state)| (function, c, state))
        });
        Self { entries: entries.collect() }
    }

    /// The state by a unit of each of the modes `shapes`, whose rows `lookup` numbers.
    pub fn of_modes(&self, lookup: &DofLookup, shapes: MatRef<'_, f64>) -> Vec<PointState> {
        let mut states = vec![PointState::default(); shapes.ncols()];
        for (row, state) in self.rows(lookup) {
            for (j, sum) in states.iter_mut().enumerate() {
                sum.add_scaled(state, shapes[(row, j)]);
            }
        }
        states
    }

    /// The state under the displacements `u` of the unknowns \[m\].
    pub fn at(&self, lookup: &DofLookup, u: &[f64]) -> PointState {
        let mut sum = PointState::default();
        self.rows(lookup).for_each(|(row, state)| sum.add_scaled(state, u[row]));
        sum
    }

    /// Adds the weights of the unknowns in the numbers of the state to the first [`N_NUMBERS`]
    /// columns of `out`.
    pub fn add_weights(&self, lookup: &DofLookup, mut out: MatMut<'_, f64>) {
        for (row, state) in self.rows(lookup) {
            for (j, value) in numbers(state).into_iter().enumerate() {
                out[(row, j)] += value;
            }
        }
    }

    /// Unknowns with their states; components that are held move nothing.
    fn rows<'a>(&'a self, lookup: &'a DofLookup) -> impl Iterator<Item = (usize, &'a PointState)> {
        self.entries.iter().filter_map(|(node, c, state)| Some((lookup.number(*node, *c)?, state)))
    }
}

/// The state whose numbers are the columns of `row` from `first` on.
pub fn state(columns: &Mat<f64>, row: usize, first: usize) -> PointState {
    let six = |from: usize| std::array::from_fn(|k| columns[(row, from + k)]);
    PointState { strain: six(first), stress: six(first + 6) }
}

fn numbers(state: &PointState) -> [f64; N_NUMBERS] {
    std::array::from_fn(|k| if k < 6 { state.strain[k] } else { state.stress[k - 6] })
}
