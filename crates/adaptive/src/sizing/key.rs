//! What stored sizes of a body are made from.

use super::SizeRequest;
use crate::spec::{Accuracy, ElasticSpec, MeshedSpec, ReductionSpec};
use crate::store::{Bytes, ModelKey, body_definition, meshed_definition};

/// Key of the sizes that the program chooses for the body `candidate`, on which sizes that are to
/// be chosen are one, up to the frequency `limit` \[Hz\] and the number `most`.
pub fn sizes_key(
    candidate: &ElasticSpec,
    (wish, accuracy): (SizeRequest, Accuracy),
    (limit, most): (f64, usize),
) -> ModelKey {
    let SizeRequest { elements, modes } = wish;
    let mut key = Bytes(body_definition(candidate));
    key.add(&(elements, modes, limit, most));
    match candidate.flexible.reduction {
        ReductionSpec::Modal { modes: n } => key.add(&(0, if modes { 0 } else { n })),
        ReductionSpec::CraigBampton { modes: n, fixed_interface_modes } => {
            key.add(&(1, if modes { 0 } else { n }, fixed_interface_modes));
        }
        ReductionSpec::All => key.add(&2),
    }
    add_level(&mut key, accuracy);
    ModelKey { kind: "sizes", definition: key.0 }
}

/// Key of the number of modes that the program chooses for the mesh `spec`, up to the frequency
/// `limit` \[Hz\] and the number `most`.
pub fn mesh_key(spec: &MeshedSpec, accuracy: Accuracy, (limit, most): (f64, usize)) -> ModelKey {
    let mut key = Bytes(meshed_definition(spec));
    key.add(&(limit, most));
    add_level(&mut key, accuracy);
    ModelKey { kind: "modes chosen for a mesh", definition: key.0 }
}

/// Adds the level of what is chosen; the usual one is what no level says.
fn add_level(key: &mut Bytes, accuracy: Accuracy) {
    if accuracy != Accuracy::default() {
        key.add(&accuracy.name());
    }
}
