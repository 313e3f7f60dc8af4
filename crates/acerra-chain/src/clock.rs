//! The clock offset of a track: as given, or found from the data.

use acerra_radar::align::OffsetLikelihood;

use crate::align::{AlignError, Aligned, Flight, align};
use crate::choices::TimeOffset;
use crate::control::Control;
use crate::offset::{OffsetError, OffsetSearch, SearchRange, Trial, by_height_and_motion, refine};
use crate::position::Positions;
use crate::read::RadarContent;
use crate::recording::TrackOptions;
use crate::warnings::Warnings;

/// A track's traces at their places, and the offset behind them.
#[derive(Clone, Debug)]
pub struct Clocked {
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// How the offset was found, when it was not given.
    pub search: Option<OffsetSearch>,
    /// What height and motion say of every offset, where they say anything.
    pub likelihood: Option<OffsetLikelihood>,
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
    /// The offset cannot be found.
    #[error(transparent)]
    Offset(#[from] OffsetError),
}

/// Places the traces at the offset given, or at the one that the data tell. Of a radargram on a
/// trajectory, what height and motion say of a given offset is kept as well.
///
/// # Errors
/// Data that tell no offset, no trace that can be placed, cancellation.
pub fn align_clocks(
    flight: Flight<'_>,
    options: &TrackOptions,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<Clocked, ClockError> {
    let likelihood = match (flight.radar, flight.positions) {
        (RadarContent::Radargram(radargram), Positions::Trajectory(trajectory)) => {
            let range = SearchRange {
                max_gap_s: options.align.max_gap_s,
                delay_s: None,
            };
            Some(by_height_and_motion(
                radargram,
                trajectory,
                flight.scene,
                range,
                control,
            ))
        }
        _ => None,
    };
    if let TimeOffset::Auto = options.align.time_offset {
        return match (likelihood, flight.positions) {
            (Some(likelihood), _) => {
                let trial = Trial {
                    flight,
                    align: &options.align,
                    clean: &options.clean,
                };
                let search = refine(trial, likelihood?, control)?;
                let time_offset_s = search.estimate.offset_s;
                Ok(Clocked {
                    time_offset_s,
                    aligned: align(flight, &options.align, time_offset_s, warnings)?,
                    likelihood: Some(search.likelihood.clone()),
                    search: Some(search),
                })
            }
            // Positions that came with the traces are on the traces' own clock.
            (None, Positions::PerTrace(_)) => at_offset(flight, options, 0.0, warnings),
            (None, Positions::Trajectory(_)) => Err(ClockError::Spectra),
        };
    }
    let TimeOffset::Seconds(time_offset_s) = options.align.time_offset else {
        return Err(ClockError::Spectra);
    };
    let likelihood = match likelihood {
        Some(Err(OffsetError::Undecided(_) | OffsetError::TooLong { .. })) | None => None,
        Some(known) => Some(known?),
    };
    Ok(Clocked {
        likelihood,
        ..at_offset(flight, options, time_offset_s, warnings)?
    })
}

fn at_offset(
    flight: Flight<'_>,
    options: &TrackOptions,
    time_offset_s: f64,
    warnings: &mut Warnings,
) -> Result<Clocked, ClockError> {
    Ok(Clocked {
        time_offset_s,
        search: None,
        likelihood: None,
        aligned: align(flight, &options.align, time_offset_s, warnings)?,
    })
}
