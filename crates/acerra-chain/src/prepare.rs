//! From recordings in memory to clean spectra at known places: everything before the image.

use std::ops::Range;

use acerra_imaging::ImagingError;
use acerra_imaging::metrics::Measurement;
use acerra_radar::align::OffsetLikelihood;
use acerra_radar::{LoggedClock, Spectrum};

use crate::align::Flight;
use crate::align::calibration::{CalibrationOptions, TrackCalibration, TrackEchoes, calibrate};
use crate::align::clock::{ClockError, Clocked, align_clocks, place_as_stated};
use crate::align::correction::PathCorrection;
use crate::align::delay::DelayFound;
use crate::align::offset::OffsetSearch;
use crate::align::overlap::check_clocks;
use crate::align::plane::{GroundFound, find_ground};
use crate::align::radar_surface::{RadarSurfaceError, SeenTrack, radar_surface};
use crate::align::recording::Recording;
use crate::align::uncovered::warn_of_uncovered;
use crate::choices::{Background, Gate, Select};
use crate::clean::{Cleaned, CleanedTraces, clean, filtered, zero_s};
use crate::control::Control;
use crate::echoes::Echoes;
use crate::error::ChainError;
use crate::focus::inversion::image::{InversionInput, invert};
use crate::focus::inversion::options::Method;
use crate::focus::permittivity::PermittivityFound;
use crate::focus::plan::ImageError;
use crate::focus::sink::ImageSink;
use crate::focus::underground::Underground;
use crate::focus::{Focused, ImageRequest, focus};
use crate::journal::Journal;
use crate::journal::warnings::Warnings;
use crate::measure::{MeasureError, MeasureOptions, measure};
use crate::position::aligned::Aligned;
use crate::position::{LogSources, Positions, in_one_frame};
use crate::read::raw::{channel_of, place};
use crate::read::trace_positions::TracePositions;
use crate::read::{RadarContent, RadarLabel};
use crate::scene::elevation::check_elevation;
use crate::scene::pixels::Pixels;
use crate::scene::{Scene, SceneError};
use crate::side_by_side::each_track;

/// A survey ready to be imaged: clean spectra of one or more tracks, in one frame.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The tracks, one or more.
    pub tracks: Vec<Track>,
    /// The height of the ground, where it was found from the data.
    pub ground: Option<GroundFound>,
    /// The ground, and the pixels that the preparation took for the image's.
    pub scene: Scene,
    /// The selected traces of all tracks and their places, track after track.
    pub aligned: Aligned,
    /// Clean, calibrated spectra of the traces.
    pub spectrum: Spectrum,
    /// The permittivity of the ground, where it was found from the data.
    pub permittivity: Option<PermittivityFound>,
    /// Result of an autofocus, where one was run.
    pub correction: Option<PathCorrection>,
}

/// Data on a track, in addition to its traces and spectra.
#[derive(Clone, Debug)]
pub struct Track {
    /// Name of the track.
    pub name: String,
    /// Label of the radar's data.
    pub radar: RadarLabel,
    /// Traces in its log.
    pub traces_in_log: usize,
    /// Lever arm of the track's antenna: forward, left, up (m).
    pub lever_arm_m: [f64; 3],
    /// Positions of the track, in the first track's frame.
    pub positions: Positions,
    /// Whether a file gives the positions in a local frame whose axes nothing confirms.
    pub has_local_axes: bool,
    /// Sources of an autopilot's log that the positions are from.
    pub log_sources: LogSources,
    /// Whether its log states no times: traces are numbered.
    pub is_untimed: bool,
    /// Step of the last digit in which a file gives its positions, east, north and up (m).
    pub resolution_m: Option<[f64; 3]>,
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
    /// Search of the offset, where it was not given.
    pub search: Option<OffsetSearch>,
    /// The clock recorded with the radar log, where the offset is by this clock.
    pub recorded_clock: Option<LoggedClock>,
    /// Likelihood of every offset by height and motion, where these depend on the offset.
    pub likelihood: Option<OffsetLikelihood>,
    /// Search of the fast time at which range is zero, where the campaign left that time open.
    pub delay: Option<DelayFound>,
    /// The gate in force.
    pub gate_ns: Gate,
    /// Whether the fast time at which range is zero was stated, rather than found from the surface.
    pub is_calibrated: bool,
    /// Background subtracted from its traces.
    pub background: Background,
    /// Traces of the track before and after cleaning; none where the log holds spectra.
    pub cleaned: Option<CleanedTraces>,
    /// Delay and phase taken off.
    pub calibration: TrackCalibration,
    /// Ranges of this track's traces and spectra among the survey's.
    pub range: Range<usize>,
    /// First and last trace of the log that was selected for its motion; none where all were used.
    pub moving: Option<[usize; 2]>,
}

