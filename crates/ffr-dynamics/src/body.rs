//! A flexible body as data: assembled matrices, standard input data, reference frame.

pub mod assembled;
pub mod shape_integrals;
mod general_mass;
pub mod modal_mass;
pub(crate) mod foreshortening;
pub mod standard_input_data;
pub mod damping;
pub mod tangent_frame;
pub mod geometric_stiffening;
pub mod reference_loads;
pub mod sparse_import;
pub mod data_parts;

pub use assembled::{AssembledBody, Dof, MassMatrix, RigidMotion};
pub use damping::{DampingLaw, RayleighDamping};
pub use data_parts::DataParts;
pub use geometric_stiffening::GeometricStiffening;
pub use modal_mass::ModalMass;
pub use reference_loads::ReferenceLoad;
pub use shape_integrals::ShapeIntegrals;
pub use sparse_import::{Triangle, sorted_unknowns, symmetric_matrix};
pub use standard_input_data::{DeformedMoments, ModalDamping, StandardInputData};
pub use tangent_frame::TangentFrame;
