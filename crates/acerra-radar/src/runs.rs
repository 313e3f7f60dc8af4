//! From a log's scans to a radargram: one filtering, one window, one clock.

use thiserror::Error;

use crate::clock::{ClockBasis, RadioClock, recover_clock};
use crate::log::RadarLog;
use crate::mrm::RadarConfig;
use crate::radargram::{Radargram, RadargramError, Samples};
use crate::scan::{Filtering, Scan, ScanWindow};

/// Scans that belong together: same radio, filtering, antenna, window and configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Filtering by the radio.
    pub filtering: Filtering,
    /// The fast-time window.
    pub window: ScanWindow,
    /// Antenna the scans were received on.
    pub antenna_id: u8,
    /// The radio's configuration, where the log states it.
    pub config: Option<RadarConfig>,
    /// Indices of the scans in [`RadarLog::scans`], in time order.
    pub scans: Vec<usize>,
    /// Scans later in the log than their time stamps, which were sorted.
    pub reordered: usize,
}

/// Run of a log that becomes the radargram.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RunChoice {
    /// The run with most scans (the first of equals).
    #[default]
    Longest,
    /// The first.
    First,
    /// By number, from 0.
    Number(usize),
}

/// Selection of the scans that become a radargram. By default raw scans are preferred to band-passed ones and
/// these to motion-filtered ones, and the longest run is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct RadargramOptions {
    /// Requested filtering; `None` prefers raw.
    pub filtering: Option<Filtering>,
    /// Requested run among those of that filtering.
    pub run: RunChoice,
}

impl RadargramOptions {
    /// This selection with the requested filtering.
    #[must_use]
    pub const fn with_filtering(mut self, filtering: Filtering) -> Self {
        self.filtering = Some(filtering);
        self
    }

    /// This selection with the requested run.
    #[must_use]
    pub const fn with_run(mut self, run: RunChoice) -> Self {
        self.run = run;
        self
    }
}

/// A radargram from a log, and its source.
#[derive(Debug, Clone, PartialEq)]
pub struct LogRadargram {
    /// Traces over fast time; time zero is the first trace.
    pub radargram: Radargram,
    /// The run used.
    pub run: Run,
    /// Number of the run among those of the same filtering.
    pub run_number: usize,
    /// Number of runs of its filtering.
    pub runs: usize,
    /// Whole scans of the log outside the radargram (other filterings, other runs).
    pub other_scans: usize,
    /// Source of the trace times.
    pub clock: RadioClock,
    /// Host time of each trace, s, where the log holds it.
    pub host_time_s: Option<Vec<f64>>,
}

/// Reason why no radargram could be made.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunError {
    /// No scan of the requested filtering.
    #[error("no {wanted} scan in the log; it holds {present}")]
    NoSuchFiltering {
        /// Filtering wanted.
        wanted: Filtering,
        /// Filterings there are.
        present: String,
    },
    /// No run of that number.
    #[error("run {wanted} requested, but the log has {runs} ({filtering})")]
    NoSuchRun {
        /// Run wanted.
        wanted: usize,
        /// Runs there are.
        runs: usize,
        /// Filtering they are of.
        filtering: Filtering,
    },
    /// The scans form no radargram.
    #[error(transparent)]
    Radargram(#[from] RadargramError),
}

impl RadarLog {
    /// The configuration in force when scan `index` was made.
    #[must_use]
    pub fn config_at(&self, index: usize) -> Option<RadarConfig> {
        let later = self.configs.partition_point(|c| c.before_scan <= index);
        self.configs[..later].last().map(|c| c.config)
    }

    /// Filtering that [`RadarLog::radargram`] takes by default.
    #[must_use]
    pub fn preferred_filtering(&self) -> Option<Filtering> {
        self.scans.iter().map(|s| s.filtering).min()
    }

