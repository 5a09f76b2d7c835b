//! A body of a run: rigid, elastic, or from a file.

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::points::DofLookup;
use contact_qs::search::SurfaceModel;
use faer::MatRef;
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use iga_core::elasticity::Material;
use iga_core::space::Space;

use crate::elastic_body::{Discretised, ElasticBody, Interface, ReducedBody};
use crate::error::AdaptiveError;
use crate::fine_model::FineBody;
use crate::gauge::Gauge;
use crate::imported::ImportedModel;
use crate::marker_loads::answers_by_marker;
use crate::mesh_surface::MeshSurface;
use crate::meshed::MeshedModel;
use crate::mode_gradients::{MeshFields, ModeFields, SplineFields};
use crate::paper::fine_modes::FineModes;
use crate::point_compliance::{Functions, ObservedPlace, PlaceFunctions};
use crate::rigid_surface::RigidSurface;
use crate::spec::{Area, Geometry, ImportedSpec, MeshedSpec, RigidSpec};
use crate::store::{ModelCache, body_definition};
use crate::unsupported::Unsupported;

/// A body of a run.
pub struct BodyModel {
    /// Name.
    pub name: String,
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// What it is made of.
    pub form: BodyForm,
}

/// A body before its reduction.
pub(crate) enum FullModel<'a> {
    /// A rigid body.
    Rigid(&'a RigidSpec),
    /// An elastic body with a geometry.
    Elastic(Box<ElasticBody>),
    /// A body from a file.
    Imported(&'a ImportedSpec),
    /// A body of finite elements.
    Meshed(&'a MeshedSpec),
}

impl FullModel<'_> {
    /// The full model of an elastic body with a geometry.
    pub fn elastic(&self) -> Option<&ElasticBody> {
        match self {
            Self::Elastic(body) => Some(body),
            Self::Rigid(_) | Self::Imported(_) | Self::Meshed(_) => None,
        }
    }

    /// Number of unknowns of its matrices; none of a rigid or a reduced body.
    pub fn n_unknowns(&self) -> usize {
        match self {
            Self::Elastic(body) => body.n_unknowns(),
            Self::Meshed(meshed) => 3 * meshed.mesh.nodes().len(),
            Self::Imported(ImportedSpec::Full { body, .. }) => body.body().dofs.len(),
            Self::Imported(_) | Self::Rigid(_) => 0,
        }
    }
}

/// What a body is made of.
pub enum BodyForm {
    /// A rigid body, with its surface if it has a shape.
    Rigid(Option<Box<RigidSurface>>),
    /// An elastic body with a geometry.
    Elastic(Box<ElasticModel>),
    /// A body from a file.
    Imported(Box<ImportedModel>),
    /// A body of finite elements.
    Meshed(Box<MeshedModel>),
}

/// Full and reduced model of an elastic body.
pub struct ElasticModel {
    /// The full model.
    pub body: ElasticBody,
    /// The reduced model.
    pub reduced: ReducedBody,
    /// The interface that it was reduced for.
    pub interface: Interface,
    /// The fine model whose modes stand for the body's in an impact, if it has modes of its own.
    pub fine: Option<Box<FineState>>,
}

/// A flexible body as contact sees it, of whatever elements it is made.
#[derive(Clone, Copy)]
pub struct FlexibleBody<'a> {
    /// Name.
    pub name: &'a str,
    /// Rigid motions of the body.
    pub motion: RigidMotion,
    /// The reduced model.
    pub reduced: &'a ReducedBody,
    /// The interface that it was reduced for.
    pub interface: &'a Interface,
    /// Numbers of the unknowns.
    pub lookup: &'a DofLookup,
    /// Its material, the one with the slowest waves if there are several.
    pub material: Option<&'a Material>,
    /// Size of the body \[m\].
    pub size: f64,
    /// Number of its elements.
    pub n_elements: usize,
    /// What it is made of.
    kind: FlexibleKind<'a>,
}

