//! The delay at which the strongest echoes are strongest, combined with the delays by surface echo and
//! coupling.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};

use acerra_imaging::PlaneGrid;
use acerra_radar::Spectrum;

use super::cues::DelayCue;
use super::curve::{DelayCurve, MOST_SIGMA_S, decide, max_of, second_best};
use super::echo_power::StrongestEcho;
use super::error::DelayError;
use super::scan::DelayScan;
use super::sensitivity::{Seen, Sensitivity};
use super::targets::REACH_S;
use super::view::{View, middle_hz};
use crate::choices::{Delay, Gate, ZeroTiming};
use crate::clean::{CleanOptions, clean};
use crate::control::Control;
use crate::echoes::history::Measured;
use crate::echoes::window::{Budget, strongest_m};
use crate::journal::warnings::Warnings;
use crate::position::aligned::Aligned;
use crate::read::RadarContent;
use crate::scene::Scene;

/// A delay found from the data, with its evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayFound {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Standard deviation of the delay (s).
    pub sigma_s: f64,
    /// The most likely delay of another maximum (s), and the difference of the log-likelihoods.
    pub second: Option<(f64, f64)>,
    /// The delay by the echo that follows the height, where one does.
    pub surface: Option<DelayCue>,
    /// The delay by the direct coupling, where the window contains it.
    pub coupling: Option<DelayCue>,
    /// Sharpness and cues together.
    pub curve: DelayCurve,
}

/// Traces at their places, whose delay is estimated.
#[derive(Clone, Copy, Debug)]
pub struct DelayTrial<'a> {
    /// The radar log.
    pub radar: &'a RadarContent,
    /// The traces with their positions.
    pub aligned: &'a Aligned,
    /// The scene below the flight.
    pub scene: &'a Scene,
    /// Options of the cleaning.
    pub clean: &'a CleanOptions,
    /// The delay by the echo that follows the height, where one does.
    pub surface: Option<DelayCue>,
    /// The delay by the direct coupling, where the window contains it.
    pub coupling: Option<DelayCue>,
}

/// Delays of an instrument without a calibration (s).
const TRIED_S: [f64; 2] = [-1e-9, 20e-9];
/// Spacing of the delays tried: ranges 2 cm apart, a quarter of a wavelength in two-way phase at 45°
/// from closest approach.
const STEP_S: f64 = 0.15e-9;
/// Largest change of the delay for which cleaned traces are used again, as the gate moves with the delay (s).
const BLOCK_S: f64 = 3e-9;
/// Contributions of traces to pixels in one image.
const CONTRIBUTIONS: f64 = 1e8;
/// Least and largest number of pixels of an image.
const PIXELS: [f64; 2] = [20_000.0, 250_000.0];
/// Variance of the echoes' phases by errors of positions, antenna and ground (a loss of one decibel of the
/// coherent sum), and the number of independent errors over an aperture, as errors of positions last for
/// seconds. A wrong delay that bends the phases by a variance v takes v from the logarithm of the sum's
/// power; the errors explain v with a log-likelihood of -v INDEPENDENT / (2 PHASE_VARIANCE).
pub(super) const PHASE_VARIANCE: f64 = 0.23;
pub(super) const INDEPENDENT: f64 = 5.0;

/// Finds the delay of traces at their places.
///
/// # Errors
/// Two delays that agree with the data, or all; positions too uncertain; traces that cannot be cleaned; cancellation.
pub fn find_delay(trial: DelayTrial<'_>, control: &Control<'_>) -> Result<DelayFound, DelayError> {
    let RadarContent::Radargram(_) = trial.radar else {
        return Err(DelayError::Spectra);
    };
    if !trial.view()?.determines_delay() {
        return Err(DelayError::Vague {
            from_ns: 1e9 * TRIED_S[0],
            to_ns: 1e9 * TRIED_S[1],
        });
    }
    let tried = trial.scan(control)?;
    let curve = trial.weighed(&tried);
    let best = decide(&curve)?;
    let second = second_best(&curve, best.index);
    // Single targets give a more precise delay, but no more precise than errors of positions allow.
    let fine_s = trial.on_single_targets(best.delay_s, control)?;
    let is_within = |fine_s: &f64| (fine_s - best.delay_s).abs() <= 2.0 * best.sigma_s;
    let delay_s = fine_s.filter(is_within).unwrap_or(best.delay_s);
    let (at_s, echo) = tried[best.index];
    let sigma_s = best.sigma_s.hypot(trial.by_positions_s(at_s, echo)?);
    if sigma_s > MOST_SIGMA_S {
        return Err(DelayError::Uncertain {
            sigma_ns: 1e9 * sigma_s,
            most_ns: 1e9 * MOST_SIGMA_S,
        });
    }
    Ok(DelayFound {
        delay_s,
        sigma_s,
        second,
        surface: trial.surface,
        coupling: trial.coupling,
        curve,
    })
}

