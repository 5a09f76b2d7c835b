//! A model as bytes.
//!
//! [`MAGIC`] (8 bytes, the last is the version), the model's name (32), the model in the encoding of postcard, and the SHA-256 of all that
//! (32).

use adaptive::store::StoredModel;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::Name;

/// First bytes of a file; the last one is the version of the format.
pub const MAGIC: [u8; 8] = *b"FBIMODE\x02";
/// Length of the checksum \[bytes\].
const CHECKSUM: usize = 32;

/// Why a file is no model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Fault {
    /// It begins in another way.
    #[error("is no model of this version's format")]
    Format,
    /// It ends too early or too late, or its checksum differs.
    #[error("is damaged")]
    Damaged,
    /// It is a model of another name.
    #[error("holds another model")]
    Other,
}

/// The bytes of a model.
pub fn encode(name: &Name, model: &StoredModel) -> Vec<u8> {
    let bytes = [&MAGIC[..], name].concat();
    let mut bytes =
        postcard::to_extend(model, bytes).expect("lists know their lengths, and memory does not end");
    let checksum = Sha256::digest(&bytes);
    bytes.extend(checksum);
    bytes
}

/// The model called `name`.
///
/// # Errors
/// [`Fault`] if a single bit is not as it was written.
pub fn decode(bytes: &[u8], name: &Name) -> Result<StoredModel, Fault> {
    if !bytes.starts_with(&MAGIC) {
        return Err(Fault::Format);
    }
    let (content, checksum) = bytes.split_last_chunk::<CHECKSUM>().ok_or(Fault::Damaged)?;
    if Sha256::digest(content).as_slice() != checksum {
        return Err(Fault::Damaged);
    }
    let data = content[MAGIC.len()..].strip_prefix(name).ok_or(Fault::Other)?;
    match postcard::take_from_bytes(data) {
        Ok((model, [])) => Ok(model),
        _ => Err(Fault::Damaged),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const NAME: Name = [7; 32];

    fn model() -> impl Strategy<Value = StoredModel> {
        let counts = prop::collection::vec(any::<u64>(), 0..6);
        let values = prop::collection::vec(any::<u64>().prop_map(f64::from_bits), 0..40);
        (counts, values).prop_map(|(counts, values)| StoredModel { counts, values })
    }

    fn bits(model: &StoredModel) -> (Vec<u64>, Vec<u64>) {
        (model.counts.clone(), model.values.iter().map(|x| x.to_bits()).collect())
    }

    proptest! {
        #[test]
        fn a_model_comes_back_to_the_last_bit(model in model()) {
            let read = decode(&encode(&NAME, &model), &NAME).unwrap();
            prop_assert_eq!(bits(&read), bits(&model));
        }

        #[test]
        fn any_changed_byte_is_found(model in model(), place in any::<prop::sample::Index>(), change in 1..=255u8) {
            let mut bytes = encode(&NAME, &model);
            let i = place.index(bytes.len());
            bytes[i] ^= change;
            prop_assert!(decode(&bytes, &NAME).is_err());
        }

        #[test]
        fn a_file_of_another_length_is_found(model in model(), place in any::<prop::sample::Index>()) {
            let mut bytes = encode(&NAME, &model);
            bytes.push(0);
            prop_assert!(decode(&bytes, &NAME).is_err());
            bytes.truncate(place.index(bytes.len() - 1));
            prop_assert!(decode(&bytes, &NAME).is_err());
        }

        #[test]
        fn arbitrary_bytes_are_no_model(tail in prop::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(decode(&tail, &NAME).is_err());
            prop_assert!(decode(&[&MAGIC[..], &tail].concat(), &NAME).is_err());
        }
    }

    #[test]
    fn a_model_under_another_name_is_found() {
        let bytes = encode(&NAME, &StoredModel::default());
        assert_eq!(decode(&bytes, &[8; 32]), Err(Fault::Other));
    }
}
