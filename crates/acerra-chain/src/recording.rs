//! A track as it enters the chain: radar data, positions, and how they are brought together.

use crate::align::AlignOptions;
use crate::clean::CleanOptions;
use crate::position::Positions;
use crate::read::RadarData;

/// One flight, in memory.
#[derive(Clone, Debug)]
pub struct Recording {
    /// What it is called in reports and messages.
    pub name: String,
    /// What the radar measured.
    pub radar: RadarData,
    /// Where the radar was.
    pub positions: Positions,
    /// How the two are brought together.
    pub options: TrackOptions,
}

/// Parameters of the stages `align` and `clean` for one track, and its instrument's errors.
#[derive(Clone, Debug)]
pub struct TrackOptions {
    /// Clock offset and selection.
    pub align: AlignOptions,
    /// From raw traces to clean spectra.
    pub clean: CleanOptions,
    /// Delay and phase to take off.
    pub known_error: InstrumentError,
}

/// Delay and phase that a track's instrument adds beside the others'.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InstrumentError {
    /// Delay (ns).
    pub delay_ns: f64,
    /// Phase (degrees).
    pub phase_deg: f64,
}