/// Elements of a flexible body.
#[derive(Clone, Copy)]
enum FlexibleKind<'a> {
    Splines(&'a ElasticBody),
    Mesh(&'a MeshedSpec),
}

impl<'a> FlexibleBody<'a> {
    /// The body of splines; none of a mesh.
    pub fn spline_body(&self) -> Option<&'a ElasticBody> {
        match self.kind {
            FlexibleKind::Splines(body) => Some(body),
            FlexibleKind::Mesh(_) => None,
        }
    }

    /// Whether fine models of both can be the same one: both are of splines, with the same matrices.
    pub fn is_like(&self, other: &FlexibleBody<'_>) -> bool {
        let both = self.spline_body().zip(other.spline_body());
        both.is_some_and(|(a, b)| body_definition(&a.spec) == body_definition(&b.spec))
    }

    /// Side of the longest element at a disc or ball that a joint or load holds \[m\]; none of a whole face.
    pub fn longest_element_at(&self, area: &Area) -> Option<f64> {
        match self.kind {
            FlexibleKind::Splines(body) => {
                area.extent.longest_element(&body.spec.shape, &body.space, &body.spec.model).ok()?
            }
            FlexibleKind::Mesh(spec) => spec.longest_element(area),
        }
    }

    /// Number of its nodes, or of its functions.
    pub fn n_nodes(&self) -> usize {
        match self.kind {
            FlexibleKind::Splines(body) => body.assembled.nodes.len(),
            FlexibleKind::Mesh(spec) => spec.mesh.nodes().len(),
        }
    }

    /// The fields of its modes in the mean-axis frame, whatever the frame in use.
    fn mode_fields(&self) -> Box<dyn ModeFields + 'a> {
        let shapes = self.reduced.basis.shapes.as_ref();
        match self.kind {
            FlexibleKind::Splines(body) => Box::new(SplineFields { body, shapes }),
            FlexibleKind::Mesh(spec) => {
                Box::new(MeshFields { name: self.name, spec, lookup: self.lookup, shapes })
            }
        }
    }

    /// What a body of finite elements was made from; none of splines.
    pub fn mesh(&self) -> Option<&'a MeshedSpec> {
        match self.kind {
            FlexibleKind::Splines(_) => None,
            FlexibleKind::Mesh(spec) => Some(spec),
        }
    }

    /// The spline space; none of a mesh.
    pub fn splines(&self) -> Option<Discretised<'a>> {
        match self.kind {
            FlexibleKind::Splines(body) => Some(body.discretised()),
            FlexibleKind::Mesh(_) => None,
        }
    }

    /// The deformable surface, by which pairs are watched.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if the body has no surface.
    pub fn surface(&self) -> Result<Arc<SurfaceModel>, AdaptiveError> {
        let shapes = self.reduced.shapes();
        let model = match self.kind {
            FlexibleKind::Splines(body) => {
                SurfaceModel::new(self.motion, &body.shape.patches, &body.space, self.lookup, shapes)
            }
            FlexibleKind::Mesh(spec) => {
                let pieces = MeshSurface::of(&spec.mesh).pieces();
                SurfaceModel::of_pieces(self.motion, &pieces, self.lookup, shapes)
            }
        };
        let model = model.and_then(|m| m.with_frequencies(&self.reduced.basis.omega));
        model.map(Arc::new).map_err(|e| surface_fault(self.name, e))
    }

    /// What the place `place` of the undeformed body shows of the unknowns.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn shown_at(&self, place: &ObservedPlace) -> Result<PlaceFunctions, AdaptiveError> {
        PlaceFunctions::new(place, |x| self.functions_at(x), |x| self.gauge_at(x))
    }

    /// Functions that are not zero at the point `x` of the undeformed body, in the components of its model \[m\], with their values.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn functions_at(&self, x: &[f64; 3]) -> Result<Functions, AdaptiveError> {
        match self.kind {
            FlexibleKind::Splines(body) => body.discretised().functions_at(x),
            FlexibleKind::Mesh(spec) => spec.functions_at(self.name, x),
        }
    }

    /// The field of the unknowns `u` as the body is drawn with it: control values of splines, values at the nodes of a mesh.
    pub fn field(&self, u: &[f64]) -> Vec<f64> {
        match self.kind {
            FlexibleKind::Splines(body) => body.discretised().control_values(u),
            FlexibleKind::Mesh(_) => u.to_vec(),
        }
    }

    /// Strain and stress at the point `x` of the undeformed body, in the components of its model \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError`] if the point is not in the body.
    pub fn gauge_at(&self, x: &[f64; 3]) -> Result<Gauge, AdaptiveError> {
        match self.kind {
            FlexibleKind::Splines(body) => Gauge::of_splines(&body.discretised(), &body.spec.material, x),
            FlexibleKind::Mesh(spec) => spec.gauge(self.name, x),
        }
    }
}

