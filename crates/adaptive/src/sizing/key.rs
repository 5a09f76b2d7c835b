//! What stored sizes of a body are made from.

use super::SizeRequest;
use super::mode_count::ModeRange;
use crate::spec::{Accuracy, ElasticSpec, MeshedSpec, ReductionSpec};
use crate::store::{Bytes, ModelKey, body_definition, meshed_definition};

/// Key of the sizes that the program chooses for the body `candidate`, on which sizes that are to
/// be chosen are one, for modes in `range`.
pub fn sizes_key(
    candidate: &ElasticSpec,
    wish: SizeRequest,
    accuracy: Accuracy,
    range: ModeRange,
) -> ModelKey {
    let SizeRequest { elements, modes } = wish;
    let mut key = Bytes(body_definition(candidate));
    key.add(&(elements, modes, range.limit, range.most));
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

/// Key of the number of modes in `range` that the program chooses for the mesh `spec`.
pub fn mesh_key(spec: &MeshedSpec, accuracy: Accuracy, range: ModeRange) -> ModelKey {
    let mut key = Bytes(meshed_definition(spec));
    key.add(&(range.limit, range.most));
    add_level(&mut key, accuracy);
    ModelKey { kind: "modes that a mesh carries", definition: key.0 }
}

/// Adds the level of what is chosen; the usual one is what no level says.
fn add_level(key: &mut Bytes, accuracy: Accuracy) {
    if accuracy != Accuracy::default() {
        key.add(&accuracy.name());
    }
}
