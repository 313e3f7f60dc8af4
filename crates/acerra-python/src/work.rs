//! Long work: without the interpreter's lock, with progress, stopped by Ctrl-C.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use acerra_chain::{Control, Progress};
use pyo3::prelude::*;

use crate::errors::Failure;

/// Interval of checks for Ctrl-C and of progress reports.
const POLL: Duration = Duration::from_millis(50);

/// Progress of the current step, from the working threads to the interpreter's.
#[derive(Default)]
struct Seen {
    step: Mutex<(String, u64)>,
    done: AtomicU64,
}

impl Progress for Seen {
    fn start(&self, name: &str, total: u64) {
        if let Ok(mut step) = self.step.lock() {
            *step = (name.to_owned(), total);
        }
        self.done.store(0, Ordering::Relaxed);
    }

    fn at(&self, done: u64) {
        self.done.fetch_max(done, Ordering::Relaxed);
    }

    fn finish(&self) {
        if let Ok(step) = self.step.lock() {
            self.done.store(step.1, Ordering::Relaxed);
        }
    }
}

impl Seen {
    /// Calls `progress(step, done, total)`, once a step has begun.
    fn report(&self, py: Python<'_>, progress: &Py<PyAny>) -> PyResult<()> {
        let Ok(step) = self.step.lock().map(|step| step.clone()) else {
            return Ok(());
        };
        if step.0.is_empty() {
            return Ok(());
        }
        let done = self.done.load(Ordering::Relaxed).min(step.1);
        progress.call1(py, (step.0, done, step.1)).map(drop)
    }
}

/// Runs `work` on a separate thread while the caller's checks for signals and calls `progress`. An exception
/// of either cancels the work and is raised.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Control<'_>) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let (cancel, seen) = (AtomicBool::new(false), Seen::default());
    let outcome = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, finished) = channel();
            let (cancel, seen) = (&cancel, &seen);
            let worker = scope.spawn(move || {
                let control = Control::default().cancelled_by(cancel).reporting_to(seen);
                let outcome = work(&control);
                // The receiver outlives this thread.
                let _ = done.send(());
                outcome
            });
            let mut interrupted = None;
            while finished.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
                if interrupted.is_none() {
                    let polled = Python::attach(|py| {
                        py.check_signals()?;
                        progress.map_or(Ok(()), |progress| seen.report(py, progress))
                    });
                    if let Err(error) = polled {
                        cancel.store(true, Ordering::Relaxed);
                        interrupted = Some(error);
                    }
                }
            }
            match (interrupted, worker.join()) {
                (Some(error), _) => Err(Failure::Raised(error)),
                (None, Ok(outcome)) => outcome,
                (None, Err(panic)) => std::panic::resume_unwind(panic),
            }
        })
    })?;
    if let Some(progress) = progress {
        seen.report(py, progress)?;
    }
    Ok(outcome)
}
