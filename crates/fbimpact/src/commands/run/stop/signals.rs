//! Signals that stop a run: those of a terminal and of its end, of the system, and those that batch
//! systems send before the time is over.

/// What a signal asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// To end; asked twice, at once.
    Now,
    /// To end, however often it is asked: SIGXCPU comes every second.
    Soon,
}

/// Calls `handler` for each signal, in a thread of its own. Comes before any other thread is
/// started: one that had been there before would be ended by signals.
///
/// # Errors
/// Why signals will end the process without closing files.
pub fn listen(handler: impl FnMut(Request) + Send + 'static) -> Result<(), String> {
    system::listen(handler)
}

#[cfg(unix)]
mod system {
    use nix::sys::signal::{SigSet, Signal};

    use super::Request;

    const NOW: [Signal; 3] = [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP];
    const SOON: [Signal; 3] = [Signal::SIGUSR1, Signal::SIGUSR2, Signal::SIGXCPU];
    /// Obeyed even if the process was started with it ignored, as shells start what runs in the
    /// background.
    const ALWAYS: [Signal; 2] = [Signal::SIGINT, Signal::SIGTERM];

    pub fn listen(mut handler: impl FnMut(Request) + Send + 'static) -> Result<(), String> {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let ignored = ignored(&status);
        let is_ignored = |signal: Signal| ignored >> (signal as i32 - 1) & 1 == 1;
        let all = NOW.into_iter().chain(SOON);
        let set: SigSet = all.filter(|signal| ALWAYS.contains(signal) || !is_ignored(*signal)).collect();
        set.thread_block().map_err(|e| e.to_string())?;
        let thread = std::thread::Builder::new().name("signals".into());
        let waiting = thread.spawn(move || {
            while let Ok(signal) = set.wait() {
                handler(if NOW.contains(&signal) { Request::Now } else { Request::Soon });
            }
        });
        if waiting.is_err() {
            // As if nobody had listened.
            let _ = set.thread_unblock();
        }
        waiting.map(drop).map_err(|e| e.to_string())
    }

    /// Bits of the signals that the process was told to ignore, as `nohup` does.
    fn ignored(status: &str) -> u64 {
        let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        line.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(0)
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn ignored_signals_are_read_by_their_bits() {
            let hangup = ignored("Name:\tx\nSigIgn:\t0000000000001001\nSigCgt:\t0\n");
            assert_eq!(hangup, 1 << (Signal::SIGHUP as i32 - 1) | 1 << (Signal::SIGPIPE as i32 - 1));
            assert_eq!(ignored(""), 0);
        }
    }
}

#[cfg(not(unix))]
mod system {
    use super::Request;

    pub fn listen(mut handler: impl FnMut(Request) + Send + 'static) -> Result<(), String> {
        ctrlc::set_handler(move || handler(Request::Now)).map_err(|e| e.to_string())
    }
}