    /// Runs of one filtering, in the log's order. A run ends where the window, the antenna, the radio or its
    /// configuration changes, or where the radio's clock restarts.
    #[must_use]
    pub fn runs(&self, filtering: Filtering) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        let mut previous: Option<&Scan> = None;
        for (i, scan) in self
            .scans
            .iter()
            .enumerate()
            .filter(|(_, s)| s.filtering == filtering)
        {
            let config = self.config_at(i);
            let belongs = previous.zip(runs.last()).is_some_and(|(p, run)| {
                run.config == config
                    && p.window == scan.window
                    && p.antenna_id == scan.antenna_id
                    && p.source_id == scan.source_id
                    && !restarted(p.timestamp_ms, scan.timestamp_ms)
            });
            match runs.last_mut() {
                Some(run) if belongs => run.scans.push(i),
                _ => runs.push(Run {
                    filtering,
                    window: scan.window,
                    antenna_id: scan.antenna_id,
                    config,
                    scans: vec![i],
                    reordered: 0,
                }),
            }
            previous = Some(scan);
        }
        for run in &mut runs {
            self.put_in_order(run);
        }
        runs
    }

    /// Sorts a run's scans by time stamp, counting late ones.
    fn put_in_order(&self, run: &mut Run) {
        let Some(&first) = run.scans.first() else {
            return;
        };
        let zero = self.scans[first].timestamp_ms;
        // Relative to the first stamp, as a signed difference, so that a wrap does no harm.
        let mut turns = 0i64;
        let mut last = 0i64;
        let mut keyed: Vec<(i64, usize)> = run
            .scans
            .iter()
            .map(|&i| {
                let raw = i64::from(self.scans[i].timestamp_ms.wrapping_sub(zero));
                let mut at = raw + (turns << 32);
                if at < last - (1 << 31) {
                    turns += 1;
                    at += 1 << 32;
                } else if at > last + (1 << 31) {
                    at -= 1 << 32; // just before the first stamp, or before a wrap
                } else {
                    last = at;
                }
                (at, i)
            })
            .collect();
        run.reordered = keyed.windows(2).filter(|w| w[1].0 < w[0].0).count();
        if run.reordered > 0 {
            keyed.sort_by_key(|k| k.0);
            run.scans = keyed.into_iter().map(|k| k.1).collect();
        }
    }

    /// Makes a radargram of the log's scans.
    ///
    /// Samples become `f32`, which keeps integers below 2²⁴ exactly.
    ///
    /// # Errors
    /// If the log has no scan of the wanted filtering or no run of the wanted number.
    pub fn radargram(&self, options: &RadargramOptions) -> Result<LogRadargram, RunError> {
        let wanted = options
            .filtering
            .or_else(|| self.preferred_filtering())
            .unwrap_or(Filtering::Raw);
        let mut runs = self.runs(wanted);
        if runs.is_empty() {
            let mut kinds: Vec<Filtering> = self.scans.iter().map(|s| s.filtering).collect();
            kinds.sort();
            kinds.dedup();
            let kinds: Vec<String> = kinds.iter().map(ToString::to_string).collect();
            let present = if kinds.is_empty() {
                "none".to_owned()
            } else {
                kinds.join(", ") + " scans"
            };
            return Err(RunError::NoSuchFiltering { wanted, present });
        }
        let run_number = match options.run {
            RunChoice::First => 0,
            RunChoice::Number(n) => n,
            RunChoice::Longest => (0..runs.len())
                .rev()
                .max_by_key(|&i| runs[i].scans.len())
                .unwrap_or(0),
        };
        if run_number >= runs.len() {
            return Err(RunError::NoSuchRun {
                wanted: run_number,
                runs: runs.len(),
                filtering: wanted,
            });
        }
        let count = runs.len();
        let run = runs.swap_remove(run_number);
        let scans: Vec<&Scan> = run.scans.iter().map(|&i| &self.scans[i]).collect();
        let samples = scans
            .iter()
            .flat_map(|s| &s.samples)
            .map(|&x| x as f32)
            .collect();
        let host_time_s: Option<Vec<f64>> = scans.iter().map(|s| s.host_time_s).collect();
        let clock = scan_clock(&scans, host_time_s.as_deref());
        let radargram = Radargram::new(
            clock.time_s.clone(),
            run.window.start_s(),
            run.window.step_s(),
            Samples::Real(samples),
        )?;
        Ok(LogRadargram {
            radargram,
            run_number,
            runs: count,
            other_scans: self.scans.len() - run.scans.len(),
            run,
            clock,
            host_time_s,
        })
    }
}

/// Whether the radio's clock restarted between two stamps, rather than wrapped, or ran back a little because
/// packets overtook each other.
fn restarted(before_ms: u32, after_ms: u32) -> bool {
    let forward = after_ms.wrapping_sub(before_ms);
    forward > u32::MAX / 2 && before_ms.wrapping_sub(after_ms) > 1000
}

/// The radio's clock, or the next source where its stamps do not advance.
fn scan_clock(scans: &[&Scan], host_time_s: Option<&[f64]>) -> RadioClock {
    let ids: Vec<u16> = scans.iter().map(|s| s.message_id).collect();
    let stamps: Vec<u32> = scans.iter().map(|s| s.timestamp_ms).collect();
    let mut clock = recover_clock(&ids, &stamps);
    let still = stamps.len() > 1 && stamps.iter().all(|&t| t == stamps[0]);
    if still {
        (clock.basis, clock.time_s) = match host_time_s {
            Some(host) => (
                ClockBasis::HostClock,
                host.iter().map(|t| t - host[0]).collect(),
            ),
            None => (
                ClockBasis::TraceNumber,
                (0..scans.len()).map(|i| i as f64).collect(),
            ),
        };
        clock.interval_s = clock
            .time_s
            .last()
            .map_or(0.0, |t| t / (scans.len() - 1) as f64);
    }
    clock
}
