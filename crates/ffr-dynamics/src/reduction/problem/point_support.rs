//! Statics of a body that is held at one point (docs/theory.md Eq. M.47).
//!
//! Loads are balanced by the force and the moment that the support exerts, whatever they are, by
//! rigid-body statics alone; what then deforms the body is in equilibrium and needs no further
//! support than one against rigid motion.

use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef};

use super::ElasticProblem;
use crate::DynamicsError;
use crate::data_error::DataError;
use crate::reduction::blocks::dense;

impl ElasticProblem<'_> {
    /// Displacements (n × k) of the body under the forces `loads` (n × k), held by `support` (n ×
    /// r): the columns are the forces on the unknowns of unit reactions, one for each rigid motion.
    /// The motion of the support itself, `supportᵀ u`, vanishes.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit, a number is not finite, the body is clamped, or the support leaves a rigid motion free.
    pub fn held_at_point(
        &self,
        loads: MatRef<'_, f64>,
        support: MatRef<'_, f64>,
    ) -> Result<Mat<f64>, DynamicsError> {
        let rigid = self.free_rigid()?;
        let (n, r) = (self.n_unknowns(), rigid.count());
        if loads.nrows() != n || support.nrows() != n || support.ncols() != r {
            let what = "the support, or the loads,".into();
            let found = (support.nrows().min(loads.nrows()), support.ncols());
            return Err(DataError::Size { what, found, expected: (n, r) }.into());
        }
        // G = R^T B: power of the reactions in rigid motions.
        let grip = dense::product(rigid.modes.transpose(), support);
        let reactions = grip.partial_piv_lu().solve(dense::product(rigid.modes.transpose(), loads));
        let mut u = loads.to_owned();
        dense::add_product(u.as_mut(), -1.0, support, reactions.as_ref());
        self.solve_held(u.as_mut());
        let moved = dense::product(support.transpose(), u.as_ref());
        let shift = grip.transpose().partial_piv_lu().solve(moved);
        dense::add_product(u.as_mut(), -1.0, rigid.modes.as_ref(), shift.as_ref());
        let is_held = (0..u.ncols()).all(|j| u.col(j).iter().all(|v| v.is_finite()));
        if is_held {
            Ok(u)
        } else {
            let (support, remedy) =
                ("a support or a load that is not finite".into(), "hold more of the body");
            Err(DataError::NotHeld { support, free: 1, remedy }.into())
        }
    }
}
