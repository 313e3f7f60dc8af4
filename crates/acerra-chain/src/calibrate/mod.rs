//! Calibration of the instrument on reflectors at known places: delay, clock offset, lever arm and
//! range scale, estimated jointly from one or more flights or from a radar at rest.
//!
//! 1. Range profiles are matched to the band of the pulse (`echo`).
//! 2. Delay and offset at which the reflectors are in focus (`focus`) are where to start (`search`), among the delays
//!    that the direct coupling allows (`coupling`).
//! 3. In each trace the crest near the predicted range is an observation (`track`); where single traces do
//!    not show the reflectors, in each coherent sum of some (`stretch_echoes`).
//! 4. Gauss-Newton estimates the unknowns (`adjust`) together with the positions' slow errors (`drift`) and
//!    the errors of the survey. The noise comes from the residuals; outliers are left out.
//! 5. Unknowns that the geometry does not determine are held at the campaign's value and named (`observe`);
//!    an undetermined delay is held at the delay at which the reflectors are in focus.
//!
//! An error of height common to a whole track acts as a lever arm up, and below the track as a delay:
//! no echo separates them. Its deviation, as the trajectory states it, is part of theirs.

mod adjust;
mod coupling;
mod drift;
mod echo;
mod error;
mod focus;
mod knots;
mod model;
mod observe;
mod parameter;
mod path;
mod points;
mod rest;
mod result;
mod rounds;
mod search;
mod stretch_echoes;
mod surface;
mod track;

use rounds::{Survey, WINDOWS_S};
use track::{Setting, TrackEchoes};

use crate::align::recording::Recording;
use crate::control::Control;
use crate::journal::warnings::Warnings;
use crate::scene::Scene;

pub use error::{CalibrateError, Solution};
pub use observe::SingularDirection;
pub use parameter::{Parameter, Values};
pub use points::{PointsError, SurveyedPoint, read_points};
pub use rest::{AtRest, RestDelay, delay_at_rest};
pub use result::{Calibrated, EchoResidual, Estimate, ReflectorFit, Sensitivity};

/// Prior knowledge of the unknowns.
#[derive(Clone, Debug)]
pub struct CalibrateOptions {
    /// Places of the reflectors' phase centres, east, north, up in the frame of the positions (m).
    pub reflector_m: Vec<[f64; 3]>,
    /// Standard deviation of each coordinate of a reflector's surveyed place (m).
    pub survey_sigma_m: f64,
    /// Lever arm of the campaign: forward, left, up (m). The recordings' positions are those of the
    /// positioned point, without the lever arm.
    pub lever_arm_m: [f64; 3],
    /// Delay of the campaign, for comparison with the estimate (s).
    pub delay_s: f64,
    /// Band of the pulse (Hz).
    pub band_hz: [f64; 2],
    /// Correlation time of the positions' errors (s).
    pub position_correlation_s: f64,
}

impl CalibrateOptions {
    /// A prior without settings: a survey to 2 cm, no lever arm, the band of the P440, and errors of carrier-phase
    /// positions that last for 10 s.
    #[must_use]
    pub fn on(reflector_m: Vec<[f64; 3]>) -> Self {
        Self {
            reflector_m,
            survey_sigma_m: 0.02,
            lever_arm_m: [0.0; 3],
            delay_s: 0.0,
            band_hz: [3.1e9, 4.8e9],
            position_correlation_s: 10.0,
        }
    }
}

/// Calibrates on reflectors at known places.
///
/// # Errors
/// Data that do not show the reflectors or leave two solutions, cancellation.
pub fn calibrate(
    recordings: &[Recording],
    scene: &Scene,
    options: &CalibrateOptions,
    warnings: &mut Warnings,
    control: &Control<'_>,
) -> Result<Calibrated, CalibrateError> {
    if options.reflector_m.is_empty() {
        return Err(CalibrateError::NoReflector);
    }
    let setting = Setting {
        reflector_m: &options.reflector_m,
        survey_sigma_m: options.survey_sigma_m,
        light_speed_m_s: scene.light_speed_m_s,
        band_hz: options.band_hz,
        scene,
    };
    let tracks = recordings
        .iter()
        .map(|recording| TrackEchoes::of(recording, scene, &setting, warnings, control))
        .collect::<Result<Vec<_>, _>>()?;
    let campaign = Values {
        delay_s: options.delay_s,
        range_scale: 0.0,
        lever_arm_m: options.lever_arm_m,
        time_offset_s: tracks.iter().map(|track| track.time_offset_s).collect(),
    };
    let mut survey = Survey {
        setting,
        tracks: &tracks,
        campaign: &campaign,
        correlation_s: options.position_correlation_s,
        summed: Vec::new(),
    };
    let mut round = survey.start(control)?;
    for half_width_s in WINDOWS_S {
        control.check()?;
        round = survey.round(&round.adjusted.values, half_width_s, false)?;
    }
    let found = &round.adjusted.values;
    for (track, offset_s) in tracks.iter().zip(&found.time_offset_s) {
        let possible_s = track.possible_delays_s();
        if !(possible_s[0]..=possible_s[1]).contains(&found.delay_s) {
            return Err(CalibrateError::Impossible {
                solutions: vec![Solution {
                    delay_ns: found.delay_s * 1e9,
                    offset_s: *offset_s,
                    below_db: 0.0,
                }],
                possible_ns: possible_s.map(|delay_s| delay_s * 1e9),
            });
        }
    }
    if !round.knows_position_errors {
        warnings.add(
            "not all positions state their standard deviations: the stated deviations do not include errors \
             of the positions",
        );
    }
    let calibrated = Calibrated::of(&survey, round);
    calibrated.doubts(warnings);
    surface::compare(&survey, &calibrated, scene, warnings);
    Ok(calibrated)
}
