//! Options of an emulated radio, and counts of its messages.

use super::channel::{ChannelCounts, Impairments};
use super::pulse_line::PulseLine;
use super::world::World;

/// How an emulated radio behaves.
#[derive(Debug, Clone)]
pub struct EmulatorOptions {
    /// Radio seconds in a second: 1 is real time. In a world, seconds of the radio's clock.
    pub speed: f64,
    /// Drift of the radio's clock, parts in a million, positive when fast. In a world the stamps drift; without
    /// a world the pace drifts, and a recording's bytes are unchanged.
    pub drift_ppm: f64,
    /// The world that the recording is of, and the world time of its first scan (s).
    pub world: Option<(World, f64)>,
    /// The link.
    pub impairments: Impairments,
    /// Where its pulses go, one a scan, in a world.
    pub pulses: Option<PulseLine>,
    /// Seconds of radio time, from the start of the emulator, at which the radio restarts by itself.
    pub reboot_at_s: Vec<f64>,
    /// Duration of a restart, in seconds of radio time.
    pub reboot_takes_s: f64,
}

impl Default for EmulatorOptions {
    fn default() -> Self {
        Self {
            speed: 1.0,
            drift_ppm: 0.0,
            world: None,
            impairments: Impairments::default(),
            pulses: None,
            reboot_at_s: Vec::new(),
            reboot_takes_s: 3.0,
        }
    }
}

/// Counts of an emulated radio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EmulatorCounts {
    /// Scans made.
    pub scans: u64,
    /// Scans of which no message was lost at the sender; a restart may still lose messages in transit.
    pub scans_sent_whole: u64,
    /// Messages of every kind, and faults of the link.
    pub channel: ChannelCounts,
    /// Datagrams handed to the system.
    pub datagrams: u64,
    /// Restarts.
    pub reboots: u64,
    /// Whether the source has no more scans.
    pub exhausted: bool,
}
