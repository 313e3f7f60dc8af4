//! A track as input of the chain: radar data, positions, and the options that combine them.

use acerra_geo::trajectory::Frame;
use acerra_radar::LoggedClock;

use crate::align::AlignOptions;
use crate::clean::CleanOptions;
use crate::position::{LogSources, Positions};
use crate::read::{RadarContent, RadarData};

/// A flight in memory.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Name in reports and messages.
    pub name: String,
    /// Data of the radar.
    pub radar: RadarData,
    /// Positions of the radar.
    pub positions: Positions,
    /// Whether a file gives the positions in a local frame whose axes nothing confirms.
    pub has_local_axes: bool,
    /// Sources of the positions in an autopilot's log.
    pub log_sources: LogSources,
    /// Step of the last digit in which a file gives the positions, east, north and up (m).
    pub resolution_m: Option<[f64; 3]>,
    /// Options for combining radar data and positions.
    pub options: TrackOptions,
}

impl Recording {
    /// A flight from arrays in memory, with the default options.
    #[must_use]
    pub fn new(
        name: impl Into<String>,
        radar: impl Into<RadarContent>,
        positions: impl Into<Positions>,
    ) -> Self {
        let positions = positions.into();
        Self {
            name: name.into(),
            radar: RadarData::in_memory(radar.into()),
            has_local_axes: *positions.frame() == Frame::Local,
            log_sources: LogSources::default(),
            resolution_m: None,
            positions,
            options: TrackOptions::default(),
        }
    }

    /// This recording with other options of the stage `clean`.
    #[must_use]
    pub fn clean_by(mut self, options: CleanOptions) -> Self {
        self.options.clean = options;
        self
    }

    /// This recording with other options of the stage `align`.
    #[must_use]
    pub fn align_by(mut self, options: AlignOptions) -> Self {
        self.options.align = options;
        self
    }
}

/// Parameters of the stages `align` and `clean` for one track, and its instrument's errors.
#[derive(Clone, Debug, Default)]
pub struct TrackOptions {
    /// Clock offset and selection.
    pub align: AlignOptions,
    /// Options of the cleaning.
    pub clean: CleanOptions,
    /// Delay and phase to remove.
    pub known_error: InstrumentError,
    /// The recorded clock that gives the offset, if any.
    pub recorded_clock: Option<LoggedClock>,
}

/// Delay and phase of a track's instrument relative to the other tracks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InstrumentError {
    /// Delay (ns).
    pub delay_ns: f64,
    /// Phase (degrees).
    pub phase_deg: f64,
}
