//! Threads that share the work.

use crate::options::PpkOptions;

/// Threads to use, at least one.
pub(crate) fn threads(options: &PpkOptions) -> usize {
    match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => n,
    }
}

/// The worker's result; a panic in it continues here.
pub(crate) fn join<T>(worker: std::thread::ScopedJoinHandle<'_, T>) -> T {
    worker
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}
