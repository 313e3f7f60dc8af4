//! A survey in files: the stages `read` and `position`, then everything before the image.

use std::collections::BTreeMap;
use std::path::PathBuf;

use acerra_formats::Contradiction;
use acerra_geo::time::GpsTime;
use acerra_radar::LoggedClock;

use crate::align::calibration::CalibrationOptions;
use crate::align::recording::{Recording, TrackOptions};
use crate::choices::{Select, TimeOffset};
use crate::control::Control;
use crate::error::ChainError;
use crate::findings::positions::weigh_source;
use crate::focus::FocusOptions;
use crate::focus::underground::Underground;
use crate::journal::Journal;
use crate::journal::finding::{Finding, Verdict};
use crate::journal::warnings::Warnings;
use crate::position::{
    PositionError, PositionOptions, PositionSource, Positioned, Positions, in_one_frame, position,
};
use crate::prepare::{Prepared, prepare};
use crate::read::grid::{GridSource, read_grid};
use crate::read::{Line, RadarData, ReadError, read_channel};
use crate::scene::{Scene, SceneOptions};
use crate::side_by_side::each_track;

/// One or more tracks in files, and the scene they are to be imaged on.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The tracks.
    pub tracks: Vec<TrackSource>,
    /// The image's rectangle and heights.
    pub scene: SceneOptions,
    /// How the tracks are calibrated against one another.
    pub calibration: CalibrationOptions,
    /// A ground whose permittivity is to be found, and how its images are made.
    pub open_ground: Option<(Underground, FocusOptions)>,
}

/// The files of a track, and how they are brought together.
#[derive(Clone, Debug)]
pub struct TrackSource {
    /// Name in reports and messages.
    pub name: String,
    /// The radar log.
    pub radar: PathBuf,
    /// Several files that make one log, instead of `radar`.
    pub grid: Option<GridSource>,
    /// The channel of a log that has several.
    pub channel: Option<String>,
    /// The line along which its traces were recorded, where the file does not place them.
    pub line: Option<Line>,
    /// Where its positions come from.
    pub positions: PositionOptions,
    /// Parameters of its later stages.
    pub options: TrackOptions,
}

/// Statements of a radar file that do not agree.
fn header_finding(found: &Contradiction) -> Finding {
    let name = format!("radar_header ({})", found.about);
    Finding::judged(name, found.other, found.unit, Verdict::Doubtful)
        .expecting(found.used)
        .because(format!(
            "the statements are {} and {} {}; the first is used",
            found.used, found.other, found.unit
        ))
}

impl Survey {
    /// Reads, positions, aligns, cleans and calibrates the tracks.
    ///
    /// # Errors
    /// The first stage that fails; the message names the file, the place, what was expected and found.
    /// Remarks of the stages until then are in the journal.
    pub fn prepare(
        &self,
        journal: &mut Journal,
        control: &Control<'_>,
    ) -> Result<Prepared, ChainError> {
        let (recordings, scene) = self.recordings(journal, control)?;
        let mut prepared = prepare(recordings, scene, &self.calibration, journal, control)?;
        if let Some((ground, options)) = &self.open_ground {
            journal.stage("focus", |_| {
                prepared.find_permittivity(ground, options, control)
            })?;
        }
        Ok(prepared)
    }

    /// Reads and positions the tracks: the stages `read` and `position`.
    ///
    /// # Errors
    /// The first stage that fails.
    pub fn recordings(
        &self,
        journal: &mut Journal,
        control: &Control<'_>,
    ) -> Result<(Vec<Recording>, Scene), ChainError> {
        let radars = journal.stage("read", |warnings| self.read(warnings, control))?;
        let mut findings = Vec::new();
        let positioned = journal.stage("position", |warnings| {
            self.position(radars, warnings, &mut findings, control)
        });
        for finding in findings {
            journal.evidence.add(finding);
        }
        positioned
    }

