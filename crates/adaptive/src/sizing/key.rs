//! What stored sizes of a body are made from.

use super::SizeRequest;
use crate::spec::{ElasticSpec, MeshedSpec, ReductionSpec};
use crate::store::{Bytes, ModelKey, body_definition, meshed_definition};

/// Key of the sizes that the program chooses for the body `candidate`, on which sizes that are to be chosen are one, up to the frequency `limit` \[Hz\] and
/// the number `most`.
pub fn sizes_key(candidate: &ElasticSpec, wish: SizeRequest, (limit, most): (f64, usize)) -> ModelKey {
    let SizeRequest { elements, modes } = wish;
    let mut key = Bytes(body_definition(candidate));
    key.add(&(elements, modes, limit, most));
    match candidate.reduction {
        ReductionSpec::Modal { modes: n } => key.add(&(0, if modes { 0 } else { n })),
        ReductionSpec::CraigBampton { modes: n, fixed_interface_modes } => {
            key.add(&(1, if modes { 0 } else { n }, fixed_interface_modes));
        }
        ReductionSpec::All => key.add(&2),
    }
    ModelKey { kind: "sizes", definition: key.0 }
}

/// Key of the number of modes that the program chooses for the mesh `spec`, up to the frequency `limit` \[Hz\] and the
/// number `most`.
pub fn mesh_key(spec: &MeshedSpec, (limit, most): (f64, usize)) -> ModelKey {
    let mut key = Bytes(meshed_definition(spec));
    key.add(&(limit, most));
    ModelKey { kind: "modes chosen for a mesh", definition: key.0 }
}
