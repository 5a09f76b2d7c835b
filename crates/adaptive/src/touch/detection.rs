//! Watches a pair that is not in contact: nearest points, first touch (\[A\] (7), Fig. 2).

use std::sync::Arc;
use std::time::{Duration, Instant};

use contact_qs::search::{
    SearchWorkspace, SurfaceModel, SurfaceSite, closing_speed_bound, minimum_distance, plane_distance,
    surface_speed_bound,
};
use contact_qs::{ContactElement, ContactError, ContactReport, Plane};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, ForceElement, GeneralisedForce, Motion};
use nalgebra::{Unit, Vector3};

/// Where two surfaces are nearest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Gap, negative when they overlap \[m\].
    pub gap: f64,
    /// On the contact body.
    pub contact: SurfaceSite,
    /// On the target; none on a plane.
    pub target: Option<SurfaceSite>,
    /// Unit normal in the inertial frame, towards the contact body.
    pub normal: Vector3<f64>,
}

/// Surfaces of a pair that may meet.
#[derive(Clone)]
pub struct Detector {
    body: usize,
    model: Arc<SurfaceModel>,
    target: DetectorTarget,
}

/// A search between the surfaces of a pair: where the last one ended, and what all have cost.
pub struct Search {
    workspace: SearchWorkspace,
    elapsed: Duration,
}

impl Search {
    /// Before the first search.
    pub fn new() -> Self {
        Self { workspace: SearchWorkspace::new(), elapsed: Duration::ZERO }
    }

    /// Forgets where the last search ended: the next one depends on the motions alone.
    pub fn forget(&mut self) {
        self.workspace.forget();
    }

    /// Time spent so far.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }
}

impl Default for Search {
    fn default() -> Self {
        Self::new()
    }
}

/// The target whose distance from the surface is looked for.
#[derive(Clone)]
pub enum DetectorTarget {
    /// A fixed plane.
    Plane(Plane),
    /// Another body, with its surface.
    Body(usize, Arc<SurfaceModel>),
}

impl DetectorTarget {
    /// The fixed plane through `point` whose `normal` points to the body's side.
    pub fn plane(point: Vector3<f64>, normal: Vector3<f64>) -> Self {
        Self::Plane(Plane { point, normal: Unit::new_normalize(normal) })
    }
}

impl Detector {
    /// A detector for the surface `model` of body `body`.
    pub fn new(body: usize, model: Arc<SurfaceModel>, target: DetectorTarget) -> Self {
        Self { body, model, target }
    }

    /// The same surface before another target.
    #[must_use]
    pub fn against(&self, target: DetectorTarget) -> Self {
        Self { target, ..self.clone() }
    }

    /// Puts `model` in the place of the surface of body `body`, if that is one of the pair; returns
    /// the one before. What a search remembers belongs to the surface before.
    pub fn replace_surface(&mut self, body: usize, model: &Arc<SurfaceModel>) -> Option<Arc<SurfaceModel>> {
        let mut before = None;
        if self.body == body {
            before = Some(std::mem::replace(&mut self.model, Arc::clone(model)));
        }
        if let DetectorTarget::Body(other, target) = &mut self.target
            && *other == body
        {
            before = Some(std::mem::replace(target, Arc::clone(model)));
        }
        before
    }

    /// Gap and nearest points in the motions `bodies`.
    ///
    /// # Errors
    /// [`ContactError`] for motions that are not finite, or a plane that leaves the model's symmetry.
    pub fn nearest(&self, bodies: &[BodyState], search: &mut Search) -> Result<Nearest, ContactError> {
        let begin = Instant::now();
        let nearest = self.found(bodies, &mut search.workspace);
        search.elapsed += begin.elapsed();
        nearest
    }

    fn found(&self, bodies: &[BodyState], workspace: &mut SearchWorkspace) -> Result<Nearest, ContactError> {
        let state = &bodies[self.body];
        match &self.target {
            DetectorTarget::Plane(plane) => {
                let found = plane_distance(&self.model, state, plane, workspace)?;
                let normal = plane.normal.into_inner();
                Ok(Nearest { gap: found.gap, contact: found.site, target: None, normal })
            }
            DetectorTarget::Body(other, model) => {
                let models = [self.model.as_ref(), model.as_ref()];
                let found = minimum_distance(models, [state, &bodies[*other]], workspace)?;
                let [contact, target] = found.sites;
                Ok(Nearest { gap: found.gap, contact, target: Some(target), normal: found.normal })
            }
        }
    }

    /// Largest speed at which the surfaces may approach each other [m/s].
    pub fn closing_speed_bound(&self, bodies: &[BodyState]) -> f64 {
        let state = &bodies[self.body];
        match &self.target {
            DetectorTarget::Plane(_) => state.velocity.norm() + surface_speed_bound(&self.model, state),
            DetectorTarget::Body(other, model) => {
                closing_speed_bound([self.model.as_ref(), model.as_ref()], [state, &bodies[*other]])
            }
        }
    }

    /// Size of the larger body \[m\].
    pub fn size(&self) -> f64 {
        match &self.target {
            DetectorTarget::Plane(_) => self.model.size(),
            DetectorTarget::Body(_, other) => self.model.size().max(other.size()),
        }
    }

    /// Size of the smaller body \[m\].
    pub fn least_size(&self) -> f64 {
        match &self.target {
            DetectorTarget::Plane(_) => self.model.size(),
            DetectorTarget::Body(_, other) => self.model.size().min(other.size()),
        }
    }
}

/// Stands in a system for a contact whose model is not there: no force, no gap to look at.
#[derive(Debug, Clone)]
pub struct InactiveContact {
    body: usize,
    target: Option<usize>,
}

impl InactiveContact {
    /// For a contact of body `body` with body `target`, or with a plane.
    pub fn new(body: usize, target: Option<usize>) -> Self {
        Self { body, target }
    }
}

impl ForceElement for InactiveContact {
    type State = ();
    type Workspace = ();
    type Found = ContactReport;

    fn start(&self) -> ((), (), ContactReport) {
        Default::default()
    }

    fn evaluate(
        &self,
        _: Motion<'_>,
        (): &mut (),
        (): &mut (),
        _: &mut ContactReport,
        _: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        Ok(())
    }
}

impl ContactElement for InactiveContact {
    fn kind(&self) -> &'static str {
        "inactive"
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.body, self.target)
    }

    fn smallest_gap(&self, _: Motion<'_>, (): &(), (): &mut ()) -> f64 {
        f64::INFINITY
    }

    fn normal(&self, _: Motion<'_>, (): &(), (): &mut ()) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn place(&self, _: Motion<'_>, (): &(), (): &mut ()) -> Vector3<f64> {
        Vector3::repeat(f64::NAN)
    }

    fn penalty(&self) -> f64 {
        f64::NAN
    }

    fn n_points(&self) -> usize {
        0
    }
}