/// Why body `name` has no surface that contact can be watched on.
fn surface_fault(name: &str, source: ContactError) -> AdaptiveError {
    AdaptiveError::unsupported_body(name, Unsupported::Surface(source))
}

impl BodyModel {
    /// The surface of a rigid body with a shape.
    pub fn rigid_surface(&self) -> Option<&RigidSurface> {
        match &self.form {
            BodyForm::Rigid(surface) => surface.as_deref(),
            BodyForm::Elastic(_) | BodyForm::Imported(_) | BodyForm::Meshed(_) => None,
        }
    }

    /// The exact shape of the body; none of a mesh, or of a body without shape.
    pub fn geometry(&self) -> Option<Geometry<'_>> {
        match &self.form {
            BodyForm::Elastic(elastic) => Some(elastic.body.spec.geometry()),
            BodyForm::Rigid(surface) => surface.as_ref().map(|surface| surface.geometry()),
            BodyForm::Imported(_) | BodyForm::Meshed(_) => None,
        }
    }

    /// The surface by which pairs are watched, of flexible bodies a deformable one; none of a body without shape.
    ///
    /// # Errors
    /// [`AdaptiveError::Unsupported`] if the shape has no surface.
    pub fn surface(&self) -> Result<Option<Arc<SurfaceModel>>, AdaptiveError> {
        match (self.flexible(), self.rigid_surface()) {
            (Some(flexible), _) => flexible.surface().map(Some),
            (None, Some(rigid)) => {
                let model = rigid.search_model().map_err(|e| surface_fault(&self.name, e))?;
                Ok(Some(Arc::new(model)))
            }
            (None, None) => Ok(None),
        }
    }

    /// The body as contact sees it; none of a rigid one and of one from a file.
    pub fn flexible(&self) -> Option<FlexibleBody<'_>> {
        let name = &self.name;
        match &self.form {
            BodyForm::Elastic(elastic) => {
                let ElasticModel { body, reduced, interface, .. } = elastic.as_ref();
                Some(FlexibleBody {
                    name,
                    motion: body.assembled.motion,
                    reduced,
                    interface,
                    lookup: &body.lookup,
                    material: Some(&body.spec.material),
                    size: body.size(),
                    n_elements: body.space.n_elements(),
                    kind: FlexibleKind::Splines(body),
                })
            }
            BodyForm::Meshed(meshed) => {
                let MeshedModel { spec, reduced, interface, lookup } = meshed.as_ref();
                Some(FlexibleBody {
                    name,
                    motion: RigidMotion::Spatial,
                    reduced,
                    interface,
                    lookup,
                    material: spec.slowest_material(),
                    size: spec.mesh.size(),
                    n_elements: spec.mesh.elements().len(),
                    kind: FlexibleKind::Mesh(spec),
                })
            }
            BodyForm::Rigid(_) | BodyForm::Imported(_) => None,
        }
    }

    pub(crate) fn new(
        name: String,
        full: FullModel<'_>,
        interface: Interface,
        cache: &ModelCache,
    ) -> Result<Self, AdaptiveError> {
        let rigid = match full {
            FullModel::Elastic(body) => {
                let body = *body;
                let reduced = body.reduce_with(&interface, cache)?;
                let data = reduced.data.clone();
                let form = BodyForm::Elastic(Box::new(ElasticModel { body, reduced, interface, fine: None }));
                return Ok(Self { name, data, form });
            }
            FullModel::Imported(imported) => {
                let model = ImportedModel::build(&name, imported, &interface.loads)?;
                return Ok(Self::imported(name, model));
            }
            FullModel::Meshed(meshed) => {
                let model = MeshedModel::build(&name, meshed, interface, cache)?;
                let data = model.reduced.data.clone();
                return Ok(Self { name, data, form: BodyForm::Meshed(Box::new(model)) });
            }
            FullModel::Rigid(rigid) => rigid,
        };
        let c = rigid.centre_of_mass;
        let steiner = nalgebra::Matrix3::identity() * c.norm_squared() - c * c.transpose();
        let inertia = rigid.inertia + steiner * rigid.mass;
        let data = StandardInputData::rigid(rigid.motion, rigid.mass, c, inertia)
            .map_err(|source| AdaptiveError::Reduction { body: name.clone(), source })?;
        let surface = rigid.shape.as_ref().map(|(shape, model)| RigidSurface::new(shape, *model));
        let surface = surface.transpose().map_err(|e| surface_fault(&name, e))?;
        Ok(Self { name, data, form: BodyForm::Rigid(surface.map(Box::new)) })
    }
}

