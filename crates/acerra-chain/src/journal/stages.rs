//! Cost of each stage of a run: seconds, and the most memory the process held.

use std::fmt;
use std::time::Instant;

use serde::Serialize;

/// One stage, as `run.json` records it.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// One of `read`, `position`, `align`, `clean`, `focus`, `measure`, `deliver`.
    pub name: &'static str,
    /// Wall-clock time.
    pub seconds: f64,
    /// Most memory that the process held during the stage, where the system reports it.
    pub peak_memory_bytes: Option<u64>,
}

/// Events of a stage, for a listener.
#[derive(Clone, Copy, Debug)]
pub enum StageEvent<'a> {
    /// A stage of this name begins.
    Started(&'static str),
    /// The stage is over.
    Finished(&'a Stage),
}

/// Hears of the stages.
type Listener = Box<dyn Fn(StageEvent<'_>) + Send + Sync>;

/// Times stages one after another.
#[derive(Default)]
pub struct Stages {
    done: Vec<Stage>,
    listener: Option<Listener>,
}

impl fmt::Debug for Stages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stages")
            .field("done", &self.done)
            .finish_non_exhaustive()
    }
}

impl Stages {
    /// Runs one stage inside a `tracing` span and records it, whether it succeeds or not. A stage that is
    /// entered again is recorded once, with the sum of its seconds and the larger peak.
    ///
    /// # Errors
    /// Errors of the stage itself.
    pub fn run<T, E>(
        &mut self,
        name: &'static str,
        stage: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let _span = tracing::info_span!("stage", name).entered();
        self.notify(StageEvent::Started(name));
        memory::start_peak();
        let start = Instant::now();
        let outcome = stage();
        let stage = Stage {
            name,
            seconds: start.elapsed().as_secs_f64(),
            peak_memory_bytes: memory::peak_bytes(),
        };
        self.notify(StageEvent::Finished(&stage));
        self.record(stage);
        outcome
    }

    /// Calls `listener` for every stage from now on.
    pub fn listen(&mut self, listener: impl Fn(StageEvent<'_>) + Send + Sync + 'static) {
        self.listener = Some(Box::new(listener));
    }

    fn notify(&self, event: StageEvent<'_>) {
        if let Some(listener) = &self.listener {
            listener(event);
        }
    }

    fn record(&mut self, stage: Stage) {
        match self.done.iter_mut().find(|done| done.name == stage.name) {
            Some(done) => {
                done.seconds += stage.seconds;
                done.peak_memory_bytes = done.peak_memory_bytes.max(stage.peak_memory_bytes);
            }
            None => self.done.push(stage),
        }
    }

    /// The stages so far.
    #[must_use]
    pub fn done(&self) -> &[Stage] {
        &self.done
    }
}

#[cfg(target_os = "linux")]
mod memory {
    /// Starts a new peak; kernels that do not allow it keep the peak of the whole process.
    pub fn start_peak() {
        let _ = std::fs::write("/proc/self/clear_refs", "5");
    }

    pub fn peak_bytes() -> Option<u64> {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = status
            .lines()
            .find_map(|line| line.strip_prefix("VmHWM:"))?;
        let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
        Some(kibibytes * 1024)
    }
}

#[cfg(not(target_os = "linux"))]
mod memory {
    pub fn start_peak() {}

    pub fn peak_bytes() -> Option<u64> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_held_by_a_stage_is_seen() {
        let mut stages = Stages::default();
        let outcome: Result<usize, ()> = stages.run("read", || {
            let held = vec![1_u8; 64 << 20];
            Ok(held.iter().map(|b| usize::from(*b)).sum())
        });
        assert_eq!(outcome, Ok(64 << 20));
        assert_eq!(stages.done()[0].name, "read");
        assert!(stages.done()[0].peak_memory_bytes.unwrap() >= 64 << 20);
    }
}
