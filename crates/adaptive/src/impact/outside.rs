//! What of the surfaces of a contact lies outside of the parts that are its zones (theory Eq. C.91):
//! whether it comes to press.

use std::collections::HashSet;
use std::sync::Arc;

use contact_qs::Target;
use contact_qs::search::{BodySurface, Detector, SearchWorkspace, SurfaceModel, reaches_into};
use ffr_dynamics::force::BodyState;

use super::AdaptiveContact;
use super::fine_side::FineSide;
use crate::body::zone::ZoneRegion;
use crate::error::AdaptiveError;

/// The rest of surfaces of which a part is a contact zone.
pub struct Outside {
    own: Option<Arc<SurfaceModel>>,
    target: Option<Arc<SurfaceModel>>,
    workspace: SearchWorkspace,
}

/// What of `surface` is not in the zone of `side`; none of a zone that is all of it, or not a part of
/// a mesh.
fn rest(surface: &SurfaceModel, side: &FineSide) -> Option<Arc<SurfaceModel>> {
    let ZoneRegion::Pieces(pieces) = &side.zone.region else { return None };
    let sides: HashSet<u32> = pieces.pieces.iter().map(|piece| piece.side).collect();
    surface.without(&sides).map(Arc::new)
}

impl AdaptiveContact {
    /// The rest of the surfaces of which the zones of `own` and of `target` are parts; none if they are
    /// none.
    pub(super) fn outside(&self, own: &FineSide, target: Option<&FineSide>) -> Option<Outside> {
        let of_target = self.detector.target.as_ref().body().zip(target);
        let own = rest(&self.detector.own.model, own);
        let target = of_target.and_then(|(surface, side)| rest(&surface.model, side));
        (own.is_some() || target.is_some()).then(|| Outside {
            own,
            target,
            workspace: SearchWorkspace::new(),
        })
    }

    /// Whether what lies outside of the zones touches in the motions `states`.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn is_touched_outside(
        &self,
        Outside { own, target, workspace }: &mut Outside,
        states: &[BodyState],
    ) -> Result<bool, AdaptiveError> {
        let Detector { own: of_own, target: of_target } = &self.detector;
        let Target::Body(of_target) = of_target else {
            let Some(model) = own else { return Ok(false) };
            let own = BodySurface { body: of_own.body, model: Arc::clone(model) };
            let rest = Detector { own, target: self.detector.target.clone() };
            return rest.nearest(states, workspace).map(|found| found.gap < 0.0).map_err(|e| self.fail(e));
        };
        let mut reaches = |part: (&SurfaceModel, usize), other: &BodySurface| {
            let motions = [&states[part.1], &states[other.body]];
            reaches_into([part.0, &*other.model], motions, workspace).map_err(|e| self.fail(e))
        };
        Ok(match own {
            Some(model) => reaches((&**model, of_own.body), of_target)?,
            None => false,
        } || match target {
            Some(model) => reaches((&**model, of_target.body), of_own)?,
            None => false,
        })
    }
}
