//! A model as bytes.
//!
//! Everything is little-endian: [`MAGIC`] (8 bytes, the last is the version), the model's name (32), the numbers of counts
//! and values (8 each), counts and values (8 each), and the SHA-256 of all that (32).

use adaptive::store::StoredModel;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::Name;

/// First bytes of a file; the last one is the version of the format.
pub const MAGIC: [u8; 8] = *b"FBIMODE\x01";
/// Length of magic number, name and sizes \[bytes\].
const HEAD: usize = 8 + 32 + 16;
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
    let (n_counts, n_values) = (model.counts.len(), model.values.len());
    let mut bytes = Vec::with_capacity(HEAD + 8 * (n_counts + n_values) + CHECKSUM);
    bytes.extend(MAGIC);
    bytes.extend(name);
    bytes.extend((n_counts as u64).to_le_bytes());
    bytes.extend((n_values as u64).to_le_bytes());
    model.counts.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    model.values.iter().for_each(|x| bytes.extend(x.to_bits().to_le_bytes()));
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
    let (head, data) = content.split_at_checked(HEAD).ok_or(Fault::Damaged)?;
    if head[8..40] != name[..] {
        return Err(Fault::Other);
    }
    let words = |bytes: &[u8]| -> Vec<u64> {
        let (words, _) = bytes.as_chunks::<8>();
        words.iter().map(|word| u64::from_le_bytes(*word)).collect()
    };
    let sizes = words(&head[40..]);
    let total = sizes[0].checked_add(sizes[1]).and_then(|n| n.checked_mul(8));
    if total != Some(data.len() as u64) {
        return Err(Fault::Damaged);
    }
    let mut counts = words(data);
    // Fits: the data are that long.
    let values = counts.split_off(sizes[0] as usize);
    Ok(StoredModel { counts, values: values.into_iter().map(f64::from_bits).collect() })
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
