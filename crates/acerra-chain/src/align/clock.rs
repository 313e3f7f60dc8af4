//! Clock offset and delay of a track, stated or found from the data, and the choices that depend on the
//! resulting positions of the traces.

use acerra_geo::trajectory::Trajectory;
use acerra_radar::Radargram;
use acerra_radar::align::OffsetLikelihood;

use crate::align::delay::{
    DelayCue, DelayError, DelayFound, DelayTrial, coupling_delay, find_delay, surface_delay,
};
use crate::align::gate::settle_gate;
use crate::align::offset::{
    OffsetError, OffsetSearch, SearchRange, Trial, by_height_and_motion, refine, with_heights_error,
};
use crate::align::overlap::ClocksError;
use crate::align::recording::TrackOptions;
use crate::align::{AlignError, Flight, align};
use crate::choices::{Delay, TimeOffset, ZeroTiming};
use crate::clean::CleanOptions;
use crate::control::Control;
use crate::journal::warnings::Warnings;
use crate::position::Positions;
use crate::position::aligned::Aligned;
use crate::read::RadarContent;

/// A track's traces with their positions, and the clock offset used.
#[derive(Clone, Debug)]
pub struct Clocked {
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// Search for the offset, where the offset was not stated.
    pub search: Option<OffsetSearch>,
    /// Likelihood of every offset by height and motion, where these depend on the offset.
    pub likelihood: Option<OffsetLikelihood>,
    /// Search for the delay, where the delay was not stated.
    pub delay: Option<DelayFound>,
    /// Options of the cleaning, with all choices left to the data settled.
    pub clean: CleanOptions,
    /// The traces with their positions.
    pub aligned: Aligned,
}

