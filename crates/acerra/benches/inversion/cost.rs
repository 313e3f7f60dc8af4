//! Time and memory of a piece of work, as the system tells them.

use std::fs::read_to_string;

use acerra_chain::journal::stages::Stages;

/// What a piece of work took.
#[derive(Clone, Copy)]
pub struct Cost {
    /// Elapsed time.
    pub seconds: f64,
    /// User and system time of all threads.
    pub processor_s: f64,
    /// Most memory that the process held, above what it held before.
    pub memory_bytes: f64,
}

/// Does `work` and tells its cost; zeros where the system does not tell.
pub fn measured<T, E>(work: impl FnOnce() -> Result<T, E>) -> Result<(T, Cost), E> {
    let mut stages = Stages::default();
    let (held_bytes, used_s) = (resident_bytes(), processor_s());
    let done = stages.run("focus", work)?;
    let stage = &stages.done()[0];
    let peak_bytes = stage.peak_memory_bytes.unwrap_or(0) as f64;
    let cost = Cost {
        seconds: stage.seconds,
        processor_s: processor_s() - used_s,
        memory_bytes: (peak_bytes - held_bytes).max(0.0),
    };
    Ok((done, cost))
}

fn resident_bytes() -> f64 {
    let status = read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kibibytes.unwrap_or(0.0) * 1024.0
}

/// Clock ticks a second in which Linux tells processor time.
const TICKS_HZ: f64 = 100.0;

fn processor_s() -> f64 {
    let stat = read_to_string("/proc/self/stat").unwrap_or_default();
    // User and system time are the 12th and 13th value behind the name in brackets.
    let values = stat.rsplit(')').next().unwrap_or_default();
    let ticks = values.split_whitespace().skip(11).take(2);
    ticks.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() / TICKS_HZ
}
