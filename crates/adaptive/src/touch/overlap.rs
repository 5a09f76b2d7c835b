//! How far two bodies overlap, and by what move they would not (docs/theory.md part P).

use contact_qs::search::Detector;
use contact_qs::{Plane, Target};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::error::AdaptiveError;
use crate::record::finding::Components;
use crate::spec::{ContactSpec, RunSpec, Start};
use crate::touch::detection::{Nearest, Search};
use crate::touch::sites::{self, Surfaces};
use crate::touch::tolerances::ROUND_OFF;

/// Moves in search of a place where two bodies no longer overlap.
const MOVES: usize = 50;

/// How the bodies of a contact overlap.
pub(crate) struct Overlap {
    pub depth: f64,
    /// Deepest point in space \[m\].
    pub point: Vector3<f64>,
    /// Displacement of the contact body that removes the overlap \[m\].
    pub shift: Vector3<f64>,
    /// Size of the bodies \[m\].
    pub size: f64,
}

impl Overlap {
    /// Whether it is more than round-off of places.
    pub fn is_real(&self) -> bool {
        self.depth > ROUND_OFF * self.size
    }
}

/// The two partners of a contact.
pub(crate) struct Pair<'a> {
    /// Name of the contact.
    pub contact: &'a str,
    /// Index of the contact body.
    pub body: usize,
    /// Name of the contact body.
    pub body_name: &'a str,
    /// Rigid motions of the contact body.
    pub motion: RigidMotion,
    /// Overlap that is allowed \[m\].
    pub allowed: f64,
}

impl Pair<'_> {
    /// How the surfaces of `detector`, whose contact body is that of the pair, overlap in the
    /// motions `states`; nothing if they do not.
    ///
    /// # Errors
    /// [`AdaptiveError::BehindPlane`] for a body that lies on the wrong side of a plane, [`AdaptiveError::Contact`] if nearest places cannot be found.
    pub fn overlap(
        &self,
        detector: &Detector,
        search: &mut Search,
        states: &[BodyState],
    ) -> Result<Option<Overlap>, AdaptiveError> {
        let first = self.nearest(detector, search, states)?;
        let size = detector.size();
        if first.gap >= -ROUND_OFF * size {
            return Ok(None);
        }
        if let Target::Plane(Plane { point, normal }) = detector.target {
            let target = Target::Plane(Plane { point, normal: -normal });
            let from_behind = Detector { target, own: detector.own.clone() };
            let farthest = self.nearest(&from_behind, &mut Search::new(), states)?.gap;
            if farthest >= 0.0 {
                return Err(self.behind_plane(farthest, &(first.normal * -first.gap)));
            }
        }
        // The deepest point leaves the other body first; others may follow.
        let (mut moved, mut shift) = (states.to_vec(), Vector3::zeros());
        let mut gap = first.gap;
        let (along, gain) = self.way_out(&first.normal);
        for _ in 0..MOVES {
            if gap >= -0.5 * ROUND_OFF * size {
                break;
            }
            shift -= along * (gap / gain);
            moved[self.body].position = states[self.body].position + shift;
            gap = self.nearest(detector, search, &moved)?.gap;
        }
        Ok(Some(Overlap { depth: -first.gap, point: first.contact.point, shift, size }))
    }

    /// Nearest places of the surfaces of `detector`.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if they cannot be found.
    pub fn nearest(
        &self,
        detector: &Detector,
        search: &mut Search,
        states: &[BodyState],
    ) -> Result<Nearest, AdaptiveError> {
        search
            .nearest(detector, states)
            .map_err(|source| AdaptiveError::Contact { contact: self.contact.to_owned(), source })
    }

    /// Direction in which the contact body can be moved along `normal`, and how much of a move that
    /// way counts.
    fn way_out(&self, normal: &Vector3<f64>) -> (Vector3<f64>, f64) {
        /// Cosine below which a move hardly helps; the places found then tell how much more is
        /// needed.
        const LEAST: f64 = 0.2;
        let mut free = *normal;
        match self.motion {
            RigidMotion::Axial => (free.x, free.y) = (0.0, 0.0),
            RigidMotion::Planar => free.z = 0.0,
            RigidMotion::Spatial => {}
        }
        let along = free.try_normalize(1e-6).unwrap_or_else(|| match self.motion {
            RigidMotion::Axial => Vector3::z(),
            _ => Vector3::x(),
        });
        (along, along.dot(normal).max(LEAST))
    }

    /// The error for an overlap that is not allowed.
    pub fn refused(&self, overlap: &Overlap) -> AdaptiveError {
        AdaptiveError::InitialOverlap {
            contact: self.contact.to_owned(),
            body: self.body_name.to_owned(),
            depth: overlap.depth,
            place: Components(overlap.point),
            shift: Components(overlap.shift),
            allowed: self.allowed,
        }
    }

    /// The error for a contact body whose nearest point is `distance` behind the plane and comes
    /// out by `shift`.
    pub fn behind_plane(&self, distance: f64, shift: &Vector3<f64>) -> AdaptiveError {
        let (contact, body) = (self.contact.to_owned(), self.body_name.to_owned());
        AdaptiveError::BehindPlane { contact, body, distance, shift: Components(*shift) }
    }
}

/// Refuses bodies that overlap at the start in the motions `poses`, before anything is built for
/// them: the undeformed ones, as they are then unless the run starts from equilibrium. Spheres of
/// Hertz contacts are left to the run.
///
/// # Errors
/// [`AdaptiveError::InitialOverlap`]; [`AdaptiveError::BehindPlane`] for a body on the wrong side of a plane; [`AdaptiveError::Contact`] if nearest places cannot be found.
pub fn check_undeformed(spec: &RunSpec, poses: &[BodyState]) -> Result<(), AdaptiveError> {
    let surfaces = Surfaces::new(&spec.bodies);
    let contacts = spec.contacts.iter().filter(|contact| contact.spheres().is_none());
    for contact in contacts.filter(|_| spec.settings.start != Start::Elastic) {
        if let Some(overlap) = of_undeformed(spec, &surfaces, contact, poses)? {
            return Err(overlap);
        }
    }
    Ok(())
}

/// The error for the overlap of a contact, if it has one that is not allowed.
fn of_undeformed(
    spec: &RunSpec,
    surfaces: &Surfaces<'_>,
    contact: &ContactSpec,
    poses: &[BodyState],
) -> Result<Option<AdaptiveError>, AdaptiveError> {
    let fail = |source| AdaptiveError::Contact { contact: contact.name.clone(), source };
    let body = &spec.bodies[contact.body];
    let Some(surfaces) = sites::Pair::new(surfaces, contact).map_err(fail)? else { return Ok(None) };
    let detector = surfaces.detector();
    if are_apart(&detector, poses) {
        return Ok(None);
    }
    let pair = Pair {
        contact: &contact.name,
        body: contact.body,
        body_name: &body.name,
        motion: body.kind.motion(),
        allowed: contact.initial_overlap,
    };
    let overlap = pair.overlap(&detector, &mut Search::new(), poses)?;
    let overlap = overlap.filter(|overlap| overlap.is_real() && overlap.depth > pair.allowed);
    Ok(overlap.map(|overlap| pair.refused(&overlap)))
}

/// Whether the balls about the origins of two bodies that hold their surfaces do not meet.
fn are_apart(Detector { own, target }: &Detector, poses: &[BodyState]) -> bool {
    target.as_ref().body().is_some_and(|other| {
        let distance = (poses[own.body].position - poses[other.body].position).norm();
        distance > own.model.radius() + other.model.radius()
    })
}
