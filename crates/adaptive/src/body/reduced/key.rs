//! What stored modes of a body are made from.

use faer::Mat;

use super::Interface;
use crate::spec::InterfaceModes;
use crate::spec::ReductionSpec;
use crate::store::{Bytes, ModelKey};

/// Key of the modes that `reduction` and `interface` make of a body with the `definition` of
/// [`crate::store::body_definition`]; `loads`: the columns of the loads to which it has static
/// answers.
pub fn modes_key(
    definition: &[u8],
    reduction: ReductionSpec,
    interface: &Interface,
    loads: &Mat<f64>,
) -> ModelKey {
    // Places and directions of loads are in their columns.
    let Interface { unknowns, modes, loads: _ } = interface;
    let mut key = Bytes(definition.to_vec());
    let is_static = *modes == InterfaceModes::Quasistatic;
    match reduction {
        ReductionSpec::Modal { modes } => key.add(&(0, modes)),
        // Nothing is held, so these are the free modes.
        ReductionSpec::CraigBampton { modes, .. } if unknowns.is_empty() && !is_static => {
            key.add(&(0, modes))
        }
        ReductionSpec::CraigBampton { modes, fixed_interface_modes } => {
            key.add(&(1, modes, fixed_interface_modes));
        }
        ReductionSpec::All => key.add(&2),
    }
    // Damping comes afterwards.
    key.add(&(is_static, unknowns));
    key.sparse(loads);
    ModelKey { kind: "modes", definition: key.0 }
}
