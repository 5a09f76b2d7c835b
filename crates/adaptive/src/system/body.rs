//! A body of a run: rigid, flexible, or from a file.

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::SurfaceModel;
use contact_qs::zone::points::DofLookup;
use faer::MatRef;
use ffr_dynamics::body::{RigidMotion, StandardInputData};

use crate::body::FullModel;
use crate::body::field::Field;
use crate::body::field_body::FieldBody;
use crate::body::fine::refined::FineBody;
use crate::body::reduced::{Interface, ReducedBody};
use crate::error::AdaptiveError;
use crate::paper::fine_modes::FineModes;
use crate::spec::{Geometry, RigidSpec};
use crate::store::ModelCache;
use crate::surface::Surface;
use crate::system::imported::ImportedModel;
use crate::system::mode_gradients::{FieldModes, ModeFields};
use crate::system::rigid_surface::{KnownSurfaces, RigidSurface};

/// A body of a run.
pub struct BodyModel {
    /// Name.
    pub name: String,
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// What it is made of.
    pub form: BodyForm,
}

/// What a body is made of.
pub enum BodyForm {
    /// A rigid body, with its surface if it has a shape.
    Rigid(Option<Arc<RigidSurface>>),
    /// A flexible body with elements.
    Flexible(Box<FlexibleModel>),
    /// A body from a file.
    Imported(Box<ImportedModel>),
}

/// Full and reduced model of a flexible body.
pub struct FlexibleModel {
    /// The full model.
    pub body: Arc<dyn FieldBody>,
    /// The reduced model.
    pub reduced: ReducedBody,
    /// The interface that it was reduced for.
    pub interface: Interface,
    /// The fine model whose modes stand for the body's in an impact, if it has modes of its own.
    pub fine: Option<Box<FineState>>,
}

impl FlexibleModel {
    /// Name of the body.
    pub fn name(&self) -> &str {
        self.body.name()
    }

    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        self.body.motion()
    }

    /// The number of the unknown of each function and component.
    pub fn lookup(&self) -> &DofLookup {
        self.body.lookup()
    }

    /// Whether fine models of both can be the same one: their matrices are.
    pub fn is_like(&self, other: &Self) -> bool {
        self.body.definition() == other.body.definition()
    }

    /// The deformable surface, by which pairs are watched.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if the body has no surface.
    pub fn surface(&self) -> Result<Arc<SurfaceModel>, AdaptiveError> {
        let model = self.body.surface(self.reduced.shapes());
        let model = model.and_then(|m| m.with_frequencies(&self.reduced.basis.omega));
        model.map(Arc::new).map_err(|e| surface_fault(self.name(), e))
    }

    /// The field that points and markers of the body move with, and the modes at its unknowns:
    /// those of a fine model while the body has modes of its own.
    pub fn in_use(&self) -> (&dyn Field, MatRef<'_, f64>) {
        match &self.fine {
            Some(state) => (state.fine.mesh.as_ref(), state.modes.reduced.shapes()),
            None => (self.body.as_ref(), self.reduced.shapes()),
        }
    }

    /// Eigenfrequencies of the elastic coordinates \[Hz\].
    pub fn frequencies(&self) -> Vec<f64> {
        self.reduced.basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect()
    }
}

/// Why body `name` has no surface that contact can be watched on.
fn surface_fault(name: &str, source: ContactError) -> AdaptiveError {
    AdaptiveError::unsupported_body(name, source.to_string())
}

impl BodyModel {
    /// The surface of a rigid body with a shape.
    pub fn rigid_surface(&self) -> Option<&RigidSurface> {
        if let BodyForm::Rigid(surface) = &self.form { surface.as_deref() } else { None }
    }

    /// The flexible body with its elements; none of a rigid one and of one from a file.
    pub fn flexible(&self) -> Option<&FlexibleModel> {
        if let BodyForm::Flexible(flexible) = &self.form { Some(flexible) } else { None }
    }

    pub(crate) fn flexible_mut(&mut self) -> Option<&mut FlexibleModel> {
        if let BodyForm::Flexible(flexible) = &mut self.form { Some(flexible) } else { None }
    }