    fn read(
        &self,
        warnings: &mut Warnings,
        control: &Control<'_>,
    ) -> Result<Vec<RadarData>, ChainError> {
        let tracks = self.tracks.iter().collect();
        let read = |track: &TrackSource, warnings: &mut Warnings, control: &Control<'_>| {
            control.check()?;
            let channel = track.channel.as_deref();
            let radar = match &track.grid {
                Some(grid) => read_grid(grid, channel, warnings)?,
                None => read_channel(&track.radar, channel, track.line, warnings)?,
            };
            Ok(radar)
        };
        each_track("read", tracks, (warnings, control), read)
    }

    /// The finding with the track's name appended to its own, where there are several tracks.
    fn named(&self, track: &TrackSource, mut finding: Finding) -> Finding {
        if self.tracks.len() > 1 {
            finding.name = format!("{} of {}", finding.name, track.name);
        }
        finding
    }

    /// The positions of a track, from the track's own sources.
    fn placed(
        &self,
        number: usize,
        radar: &RadarData,
        warnings: &mut Warnings,
    ) -> Result<Positioned, ChainError> {
        let track = &self.tracks[number];
        let inside = radar.positions.as_ref();
        let is_open = matches!(track.positions.source, PositionSource::RadarFile);
        if track.grid.is_some() && inside.is_none() && is_open {
            let path = track.radar.clone();
            return Err(ReadError::NoPlace { path }.into());
        }
        let log = (track.radar.as_path(), radar.content.time_s());
        Ok(position(&track.positions, log, inside, warnings)?)
    }

    /// The positions of all tracks. The logs of a flight are read and processed once for all tracks recorded in it.
    fn all_placed(
        &self,
        radars: &[RadarData],
        warnings: &mut Warnings,
        control: &Control<'_>,
    ) -> Result<Vec<Positioned>, ChainError> {
        let is_outside = |number: usize| radars[number].positions.is_none();
        let first_alike = |number: usize| {
            let is_alike = |other: &usize| {
                is_outside(*other) && self.tracks[*other].positions == self.tracks[number].positions
            };
            let alike = (0..number).find(is_alike);
            alike.filter(|_| is_outside(number)).unwrap_or(number)
        };
        let (first, others): (Vec<usize>, Vec<usize>) =
            (0..radars.len()).partition(|number| first_alike(*number) == *number);
        let said = (&mut *warnings, control);
        let placed = each_track(
            "position",
            first.clone(),
            said,
            |number, warnings, control| {
                control.check()?;
                self.placed(number, &radars[number], warnings)
            },
        )?;
        let mut all: BTreeMap<usize, Positioned> = first.into_iter().zip(placed).collect();
        for number in others {
            let shared = all.get(&first_alike(number));
            let own = match shared.filter(|placed| !placed.by_trace_number) {
                Some(placed) => placed.clone(),
                None => self.placed(number, &radars[number], warnings)?,
            };
            all.insert(number, own);
        }
        Ok(all.into_values().collect())
    }

    /// The recordings in one frame, and the scene below them.
    fn position(
        &self,
        radars: Vec<RadarData>,
        warnings: &mut Warnings,
        findings: &mut Vec<Finding>,
        control: &Control<'_>,
    ) -> Result<(Vec<Recording>, Scene), ChainError> {
        let mut recordings = Vec::new();
        let all_placed = self.all_placed(&radars, warnings, control)?;
        for ((track, radar), placed) in self.tracks.iter().zip(radars).zip(all_placed) {
            // Times of positions say nothing of traces that have none.
            let needs_times =
                matches!(placed.positions, Positions::Trajectory(_)) && !placed.by_trace_number;
            if radar.is_untimed && needs_times {
                let path = track.radar.clone();
                return Err(ReadError::NoPlace { path }.into());
            }
            let headers = radar.contradictions.iter().map(header_finding);
            let own = headers.chain(weigh_source(&placed.seen));
            findings.extend(own.map(|finding| self.named(track, finding)));
            let mut options = track.options.clone();
            // Numbers of traces are no times: they give no speed.
            if radar.is_untimed && options.align.select == Select::Auto {
                options.align.select = Select::All;
            }
            let settled = settle_offset(track, &radar, &placed, warnings)?;
            options.align.time_offset = settled.offset;
            options.recorded_clock = settled.clock;
            recordings.push(Recording {
                name: track.name.clone(),
                positions: placed.positions,
                has_local_axes: placed.has_local_axes,
                log_sources: placed.log_sources,
                resolution_m: placed.resolution_m,
                radar,
                options,
            });
        }
        in_one_frame(recordings.iter_mut().map(|r| &mut r.positions))?;
        let positions: Vec<&Positions> = recordings.iter().map(|r| &r.positions).collect();
        let scene = Scene::find(&self.scene, &positions, warnings)?;
        Ok((recordings, scene))
    }
}

/// The clock offset of a track before its data are looked at.
struct SettledOffset {
    offset: Option<TimeOffset>,
    /// The recorded clock that it is taken from, where it is.
    clock: Option<LoggedClock>,
}

/// The offset of a track: as stated, or that of the clock recorded with the radar log, where the campaign
/// asks for the recorded clock or states no offset. Both the clock and the positions must be on GPS time, so
/// that positions of another week do not fit.
fn settle_offset(
    track: &TrackSource,
    radar: &RadarData,
    placed: &Positioned,
    warnings: &mut Warnings,
) -> Result<SettledOffset, ChainError> {
    let stated = track.options.align.time_offset;
    if placed.by_trace_number {
        let none = TimeOffset::Seconds(0.0);
        if stated.is_some_and(|stated| stated != none) {
            let radar_file = track.radar.clone();
            return Err(PositionError::OffsetOfTraceNumbers { radar_file }.into());
        }
        return Ok(SettledOffset {
            offset: Some(none),
            clock: None,
        });
    }
    let as_stated = SettledOffset {
        offset: stated,
        clock: None,
    };
    let (None | Some(TimeOffset::Logged), Positions::Trajectory(trajectory)) =
        (stated, &placed.positions)
    else {
        return Ok(as_stated);
    };
    let is_asked_for = stated.is_some();
    let Some(clock) = &radar.clock else {
        if !is_asked_for {
            return Ok(as_stated);
        }
        let path = LoggedClock::path_beside(&track.radar);
        return Err(ReadError::NoClock { path }.into());
    };
    let first_trace = GpsTime::from_week_tow(clock.gps_week, clock.time_offset_s);
    match trajectory.time_s_at(first_trace) {
        Some(offset_s) => Ok(SettledOffset {
            offset: Some(TimeOffset::Seconds(offset_s)),
            clock: Some(clock.clone()),
        }),
        None if is_asked_for => Err(PositionError::NotOnGpsTime {
            radar_file: track.radar.clone(),
        }
        .into()),
        None => {
            warnings.add(format!(
                "{}: the recorded clock is on GPS time, the times of the positions name no day: it is not \
                 used, and time_offset_s is 0 ([trajectory] time_offset_s)",
                LoggedClock::path_beside(&track.radar).display()
            ));
            Ok(as_stated)
        }
    }
}
