//! Estimation of the ground's height, where neither terrain nor origin nor the campaign gives the height.
//!
//! The surface echo ties the ground to the delay at which range is zero: raising the ground by Δz moves the
//! echo's expected time by −2Δz/c, and zero-timing follows. Along this line of pairs of height and delay,
//! echoes of targets have the right curvature only at the true ground, where the image is sharpest. Direct
//! coupling, where present, narrows the heights to a few decimetres.

use acerra_geo::trajectory::Trajectory;
use acerra_imaging::{ImagingError, PlaneGrid, TrialImage, TrialImages};
use acerra_radar::quality;
use acerra_radar::{Radargram, Spectrum};

use crate::align::delay::delayed;
use crate::align::offset::{OffsetError, SearchRange, by_height_and_motion};
use crate::align::recording::Recording;
use crate::align::{AlignError, AlignOptions, Flight, align};
use crate::choices::{Delay, TimeOffset};
use crate::clean::{CleanError, CleanOptions, clean};
use crate::control::{Cancelled, Control};
use crate::echoes::sharpen::{
    Sharpest, coarse, fourth_moment, log_fourth_moment, patches, sharpest,
};
use crate::echoes::{Searched, quick_look};
use crate::journal::warnings::Warnings;
use crate::position::Positions;
use crate::position::aligned::Aligned;
use crate::read::RadarContent;
use crate::scene::Scene;

/// Height of the ground found by the radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundFound {
    /// Height in the frame of the positions (m).
    pub z_m: f64,
    /// Standard deviation of the height (m).
    pub sigma_m: f64,
}

