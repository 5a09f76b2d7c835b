//! What stored sizes of a body are made from.

use super::SizeWish;
use crate::spec::{ElasticSpec, ReductionSpec};
use crate::store::{Bytes, ModelKey, body_definition};

/// Key of the sizes that the program chooses for the body `trial`, on which sizes that are to be chosen are one, up to the frequency `limit` \[Hz\].
pub fn sizes_key(trial: &ElasticSpec, wish: SizeWish, limit: f64) -> ModelKey {
    let SizeWish { elements, modes } = wish;
    let mut key = Bytes(body_definition(trial));
    key.count(usize::from(elements));
    key.count(usize::from(modes));
    key.number(limit);
    match trial.reduction {
        ReductionSpec::Modal { modes: n } => key.counts(&[0, if modes { 0 } else { n }]),
        ReductionSpec::CraigBampton { modes: n, fixed_interface_modes } => {
            key.counts(&[1, if modes { 0 } else { n }]);
            key.counts(fixed_interface_modes.as_slice());
        }
        ReductionSpec::All => key.counts(&[2]),
    }
    ModelKey { kind: "sizes", definition: key.0 }
}