/// Reason for which a track's traces cannot be placed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClockError {
    /// The offset is to be found from spectra.
    #[error(
        "[trajectory] time_offset_s = \"auto\": expected a radargram, found spectra; state the offset"
    )]
    Spectra,
    /// The offset is to come from a recorded clock, and the traces came without one.
    #[error(
        "[trajectory] time_offset_s = \"logged\": expected traces with the clock of their recording, found \
         traces in memory; state the offset"
    )]
    NotRecorded,
    /// An offset or a delay is `"auto"` in a run without a search.
    #[error("{key}: expected a number, as nothing is searched here, found \"auto\"")]
    NotStated {
        /// The key of the campaign file.
        key: &'static str,
    },
    /// The clocks of radar log and positions cannot belong together.
    #[error(transparent)]
    Clocks(#[from] ClocksError),
    /// No trace can be placed.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The offset cannot be found.
    #[error(transparent)]
    Offset(#[from] OffsetError),
    /// The delay cannot be found.
    #[error(transparent)]
    Delay(#[from] DelayError),
}

/// Largest number of alternations between offset and delay, each found at the other's last value.
const TURNS: usize = 3;

/// Places the traces at the stated or the estimated offset, and makes the choices that depend on the places:
/// delay and gate. For a radargram on a trajectory, the likelihood of a stated offset by height and motion is
/// kept as well.
///
/// # Errors
/// Data that leave the offset or the delay open, no trace that can be placed, cancellation.
pub fn align_clocks(
    flight: Flight<'_>,
    options: &TrackOptions,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<Clocked, ClockError> {
    let likelihood = likelihood_of(flight, options, control)?;
    let track = ClockedTrack {
        flight,
        options,
        surface: likelihood.as_ref().and_then(surface_delay),
        control,
    };
    let clocked = match (
        options.align.time_offset.unwrap_or_default(),
        flight.positions,
    ) {
        (TimeOffset::Seconds(offset_s), _) => track.at_offset(offset_s, warnings)?,
        // Positions in the radar file are on the traces' clock.
        (TimeOffset::Auto | TimeOffset::Logged, Positions::PerTrace(_)) => {
            track.at_offset(0.0, warnings)?
        }
        (TimeOffset::Logged, Positions::Trajectory(_)) => return Err(ClockError::NotRecorded),
        (TimeOffset::Auto, Positions::Trajectory(_)) => {
            let likelihood = likelihood.clone().ok_or(ClockError::Spectra)?;
            track.at_offset_found(likelihood, warnings)?
        }
    };
    Ok(Clocked {
        likelihood,
        aligned: align(flight, &options.align, clocked.time_offset_s, warnings)?,
        ..clocked
    })
}

/// Places the traces at the stated offset without computing the offset's likelihood.
///
/// # Errors
/// An offset or a delay that is left to the data, no trace that can be placed.
pub fn place_as_stated(
    flight: Flight<'_>,
    options: &TrackOptions,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<Clocked, ClockError> {
    if options.clean.delay_ns == Some(Delay::Auto) {
        let key = "[radar] delay_ns";
        return Err(ClockError::NotStated { key });
    }
    let time_offset_s = match (
        options.align.time_offset.unwrap_or_default(),
        flight.positions,
    ) {
        (TimeOffset::Seconds(offset_s), _) => offset_s,
        (TimeOffset::Auto | TimeOffset::Logged, Positions::PerTrace(_)) => 0.0,
        (TimeOffset::Logged, Positions::Trajectory(_)) => return Err(ClockError::NotRecorded),
        (TimeOffset::Auto, Positions::Trajectory(_)) => {
            let key = "[trajectory] time_offset_s";
            return Err(ClockError::NotStated { key });
        }
    };
    let track = ClockedTrack {
        flight,
        options,
        surface: None,
        control,
    };
    track.at_offset(time_offset_s, warnings)
}

/// Likelihood of every offset by height and motion, where radargram and trajectory depend on the offset.
fn likelihood_of(
    flight: Flight<'_>,
    options: &TrackOptions,
    control: &Control<'_>,
) -> Result<Option<OffsetLikelihood>, OffsetError> {
    let (RadarContent::Radargram(radargram), Positions::Trajectory(trajectory)) =
        (flight.radar, flight.positions)
    else {
        return Ok(None);
    };
    let range = SearchRange {
        max_gap_s: options.align.max_gap_s,
        delay_s: None,
    };
    let near = match options.align.time_offset.unwrap_or_default() {
        TimeOffset::Seconds(offset_s) => about_offset(radargram, trajectory, offset_s),
        TimeOffset::Auto | TimeOffset::Logged => None,
    };
    let trajectory = near.as_ref().unwrap_or(trajectory);
    match by_height_and_motion(radargram, trajectory, flight.scene, range, control) {
        Ok(likelihood) => Ok(Some(likelihood)),
        // A stated offset needs no cue.
        Err(OffsetError::Undecided { .. } | OffsetError::TooLong { .. })
            if options.align.time_offset != Some(TimeOffset::Auto) =>
        {
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// Largest distance of the offsets compared with a stated offset (s), large enough to include offsets of
/// other time zones.
const COMPARED_S: f64 = 3600.0;

/// The positions within [`COMPARED_S`] of the traces at a stated offset; `None` where all positions are
/// within this time.
fn about_offset(
    radargram: &Radargram,
    trajectory: &Trajectory,
    offset_s: f64,
) -> Option<Trajectory> {
    let ends_s = [radargram.time_s.first()?, radargram.time_s.last()?];
    let from_s = ends_s[0] + offset_s - COMPARED_S;
    let to_s = ends_s[1] + offset_s + COMPARED_S;
    if from_s <= trajectory.start_s() && trajectory.end_s() <= to_s {
        return None;
    }
    let fixes = trajectory.fixes();
    let first = fixes.partition_point(|fix| fix.time_s < from_s);
    let end = fixes.partition_point(|fix| fix.time_s <= to_s);
    let kept = fixes.get(first..end)?.to_vec();
    Trajectory::new(*trajectory.frame(), trajectory.time_origin(), kept).ok()
}

/// A track whose offset or delay may be left to the data.
struct ClockedTrack<'a> {
    flight: Flight<'a>,
    options: &'a TrackOptions,
    /// Delay of the echo that follows the height.
    surface: Option<DelayCue>,
    control: &'a Control<'a>,
}

impl ClockedTrack<'_> {
    /// The result at a known offset.
    fn at_offset(
        &self,
        time_offset_s: f64,
        warnings: &mut Warnings,
    ) -> Result<Clocked, ClockError> {
        let aligned = self.aligned_at(time_offset_s)?;
        let mut clean = self.cleaning(&aligned, warnings);
        let delay = self.find_delay_in(&mut clean, &aligned)?;
        Ok(Clocked {
            time_offset_s,
            search: None,
            likelihood: None,
            delay,
            clean,
            aligned,
        })
    }

    /// Estimates offset and delay in turn, each at the other's last value, until the offset is stationary.
    fn at_offset_found(
        &self,
        likelihood: OffsetLikelihood,
        warnings: &mut Warnings,
    ) -> Result<Clocked, ClockError> {
        let first_s = likelihood.candidates.first().map_or(0.0, |c| c.offset_s);
        let mut clocked = self.at_offset(first_s, warnings)?;
        for _ in 0..TURNS {
            let trial = Trial {
                flight: self.flight,
                align: &self.options.align,
                clean: &clocked.clean,
            };
            let search = refine(trial, likelihood.clone(), self.control)?;
            let found = &search.estimate;
            let moved_s = (found.offset_s - clocked.time_offset_s).abs();
            let is_settled = clocked.delay.is_none() || moved_s <= found.sigma_s;
            clocked.time_offset_s = found.offset_s;
            clocked.search = Some(search);
            if is_settled {
                break;
            }
            clocked.clean.delay_ns = self.options.clean.delay_ns;
            let aligned = self.aligned_at(clocked.time_offset_s)?;
            clocked.delay = self.find_delay_in(&mut clocked.clean, &aligned)?;
        }
        clocked.search = clocked.search.map(|search| OffsetSearch {
            estimate: with_heights_error(search.estimate, &likelihood),
            ..search
        });
        Ok(clocked)
    }

    /// The traces at an offset; warnings about the traces are given only for the final offset.
    fn aligned_at(&self, time_offset_s: f64) -> Result<Aligned, AlignError> {
        let discarded = &mut Warnings::default();
        align(self.flight, &self.options.align, time_offset_s, discarded)
    }

    /// Options of the cleaning with the gate settled.
    fn cleaning(&self, aligned: &Aligned, warnings: &mut Warnings) -> CleanOptions {
        let stated = &self.options.clean;
        let gate_ns = match self.flight.radar {
            RadarContent::Radargram(_) => {
                let sees_surface = self.surface.is_some();
                let scene = self.flight.scene;
                settle_gate(stated.gate_ns, aligned, scene, sees_surface, warnings)
            }
            RadarContent::Spectrum(_) => stated.gate_ns,
        };
        CleanOptions {
            gate_ns,
            surface_delay_s: self.surface.map(|cue| cue.delay_s),
            ..stated.clone()
        }
    }

    /// Finds the delay where the campaign leaves it to the data, and sets it.
    fn find_delay_in(
        &self,
        clean: &mut CleanOptions,
        aligned: &Aligned,
    ) -> Result<Option<DelayFound>, ClockError> {
        if clean.delay_ns != Some(Delay::Auto) {
            return Ok(None);
        }
        let coupling = match self.flight.radar {
            RadarContent::Radargram(radargram) => coupling_delay(radargram),
            RadarContent::Spectrum(_) => None,
        };
        let trial = DelayTrial {
            radar: self.flight.radar,
            aligned,
            scene: self.flight.scene,
            clean,
            surface: self.surface,
            coupling,
        };
        let found = find_delay(trial, self.control)?;
        clean.delay_ns = Some(Delay::Nanoseconds(1e9 * found.delay_s));
        clean.zero_timing = ZeroTiming::None;
        Ok(Some(found))
    }
}
