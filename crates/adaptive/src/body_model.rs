//! A body of a run: rigid, elastic, or from a file.

use std::sync::Arc;

use contact_qs::search::SurfaceModel;
use faer::MatRef;
use ffr_dynamics::body::StandardInputData;

use crate::elastic_body::{Discretised, ElasticBody, Interface, ReducedBody};
use crate::error::AdaptiveError;
use crate::fine_model::FineBody;
use crate::fine_modes::FineModes;
use crate::imported::ImportedModel;
use crate::marker_loads::answers_by_marker;
use crate::meshed::MeshedModel;
use crate::spec::{ImportedSpec, MeshedSpec, RigidSpec};
use crate::store::ModelCache;

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
}

/// What a body is made of.
pub enum BodyForm {
    /// A rigid body.
    Rigid,
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

impl BodyModel {
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
                let model = MeshedModel::build(&name, meshed, &interface.loads, cache)?;
                let data = model.data.clone();
                return Ok(Self { name, data, form: BodyForm::Meshed(Box::new(model)) });
            }
            FullModel::Rigid(rigid) => rigid,
        };
        let c = rigid.centre_of_mass;
        let steiner = nalgebra::Matrix3::identity() * c.norm_squared() - c * c.transpose();
        let inertia = rigid.inertia + steiner * rigid.mass;
        let data = StandardInputData::rigid(rigid.motion, rigid.mass, c, inertia)
            .map_err(|source| AdaptiveError::Reduction { body: name.clone(), source })?;
        Ok(Self { name, data, form: BodyForm::Rigid })
    }
}

impl BodyModel {
    /// Eigenfrequencies of the elastic coordinates \[Hz\]; none of a rigid body.
    pub fn frequencies(&self) -> Vec<f64> {
        match &self.form {
            BodyForm::Elastic(elastic) => elastic.frequencies(),
            BodyForm::Imported(imported) => imported.frequencies.clone(),
            BodyForm::Meshed(meshed) => meshed.frequencies.clone(),
            BodyForm::Rigid => Vec::new(),
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
            BodyForm::Rigid | BodyForm::Imported(_) | BodyForm::Meshed(_) => None,
        }
    }

    pub(crate) fn elastic_mut(&mut self) -> Option<&mut ElasticModel> {
        match &mut self.form {
            BodyForm::Elastic(elastic) => Some(elastic),
            BodyForm::Rigid | BodyForm::Imported(_) | BodyForm::Meshed(_) => None,
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
    /// What the elastic coordinates stand for.
    pub fn coordinates(&self) -> CoordinateCounts {
        let n = self.data.n_modes();
        match &self.form {
            BodyForm::Elastic(elastic) => {
                let reduced = &elastic.reduced;
                let n_low = reduced.basis.n_low;
                let answers = answers_by_marker(&reduced.loads, &reduced.basis.static_loads);
                let n_static: usize = answers.iter().map(|(_, n)| n).sum();
                // Interface modes are beyond the low-frequency ones, and static answers are then, too.
                let free = if n_low == n { n - n_static } else { n_low };
                CoordinateCounts { free, interface: n - free - n_static, answers }
            }
            BodyForm::Imported(imported) => counts(n, &imported.answers),
            BodyForm::Meshed(meshed) => counts(n, &meshed.answers),
            BodyForm::Rigid => CoordinateCounts::default(),
        }
    }
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
