//! Flexible bodies, of whatever elements: a [`field::Field`] of displacements, its matrices and
//! what they are reduced for ([`field_body::FieldBody`], [`reduced`]), finer models of it about a
//! contact ([`fine::FineModel`]), and the parts of its surface that may touch ([`zone`]).
//!
//! [`splines`] and [`mesh`] say what splines and finite elements have to say, [`fine::refined`] and
//! [`fine::divided`] how either is made finer, [`field_body`] what both are asked; nothing outside
//! these, and `Workshop`, which builds bodies, asks which of the two a body is. Knows no other body,
//! no motion and no time.

pub mod gauge;
pub mod loads;
pub mod part_motion;
pub mod field;
pub mod reduced;
pub mod point_compliance;
pub mod mesh;
pub mod splines;
pub mod zone;
pub mod fine;
pub mod field_body;
pub mod whole;

use std::sync::Arc;

use crate::body::mesh::MeshedBody;
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;
use crate::spec::{BodyKind, ImportedSpec, RefinementSpec, RigidSpec};
use crate::store::{body_definition, meshed_definition};
use field_body::FieldBody;

/// A body before its reduction.
pub(crate) enum FullModel<'a> {
    /// A rigid body.
    Rigid(&'a RigidSpec),
    /// A flexible body with elements.
    Flexible(Arc<dyn FieldBody>),
    /// A body from a file.
    Imported(&'a ImportedSpec),
}

impl FullModel<'_> {
    /// Number of unknowns of its matrices; none of a rigid or a reduced body.
    pub fn n_unknowns(&self) -> usize {
        match self {
            Self::Flexible(body) => body.n_unknowns(),
            Self::Imported(imported) => imported.n_unknowns(),
            Self::Rigid(_) => 0,
        }
    }
}

/// Builds bodies, and keeps each with what its matrices are made from: of equal ones the matrices
/// are made once.
#[derive(Default)]
pub(crate) struct Workshop {
    splines: Vec<(Vec<u8>, Arc<ElasticBody>)>,
    meshes: Vec<(Vec<u8>, Arc<MeshedBody>)>,
}

impl Workshop {
    /// The body `name` that is made from `kind`, with its matrices, and with smaller elements in
    /// `zones` where its elements are made here.
    ///
    /// # Errors
    /// Those of [`ElasticBody::build`] and [`MeshedBody::build`].
    pub fn build<'a>(
        &mut self,
        name: &str,
        kind: &'a BodyKind,
        zones: Vec<RefinementSpec>,
    ) -> Result<FullModel<'a>, AdaptiveError> {
        Ok(match kind {
            BodyKind::Rigid(rigid) => FullModel::Rigid(rigid),
            BodyKind::Imported(imported) => FullModel::Imported(imported),
            BodyKind::Elastic(spec) => {
                let mut spec = (**spec).clone();
                spec.discretisation.refine.extend(zones);
                let definition = body_definition(&spec);
                let body = match equal(&self.splines, &definition) {
                    Some(equal) => equal.copied(name, spec),
                    None => ElasticBody::build(name, spec)?,
                };
                FullModel::Flexible(keep(&mut self.splines, definition, body))
            }
            BodyKind::Meshed(spec) => {
                let (spec, definition) = ((**spec).clone(), meshed_definition(spec));
                let body = match equal(&self.meshes, &definition) {
                    Some(equal) => equal.copied(name, spec),
                    None => MeshedBody::build(name, spec)?,
                };
                FullModel::Flexible(keep(&mut self.meshes, definition, body))
            }
        })
    }
}

/// The body `name` that is made from `kind`, with its matrices; none if it has no elements.
///
/// # Errors
/// [`AdaptiveError`] with the body's name for a shape or a mesh that makes no body.
pub fn built(name: &str, kind: &BodyKind) -> Result<Option<Arc<dyn FieldBody>>, AdaptiveError> {
    let full = Workshop::default().build(name, kind, Vec::new())?;
    Ok(if let FullModel::Flexible(body) = full { Some(body) } else { None })
}

fn equal<'a, B>(built: &'a [(Vec<u8>, Arc<B>)], definition: &[u8]) -> Option<&'a B> {
    built.iter().find(|(other, _)| other == definition).map(|(_, body)| body.as_ref())
}

fn keep<B: FieldBody + 'static>(
    built: &mut Vec<(Vec<u8>, Arc<B>)>,
    definition: Vec<u8>,
    body: B,
) -> Arc<dyn FieldBody> {
    let body = Arc::new(body);
    built.push((definition, Arc::clone(&body)));
    body
}