impl DelayTrial<'_> {
    /// View of the image from the traces.
    fn view(&self) -> Result<View<'_>, DelayError> {
        Ok(View {
            position_m: &self.aligned.position_m,
            grid: self.whole()?,
            middle_hz: middle_hz(&self.clean.frequency_hz),
            light_speed_m_s: self.scene.light_speed_m_s,
        })
    }

    /// The image's rectangle at the middle of its heights.
    pub(crate) fn whole(&self) -> Result<PlaneGrid, DelayError> {
        let middle_m = self.scene.pixels.middle_m();
        Ok(self.scene.around(&self.aligned.position_m, middle_m)?)
    }

    /// Number of pixels for a search over this many traces.
    fn budget(&self) -> Budget {
        let traces = self.aligned.position_m.len().max(1) as f64;
        let pixels = (CONTRIBUTIONS / traces).clamp(PIXELS[0], PIXELS[1]);
        let middle_hz = middle_hz(&self.clean.frequency_hz);
        Budget::new(pixels, middle_hz, self.scene.light_speed_m_s)
    }

    /// The scan of cleaned traces on the pixels `grid`.
    pub(super) fn on<'s>(&'s self, spectrum: &'s Spectrum, grid: PlaneGrid) -> DelayScan<'s> {
        DelayScan {
            position_m: &self.aligned.position_m,
            spectrum,
            grid,
            light_speed_m_s: self.scene.light_speed_m_s,
        }
    }

    /// Sensitivity of the delay to errors of the ranges of the strongest echo.
    fn sensitivity(
        &self,
        delay_s: f64,
        place_m: [f64; 3],
    ) -> Result<Option<Sensitivity>, DelayError> {
        let spectrum = self.cleaned_at(delay_s, REACH_S)?;
        let (position_m, speed_m_s) = (&self.aligned.position_m, self.scene.light_speed_m_s);
        let traces = 0..position_m.len();
        let Some(measured) = Measured::part(position_m, &spectrum, traces, speed_m_s) else {
            return Ok(None);
        };
        let history = measured.history(place_m);
        let amplitude: Vec<f64> = history.iter().map(|h| h.norm()).collect();
        Ok(Sensitivity::of(Seen {
            time_s: &self.aligned.time_s,
            position_m,
            amplitude: &amplitude,
            place_m,
            wavenumber_rad_m: wavenumbers_rad_m(&spectrum.frequency_hz, speed_m_s),
        }))
    }

    /// Standard deviation (s) of the delay at which an echo is strongest, from the stated errors of the
    /// positions: common errors of all traces, and varying ones.
    fn by_positions_s(&self, delay_s: f64, echo: StrongestEcho) -> Result<f64, DelayError> {
        let stated_m = &self.aligned.sigma_m;
        let Some([x_m, y_m]) = echo.place_m.filter(|_| !stated_m.is_empty()) else {
            return Ok(0.0);
        };
        let place_m = [x_m, y_m, self.scene.pixels.middle_m()];
        let sensitivity = self.sensitivity(delay_s, place_m)?;
        let deviation_m = sensitivity.map_or(0.0, |s| s.deviation_m(stated_m));
        Ok(2.0 * deviation_m / self.scene.light_speed_m_s)
    }

    /// The strongest echo at every delay tried (s).
    fn scan(&self, control: &Control<'_>) -> Result<Vec<(f64, StrongestEcho)>, DelayError> {
        let block_s = match self.clean.gate_ns.about_ns() {
            Some(_) => BLOCK_S,
            None => TRIED_S[1] - TRIED_S[0],
        };
        let blocks = ((TRIED_S[1] - TRIED_S[0]) / block_s).round() as usize;
        let each = (block_s / STEP_S).round() as usize;
        let starts_s = (0..blocks).map(|block| TRIED_S[0] + block as f64 * block_s);
        // Echoes move over the image with the delay: the echoes of every block count.
        let grid = self.budget().window(self.whole()?, |whole| {
            let mut maxima_m = Vec::new();
            for from_s in starts_s.clone() {
                control.check()?;
                let spectrum = self.cleaned_at(from_s + 0.5 * block_s, 0.5 * block_s)?;
                maxima_m.extend(self.on(&spectrum, whole).strongest_m()?);
            }
            Ok::<_, DelayError>(maxima_m)
        })?;
        control.start("delay", (blocks * each) as u64);
        let mut tried: Vec<(f64, StrongestEcho)> = Vec::new();
        let done = AtomicU64::new(0);
        for from_s in starts_s {
            let middle_s = from_s + 0.5 * block_s;
            let spectrum = self.cleaned_at(middle_s, 0.5 * block_s)?;
            let delays_s: Vec<f64> = (0..each)
                .map(|k| from_s + (k as f64 + 0.5) * STEP_S)
                .collect();
            let later_s: Vec<f64> = delays_s.iter().map(|d| d - middle_s).collect();
            let echoes = self.on(&spectrum, grid).strongest_at(&later_s, || {
                control.check()?;
                control.at(done.fetch_add(1, Ordering::Relaxed) + 1);
                Ok(())
            })?;
            tried.extend(delays_s.into_iter().zip(echoes));
        }
        control.finish();
        Ok(tried)
    }

    /// The horizontal path that each trace covers, in units of the mean path: on a climb the ground straight
    /// below adds up under a single angle, which determines the delay no better than the surface echo does.
    pub(super) fn weights(&self) -> Vec<f64> {
        let level = |p: &[f64; 3]| [p[0], p[1], 0.0];
        let level_m: Vec<[f64; 3]> = self.aligned.position_m.iter().map(level).collect();
        let path_m = self.aligned.path_along_lines_m(&level_m);
        let mean_m = path_m.iter().sum::<f64>() / path_m.len().max(1) as f64;
        let of_mean = |m: &f64| if mean_m > 0.0 { m / mean_m } else { 1.0 };
        path_m.iter().map(of_mean).collect()
    }

    /// The clean spectra with range zero at a delay, weighted by the path, gated for delays within `reach_s`
    /// of that delay.
    pub(super) fn cleaned_at(&self, delay_s: f64, reach_s: f64) -> Result<Spectrum, DelayError> {
        let gate_ns = match self.clean.gate_ns.about_ns() {
            Some([from, to]) => Gate::About([from - 1e9 * reach_s, to + 1e9 * reach_s]),
            None => Gate::None,
        };
        let options = CleanOptions {
            delay_ns: Some(Delay::Nanoseconds(1e9 * delay_s)),
            zero_timing: ZeroTiming::None,
            gate_ns,
            ..self.clean.clone()
        };
        let discarded = &mut Warnings::default();
        let mut spectrum =
            clean(self.radar, self.aligned, self.scene, &options, discarded)?.spectrum;
        let width = spectrum.frequency_hz.len().max(1);
        for (trace, weight) in spectrum.values.chunks_mut(width).zip(self.weights()) {
            trace.iter_mut().for_each(|v| *v *= weight);
        }
        Ok(spectrum)
    }

    /// Log-likelihood of every delay tried, from strongest echo, surface echo and coupling, 0 at best.
    fn weighed(&self, tried: &[(f64, StrongestEcho)]) -> DelayCurve {
        let cues = [self.surface, self.coupling];
        let log_likelihood = |(delay_s, echo): &(f64, StrongestEcho)| {
            let by_cues = cues
                .iter()
                .flatten()
                .map(|cue| cue.log_likelihood(*delay_s));
            INDEPENDENT / (2.0 * PHASE_VARIANCE) * echo.log_power + by_cues.sum::<f64>()
        };
        let mut curve = DelayCurve {
            delay_s: tried.iter().map(|(delay_s, _)| *delay_s).collect(),
            log_likelihood: tried.iter().map(log_likelihood).collect(),
        };
        let best = max_of(&curve.log_likelihood);
        curve.log_likelihood.iter_mut().for_each(|v| *v -= best);
        curve
    }

    /// The delay at which the strongest echoes are sharpest, each on a separate patch (s).
    fn on_single_targets(
        &self,
        about_s: f64,
        control: &Control<'_>,
    ) -> Result<Option<f64>, DelayError> {
        let spectrum = self.cleaned_at(about_s, REACH_S)?;
        let look = |whole| self.on(&spectrum, whole).strongest_m();
        let grid = self.budget().window(self.whole()?, look)?;
        let found = self.on(&spectrum, grid).sharpest_targets(control)?;
        Ok(found.map(|f| about_s + f.value))
    }
}

/// Mean and standard deviation of a band's wavenumbers (rad/m).
fn wavenumbers_rad_m(frequency_hz: &[f64], light_speed_m_s: f64) -> [f64; 2] {
    let count = frequency_hz.len().max(1) as f64;
    let mean_hz = frequency_hz.iter().sum::<f64>() / count;
    let squares: f64 = frequency_hz.iter().map(|f| (f - mean_hz).powi(2)).sum();
    [mean_hz, (squares / count).sqrt()].map(|hz| TAU * hz / light_speed_m_s)
}

impl DelayScan<'_> {
    /// Places (x, y) of the strongest echoes (m).
    pub(super) fn strongest_m(&self) -> Result<Vec<[f64; 2]>, DelayError> {
        let (position_m, speed_m_s) = (self.position_m, self.light_speed_m_s);
        Ok(strongest_m(
            position_m,
            self.spectrum,
            self.grid,
            speed_m_s,
        )?)
    }
}