/// Reason for which the ground cannot be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GroundError {
    /// No echo follows the height.
    #[error(
        "[image] z_m: neither z_m, nor terrain, nor [trajectory] origin_deg_m gives the height of the \
         ground, and at no clock offset does a surface echo follow the flight's height (do the logs belong \
         together?); state one of them"
    )]
    NoSurface,
    /// Two heights are equally sharp, or none is sharp.
    #[error(
        "[image] z_m: neither z_m, nor terrain, nor [trajectory] origin_deg_m gives the height of the \
         ground; the image is as sharp on the ground at {first_m:.2} m as at {second_m:.2} m; state one of \
         them, or [radar] delay_ns, with which the surface echo gives the height"
    )]
    Ambiguous {
        /// The sharpest height (m).
        first_m: f64,
        /// The second sharpest height (m).
        second_m: f64,
    },
    /// The clock offset, which the comparison of heights needs, cannot be found.
    #[error(transparent)]
    Offset(#[from] OffsetError),
    /// No trace can be placed.
    #[error(transparent)]
    Align(#[from] AlignError),
    /// The traces cannot be cleaned.
    #[error(transparent)]
    Clean(#[from] CleanError),
    /// The images of the search cannot be made.
    #[error(transparent)]
    Imaging(#[from] ImagingError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Fast time of the direct coupling after fast time zero (s).
const COUPLING_S: f64 = 1.0e-9;
/// Standard deviation of this fast time (s).
const COUPLING_SIGMA_S: f64 = 1.0e-9;
/// Least level of the coupling above the rest of the mean trace (dB).
const COUPLING_CONTRAST_DB: f64 = 20.0;
/// Largest wander of the coupling (s).
const COUPLING_SPREAD_S: f64 = 0.1e-9;
/// Delays of an instrument without a calibration (s).
const DELAY_S: [f64; 2] = [-1e-9, 20e-9];
/// Pixels of the coarse images: 5 cm apart on 1000 m², as fine as the targets are narrow.
const PIXELS: f64 = 400_000.0;
/// Spacing of the heights of the coarse search (m).
const COARSE_STEP_M: f64 = 0.03;
/// Spacing of the heights of the fine search (m).
const FINE_STEP_M: f64 = 0.01;
/// Range of the fine search to either side of the coarse maximum (m).
const FINE_REACH_M: f64 = 0.1;
/// Heights nearer than this to the sharpest count as the same maximum (m).
const APART_M: f64 = 0.2;
/// Logarithm of the fourth moment by which the sharpest must surpass every other.
const LEAST_MARGIN: f64 = 0.3;

/// Finds the height of the ground under a recording whose scene states none.
///
/// # Errors
/// A radargram without a surface echo, heights that cannot be distinguished, cancellation.
pub fn find_ground(
    recording: &Recording,
    scene: &Scene,
    control: &Control<'_>,
) -> Result<GroundFound, GroundError> {
    let (RadarContent::Radargram(radargram), Positions::Trajectory(trajectory)) =
        (&recording.radar.content, &recording.positions)
    else {
        return Err(GroundError::NoSurface);
    };
    let guess_m = lowest_m(trajectory);
    let guessed = scene.on_ground(guess_m);
    let spread_s = 2.0 * (highest_m(trajectory) - guess_m) / scene.light_speed_m_s;
    let range = SearchRange {
        max_gap_s: recording.options.align.max_gap_s,
        delay_s: Some([-spread_s - 20e-9, spread_s + 20e-9]),
    };
    let likelihood = by_height_and_motion(radargram, trajectory, &guessed, range, control)?;
    let cue = likelihood.height.as_ref().ok_or(GroundError::NoSurface)?;
    let offset_s = match recording.options.align.time_offset.unwrap_or_default() {
        TimeOffset::Seconds(offset_s) => offset_s,
        TimeOffset::Auto | TimeOffset::Logged => likelihood
            .candidates
            .first()
            .map_or(cue.offset_s, |best| best.offset_s),
    };
    let [least_s, most_s] = delay_range_s(radargram, &recording.options.clean);
    // The echo is late by `cue.delay_s` over the guess; the true ground leaves the true delay.
    let height_m = |delay_s: f64| guess_m - 0.5 * scene.light_speed_m_s * (cue.delay_s - delay_s);
    let search = Search::new(
        recording,
        scene,
        [height_m(least_s), height_m(most_s)],
        offset_s,
    )?;
    search.run(control)
}

/// The height that the positions rarely fall below (m).
pub(crate) fn lowest_m(trajectory: &Trajectory) -> f64 {
    quantile_m(trajectory, 0.02)
}

/// The height that the positions rarely exceed (m).
pub(crate) fn highest_m(trajectory: &Trajectory) -> f64 {
    quantile_m(trajectory, 0.98)
}

fn quantile_m(trajectory: &Trajectory, share: f64) -> f64 {
    let mut z_m: Vec<f64> = trajectory.fixes().iter().map(|f| f.position_m[2]).collect();
    z_m.sort_by(f64::total_cmp);
    let last = z_m.len().saturating_sub(1) as f64;
    z_m.get((share * last) as usize).copied().unwrap_or(0.0)
}

/// Delays at which range may be zero: as stated, by the coupling, or any.
fn delay_range_s(radargram: &Radargram, options: &CleanOptions) -> [f64; 2] {
    if let Some(delay_ns) = options.delay_ns.and_then(Delay::given_ns) {
        return [1e-9 * delay_ns - 0.3e-9, 1e-9 * delay_ns + 0.3e-9];
    }
    let seen = quality::coupling(radargram).filter(|seen| {
        seen.contrast_db >= COUPLING_CONTRAST_DB && seen.spread_s <= COUPLING_SPREAD_S
    });
    match seen {
        Some(seen) => {
            let middle_s = seen.fast_time_s - COUPLING_S;
            [-3.0, 3.0].map(|k| middle_s + k * COUPLING_SIGMA_S)
        }
        None => DELAY_S,
    }
}

/// Search over heights, on traces cleaned at one of the heights.
struct Search {
    aligned: Aligned,
    spectrum: Spectrum,
    grid: PlaneGrid,
    z_m: [f64; 2],
    light_speed_m_s: f64,
}

impl Search {
    fn new(
        recording: &Recording,
        scene: &Scene,
        z_m: [f64; 2],
        offset_s: f64,
    ) -> Result<Self, GroundError> {
        let middle = scene.on_ground(0.5 * (z_m[0] + z_m[1]));
        let discarded = &mut Warnings::default();
        let flight = Flight {
            radar: &recording.radar.content,
            positions: &recording.positions,
            scene: &middle,
        };
        let options = AlignOptions {
            time_offset: Some(TimeOffset::Seconds(offset_s)),
            ..recording.options.align.clone()
        };
        let aligned = align(flight, &options, offset_s, discarded)?;
        let cleaned = clean(
            flight.radar,
            &aligned,
            &middle,
            &recording.options.clean,
            discarded,
        )?;
        let fine = scene.around(&aligned.position_m, middle.pixels.grid.z_m)?;
        let grid = coarse(fine, PIXELS)?;
        Ok(Self {
            aligned,
            spectrum: cleaned.spectrum,
            grid,
            z_m,
            light_speed_m_s: scene.light_speed_m_s,
        })
    }

    /// The sharpest height: a coarse search on the whole image, then a fine one on the image's strongest
    /// echoes.
    fn run(&self, control: &Control<'_>) -> Result<GroundFound, GroundError> {
        let count = ((self.z_m[1] - self.z_m[0]) / COARSE_STEP_M)
            .ceil()
            .max(2.0);
        let tried_m: Vec<f64> = (0..=count as usize)
            .map(|k| self.z_m[0] + k as f64 * COARSE_STEP_M)
            .collect();
        control.start("ground", tried_m.len() as u64);
        let mut score = Vec::new();
        for (k, z_m) in tried_m.iter().enumerate() {
            control.check()?;
            score.push(self.score(*z_m)?);
            control.at(k as u64 + 1);
        }
        control.finish();
        let best = (0..score.len())
            .max_by(|a, b| score[*a].total_cmp(&score[*b]))
            .unwrap_or_default();
        self.refuse_rivals(&tried_m, &score, best)?;
        let found = self.refine(tried_m[best], control)?;
        Ok(match found {
            Some(found) => GroundFound {
                z_m: found.value,
                sigma_m: found.sigma,
            },
            None => GroundFound {
                z_m: tried_m[best],
                sigma_m: COARSE_STEP_M,
            },
        })
    }

    fn refuse_rivals(
        &self,
        tried_m: &[f64],
        score: &[f64],
        best: usize,
    ) -> Result<(), GroundError> {
        let rival = (0..score.len())
            .filter(|k| (tried_m[*k] - tried_m[best]).abs() > APART_M)
            .max_by(|a, b| score[*a].total_cmp(&score[*b]));
        match rival {
            Some(rival) if score[best] - score[rival] < LEAST_MARGIN => {
                Err(GroundError::Ambiguous {
                    first_m: tried_m[best],
                    second_m: tried_m[rival],
                })
            }
            _ => Ok(()),
        }
    }

    /// Logarithm of the fourth moment of the image on the plane at `z_m`, about its strongest maxima: on the
    /// coarse pixels of the search for maxima, missing a lobe's top costs as much as a wrong height.
    fn score(&self, z_m: f64) -> Result<f64, GroundError> {
        let spectrum = self.spectrum_on(z_m);
        let grid = PlaneGrid { z_m, ..self.grid };
        let places = &self.aligned.position_m;
        let mut moment = 0.0;
        for patch in patches(places, &spectrum, grid, self.light_speed_m_s)? {
            let image = quick_look(places, &spectrum, patch, self.light_speed_m_s)?;
            moment += fourth_moment(&image);
        }
        Ok(moment.max(f64::MIN_POSITIVE).ln())
    }

    fn refine(&self, about_m: f64, control: &Control<'_>) -> Result<Option<Sharpest>, GroundError> {
        let spectrum = self.spectrum_on(about_m);
        let grid = PlaneGrid {
            z_m: about_m,
            ..self.grid
        };
        let places = &self.aligned.position_m;
        let patches = patches(places, &spectrum, grid, self.light_speed_m_s)?;
        let steps = (FINE_REACH_M / FINE_STEP_M).round() as i32;
        let tried_m: Vec<f64> = (-steps..=steps)
            .map(|k| about_m + f64::from(k) * FINE_STEP_M)
            .collect();
        let searched = Searched::new(places, &spectrum, self.light_speed_m_s);
        // Zero-timing moves the ranges as far as the plane moves.
        let looks: Vec<TrialImages> = (patches.iter())
            .map(|patch| searched.looks(*patch, 2.0 * FINE_REACH_M))
            .collect::<Result<_, _>>()?;
        let mut scores = Vec::new();
        for z_m in &tried_m {
            control.check()?;
            let of_patch = |(patch, looks): (&PlaneGrid, &TrialImages)| {
                let image = looks.image(&TrialImage {
                    position_m: places,
                    beyond_m: z_m - about_m,
                    grid: PlaneGrid {
                        z_m: *z_m,
                        ..*patch
                    },
                })?;
                Ok::<_, ImagingError>(log_fourth_moment(&image))
            };
            scores.push(
                patches
                    .iter()
                    .zip(&looks)
                    .map(of_patch)
                    .collect::<Result<Vec<_>, _>>()?,
            );
        }
        Ok(sharpest(&tried_m, &scores))
    }

    /// The spectra after zero-timing with the ground at `z_m`.
    fn spectrum_on(&self, z_m: f64) -> Spectrum {
        let earlier_s = 2.0 * (z_m - self.grid.z_m) / self.light_speed_m_s;
        delayed(&self.spectrum, -earlier_s)
    }
}