impl BodyModel {
    /// Eigenfrequencies of the elastic coordinates \[Hz\]; none of a rigid body.
    pub fn frequencies(&self) -> Vec<f64> {
        match &self.form {
            BodyForm::Elastic(elastic) => elastic.frequencies(),
            BodyForm::Imported(imported) => imported.frequencies.clone(),
            BodyForm::Meshed(meshed) => {
                meshed.reduced.basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect()
            }
            BodyForm::Rigid(_) => Vec::new(),
        }
    }

    /// A body from a file.
    pub(crate) fn imported(name: String, model: ImportedModel) -> Self {
        Self { name, data: model.data.clone(), form: BodyForm::Imported(Box::new(model)) }
    }

    /// The models of an elastic body with a geometry.
    pub fn elastic(&self) -> Option<&ElasticModel> {
        match &self.form {
            BodyForm::Elastic(elastic) => Some(elastic),
            BodyForm::Rigid(_) | BodyForm::Imported(_) | BodyForm::Meshed(_) => None,
        }
    }

    pub(crate) fn elastic_mut(&mut self) -> Option<&mut ElasticModel> {
        match &mut self.form {
            BodyForm::Elastic(elastic) => Some(elastic),
            BodyForm::Rigid(_) | BodyForm::Imported(_) | BodyForm::Meshed(_) => None,
        }
    }
}

/// What the elastic coordinates of a body stand for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CoordinateCounts {
    /// Free modes.
    pub free: usize,
    /// Modes that a contact interface adds; none where it follows statically.
    pub interface: usize,
    /// Static answers to what each joint or load exerts; the last coordinates if there are no interface modes.
    pub answers: Vec<(String, usize)>,
}

impl BodyModel {
    /// The fields of the modes, those of the mean-axis frame of bodies reduced here; none of a rigid body.
    pub fn mode_fields(&self) -> Option<Box<dyn ModeFields + '_>> {
        match &self.form {
            BodyForm::Elastic(_) | BodyForm::Meshed(_) => {
                self.flexible().map(|flexible| flexible.mode_fields())
            }
            BodyForm::Imported(imported) => Some(Box::new(imported.as_ref())),
            BodyForm::Rigid(_) => None,
        }
    }

    /// What the elastic coordinates stand for.
    pub fn coordinates(&self) -> CoordinateCounts {
        let n = self.data.n_modes();
        match &self.form {
            BodyForm::Elastic(elastic) => of_basis(n, &elastic.reduced),
            BodyForm::Imported(imported) => counts(n, &imported.answers),
            BodyForm::Meshed(meshed) => of_basis(n, &meshed.reduced),
            BodyForm::Rigid(_) => CoordinateCounts::default(),
        }
    }
}

/// What the `n` coordinates of a body reduced here stand for.
fn of_basis(n: usize, reduced: &ReducedBody) -> CoordinateCounts {
    let n_low = reduced.basis.n_low;
    let answers = answers_by_marker(&reduced.loads, &reduced.basis.static_loads);
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

impl ElasticModel {
    /// The mesh that points and markers of the body move with, and the modes at its unknowns: those of a fine model while the body has
    /// modes of its own.
    pub fn in_use(&self) -> (Discretised<'_>, MatRef<'_, f64>) {
        match &self.fine {
            Some(state) => (state.fine.discretised(), state.modes.reduced.shapes()),
            None => (self.body.discretised(), self.reduced.shapes()),
        }
    }

    /// Eigenfrequencies of the elastic coordinates \[Hz\].
    pub fn frequencies(&self) -> Vec<f64> {
        self.reduced.basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect()
    }
}

/// A fine model in use. While it is, its view is the body's reduced model; the coarse one is kept here.
pub struct FineState {
    /// The refined body.
    pub(crate) fine: FineBody,
    /// Its modes.
    pub(crate) modes: FineModes,
    /// The surface that belongs to the coarse modes.
    pub(crate) surface: Option<Arc<SurfaceModel>>,
}
