//! The fine model of a body in a contact, of whatever elements, or the body's own elements with its
//! whole surface.

pub mod refined;
pub mod divided;

use std::borrow::Cow;
use std::sync::Arc;

use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::{BodyTurn, FreeFlexibility, LowModes, ResidualFlexibility};

use super::field::Field;
use super::reduced::ReducedBody;
use crate::adaptivity::interval::IntervalGrid;
use crate::body::point_compliance::{ObservedPlace, add_places};
use crate::body::splines::Discretised;
use crate::body::zone::ContactZone;
use crate::error::AdaptiveError;
use crate::record::TargetPlace;
use crate::spec::PointRule;
use crate::store::{Bytes, ModelKey, matrix_values};
use divided::FineElements;
use refined::FineMesh;

/// A fine model before its matrices, with what was asked for. What a new kind of elements has to
/// say is required.
pub trait FineModel: Send + Sync {
    /// Its displacements.
    fn field(&self) -> &dyn Field;

    /// Contact points, by `rule` on splines, and interface; `contact` is the contact's name.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if no point lies in the zone, [`AdaptiveError::Mesh`] for a side without area.
    fn zone(&self, rule: PointRule, contact: &str) -> Result<ContactZone, AdaptiveError>;

    /// The rows by which the use of the zone is judged; a whole surface has none.
    fn grid(&self) -> IntervalGrid;

    /// The row of each point of `zone`, per direction.
    fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]>;

    /// Stiffness and mass before the model is turned.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the body's name.
    fn assemble(&self) -> Result<Cow<'_, AssembledBody>, AdaptiveError>;

    /// Displacements of the body's own unknowns (n x k) on these: the same fields, on a turned net
    /// the nearest ones (theory Eq. A.12).
    fn prolong(&self, shapes: MatRef<'_, f64>) -> Mat<f64>;

    /// What its matrices, before it is turned, are made from.
    fn definition(&self) -> Bytes;

    /// How far a zone on smooth surfaces in place of the sides of the mesh may be moved outwards, any way at one place, none at several \[m\]; none if
    /// it lies on the surface of the body.
    fn most_outwards(&self) -> Option<f64> {
        None
    }

    /// Moves `zone` by `offset` \[m\] along the normals of these smooth surfaces.
    fn move_out(&self, _zone: &mut ContactZone, _offset: f64) {}

    /// What the zone meets of the target at one place, if that has an edge or a corner there.
    fn meets(&self) -> Option<&TargetPlace> {
        None
    }

    /// The rotation by which the model is turned after its matrices are made; none of most.
    fn turn(&self) -> Option<BodyTurn> {
        None
    }

    /// Whether the elements are those of the body itself.
    fn is_own(&self) -> bool {
        false
    }

    /// The splines on whose faces the zone lies; none if it brings its surface with it.
    fn faces(&self) -> Option<Discretised<'_>> {
        None
    }

    /// The refined splines; none of other elements, and if the elements are the body's own.
    fn splines(&self) -> Option<&Arc<FineMesh>> {
        None
    }

    /// The divided mesh; none of other elements, and if the elements are the body's own.
    fn mesh(&self) -> Option<&FineElements> {
        None
    }
}

impl dyn FineModel + '_ {
    /// Modes of the body in use, reduced as `coarse`, at the unknowns.
    pub fn shapes(&self, coarse: &ReducedBody) -> Mat<f64> {
        self.prolong(coarse.shapes())
    }

    /// Free modes of the body, reduced as `coarse`, that are dynamic, at the unknowns.
    pub fn low_modes(&self, coarse: &ReducedBody) -> LowModes {
        let LowModes { shapes, omega } = coarse.basis.low_modes();
        LowModes { shapes: self.prolong(shapes.as_ref()), omega }
    }

    /// Flexibility of the interface `unknowns` of `assembled`, the matrices before the model is
    /// turned.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn flexibility(
        &self,
        assembled: &AssembledBody,
        unknowns: &[usize],
    ) -> Result<FreeFlexibility, AdaptiveError> {
        let problem = ElasticProblem::free(assembled, unknowns);
        let flexibility = problem.and_then(|problem| FreeFlexibility::new(&problem, unknowns));
        flexibility.map_err(|source| self.reduction(source))
    }

    /// What the modes of the body, prolonged, leave of `flexibility` (theory Eq. A.13).
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn residual(
        &self,
        flexibility: FreeFlexibility,
        low: LowModes,
    ) -> Result<ResidualFlexibility, AdaptiveError> {
        flexibility.without(low, self.turn()).map_err(|source| self.reduction(source))
    }

    /// Key of what is kept of the flexibility of the interface `unknowns` and, if `has_modes`,
    /// without the modes of the body, reduced as `coarse`, and with what `points` show of it, of
    /// the model as it is turned.
    pub fn compliance_key(
        &self,
        coarse: &ReducedBody,
        unknowns: &[usize],
        points: &[ObservedPlace],
        has_modes: bool,
    ) -> ModelKey {
        let mut key = self.definition();
        key.add(&has_modes);
        if has_modes {
            let basis = &coarse.basis;
            key.add(&(basis.n_low, &basis.omega, basis.shapes.nrows(), matrix_values(&basis.shapes)));
            key.add(&self.turn().map(|turn| (turn.rotation, turn.n_components)));
        }
        // They say as well by which points the contact is watched.
        add_places(&mut key, unknowns, points);
        ModelKey { kind: "compliance", definition: key.0 }
    }

    /// The error of a reduction, with the name of the body.
    fn reduction(&self, source: DynamicsError) -> AdaptiveError {
        AdaptiveError::Reduction { body: self.field().name().to_owned(), source }
    }
}