    /// The exact shape of the body; none of a mesh, or of a body without shape.
    pub fn geometry(&self) -> Option<Geometry<'_>> {
        let splines = self.flexible().and_then(|flexible| flexible.body.splines());
        splines.map(|body| body.spec.geometry()).or_else(|| self.rigid_surface().map(RigidSurface::geometry))
    }

    /// Its undeformed surface; none of a body that has none to touch.
    pub fn undeformed(&self) -> Option<&dyn Surface> {
        match (self.flexible(), self.rigid_surface()) {
            (Some(flexible), _) => Some(flexible.body.undeformed()),
            (None, rigid) => rigid.map(RigidSurface::undeformed),
        }
    }

    /// The surface by which pairs are watched, of flexible bodies a deformable one; none of a body
    /// without shape.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if the shape has no surface.
    pub fn surface(&self) -> Result<Option<Arc<SurfaceModel>>, AdaptiveError> {
        match (self.flexible(), self.rigid_surface()) {
            (Some(flexible), _) => flexible.surface().map(Some),
            (None, Some(rigid)) => {
                let model = rigid.undeformed().search_model().map_err(|e| surface_fault(&self.name, e))?;
                Ok(Some(Arc::new(model)))
            }
            (None, None) => Ok(None),
        }
    }

    pub(crate) fn new(
        name: String,
        full: FullModel<'_>,
        interface: Interface,
        cache: &ModelCache,
        surfaces: &mut KnownSurfaces,
    ) -> Result<Self, AdaptiveError> {
        match full {
            FullModel::Flexible(body) => {
                let reduced = body.reduce_with(&interface, cache)?;
                let data = reduced.data.clone();
                let model = FlexibleModel { body, reduced, interface, fine: None };
                Ok(Self { name, data, form: BodyForm::Flexible(Box::new(model)) })
            }
            FullModel::Imported(imported) => {
                let model = ImportedModel::build(&name, imported, &interface.loads)?;
                Ok(Self::imported(name, model))
            }
            FullModel::Rigid(rigid) => Self::rigid(name, rigid, surfaces),
        }
    }

    fn rigid(name: String, rigid: &RigidSpec, surfaces: &mut KnownSurfaces) -> Result<Self, AdaptiveError> {
        let c = rigid.centre_of_mass;
        let steiner = nalgebra::Matrix3::identity() * c.norm_squared() - c * c.transpose();
        let inertia = rigid.inertia + steiner * rigid.mass;
        let data = StandardInputData::rigid(rigid.motion, rigid.mass, c, inertia)
            .map_err(|source| AdaptiveError::Reduction { body: name.clone(), source })?;
        let surface = rigid.shape.as_ref().map(|(shape, model)| surfaces.of(shape, *model));
        let surface = surface.transpose().map_err(|e| surface_fault(&name, e))?;
        Ok(Self { name, data, form: BodyForm::Rigid(surface) })
    }

    /// Size of its surface \[m\]; zero of a body without one.
    pub fn size(&self) -> f64 {
        match (self.flexible(), self.rigid_surface()) {
            (Some(flexible), _) => flexible.body.size(),
            (None, rigid) => rigid.map_or(0.0, |rigid| rigid.undeformed().length()),
        }
    }

    /// How far the surface rises between neighbouring contact points of its whole surface at most
    /// \[m\]; zero of a body without elements.
    pub fn height_between_points(&self) -> f64 {
        self.flexible().map_or(0.0, |flexible| flexible.body.height_between_points())
    }

    /// Eigenfrequencies of the elastic coordinates \[Hz\]; none of a rigid body.
    pub fn frequencies(&self) -> Vec<f64> {
        match &self.form {
            BodyForm::Flexible(flexible) => flexible.frequencies(),
            BodyForm::Imported(imported) => imported.frequencies.clone(),
            BodyForm::Rigid(_) => Vec::new(),
        }
    }

    /// A body from a file.
    pub(crate) fn imported(name: String, model: ImportedModel) -> Self {
        Self { name, data: model.data.clone(), form: BodyForm::Imported(Box::new(model)) }
    }
}

/// What the elastic coordinates of a body stand for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CoordinateCounts {
    /// Free modes.
    pub free: usize,
    /// Modes that a contact interface adds; none where it follows statically.
    pub interface: usize,
    /// Static answers to what each joint or load exerts; the last coordinates if there are no
    /// interface modes.
    pub answers: Vec<(String, usize)>,
}

impl BodyModel {
    /// The fields of the modes, those of the mean-axis frame of bodies reduced here; none of a
    /// rigid body.
    pub fn mode_fields(&self) -> Option<Box<dyn ModeFields + '_>> {
        match &self.form {
            BodyForm::Flexible(flexible) => {
                let shapes = flexible.reduced.basis.shapes.as_ref();
                Some(Box::new(FieldModes { field: flexible.body.as_ref(), shapes }))
            }
            BodyForm::Imported(imported) => Some(Box::new(imported.as_ref())),
            BodyForm::Rigid(_) => None,
        }
    }

    /// What the elastic coordinates stand for.
    pub fn coordinates(&self) -> CoordinateCounts {
        let n = self.data.n_modes();
        match &self.form {
            BodyForm::Flexible(flexible) => of_basis(n, &flexible.reduced),
            BodyForm::Imported(imported) => counts(n, &imported.answers),
            BodyForm::Rigid(_) => CoordinateCounts::default(),
        }
    }
}

/// What the `n` coordinates of a body reduced here stand for.
fn of_basis(n: usize, reduced: &ReducedBody) -> CoordinateCounts {
    let n_low = reduced.basis.n_low;
    let answers = reduced.loads.answers(&reduced.basis.static_loads);
    let n_static: usize = answers.iter().map(|(_, n)| n).sum();
    // Interface modes are beyond the low-frequency ones, and static answers are then, too.
    let free = if n_low == n { n - n_static } else { n_low };
    CoordinateCounts { free, interface: n - free - n_static, answers }
}

/// `n` coordinates of a body without contact, the last of which are static answers.
fn counts(n: usize, answers: &[(String, usize)]) -> CoordinateCounts {
    let n_static: usize = answers.iter().map(|(_, n)| n).sum();
    CoordinateCounts { free: n - n_static, interface: 0, answers: answers.to_vec() }
}

/// A fine model in use. While it is, its view is the body's reduced model; the coarse one is kept
/// here.
pub struct FineState {
    /// The refined body.
    pub(crate) fine: FineBody,
    /// Its modes.
    pub(crate) modes: FineModes,
    /// The surface that belongs to the coarse modes.
    pub(crate) surface: Option<Arc<SurfaceModel>>,
}
