//! What a process does that gets no more memory: it says so, what a run holds open is closed, and
//! it ends with the exit code of a model that cannot be built. Requests are compared with what is
//! left first: a control group does not refuse, it kills.
#![expect(
    unsafe_code,
    reason = "an allocator can only be written so; it hands everything on to the system's"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
#[cfg(not(unix))]
use std::io::Write;
use std::process::ExitCode;
use std::ptr::null_mut;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};
use std::thread::Thread;
use std::time::Duration;

use ffr_dynamics::memory::{self, gigabytes};

/// Exit code when memory ends: that of a model that cannot be built.
pub const EXIT_CODE: u8 = 4;
/// What a thread may ask for before it looks again, as a part of what was left: so many threads may do so at once.
const PART: u64 = 64;
/// Requests that count \[bytes\].
const COUNTED: usize = 1 << 10;
/// What is not given away: the message and the libraries need it \[bytes\].
const KEPT: u64 = 1 << 22;
/// What is given back when memory ends, for the message and for closing files \[bytes\].
const RESERVE: usize = 1 << 22;
/// Time for closing what a run holds open.
const PATIENCE: Duration = Duration::from_secs(3);

static RESERVED: AtomicPtr<u8> = AtomicPtr::new(null_mut());
static IS_SHORT: AtomicBool = AtomicBool::new(false);
static CLOSER: OnceLock<Thread> = OnceLock::new();

thread_local! {
    static IS_TELLING: Cell<bool> = const { Cell::new(false) };
    /// Bytes after which this thread looks at what is left.
    static UNSEEN: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, which ends the process where that refuses.
pub struct EndingAllocator;

// SAFETY: all requests are the system's, which keeps the promises; what it refuses does not return.
unsafe impl GlobalAlloc for EndingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those that the system asks for.
        given(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        given(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        given(size.saturating_sub(layout.size()), || unsafe { System.realloc(pointer, layout, size) })
    }
}

/// The answer of `ask` to a request of so many more bytes.
fn given(bytes: usize, ask: impl FnOnce() -> *mut u8) -> *mut u8 {
    if bytes >= COUNTED {
        match UNSEEN.get().checked_sub(bytes) {
            Some(unseen) => UNSEEN.set(unseen),
            None => look(bytes),
        }
    }
    let pointer = ask();
    if pointer.is_null() {
        end(bytes);
    }
    pointer
}

/// Ends the process if less is left than `bytes`: a control group does not refuse, it kills.
fn look(bytes: usize) {
    // What looking itself asks for is not looked at.
    UNSEEN.set(usize::MAX);
    let Some(free) = memory::free() else { return };
    if bytes as u64 > free.saturating_sub(KEPT) && !IS_TELLING.get() && !has_ended() {
        end(bytes);
    }
    UNSEEN.set(usize::try_from(free / PART).unwrap_or(usize::MAX));
}

/// Sets memory aside for the end; comes first.
pub fn prepare() {
    if let Ok(layout) = Layout::from_size_align(RESERVE, 16) {
        // SAFETY: the size is not zero.
        RESERVED.store(unsafe { System.alloc(layout) }, Ordering::SeqCst);
    }
    #[cfg(unix)]
    {
        end_aborts();
        end_panics();
        answer_long_files();
    }
}

/// Has writes beyond `ulimit -f` refused as those to a full disk are, in place of a signal that ends the process.
#[cfg(unix)]
fn answer_long_files() {
    use nix::sys::signal::{SigHandler, Signal, signal};
    // SAFETY: to ignore a signal runs nothing.
    let _ = unsafe { signal(Signal::SIGXFSZ, SigHandler::SigIgn) };
}

/// Does `work` on a stack that suffices, where `ulimit -s` leaves the first thread less.
pub fn on_enough_stack(work: fn() -> ExitCode) -> ExitCode {
    #[cfg(unix)]
    if has_small_stack() {
        return on_own_stack(work);
    }
    work()
}

/// Stack of the program: what systems usually give \[bytes\].
#[cfg(unix)]
const STACK: usize = 1 << 23;

#[cfg(unix)]
fn has_small_stack() -> bool {
    use nix::libc::{RLIMIT_STACK, getrlimit, rlimit};
    let mut limit = rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: it writes the limit and nothing else.
    unsafe { getrlimit(RLIMIT_STACK, &raw mut limit) == 0 && limit.rlim_cur < STACK as u64 }
}

#[cfg(unix)]
fn on_own_stack(work: fn() -> ExitCode) -> ExitCode {
    use nix::sys::signal::SigSet;
    // Signals are for the thread that works, and for those that it starts.
    let usual = SigSet::thread_get_mask();
    let _ = SigSet::all().thread_block();
    let thread = std::thread::Builder::new().name("program".into()).stack_size(STACK);
    let working = thread.spawn(move || {
        let _ = usual.map(|mask| mask.thread_set_mask());
        work()
    });
    match working {
        Ok(working) => working.join().unwrap_or(ExitCode::from(101)),
        Err(_) => end_without_room(),
    }
}

/// Room that the system's allocator asks for to give a few bytes: if that is not there, memory has
/// ended \[bytes\].
#[cfg(unix)]
const ROOM: usize = 1 << 21;

/// Ends a process that a library aborts because it got no memory, as the C library does where a
/// thread begins, like one whose own request is refused.
#[cfg(unix)]
fn end_aborts() {
    use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, sigaction};
    let action = SigAction::new(SigHandler::Handler(on_abort), SaFlags::empty(), SigSet::empty());
    // SAFETY: the handler calls what may be called in one. Without it the process is aborted as
    // ever.
    let _ = unsafe { sigaction(Signal::SIGABRT, &action) };
}

