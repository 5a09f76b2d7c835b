//! Models that are kept instead of being built again: of equal bodies within a run, and between
//! runs (`docs/cache.md`).
//!
//! This module knows what a model is made from ([`ModelKey`]) and what of it is kept
//! ([`StoredModel`]); where it is kept is the business of a [`ModelStore`]. A model that was kept
//! gives the same results to the last bit as one that is built.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use faer::Mat;
use serde::{Deserialize, Serialize};

mod key;

pub use key::{Bytes, ModelKey, body_definition, meshed_definition};

/// A model as the store keeps it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StoredModel {
    /// Sizes and counts.
    pub counts: Vec<u64>,
    /// Numbers, to the last bit.
    pub values: Vec<f64>,
}

/// A place for models. Nothing that goes wrong in it may stop a run: what cannot be read is not
/// there, what cannot be written is lost.
pub trait ModelStore: Send + Sync {
    /// The model of `key`, if it is there and undamaged.
    fn load(&self, key: &ModelKey) -> Option<StoredModel>;

    /// Keeps a model.
    fn save(&self, key: &ModelKey, model: &StoredModel);
}

/// How models were kept and built in a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CacheUse {
    /// Models found.
    pub hits: u64,
    /// Models that had to be built.
    pub misses: u64,
    /// Time for reading and writing \[s\].
    pub seconds: f64,
    /// Fine models that were built, with or without a store.
    pub fine_models: u64,
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
    /// Models used last in this run, the latest one last. There are few, so they are searched one
    /// by one.
    recent: Vec<(ModelKey, Arc<StoredModel>)>,
    used: CacheUse,
}

/// Numbers that the models used last may have together: 256 MB, those of some thirty contact zones
/// of 1000 unknowns.
const RECENT_NUMBERS: usize = 32 << 20;

impl State {
    fn take_recent(&mut self, key: &ModelKey) -> Option<Arc<StoredModel>> {
        let place = self.recent.iter().position(|(k, _)| k == key)?;
        Some(self.recent.remove(place).1)
    }

    fn keep_recent(&mut self, key: ModelKey, model: Arc<StoredModel>) {
        self.recent.push((key, model));
        let size = |recent: &[(ModelKey, Arc<StoredModel>)]| {
            recent.iter().map(|(key, model)| model.values.len() + key.definition.len() / 8).sum::<usize>()
        };
        while size(&self.recent) > RECENT_NUMBERS {
            self.recent.remove(0);
        }
    }
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

    /// Counts a fine model that is built.
    pub fn count_fine_model(&self) {
        self.lock().used.fine_models += 1;
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The model of `key` from those that the run used last, otherwise as [`ModelCache::stored`].
    /// `decode` returns nothing if what was kept does not fit.
    ///
    /// # Errors
    /// That of `build`.
    pub fn recent<T, E>(
        &self,
        key: ModelKey,
        decode: impl Fn(&StoredModel) -> Option<T>,
        build: impl FnOnce() -> Result<T, E>,
        encode: impl Fn(&T) -> StoredModel,
    ) -> Result<T, E> {
        let earlier = self.lock().take_recent(&key);
        if let Some((model, found)) = earlier.and_then(|model| decode(&model).map(|found| (model, found))) {
            self.lock().keep_recent(key, model);
            return Ok(found);
        }
        let model = self.stored(|| key.clone(), decode, build, &encode)?;
        let encoded = Arc::new(encode(&model));
        self.lock().keep_recent(key, encoded);
        Ok(model)
    }

    /// The model of `key` from the store, otherwise built and kept there. Without a store the key
    /// is not made.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_used_long_ago_make_room() {
        let mut state = State::default();
        let key = |n: u8| ModelKey { kind: "test", definition: vec![n] };
        let large = || Arc::new(StoredModel { counts: Vec::new(), values: vec![0.0; RECENT_NUMBERS / 3] });
        (1..=3).for_each(|n| state.keep_recent(key(n), large()));
        // Used again, the first is the latest.
        let first = state.take_recent(&key(1)).expect("kept");
        state.keep_recent(key(1), first);
        state.keep_recent(key(4), large());
        let held = |state: &mut State, n| state.take_recent(&key(n)).is_some();
        assert!(!held(&mut state, 2) && held(&mut state, 3) && held(&mut state, 1) && held(&mut state, 4));
    }
}
