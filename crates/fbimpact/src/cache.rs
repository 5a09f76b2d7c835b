//! Reduced models kept between runs: files in a folder, one per model (`docs/cache.md`).

mod container;
mod folder;
mod program;
mod settings;

pub use container::{Fault, MAGIC, decode, encode};
pub use folder::{Contents, Folder};
pub use settings::{CacheSettings, default_folder};

/// Size of the folder unless the command line says otherwise \[GiB\].
pub const DEFAULT_LIMIT: f64 = 4.0;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use adaptive::store::{ModelCache, ModelKey, ModelStore, StoredModel};
use sha2::{Digest, Sha256};

/// Name of a model: SHA-256 of everything that defines it.
pub type Name = [u8; 32];

/// The models in a folder.
pub struct DiskStore {
    folder: Folder,
    program: OnceLock<Name>,
    /// Whether writing has failed: one warning is enough.
    has_failed: AtomicBool,
}

impl DiskStore {
    /// The models in `folder`, which is made when the first one is written.
    pub fn new(folder: Folder) -> Self {
        Self { folder, program: OnceLock::new(), has_failed: AtomicBool::new(false) }
    }

    /// Name of the model of `key` as this very program builds it.
    fn name(&self, key: &ModelKey) -> Name {
        let mut hash = Sha256::new();
        hash.update(self.program.get_or_init(program::fingerprint));
        // Nobody takes models that somebody else has written.
        #[cfg(unix)]
        hash.update(nix::unistd::geteuid().as_raw().to_le_bytes());
        hash.update((key.kind.len() as u64).to_le_bytes());
        hash.update(key.kind);
        hash.update(&key.definition);
        hash.finalize().into()
    }

    fn failed(&self, error: &std::io::Error) {
        if !self.has_failed.swap(true, Ordering::Relaxed) {
            let folder = self.folder.path().display();
            tracing::warn!("models cannot be kept in {folder}, the run goes on without: {error}");
        }
    }
}

impl ModelStore for DiskStore {
    fn load(&self, key: &ModelKey) -> Option<StoredModel> {
        let name = self.name(key);
        let found = match self.folder.read(&name) {
            Ok(bytes) => decode(&bytes?, &name),
            Err(error) => {
                let path = self.folder.file(&name);
                tracing::warn!("{} cannot be read, the model is built anew: {error}", path.display());
                return None;
            }
        };
        match found {
            Ok(model) => {
                tracing::debug!(kind = key.kind, file = %self.folder.file(&name).display(), "model found");
                Some(model)
            }
            Err(fault) => {
                let path = self.folder.file(&name);
                tracing::warn!("{} {fault}, the model is built anew", path.display());
                None
            }
        }
    }

    fn save(&self, key: &ModelKey, model: &StoredModel) {
        let name = self.name(key);
        if let Err(error) = self.folder.write(&name, &encode(&name, model)) {
            self.failed(&error);
        }
    }
}

/// The models of a run with `settings`.
pub fn open(settings: &CacheSettings) -> ModelCache {
    match settings.folder() {
        Some(folder) => ModelCache::new(Arc::new(DiskStore::new(folder))),
        None => ModelCache::default(),
    }
}

/// Says in the log how the folder was used.
pub fn log_use(cache: &ModelCache) {
    let used = cache.used();
    if used.hits + used.misses > 0 {
        tracing::info!(
            "models: {} from the cache, {} built, {:.3} s for reading and writing",
            used.hits,
            used.misses,
            used.seconds
        );
    }
}
