//! A track as the calibration sees it: its path, its range profiles, and the echoes in them.

use acerra_radar::Radargram;
use acerra_radar::align::AlignError as Undecided;
use acerra_radar::clean::{Background, remove_background};

use super::coupling;
use super::echo::Profiles;
use super::error::CalibrateError;
use super::model::predict;
use super::parameter::Values;
use super::path::{Path, Pose};
use crate::align::clock::{ClockError, align_clocks};
use crate::align::delay::DelayCue;
use crate::align::offset::OffsetError;
use crate::align::recording::{Recording, TrackOptions};
use crate::align::select::SelectError;
use crate::align::{AlignError, Flight, align};
use crate::choices::{Delay, Select, TimeOffset};
use crate::clean::{CleanError, removal};
use crate::control::Control;
use crate::journal::warnings::Warnings;
use crate::position::Positions;
use crate::read::RadarContent;
use crate::scene::Scene;

/// Settings common to all tracks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting<'a> {
    /// Places of the reflectors, east, north, up (m).
    pub reflector_m: &'a [[f64; 3]],
    /// Standard deviation of each coordinate of a reflector's surveyed place (m).
    pub survey_sigma_m: f64,
    /// Propagation speed stated (m/s).
    pub light_speed_m_s: f64,
    /// Band of the pulse (Hz).
    pub band_hz: [f64; 2],
    /// Scene below the flight.
    pub scene: &'a Scene,
}

/// A track's path and range profiles.
#[derive(Clone, Debug)]
pub(super) struct TrackEchoes {
    /// Name.
    pub name: String,
    /// Path of the positioned point.
    pub path: Path,
    /// Envelopes of the traces that count.
    pub profiles: Profiles,
    /// Traces before background removal.
    pub raw: Radargram,
    /// Delay by the direct coupling, where the record shows it.
    pub coupling: Option<DelayCue>,
    /// Delay of this track relative to the first track's, as stated (s).
    pub known_delay_s: f64,
    /// Clock offset of the campaign, or the likeliest where the logs leave it open (s).
    pub time_offset_s: f64,
    /// Stretches `[from, to]` of clock offsets among which the reflectors decide (s).
    pub open_offsets_s: Vec<[f64; 2]>,
    /// Whether the platform is at rest.
    pub at_rest: bool,
}

impl Setting<'_> {
    /// Distance in fast time from which echoes are resolved (s): from the crest of a
    /// cosine-weighted pulse to its first zero.
    fn cell_s(&self) -> f64 {
        1.5 / (self.band_hz[1] - self.band_hz[0])
    }

    /// The ground straight below a place, where its height is known (m).
    fn below(&self, [x_m, y_m, _]: [f64; 3]) -> Option<[f64; 3]> {
        let is_known = !self.scene.open.ground;
        is_known.then(|| [x_m, y_m, self.scene.ground.below_m(x_m, y_m)])
    }
}

/// An echo of a reflector in a trace.
#[derive(Clone, Copy, Debug)]
pub(super) struct Echo {
    /// Number of the track.
    pub track: usize,
    /// Number of the reflector.
    pub reflector: usize,
    /// Radar time of the trace (s).
    pub time_s: f64,
    /// Apparent range, c/2 times fast time (m).
    pub range_m: f64,
    /// Deviation relative to that of an echo as high as the floor.
    pub relative_sigma: f64,
}

/// Least contrast of an echo: noise alone reaches it in one of some thousand windows.
const LEAST_CONTRAST: f64 = 4.0;
/// Least relative deviation of an echo, however strong: the remainder by the shape of echoes.
const LEAST_RELATIVE_SIGMA: f64 = 0.02;

impl TrackEchoes {
    /// Selects the traces of a recording that its campaign would image, and forms their profiles. For a
    /// platform at rest all traces are used, and no background is removed, since the reflector would be
    /// removed with it.
    pub fn of(
        recording: &Recording,
        scene: &Scene,
        setting: &Setting<'_>,
        warnings: &mut Warnings,
        control: &Control<'_>,
    ) -> Result<Self, CalibrateError> {
        let name = || recording.name.clone();
        let RadarContent::Radargram(radargram) = &recording.radar.content else {
            return Err(CalibrateError::Spectra { track: name() });
        };
        check_band(setting.band_hz, radargram, &recording.name)?;
        let selected =
            Selected::of(recording, radargram, scene, (warnings, control)).map_err(|cause| {
                CalibrateError::Align {
                    track: name(),
                    cause,
                }
            })?;
        let clean_error = |cause| CalibrateError::Clean {
            track: name(),
            cause,
        };
        let raw = radargram
            .select(&selected.traces)
            .map_err(|cause| clean_error(CleanError::Traces(cause)))?;
        let background = if selected.at_rest {
            Background::None
        } else {
            removal(recording.options.clean.background).unwrap_or_default()
        };
        let clean = remove_background(raw.clone(), background)
            .map_err(|cause| clean_error(CleanError::Background(cause)))?;
        let max_gap_s = recording.options.align.max_gap_s;
        Ok(Self {
            name: name(),
            path: Path::new(&recording.positions, radargram.time_s.as_slice(), max_gap_s),
            profiles: Profiles::new(&clean, setting.band_hz),
            coupling: coupling::seen(&raw),
            raw,
            known_delay_s: recording.options.known_error.delay_ns * 1e-9,
            time_offset_s: selected.time_offset_s,
            open_offsets_s: selected.open_offsets_s,
            at_rest: selected.at_rest,
        })
    }

