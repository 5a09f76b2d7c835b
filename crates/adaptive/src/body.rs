//! Flexible bodies, of whatever elements: a [`field::Field`] of displacements, its matrices and what they are reduced for ([`field_body::FieldBody`],
//! [`reduced`]), and finer models of it about a contact ([`fine::FineModel`]).
//!
//! [`of_splines`] and [`of_mesh`] say what splines and finite elements have to say; nothing outside them, and the place that builds bodies,
//! asks which of the two a body is.

pub mod field;
pub mod reduced;
pub mod fine;
pub mod field_body;
pub mod whole;
pub mod of_splines;
pub mod of_mesh;

use std::sync::Arc;

use crate::elastic_body::ElasticBody;
use crate::error::AdaptiveError;
use crate::meshed::MeshedBody;
use crate::spec::BodyKind;
use field_body::FieldBody;

/// The body `name` that is made from `kind`, with its matrices; none if it has no elements.
///
/// # Errors
/// Those of [`ElasticBody::build`] and [`MeshedBody::build`].
pub fn built(name: &str, kind: &BodyKind) -> Result<Option<Arc<dyn FieldBody>>, AdaptiveError> {
    Ok(match kind {
        BodyKind::Elastic(spec) => Some(Arc::new(ElasticBody::build(name, (**spec).clone())?)),
        BodyKind::Meshed(spec) => Some(Arc::new(MeshedBody::build(name, (**spec).clone())?)),
        BodyKind::Rigid(_) | BodyKind::Imported(_) => None,
    })
}
