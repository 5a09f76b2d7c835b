//! Memory that a reader holds at once, counted by the allocator of the target: what the fuzzer itself needs does not matter then.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// How often the bytes of a file may be held.
const TIMES: usize = 10;
/// What a reader may hold of any file, however small: tables of elements, buffers, messages \[bytes\].
const TABLES: usize = 16 << 10;

struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn taken(n: usize) {
    MOST.fetch_max(HELD.fetch_add(n, Relaxed) + n, Relaxed);
}

fn given_back(n: usize) {
    HELD.fetch_sub(n, Relaxed);
}

// SAFETY: every call goes on to the allocator of the system as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Large blocks, which alone matter, are moved by their pages and never twice there.
        given_back(layout.size());
        taken(size);
        unsafe { System.realloc(place, layout, size) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        given_back(layout.size());
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `read` makes of `bytes`; panics if it holds more than ten times their number.
pub fn bounded<T>(bytes: &[u8], read: impl FnOnce(&[u8]) -> T) -> T {
    let before = HELD.load(Relaxed);
    MOST.store(before, Relaxed);
    let made = read(bytes);
    let most = MOST.load(Relaxed).saturating_sub(before);
    assert!(most <= TIMES * bytes.len() + TABLES, "{most} bytes held for {} bytes of a file", bytes.len());
    made
}
