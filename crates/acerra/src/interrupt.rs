//! Ending in order on SIGINT, SIGTERM and SIGHUP.
//!
//! The process prints the signal's name, removes its staging files, and exits with 128 plus the number of the
//! signal, as shells do: 130, 143 and 129. Products of older runs are unchanged; a publication that has begun
//! is completed first. Signals that the process was started to ignore, as under `nohup`, stay ignored.

use std::io;
#[cfg(unix)]
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);
/// Whether the first signal only asks to stop.
static STOPS_IN_ORDER: AtomicBool = AtomicBool::new(false);
static STOP: AtomicBool = AtomicBool::new(false);

/// Set once the process is asked to end: for libraries that poll such a flag.
#[must_use]
pub fn cancel_flag() -> &'static AtomicBool {
    &REQUESTED
}

/// From now on the first signal sets the returned flag, so that the process ends by itself; the second signal
/// ends the process at once. For commands that run until they are stopped.
pub fn stop_in_order() -> &'static AtomicBool {
    STOPS_IN_ORDER.store(true, Ordering::SeqCst);
    &STOP
}

/// The flag, cleared until the next signal: for commands that have ended their work in order and continue to
/// show the result.
pub fn wait_again() -> &'static AtomicBool {
    STOP.store(false, Ordering::SeqCst);
    stop_in_order()
}

/// Ends the process on the first of the signals from now on. On systems other than Unix the default behaviour
/// is unchanged.
///
/// # Errors
/// The system refuses handlers or threads.
pub fn end_on_signals() -> io::Result<()> {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
        let ignored = ignored_signals();
        let heard = [SIGINT, SIGTERM, SIGHUP]
            .into_iter()
            .filter(|signal| ignored & (1 << (signal - 1)) == 0);
        // A write beyond the limit of a file's size returns an error once its signal is ignored.
        signal_hook::flag::register(SIGXFSZ, Arc::default())?;
        let mut signals = signal_hook::iterator::Signals::new(heard)?;
        std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(move || {
                for signal in signals.forever() {
                    if !STOPS_IN_ORDER.load(Ordering::SeqCst) || STOP.swap(true, Ordering::SeqCst) {
                        end(signal);
                    }
                }
            })?;
    }
    Ok(())
}

/// Blocks where the process was asked to end: later failures need no message.
pub fn wait_if_ending() {
    while REQUESTED.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

/// The signals that the process ignores, one bit each from signal 1 on; none where the system does
/// not state.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(unix)]
fn end(signal: i32) -> ! {
    use std::io::{IsTerminal, Write};
    REQUESTED.store(true, Ordering::SeqCst);
    acerra_products::staging::discard_unfinished();
    let name = signal_hook::low_level::signal_name(signal).unwrap_or("a signal");
    // On a terminal a line of progress may be before it.
    let lead = if io::stderr().is_terminal() { "\n" } else { "" };
    // If stderr is closed, as after a hang-up, nothing can be reported.
    let _ = writeln!(
        io::stderr(),
        "{lead}acerra: interrupted by {name}; unfinished products were removed"
    );
    std::process::exit(128 + signal)
}