impl Track {
    /// Whether the surface echo at the height of the positions set the fast time at which range is zero: an
    /// error of the height is then an error of that time.
    #[must_use]
    pub fn has_zero_by_surface(&self) -> bool {
        // Logs of spectra have no fast time to shift.
        self.cleaned.is_some() && !self.is_calibrated && self.delay.is_none()
    }

    /// Length of the horizontal part of its lever arm, which turns with the heading (m).
    #[must_use]
    pub fn horizontal_lever_arm_m(&self) -> f64 {
        self.lever_arm_m[0].hypot(self.lever_arm_m[1])
    }

    /// Whether the log of its positions holds attitudes; positions in the radar's own file need no attitudes.
    #[must_use]
    pub fn has_attitude(&self) -> bool {
        match &self.positions {
            Positions::Trajectory(trajectory) => {
                trajectory.fixes().iter().any(|fix| fix.attitude.is_some())
            }
            Positions::PerTrace(_) => true,
        }
    }

    /// Selection from its log.
    #[must_use]
    pub fn selected(&self) -> Select {
        self.moving.map_or(Select::All, Select::Range)
    }
}

/// Aligns, cleans and calibrates recordings: the stages `align` and `clean`.
///
/// The pixels of `scene` are where the search of a clock offset and of a common target look.
///
/// # Errors
/// The first stage that fails; remarks of the stages until then are in the journal.
pub fn prepare(
    mut recordings: Vec<Recording>,
    scene: Scene,
    calibration: &CalibrationOptions,
    journal: &mut Journal,
    control: &Control<'_>,
) -> Result<Prepared, ChainError> {
    in_one_frame(recordings.iter_mut().map(|r| &mut r.positions))?;
    let (scene, ground) = journal.stage("align", |warnings| {
        for recording in &recordings {
            check_clocks(recording).map_err(ClockError::from)?;
        }
        let settled = settle_ground(&recordings, scene, control);
        if let (Err(ChainError::Ground(_)), Some(first)) = (&settled, recordings.first()) {
            warn_of_uncovered(first, warnings);
        }
        settled
    })?;
    let (scene, clocked) = journal.stage("align", |warnings| {
        let tracks = recordings.iter().collect();
        let said = (&mut *warnings, control);
        let clocked = each_track("align", tracks, said, |recording, warnings, control| {
            control.check()?;
            let flight = flight_of(recording, &scene);
            let clocked = align_clocks(flight, &recording.options, warnings, control);
            if let Err(ClockError::Offset(_)) = &clocked {
                warn_of_uncovered(recording, warnings);
            }
            Ok::<_, ChainError>(clocked?)
        })?;
        over_surface(&recordings, scene, clocked, warnings)
    })?;
    journal.stage("clean", |warnings| {
        let tracks = recordings.into_iter().zip(clocked).collect();
        let said = (&mut *warnings, control);
        let cleaned = each_track(
            "clean",
            tracks,
            said,
            |(recording, clocked): (Recording, _), warnings, control| {
                control.check()?;
                clean_track(&recording, &scene, clocked, warnings)
            },
        )?;
        let (tracks, mut echoes): (Vec<_>, Vec<_>) = cleaned.into_iter().unzip();
        calibrate(&mut echoes, calibration, &scene, warnings, control)?;
        join(tracks, echoes, scene, ground)
    })
}

