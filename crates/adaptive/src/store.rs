//! Models that are kept instead of being built again: of equal bodies within a run, and between runs (`docs/cache.md`).
//!
//! This module knows what a model is made from ([`ModelKey`]) and what of it is kept ([`StoredModel`]); where it is kept is
//! the business of a [`ModelStore`]. A model that was kept gives the same results to the last bit as one that is built.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use faer::Mat;
use serde::{Deserialize, Serialize};

mod key;

pub use key::{Bytes, ModelKey, body_definition};

/// What of a model is kept.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StoredModel {
    /// Sizes and counts.
    pub counts: Vec<u64>,
    /// Numbers, to the last bit.
    pub values: Vec<f64>,
}

/// A place for models. Nothing that goes wrong in it may stop a run: what cannot be read is not there, what cannot be
/// written is lost.
pub trait ModelStore: Send + Sync {
    /// The model of `key`, if it is there and undamaged.
    fn load(&self, key: &ModelKey) -> Option<StoredModel>;

    /// Keeps a model.
    fn save(&self, key: &ModelKey, model: &StoredModel);
}

/// How a store was used in a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CacheUse {
    /// Models found.
    pub hits: u64,
    /// Models that had to be built.
    pub misses: u64,
    /// Time for reading and writing \[s\].
    pub seconds: f64,
}

/// The models of a run: those that it has built of its bodies, and the store, if there is one.
///
/// Clones share everything.
#[derive(Clone, Default)]
pub struct ModelCache {
    store: Option<Arc<dyn ModelStore>>,
    state: Arc<Mutex<State>>,
}

#[derive(Default)]
struct State {
    /// Models of this run. There are few, so they are searched one by one.
    built: Vec<(ModelKey, Arc<StoredModel>)>,
    used: CacheUse,
}

impl ModelCache {
    /// A cache over `store`.
    pub fn new(store: Arc<dyn ModelStore>) -> Self {
        Self { store: Some(store), state: Arc::default() }
    }

    /// How the store was used so far.
    pub fn used(&self) -> CacheUse {
        self.lock().used
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The model of `key` from this run or the store, otherwise built and kept in both. `decode` returns nothing if what was
    /// kept does not fit.
    ///
    /// # Errors
    /// That of `build`.
    pub fn shared<T, E>(
        &self,
        key: ModelKey,
        decode: impl Fn(&StoredModel) -> Option<T>,
        build: impl FnOnce() -> Result<T, E>,
        encode: impl Fn(&T) -> StoredModel,
    ) -> Result<T, E> {
        let earlier = self.lock().built.iter().find(|(k, _)| *k == key).map(|(_, model)| Arc::clone(model));
        if let Some(found) = earlier.and_then(|model| decode(&model)) {
            return Ok(found);
        }
        let model = self.stored(|| key.clone(), decode, build, &encode)?;
        let encoded = Arc::new(encode(&model));
        self.lock().built.push((key, encoded));
        Ok(model)
    }

    /// The model of `key` from the store, otherwise built and kept there. Without a store the key is not made.
    ///
    /// # Errors
    /// That of `build`.
    pub fn stored<T, E>(
        &self,
        key: impl FnOnce() -> ModelKey,
        decode: impl Fn(&StoredModel) -> Option<T>,
        build: impl FnOnce() -> Result<T, E>,
        encode: impl Fn(&T) -> StoredModel,
    ) -> Result<T, E> {
        let Some(store) = &self.store else { return build() };
        let began = Instant::now();
        let key = key();
        let found = store.load(&key).and_then(|model| decode(&model));
        let mut seconds = began.elapsed().as_secs_f64();
        let is_hit = found.is_some();
        let model = match found {
            Some(model) => model,
            None => {
                let model = build()?;
                let began = Instant::now();
                store.save(&key, &encode(&model));
                seconds += began.elapsed().as_secs_f64();
                model
            }
        };
        let used = &mut self.lock().used;
        used.seconds += seconds;
        *(if is_hit { &mut used.hits } else { &mut used.misses }) += 1;
        Ok(model)
    }
}

/// A matrix as numbers, column by column.
pub fn matrix_values(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.ncols()).flat_map(|j| matrix.col(j).iter().copied()).collect()
}

/// The matrix with `n_rows` rows whose columns are `values`; none if they do not fit.
pub fn matrix(values: &[f64], n_rows: usize, n_columns: usize) -> Option<Mat<f64>> {
    (n_rows.checked_mul(n_columns)? == values.len())
        .then(|| Mat::from_fn(n_rows, n_columns, |i, j| values[j * n_rows + i]))
}
