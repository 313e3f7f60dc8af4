//! The pulse per second of an emulated receiver, as the text of a kernel's PPS device.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use acerra_geo::time::GpsTime;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::world::World;
use crate::pps::PulseStamp;

/// Longest sleep: a radio that starts, or a stop, is not waited for longer.
const LONGEST_SLEEP: Duration = Duration::from_millis(20);
/// Delay of the pulse of a receiver without a fix after its second (s): the receiver counts its own seconds.
const UNLOCKED_S: f64 = 0.3;

/// Behaviour of an emulated pulse.
#[derive(Debug, Clone)]
pub struct PpsOptions {
    /// The time it lives in.
    pub world: World,
    /// GPS time at the world's beginning.
    pub starts_at: GpsTime,
    /// Time from the second to the edge that is stamped (s): the pulse's width where that is its other edge.
    pub edge_s: f64,
    /// Share of the pulses that are missed.
    pub loss: f64,
    /// World times from and to which the receiver has no fix (s): its pulses are then at another phase.
    pub no_fix_s: Vec<[f64; 2]>,
    /// Seed of everything random.
    pub seed: u64,
}

impl PpsOptions {
    /// Pulses at each second, none missed.
    #[must_use]
    pub fn new(world: World, starts_at: GpsTime) -> Self {
        Self {
            world,
            starts_at,
            edge_s: 0.0,
            loss: 0.0,
            no_fix_s: Vec::new(),
            seed: 1,
        }
    }
}

/// A PPS device emulated by a separate thread, until it is dropped: a file that is replaced at each pulse.
pub struct EmulatedPps {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl EmulatedPps {
    /// Emulates a device whose pulses are written to `file`, which is created or replaced.
    ///
    /// # Errors
    /// If the file cannot be written, or the system gives no thread.
    pub fn start(file: &Path, options: PpsOptions) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let device = Device {
            file: file.to_owned(),
            random: ChaCha8Rng::seed_from_u64(options.seed),
            options,
            sequence: 0,
            stop: Arc::clone(&stop),
        };
        device.show(Duration::ZERO)?;
        let thread = std::thread::Builder::new()
            .name("emulated pps".to_owned())
            .spawn(move || device.run())?;
        Ok(Self {
            stop,
            thread: Some(thread),
        })
    }
}

impl Drop for EmulatedPps {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has printed its message.
            let _ = thread.join();
        }
    }
}

struct Device {
    file: PathBuf,
    options: PpsOptions,
    random: ChaCha8Rng,
    /// Pulses so far.
    sequence: u32,
    stop: Arc<AtomicBool>,
}

impl Device {
    fn run(mut self) {
        // The first whole second of the world.
        let fraction_s = self.options.starts_at.fraction();
        let mut second_s = if fraction_s > 0.0 {
            1.0 - fraction_s
        } else {
            0.0
        };
        while !self.stop.load(Ordering::SeqCst) {
            let edge_s = self.edge_s(second_s);
            let Some(edge) = self.options.world.instant(edge_s) else {
                std::thread::sleep(LONGEST_SLEEP);
                continue;
            };
            let left = edge.saturating_duration_since(Instant::now());
            if !left.is_zero() {
                std::thread::sleep(left.min(LONGEST_SLEEP));
                continue;
            }
            second_s += 1.0;
            if self.random.random_bool(self.options.loss.clamp(0.0, 1.0)) {
                continue;
            }
            self.sequence = self.sequence.wrapping_add(1);
            // Stamp of the edge by an interrupt.
            let since = edge.elapsed();
            let now = SystemTime::now().duration_since(UNIX_EPOCH);
            let stamp = now.unwrap_or_default().saturating_sub(since);
            // A disk that is full misses pulses.
            let _ = self.show(stamp);
        }
    }

    /// World time of the edge of a second's pulse (s).
    fn edge_s(&self, second_s: f64) -> f64 {
        let mut no_fix_s = self.options.no_fix_s.iter();
        let is_unlocked = no_fix_s.any(|[from, to]| (*from..*to).contains(&second_s));
        let unlocked_s = if is_unlocked { UNLOCKED_S } else { 0.0 };
        second_s + self.options.edge_s + unlocked_s
    }

    /// Replaces the file, so that a reader finds one pulse or the next, whole.
    fn show(&self, unix: Duration) -> io::Result<()> {
        let stamp = PulseStamp {
            unix,
            sequence: self.sequence,
        };
        let mut aside = self.file.clone().into_os_string();
        aside.push(".part");
        std::fs::write(&aside, format!("{stamp}\n"))?;
        std::fs::rename(&aside, &self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten times as fast: a pulse each 100 ms, at the seconds of a world that begins within one.
    #[test]
    fn pulses_come_at_the_worlds_seconds() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("assert");
        let world = World::new(10.0);
        let options = PpsOptions {
            no_fix_s: vec![[3.0, 5.0]],
            ..PpsOptions::new(world.clone(), GpsTime::from_week_tow(2345, 1000.4))
        };
        let _pps = EmulatedPps::start(&file, options).unwrap();
        let read = || PulseStamp::parse(&std::fs::read(&file).unwrap()).unwrap();
        assert_eq!(read().sequence, 0);
        world.begin();
        let since = world.instant(0.0).unwrap().elapsed();
        let began = SystemTime::now().duration_since(UNIX_EPOCH).unwrap() - since;
        let mut worst_s = 0.0_f64;
        let mut seen = 0;
        while seen < 8 {
            let stamp = read();
            if stamp.sequence > seen {
                seen = stamp.sequence;
                let world_s = 10.0 * (stamp.unix.as_secs_f64() - began.as_secs_f64());
                let late_s = if matches!(seen, 4 | 5) {
                    UNLOCKED_S
                } else {
                    0.0
                };
                let expected_s = f64::from(seen) - 0.4 + late_s;
                worst_s = worst_s.max((world_s - expected_s).abs());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        // The world's beginning is known to this test within a scheduling delay.
        assert!(worst_s < 0.1, "{worst_s}");
    }
}