    /// First and last delay at which range zero is possible (s), less the delay of this track as stated.
    pub fn possible_delays_s(&self) -> [f64; 2] {
        coupling::possible_delays_s(self.coupling).map(|delay_s| delay_s - self.known_delay_s)
    }

    /// Highest speed of the positioned point over the traces (m/s).
    pub fn top_speed_m_s(&self, offset_s: f64) -> f64 {
        let sampler = self.path.sampler();
        let speed = |t: &f64| Some(speed_m_s(&sampler.at(*t, offset_s)?));
        self.profiles
            .time_s
            .iter()
            .filter_map(speed)
            .fold(0.0, f64::max)
    }

    /// The echoes within `half_width_s` of where the model puts them.
    pub fn echoes(
        &self,
        setting: &Setting<'_>,
        number: usize,
        values: &Values,
        half_width_s: f64,
    ) -> Vec<Echo> {
        let c = setting.light_speed_m_s;
        let expected = self.expected(setting, number, values);
        let surface_is_seen = self.surface_is_seen(setting, &expected);
        let mut found = Vec::new();
        for Expected {
            trace,
            time_s,
            reflectors_s: others_s,
            surface_s,
        } in expected
        {
            let surface_s = surface_s.filter(|_| surface_is_seen);
            for (reflector, &expected_s) in others_s.iter().enumerate() {
                let is_close = |other_s: f64| (other_s - expected_s).abs() < setting.cell_s();
                let is_met = others_s
                    .iter()
                    .enumerate()
                    .any(|(k, other_s)| k != reflector && is_close(*other_s));
                if is_met || surface_s.is_some_and(is_close) {
                    continue;
                }
                let crest = self.profiles.crest(trace, expected_s, half_width_s);
                if let Some(crest) = crest.filter(|c| c.contrast >= LEAST_CONTRAST) {
                    found.push(Echo {
                        track: number,
                        reflector,
                        time_s,
                        range_m: 0.5 * c * (crest.fast_time_s - self.known_delay_s),
                        relative_sigma: crest.contrast.recip().hypot(LEAST_RELATIVE_SIGMA),
                    });
                }
            }
        }
        found
    }
}

impl TrackEchoes {
    /// Delays of the echoes by the model, for each trace that has a place. Traces at rest before and after a motion
    /// repeat one echo, bent by one clutter.
    fn expected(&self, setting: &Setting<'_>, number: usize, values: &Values) -> Vec<Expected> {
        let sampler = self.path.sampler();
        let c = setting.light_speed_m_s;
        let repeats = !self.at_rest && matches!(self.path, Path::Flown { .. });
        let of_trace = |(trace, &time_s): (usize, &f64)| {
            let pose = sampler.at(time_s, values.time_offset_s[number])?;
            if repeats && speed_m_s(&pose) < SLOWEST_M_S {
                return None;
            }
            let expected_s = |place: &[f64; 3]| {
                2.0 * predict(values, &pose, *place, c).range_m / c + self.known_delay_s
            };
            Some(Expected {
                trace,
                time_s,
                reflectors_s: setting.reflector_m.iter().map(expected_s).collect(),
                surface_s: setting
                    .below(pose.phase_centre_m(values.lever_arm_m))
                    .map(|nadir| expected_s(&nadir)),
            })
        };
        let traces = self.profiles.time_s.iter().enumerate();
        traces.filter_map(of_trace).collect()
    }

    /// Whether the surface echo is above the floor in most traces in which no reflector is near it: a weaker
    /// surface echo displaces no crest.
    fn surface_is_seen(&self, setting: &Setting<'_>, expected: &[Expected]) -> bool {
        let apart_s = 2.0 * setting.cell_s();
        let contrast = |one: &Expected| {
            let surface_s = one.surface_s?;
            let is_apart = |s: &f64| (s - surface_s).abs() > apart_s;
            let alone = one.reflectors_s.iter().all(is_apart);
            alone.then(|| self.profiles.contrast_at(one.trace, surface_s))?
        };
        let seen: Vec<bool> = expected
            .iter()
            .filter_map(contrast)
            .map(|contrast| contrast > SURFACE_CONTRAST)
            .collect();
        2 * seen.iter().filter(|s| **s).count() > seen.len()
    }
}

/// Fast times at which the echoes of a trace are expected.
struct Expected {
    trace: usize,
    time_s: f64,
    reflectors_s: Vec<f64>,
    surface_s: Option<f64>,
}

/// Contrast from which the surface counts as seen: noise reaches it in one of seven traces.
const SURFACE_CONTRAST: f64 = 2.0;

