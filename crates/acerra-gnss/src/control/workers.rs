//! Threads that share the work.

use crate::options::PpkOptions;
use std::sync::{Condvar, Mutex, PoisonError};

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

/// The results of `work` on each item, in order, by the given number of threads.
pub(crate) fn each<T: Send, R: Send>(
    threads: usize,
    items: Vec<T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    if threads <= 1 || items.len() <= 1 {
        return items.into_iter().map(work).collect();
    }
    let workers = threads.min(items.len());
    let waiting = Mutex::new(items.into_iter().enumerate());
    let next = || {
        let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.next()
    };
    let share = || {
        let taken = std::iter::from_fn(next);
        taken
            .map(|(place, item)| (place, work(item)))
            .collect::<Vec<_>>()
    };
    let mut found: Vec<(usize, R)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..workers).map(|_| scope.spawn(share)).collect();
        let own = share();
        own.into_iter()
            .chain(others.into_iter().flat_map(join))
            .collect()
    });
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, result)| result).collect()
}

/// Permits to work, for fewer threads at once than there are.
pub(crate) struct Permits {
    free: Mutex<usize>,
    returned: Condvar,
}

impl Permits {
    /// Permits for the given number of threads.
    pub(crate) fn new(threads: usize) -> Self {
        Self {
            free: Mutex::new(threads.max(1)),
            returned: Condvar::new(),
        }
    }

    /// Waits for a free permit. The holder must not wait for another permit.
    pub(crate) fn take(&self) -> Permit<'_> {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.returned.wait_while(free, |free| *free == 0);
        *waited.unwrap_or_else(PoisonError::into_inner) -= 1;
        Permit { of: self }
    }
}

/// A permit, returned when dropped.
pub(crate) struct Permit<'a> {
    of: &'a Permits,
}

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        let free = self.of.free.lock();
        *free.unwrap_or_else(PoisonError::into_inner) += 1;
        self.of.returned.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        for threads in [1, 2, 7] {
            let squares = each(threads, (0..20).collect(), |k: usize| k * k);
            assert_eq!(squares, (0..20).map(|k| k * k).collect::<Vec<_>>());
        }
    }

    #[test]
    fn no_more_threads_work_than_have_permits() {
        let (permits, working) = (Permits::new(2), AtomicUsize::new(0));
        let seen = each(6, (0..60).collect(), |_: usize| {
            let _permit = permits.take();
            let now = working.fetch_add(1, Ordering::SeqCst) + 1;
            std::thread::yield_now();
            working.fetch_sub(1, Ordering::SeqCst);
            now
        });
        assert!(seen.into_iter().all(|now| now <= 2));
    }
}