/// Aligns, cleans and calibrates recordings whose offsets, delays and gates are stated, as often as needed:
/// nothing is searched, and no likelihood of a setting is computed.
///
/// # Errors
/// A setting that is left to the data; the first stage that fails.
pub fn prepare_as_stated(
    recordings: &[Recording],
    scene: Scene,
    calibration: &CalibrationOptions,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<Prepared, ChainError> {
    let placed = |recording: &Recording| {
        control.check()?;
        let flight = flight_of(recording, &scene);
        Ok(place_as_stated(
            flight,
            &recording.options,
            warnings,
            control,
        )?)
    };
    let clocked: Result<Vec<_>, ChainError> = recordings.iter().map(placed).collect();
    let (scene, clocked) = over_surface(recordings, scene, clocked?, warnings)?;
    let mut tracks = Vec::new();
    let mut echoes = Vec::new();
    for (recording, clocked) in recordings.iter().zip(clocked) {
        let (track, own) = clean_track(recording, &scene, clocked, warnings)?;
        tracks.push(track);
        echoes.push(own);
    }
    calibrate(&mut echoes, calibration, &scene, warnings, control)?;
    join(tracks, echoes, scene, None)
}

/// Data of a recording, their positions, and the ground below.
fn flight_of<'a>(recording: &'a Recording, scene: &'a Scene) -> Flight<'a> {
    Flight {
        radar: &recording.radar.content,
        positions: &recording.positions,
        scene,
    }
}

/// Cleans a recording whose traces have their places.
fn clean_track(
    recording: &Recording,
    scene: &Scene,
    clocked: Clocked,
    warnings: &mut Warnings,
) -> Result<(Track, TrackEchoes), ChainError> {
    let cleaned = clean(
        &recording.radar.content,
        &clocked.aligned,
        scene,
        &clocked.clean,
        warnings,
    )?;
    Ok(parts(recording, clocked, cleaned))
}

/// The scene with its ground found, where the campaign leaves the ground to the data.
fn settle_ground(
    recordings: &[Recording],
    scene: Scene,
    control: &Control<'_>,
) -> Result<(Scene, Option<GroundFound>), ChainError> {
    let (true, Some(first)) = (scene.open.ground, recordings.first()) else {
        return Ok((scene, None));
    };
    let found = find_ground(first, &scene, control)?;
    Ok((scene.on_ground(found.z_m), Some(found)))
}

/// Share of the image without a trace near it from which an extrapolated surface is named.
const NAMED_BEYOND: f64 = 0.05;

/// The scene over the surface by the radar, and the heights of the traces above it, where the campaign uses
/// this surface.
fn over_surface(
    recordings: &[Recording],
    scene: Scene,
    mut clocked: Vec<Clocked>,
    warnings: &mut Warnings,
) -> Result<(Scene, Vec<Clocked>), ChainError> {
    if !scene.open.surface {
        return Ok((scene, clocked));
    }
    let mut raw = Vec::new();
    for (recording, clocked) in recordings.iter().zip(&clocked) {
        let RadarContent::Radargram(radargram) = &recording.radar.content else {
            return Err(RadarSurfaceError::Spectra.into());
        };
        let traces = radargram.select(&clocked.aligned.traces);
        let traces = traces.map_err(RadarSurfaceError::Traces)?;
        raw.push(filtered(traces, &clocked.clean)?);
    }
    let mut seen = Vec::new();
    for (radargram, clocked) in raw.iter().zip(&clocked) {
        let aligned = &clocked.aligned;
        let delay_s = zero_s(radargram, aligned, &clocked.clean)?;
        seen.push(SeenTrack {
            radargram,
            aligned,
            delay_s,
        });
    }
    let found = radar_surface(&seen, &scene)?;
    if found.beyond > NAMED_BEYOND {
        warnings.add(format!(
            "[ground] surface = \"radar\": {:.0} % of the image are farther from every trace than half the height of the \
             flight; the surface there is that under the nearest traces",
            100.0 * found.beyond
        ));
    }
    let scene = scene.over(found.heights);
    for one in &mut clocked {
        let places = (one.aligned.position_m).iter();
        for ([x_m, y_m, z_m], height_m) in places.zip(&mut one.aligned.height_m) {
            *height_m = z_m - scene.ground.below_m(*x_m, *y_m);
        }
    }
    Ok((scene, clocked))
}

/// Results kept for a recording, and values that the calibration corrects.
fn parts(recording: &Recording, clocked: Clocked, cleaned: Cleaned) -> (Track, TrackEchoes) {
    let calibration = TrackCalibration::given(recording.options.known_error);
    let track = Track {
        name: recording.name.clone(),
        traces_in_log: recording.radar.content.time_s().len(),
        radar: recording.radar.label.clone(),
        lever_arm_m: recording.options.align.lever_arm_m,
        positions: recording.positions.clone(),
        has_local_axes: recording.has_local_axes,
        log_sources: recording.log_sources.clone(),
        is_untimed: recording.radar.is_untimed,
        resolution_m: recording.resolution_m,
        time_offset_s: clocked.time_offset_s,
        search: clocked.search,
        recorded_clock: recording.options.recorded_clock.clone(),
        likelihood: clocked.likelihood,
        delay: clocked.delay,
        gate_ns: clocked.clean.gate_ns,
        is_calibrated: recording.options.clean.is_calibrated(),
        background: recording.options.clean.background,
        cleaned: cleaned.traces,
        calibration,
        range: 0..0,
        moving: clocked.aligned.moving(),
    };
    let echoes = TrackEchoes {
        name: recording.name.clone(),
        aligned: clocked.aligned,
        spectrum: cleaned.spectrum,
        calibration,
    };
    (track, echoes)
}

/// Puts the traces and spectra of all tracks into one list.
fn join(
    mut tracks: Vec<Track>,
    echoes: Vec<TrackEchoes>,
    mut scene: Scene,
    ground: Option<GroundFound>,
) -> Result<Prepared, ChainError> {
    let mut aligned = Aligned::default();
    let mut joined: Option<Spectrum> = None;
    for (track, mut own) in tracks.iter_mut().zip(echoes) {
        let start = aligned.traces.len();
        aligned.append(own.aligned);
        track.range = start..aligned.traces.len();
        track.calibration = own.calibration;
        match &mut joined {
            None => joined = Some(own.spectrum),
            Some(first) if first.frequency_hz == own.spectrum.frequency_hz => {
                first.values.append(&mut own.spectrum.values);
                first.time_s.append(&mut own.spectrum.time_s);
            }
            Some(first) => return Err(other_frequencies(own.name, first, &own.spectrum)),
        }
    }
    if scene.open.sides != [false; 2] {
        let z_m = scene.pixels.grid.z_m;
        let grid = scene.around(&aligned.position_m, z_m);
        scene.pixels.grid = grid.map_err(SceneError::Grid)?;
    }
    Ok(Prepared {
        tracks,
        ground,
        scene,
        aligned,
        spectrum: joined.ok_or(ChainError::NoTrack)?,
        permittivity: None,
        correction: None,
    })
}

fn other_frequencies(track: String, expected: &Spectrum, found: &Spectrum) -> ChainError {
    let from_hz = |s: &Spectrum| s.frequency_hz.first().copied().unwrap_or(f64::NAN);
    ChainError::Frequencies {
        track,
        expected_count: expected.frequency_hz.len(),
        expected_from_hz: from_hz(expected),
        found_count: found.frequency_hz.len(),
        found_from_hz: from_hz(found),
    }
}

impl Prepared {
    /// The first track: the measure of delay, phase and frame.
    #[must_use]
    pub fn first(&self) -> &Track {
        // `prepare` makes no survey without a track.
        &self.tracks[0]
    }

    /// The traces of a survey of one track before and after cleaning, where the track's log holds traces.
    #[must_use]
    pub fn cleaned(&self) -> Option<&CleanedTraces> {
        match self.tracks.as_slice() {
            [only] => only.cleaned.as_ref(),
            _ => None,
        }
    }

    /// The cleaned traces of a track with their places, for export; none where the track's log holds spectra.
    #[must_use]
    pub fn cleaned_channel(&self, track: &Track) -> Option<acerra_formats::Channel> {
        let own = track.range.clone();
        let mut channel = channel_of(track.cleaned.as_ref()?.clean.clone());
        let mut places = TracePositions::from(self.aligned.position_m.get(own.clone())?.to_vec());
        places.frame = *self.first().positions.frame();
        if !self.aligned.antennas_from_place_m.is_empty() {
            let (mut transmitters, mut receivers) = (Vec::new(), Vec::new());
            for k in own {
                let [transmitter, receiver] = self.aligned.antennas_at_m(k);
                transmitters.push(transmitter);
                receivers.push(receiver);
            }
            places.antennas_m = Some([transmitters, receivers]);
        }
        place(&mut channel, places);
        Some(channel)
    }

    /// Traces in the logs of all tracks.
    #[must_use]
    pub fn traces_in_log(&self) -> usize {
        self.tracks.iter().map(|track| track.traces_in_log).sum()
    }

    /// Input of the imaging.
    #[must_use]
    pub fn echoes(&self) -> Echoes<'_> {
        Echoes {
            spectrum: &self.spectrum,
            aligned: &self.aligned,
            light_speed_m_s: self.scene.light_speed_m_s,
        }
    }

    /// Nearest and farthest range that the cleaned data of every trace hold (m).
    #[must_use]
    pub fn ranges_held_m(&self) -> Vec<[f64; 2]> {
        let of = |track: &Track| self.ranges_held_by_m(track);
        self.tracks.iter().flat_map(of).collect()
    }

    /// Ranges held by one track: those of the recorded window and the gate, or unbounded for spectra.
    #[must_use]
    pub fn ranges_held_by_m(&self, track: &Track) -> Vec<[f64; 2]> {
        let half_speed_m_s = 0.5 * self.scene.light_speed_m_s;
        let heights_m = &self.aligned.height_m[track.range.clone()];
        let Some(traces) = &track.cleaned else {
            return vec![[0.0, f64::INFINITY]; heights_m.len()];
        };
        let window_s = [
            traces.clean.fast_time_start_s,
            traces.clean.fast_time_end_s(),
        ];
        let held_s = |height_m: &f64| match traces.gate_s {
            None => window_s,
            Some([start_s, end_s]) => {
                let surface_s = height_m / half_speed_m_s;
                [
                    window_s[0].max(surface_s + start_s),
                    window_s[1].min(surface_s + end_s),
                ]
            }
        };
        heights_m
            .iter()
            .map(|height_m| held_s(height_m).map(|time_s| time_s.max(0.0) * half_speed_m_s))
            .collect()
    }

    /// Doubts about an image before it is made.
    #[must_use]
    pub fn doubts(&self, request: &ImageRequest) -> Warnings {
        let mut warnings = Warnings::default();
        let frequency_hz = &self.spectrum.frequency_hz;
        if let (Some(volume), Some(low), Some(high)) = (
            &request.pixels.volume,
            frequency_hz.first(),
            frequency_hz.last(),
        ) {
            let wavelength_m = self.scene.light_speed_m_s / (0.5 * (low + high));
            let position_m = &self.aligned.position_m;
            check_elevation(volume, position_m, wavelength_m, &mut warnings);
        }
        let causes = [
            (
                request.underground.is_some(),
                "rays are refracted below ground",
            ),
            (
                !self.aligned.antennas_from_place_m.is_empty(),
                "transmitter and receiver are apart",
            ),
        ];
        for (_, cause) in causes.iter().filter(|(applies, _)| *applies) {
            warnings.add(format!(
                "{cause}: expected widths, sidelobes, ghosts and deviations of targets are computed for one \
                 antenna in air"
            ));
        }
        warnings
    }

    /// Makes an image, on any pixels and any number of times; looks and volume slices go to the
    /// sink.
    ///
    /// # Errors
    /// Data that the imaging operators refuse, a sink that is full, cancellation.
    pub fn image(
        &self,
        request: &ImageRequest,
        sink: &mut dyn ImageSink,
        control: &Control<'_>,
    ) -> Result<Focused, ImageError> {
        let pixels = request.pixels.grid.len();
        let traces = self.aligned.traces.len();
        let _span = tracing::info_span!("image", pixels, traces).entered();
        let parts: Vec<_> = self
            .tracks
            .iter()
            .map(|track| track.range.clone())
            .collect();
        let underground = (request.underground.as_ref())
            .map(|ground| self.underground_of(ground, &request.pixels))
            .transpose()
            .map_err(ImageError::Ground)?;
        let request = &ImageRequest {
            underground,
            ..request.clone()
        };
        if request.options.inversion.method == Method::Adjoint {
            return focus(self.echoes(), &parts, request, sink, control);
        }
        let held_m = self.ranges_held_m();
        let input = InversionInput {
            echoes: self.echoes(),
            parts: &parts,
            held_m: &held_m,
        };
        invert(input, request, sink, control)
    }

    /// A ground with the permittivity found from the data, and the terrain under pixels and antennas.
    fn underground_of(
        &self,
        ground: &Underground,
        pixels: &Pixels,
    ) -> Result<Underground, ImagingError> {
        let found = self.permittivity.filter(|_| ground.is_open);
        let ground = found.map_or(ground.clone(), |found| ground.of_permittivity(found.value));
        ground.over(&self.scene.ground, pixels, &self.aligned.position_m)
    }

    /// Half the optical length of the way of a place's echo for every trace, from the transmitter to the place and back
    /// to the receiver (m): the range in air, refracted rays below the surface of an image's ground.
    ///
    /// # Errors
    /// Invalid soils or layers, heights that are not finite.
    pub fn half_ways_m(
        &self,
        request: &ImageRequest,
        place_m: [f64; 3],
    ) -> Result<Vec<f64>, ImagingError> {
        let ground = (request.underground.as_ref())
            .map(|ground| {
                let ground = self.underground_of(ground, &request.pixels)?;
                ground.seen_at(&self.spectrum.frequency_hz)
            })
            .transpose()?;
        let way_m = |antenna_m: [f64; 3]| match &ground {
            Some(ground) => ground.ray(antenna_m, place_m).optical_m,
            None => {
                let [x, y, z] = [0, 1, 2].map(|axis| place_m[axis] - antenna_m[axis]);
                (x * x + y * y + z * z).sqrt()
            }
        };
        let half_way_m = |k: usize| {
            let [transmitter_m, receiver_m] = self.aligned.antennas_at_m(k);
            0.5 * (way_m(transmitter_m) + way_m(receiver_m))
        };
        Ok((0..self.aligned.position_m.len()).map(half_way_m).collect())
    }

    /// Finds and measures the targets of an image.
    ///
    /// # Errors
    /// Pixel values that are not finite, cancellation.
    pub fn measure(
        &self,
        focused: &Focused,
        options: &MeasureOptions,
        control: &Control<'_>,
    ) -> Result<Measurement, MeasureError> {
        measure(self.echoes(), focused, options, control)
    }
}