/// The same where the standard library panics, as it does where a thread begins and its stack for
/// signals finds no room.
#[cfg(unix)]
fn end_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let (payload, owned) = (panic.payload(), panic.payload().downcast_ref::<String>());
        let text = payload.downcast_ref::<&str>().copied().or(owned.map(String::as_str));
        if is_of_memory(text) || has_no_room() {
            end_without_room();
        }
        usual(panic);
    }));
}

/// Whether the standard library panics with this text for want of memory only: what was missing may
/// be there again when one looks.
#[cfg(unix)]
fn is_of_memory(text: Option<&str>) -> bool {
    const BEGINNINGS: [&str; 2] =
        ["failed to allocate an alternative stack", "failed to set up alternative stack guard page"];
    text.is_some_and(|text| BEGINNINGS.iter().any(|beginning| text.starts_with(beginning)))
}

/// Looks whether memory has ended; if not, the process is aborted after this.
#[cfg(unix)]
extern "C" fn on_abort(_: i32) {
    if has_no_room() {
        end_without_room();
    }
}

/// Whether the system gives no more addresses, or has given none to another thread, which then gave
/// back what was set aside.
#[cfg(unix)]
fn has_no_room() -> bool {
    use nix::libc::{MAP_ANONYMOUS, MAP_FAILED, MAP_PRIVATE, PROT_NONE, mmap, munmap};
    // SAFETY: an anonymous mapping that nobody uses, and its end.
    let has_room = unsafe {
        let room = mmap(null_mut(), ROOM, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        room != MAP_FAILED && munmap(room, ROOM) == 0
    };
    !has_room || has_ended()
}

/// Tells that memory has ended, and ends the process.
#[cfg(unix)]
fn end_without_room() -> ! {
    if IS_SHORT.swap(true, Ordering::SeqCst) {
        // Another thread is at it.
        std::thread::sleep(2 * PATIENCE);
    } else {
        tell("error: memory ends; let the process have more, or use fewer elements\n");
        if let Some(closer) = CLOSER.get() {
            closer.unpark();
            std::thread::sleep(PATIENCE);
        }
    }
    leave()
}

/// Has `closer` woken when memory has ended.
pub fn on_end(closer: Thread) {
    // The first one stays, as in tests that run twice.
    let _ = CLOSER.set(closer);
}

/// Whether memory has ended.
pub fn has_ended() -> bool {
    IS_SHORT.load(Ordering::SeqCst)
}

/// Tells that a request of `bytes` is refused, and ends the process.
fn end(bytes: usize) -> ! {
    if IS_TELLING.replace(true) {
        // Not even the message has found room.
        tell("error: memory ends; let the process have more, or use fewer elements\n");
        leave();
    }
    if IS_SHORT.swap(true, Ordering::SeqCst) {
        // Another thread is at it.
        std::thread::sleep(2 * PATIENCE);
        leave();
    }
    let reserved = RESERVED.swap(null_mut(), Ordering::SeqCst);
    if let (false, Ok(layout)) = (reserved.is_null(), Layout::from_size_align(RESERVE, 16)) {
        // SAFETY: it was made with this layout, and is given back once.
        unsafe { System.dealloc(reserved, layout) }
    }
    tell(&message(bytes));
    if let Some(closer) = CLOSER.get() {
        closer.unpark();
        std::thread::sleep(PATIENCE);
    }
    leave()
}

fn message(bytes: usize) -> String {
    let told = |bytes: Option<u64>| bytes.map_or("?".to_owned(), |bytes| gigabytes(1e-9 * bytes as f64));
    format!(
        "error: memory ends: {} GB more are needed, of the {} GB that the process may take {} GB are free (machine, control group, ulimit, --memory); let it have more, or use fewer elements, in contact zones a smaller interval.elements\n",
        told(Some(bytes as u64)),
        told(memory::most()),
        told(memory::free())
    )
}

/// Writes to standard error, past its lock: this thread may hold it.
fn tell(text: &str) {
    #[cfg(unix)]
    let _ = nix::unistd::write(std::io::stderr(), text.as_bytes());
    #[cfg(not(unix))]
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// Ends the process as it is: no lock may be waited for.
fn leave() -> ! {
    #[cfg(unix)]
    // SAFETY: it returns to nobody.
    unsafe {
        nix::libc::_exit(i32::from(EXIT_CODE))
    }
    #[cfg(not(unix))]
    std::process::exit(i32::from(EXIT_CODE))
}
