//! The clock offset of a track: as given, or found from the data.

use acerra_radar::Radargram;

use crate::align::{AlignError, Aligned, Flight, align};
use crate::choices::TimeOffset;
use crate::clean::{CleanError, clean};
use crate::control::Control;
use crate::echoes::Echoes;
use crate::offset::{OffsetError, OffsetSearch, Trial, by_motion, refine};
use crate::position::Positions;
use crate::read::RadarContent;
use crate::recording::TrackOptions;
use crate::warnings::Warnings;
use acerra_geo::trajectory::Trajectory;

/// A track's traces at their places, and the offset behind them.
#[derive(Clone, Debug)]
pub struct Clocked {
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// How the offset was found, when it was not given.
    pub search: Option<OffsetSearch>,
    /// The traces.
    pub aligned: Aligned,
}

/// Why a track's traces cannot be placed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClockError {
    /// The offset is to be found from spectra.
    #[error(
        "[trajectory] time_offset_s = \"auto\": expected a radargram, found spectra; state the offset"
    )]
    Spectra,
    /// No trace can be placed.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The traces of the search cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// The offset cannot be found.
    #[error(transparent)]
    Offset(#[from] OffsetError),
}

/// Places the traces at the offset given, or at the one that the data tell.
///
/// # Errors
/// Data that tell no offset, no trace that can be placed, cancellation.
pub fn align_clocks(
    flight: Flight<'_>,
    options: &TrackOptions,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<Clocked, ClockError> {
    let time_offset_s = match (options.align.time_offset, flight.positions, flight.radar) {
        (TimeOffset::Seconds(offset_s), ..) => offset_s,
        // Positions that came with the traces are on the traces' own clock.
        (TimeOffset::Auto, Positions::PerTrace(_), _) => 0.0,
        (TimeOffset::Auto, Positions::Trajectory(_), RadarContent::Spectrum(_)) => {
            return Err(ClockError::Spectra);
        }
        (TimeOffset::Auto, Positions::Trajectory(trajectory), RadarContent::Radargram(radar)) => {
            let search = search(flight, radar, trajectory, options, control)?;
            return at_offset_found(flight, options, search, warnings);
        }
    };
    Ok(Clocked {
        time_offset_s,
        search: None,
        aligned: align(flight, &options.align, time_offset_s, warnings)?,
    })
}

/// Finds the offset by motion, then by sharpness.
fn search(
    flight: Flight<'_>,
    radargram: &Radargram,
    trajectory: &Trajectory,
    options: &TrackOptions,
    control: &Control<'_>,
) -> Result<OffsetSearch, ClockError> {
    let motion = by_motion(radargram, trajectory, options.align.max_gap_s)?;
    // Warnings are given once, at the offset finally taken.
    let unsaid = &mut Warnings::default();
    let first = align(flight, &options.align, motion.offset_s, unsaid)?;
    let spectrum = clean(flight.radar, &first, &options.clean, unsaid)?.spectrum;
    let trial = Trial {
        flight,
        options: &options.align,
        echoes: Echoes {
            spectrum: &spectrum,
            aligned: &first,
            light_speed_m_s: flight.scene.light_speed_m_s,
        },
    };
    Ok(refine(trial, motion, control)?)
}

fn at_offset_found(
    flight: Flight<'_>,
    options: &TrackOptions,
    search: OffsetSearch,
    warnings: &mut Warnings,
) -> Result<Clocked, ClockError> {
    if !search.is_clear() {
        warnings.add(format!(
            "the clock offset of {:.3} s is uncertain: motion correlates with {:.2} there and with \
             {:.2} elsewhere; state time_offset_s if it is known",
            search.time_offset_s, search.motion.correlation, search.motion.runner_up
        ));
    }
    Ok(Clocked {
        time_offset_s: search.time_offset_s,
        aligned: align(flight, &options.align, search.time_offset_s, warnings)?,
        search: Some(search),
    })
}
