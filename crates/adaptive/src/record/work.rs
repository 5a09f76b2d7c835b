//! What the process works at, for whoever shows how it gets on. It takes part in no result.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Texts of the work that is going on, with their numbers, in the order in which it began.
static NOW: Mutex<(u64, Vec<(u64, String)>)> = Mutex::new((0, Vec::new()));

/// Work that lasts until this is dropped.
#[derive(Debug)]
#[must_use = "work ends when this is dropped"]
pub struct Work(u64);

/// Begins work that `text` names: the body, its unknowns, how much is done.
pub fn begin(text: String) -> Work {
    let mut now = lock();
    now.0 += 1;
    let number = now.0;
    now.1.push((number, text));
    Work(number)
}

/// The work that is being done at present, the whole first, then its parts; none if nothing is.
pub fn now() -> Option<String> {
    let texts: Vec<String> = lock().1.iter().map(|(_, text)| text.clone()).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

impl Drop for Work {
    fn drop(&mut self) {
        lock().1.retain(|(number, _)| *number != self.0);
    }
}

fn lock() -> MutexGuard<'static, (u64, Vec<(u64, String)>)> {
    NOW.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_told_behind_the_whole_until_they_end() {
        // Other tests of this process work as well.
        let told = |text: &str| now().is_some_and(|now| now.contains(text));
        let whole = begin("body \"ring\" (2 of 3)".into());
        let part = begin("modes of 4711 unknowns".into());
        assert!(told("body \"ring\" (2 of 3)") && told("modes of 4711 unknowns"));
        drop(part);
        assert!(told("body \"ring\" (2 of 3)") && !told("4711"));
        drop(whole);
        assert!(!told("body \"ring\" (2 of 3)"));
    }
}