/// Slowest motion (m/s): below it clutter stays the same for seconds.
const SLOWEST_M_S: f64 = 0.01;

fn speed_m_s(pose: &Pose) -> f64 {
    let squares = pose.velocity_m_s.iter().map(|v| v * v);
    squares.sum::<f64>().sqrt()
}

/// Offsets tried to each side of one that is stated or found (s).
const ABOUT_S: f64 = 1.0;

/// The traces that count, and the offsets at which they may be.
struct Selected {
    traces: Vec<usize>,
    time_offset_s: f64,
    open_offsets_s: Vec<[f64; 2]>,
    at_rest: bool,
}

impl Selected {
    fn of(
        recording: &Recording,
        radargram: &Radargram,
        scene: &Scene,
        (warnings, control): (&mut Warnings, &Control<'_>),
    ) -> Result<Self, ClockError> {
        let flight = Flight {
            radar: &recording.radar.content,
            positions: &recording.positions,
            scene,
        };
        let options = for_calibration(&recording.options);
        let about = |offset_s: f64| vec![[offset_s - ABOUT_S, offset_s + ABOUT_S]];
        match align_clocks(flight, &options, warnings, control) {
            Ok(clocked) => Ok(Self {
                at_rest: is_at_rest(&clocked.aligned.position_m),
                traces: clocked.aligned.traces,
                time_offset_s: clocked.time_offset_s,
                open_offsets_s: about(clocked.time_offset_s),
            }),
            Err(ClockError::Offset(OffsetError::Undecided { cause })) => {
                // Where each trace was taken differs from offset to offset: all of them may count.
                let open = match cause {
                    Undecided::NoCue => overlapping(&recording.positions, &radargram.time_s),
                    _ => cause
                        .open_offsets()
                        .map(|open| (open.best_s, open.stretches_s)),
                };
                let (time_offset_s, open_offsets_s) =
                    open.ok_or(OffsetError::Undecided { cause })?;
                Ok(Self {
                    traces: (0..radargram.time_s.len()).collect(),
                    time_offset_s,
                    open_offsets_s,
                    at_rest: false,
                })
            }
            Err(ClockError::Align(AlignError::Select(SelectError::NeverMoves))) => {
                let mut options = recording.options.align.clone();
                options.select = Select::All;
                let time_offset_s = match options.time_offset.unwrap_or_default() {
                    TimeOffset::Seconds(offset_s) => offset_s,
                    TimeOffset::Auto | TimeOffset::Logged => 0.0,
                };
                let aligned = align(flight, &options, time_offset_s, warnings)?;
                Ok(Self {
                    traces: aligned.traces,
                    time_offset_s,
                    open_offsets_s: vec![[time_offset_s; 2]],
                    at_rest: true,
                })
            }
            Err(error) => Err(error),
        }
    }
}

/// Share of the radar log that has places at every offset tried, where nothing but the overlap limits the offsets.
const OVERLAP: f64 = 0.8;

/// The middle and the stretch of the offsets at which radar log and trajectory overlap; none of positions trace by
/// trace.
fn overlapping(positions: &Positions, time_s: &[f64]) -> Option<(f64, Vec<[f64; 2]>)> {
    let Positions::Trajectory(trajectory) = positions else {
        return None;
    };
    let (first_s, last_s) = (*time_s.first()?, *time_s.last()?);
    let beyond_s = (1.0 - OVERLAP) * (last_s - first_s);
    let ends_s = [trajectory.start_s() - first_s, trajectory.end_s() - last_s];
    let [from_s, to_s] = [ends_s[0].min(ends_s[1]), ends_s[0].max(ends_s[1])];
    let stretch_s = [from_s - beyond_s, to_s + beyond_s];
    Some((0.5 * (from_s + to_s), vec![stretch_s]))
}

/// Whether places are so close together that no echo changes its range by more than a pulse.
fn is_at_rest(position_m: &[[f64; 3]]) -> bool {
    const LONGEST_M: f64 = 0.1;
    let extent_m = |axis: usize| {
        let along = position_m.iter().map(|p| p[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    (0..3).all(|axis| extent_m(axis) < LONGEST_M)
}

fn check_band(band_hz: [f64; 2], radargram: &Radargram, track: &str) -> Result<(), CalibrateError> {
    let limit_hz = 0.5 / radargram.fast_time_step_s;
    if band_hz[1] < limit_hz {
        return Ok(());
    }
    Err(CalibrateError::Band {
        track: track.to_owned(),
        limit_ghz: limit_hz * 1e-9,
        found_ghz: band_hz.map(|f| f * 1e-9),
    })
}

/// The options of a track whose delay and traces the calibration itself judges.
fn for_calibration(stated: &TrackOptions) -> TrackOptions {
    let mut options = stated.clone();
    if options.clean.delay_ns == Some(Delay::Auto) {
        options.clean.delay_ns = None;
    }
    if options.align.select == Select::Auto {
        // Traces at rest would fill the background with the reflectors.
        options.align.select = Select::Moving;
    }
    options
}
