//! The delay at which the image is sharpest, weighed with what the echoes themselves say.

use acerra_imaging::PlaneGrid;
use acerra_radar::Spectrum;

use super::cues::DelayCue;
use super::error::DelayError;
use super::scan::{DelayScan, ScanPoint, delayed};
use crate::align::Aligned;
use crate::choices::{Delay, Gate, ZeroTiming};
use crate::clean::{CleanOptions, clean};
use crate::control::Control;
use crate::ground::Scene;
use crate::read::RadarContent;
use crate::sharpen::{Sharpest, coarse, log_fourth_moment, patches, sharpest};
use crate::warnings::Warnings;

/// Log-likelihood over delays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DelayCurve {
    /// Delays (s), rising.
    pub delay_s: Vec<f64>,
    /// Log-likelihoods, 0 at best.
    pub log_likelihood: Vec<f64>,
}

/// How a delay was found.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayFound {
    /// Fast time at which range is zero (s).
    pub delay_s: f64,
    /// Its standard deviation (s).
    pub sigma_s: f64,
    /// The most likely delay that is not of the same maximum (s), and the log-likelihood by which it
    /// is surpassed.
    pub second: Option<(f64, f64)>,
    /// The delay by the echo that follows the height, where one does.
    pub surface: Option<DelayCue>,
    /// The delay by the direct coupling, where it is seen.
    pub coupling: Option<DelayCue>,
    /// Sharpness and cues together.
    pub curve: DelayCurve,
}

/// Traces at their places, whose delay is wanted.
#[derive(Clone, Copy, Debug)]
pub struct DelayTrial<'a> {
    /// The radar log.
    pub radar: &'a RadarContent,
    /// Its traces at their places.
    pub aligned: &'a Aligned,
    /// What was flown over.
    pub scene: &'a Scene,
    /// How the traces are cleaned.
    pub clean: &'a CleanOptions,
    /// The delay by the echo that follows the height, where one does.
    pub surface: Option<DelayCue>,
    /// The delay by the direct coupling, where it is seen.
    pub coupling: Option<DelayCue>,
}

/// Delays of an instrument without a calibration (s).
const TRIED_S: [f64; 2] = [-1e-9, 20e-9];
/// Spacing of the delays tried: ranges 2 cm apart, a quarter of a wavelength in two-way phase at 45°
/// from closest approach.
const STEP_S: f64 = 0.15e-9;
/// Traces are cleaned anew so often, as the gate moves with the delay (s).
const BLOCK_S: f64 = 3e-9;
/// Contributions of traces to pixels in one image, and its pixels at most and at least.
const CONTRIBUTIONS: f64 = 1e8;
const PIXELS: [f64; 2] = [20_000.0, 150_000.0];
/// Standard deviation of a log contrast by errors of positions and antenna, beside the clutter's: a
/// tenth.
const MODEL_SIGMA: f64 = 0.1;
/// Log-likelihood by which the best delay must surpass every other (odds of 400 to 1).
const MARGIN: f64 = 6.0;
/// Widest stretch of delays within the margin that counts as one (s): 30 cm of range.
const WIDEST_S: f64 = 2e-9;
/// Spacing of the delays tried on single targets, and how far about the best (s).
const FINE_STEP_S: f64 = 0.05e-9;
const FINE_REACH_S: f64 = 0.6e-9;

/// Finds the delay of traces at their places.
///
/// # Errors
/// Two delays that agree with the data, or all; traces that cannot be cleaned; cancellation.
pub fn find_delay(trial: DelayTrial<'_>, control: &Control<'_>) -> Result<DelayFound, DelayError> {
    let RadarContent::Radargram(_) = trial.radar else {
        return Err(DelayError::Spectra);
    };
    if !trial.view()?.tells_delay() {
        return Err(DelayError::Vague {
            from_ns: 1e9 * TRIED_S[0],
            to_ns: 1e9 * TRIED_S[1],
        });
    }
    let points = trial.scan(control)?;
    let curve = trial.weighed(&points);
    let best = decide(&curve)?;
    let second = second_best(&curve, best.index);
    // Contrast also changes as echoes move over the image: single targets must be sharp there.
    let fine = trial.on_single_targets(curve.delay_s[best.index], control)?;
    let fine = fine.ok_or(DelayError::Vague {
        from_ns: 1e9 * (curve.delay_s[best.index] - FINE_REACH_S),
        to_ns: 1e9 * (curve.delay_s[best.index] + FINE_REACH_S),
    })?;
    Ok(DelayFound {
        delay_s: fine.value,
        sigma_s: fine.sigma,
        second,
        surface: trial.surface,
        coupling: trial.coupling,
        curve,
    })
}

impl DelayTrial<'_> {
    /// The image as its traces see it.
    fn view(&self) -> Result<View<'_>, DelayError> {
        let frequency_hz = &self.clean.frequency_hz;
        Ok(View {
            position_m: &self.aligned.position_m,
            grid: search_grid(self.scene, &self.aligned.position_m)?,
            middle_hz: 0.5
                * (frequency_hz.first().unwrap_or(&0.0) + frequency_hz.last().unwrap_or(&0.0)),
            light_speed_m_s: self.scene.light_speed_m_s,
        })
    }

    /// Sharpness at every delay tried; `later_s` is the delay itself.
    fn scan(&self, control: &Control<'_>) -> Result<Vec<ScanPoint>, DelayError> {
        let grid = search_grid(self.scene, &self.aligned.position_m)?;
        let block_s = match self.clean.gate_ns.about_ns() {
            Some(_) => BLOCK_S,
            None => TRIED_S[1] - TRIED_S[0],
        };
        let blocks = ((TRIED_S[1] - TRIED_S[0]) / block_s).round() as usize;
        let each = (block_s / STEP_S).round() as usize;
        control.start("delay", (blocks * each) as u64);
        let mut points = Vec::new();
        for block in 0..blocks {
            let from_s = TRIED_S[0] + block as f64 * block_s;
            let middle_s = from_s + 0.5 * block_s;
            let spectrum = self.cleaned_at(middle_s, 0.5 * block_s)?;
            let scan = DelayScan {
                position_m: &self.aligned.position_m,
                spectrum: &spectrum,
                grid,
                light_speed_m_s: self.scene.light_speed_m_s,
            };
            for k in 0..each {
                control.check()?;
                let delay_s = from_s + (k as f64 + 0.5) * STEP_S;
                points.push(ScanPoint {
                    later_s: delay_s,
                    ..scan.at(delay_s - middle_s)?
                });
                control.at(points.len() as u64);
            }
        }
        control.finish();
        Ok(points)
    }

    /// The clean spectra with range zero at a delay, gated for delays as far from it as `reach_s`.
    fn cleaned_at(&self, delay_s: f64, reach_s: f64) -> Result<Spectrum, DelayError> {
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
        let unsaid = &mut Warnings::default();
        Ok(clean(self.radar, self.aligned, &options, unsaid)?.spectrum)
    }

    /// Sharpness as a log-likelihood, with what the echoes themselves say.
    fn weighed(&self, points: &[ScanPoint]) -> DelayCurve {
        let mut curve = likelihood_of(points);
        for (delay_s, value) in curve.delay_s.iter().zip(&mut curve.log_likelihood) {
            for cue in [self.surface, self.coupling].into_iter().flatten() {
                *value += cue.log_likelihood(*delay_s);
            }
        }
        let best = max_of(&curve.log_likelihood);
        curve.log_likelihood.iter_mut().for_each(|v| *v -= best);
        curve
    }

    /// The delay by each of the strongest echoes alone: one independent answer each.
    fn on_single_targets(
        &self,
        about_s: f64,
        control: &Control<'_>,
    ) -> Result<Option<Sharpest>, DelayError> {
        let spectrum = self.cleaned_at(about_s, FINE_REACH_S)?;
        let scan = DelayScan {
            position_m: &self.aligned.position_m,
            spectrum: &spectrum,
            grid: search_grid(self.scene, &self.aligned.position_m)?,
            light_speed_m_s: self.scene.light_speed_m_s,
        };
        let found = scan.sharpest_target(FINE_REACH_S, control)?;
        Ok(found.map(|f| Sharpest {
            value: about_s + f.value,
            ..f
        }))
    }
}

/// An image as its traces see it.
#[derive(Clone, Copy, Debug)]
struct View<'a> {
    position_m: &'a [[f64; 3]],
    grid: PlaneGrid,
    middle_hz: f64,
    light_speed_m_s: f64,
}

impl View<'_> {
    /// Whether some pixel is seen under angles so different that a delay off by half of
    /// [`WIDEST_S`] costs it focus: ranges ΔR too long bend its echoes by ΔR(1 − R₀/R₁) from the
    /// nearest range R₀ to the farthest R₁, and λ/8 of that is a quarter of a turn.
    fn tells_delay(&self) -> bool {
        let wavelength_m = self.light_speed_m_s / self.middle_hz;
        let error_m = 0.25 * self.light_speed_m_s * WIDEST_S;
        let along = |count: usize| (0..=8).map(move |k| count.saturating_sub(1) * k / 8);
        along(self.grid.ny)
            .flat_map(|iy| along(self.grid.nx).map(move |ix| [ix, iy]))
            .any(|[ix, iy]| {
                let pixel = [self.grid.x_m(ix), self.grid.y_m(iy), self.grid.z_m];
                let range_m = |p: &[f64; 3]| {
                    let square: f64 = (0..3).map(|i| (p[i] - pixel[i]).powi(2)).sum();
                    square.sqrt()
                };
                let ranges = self.position_m.iter().map(range_m);
                let (near, far) = ranges
                    .fold((f64::INFINITY, 0.0), |(near, far): (f64, f64), r| {
                        (near.min(r), far.max(r))
                    });
                far > 0.0 && error_m * (1.0 - near / far) >= wavelength_m / 8.0
            })
    }
}

impl DelayScan<'_> {
    /// Mean log contrast of the strongest targets, each on a patch of its own.
    fn target_contrast(&self) -> Result<f64, DelayError> {
        let (position_m, speed_m_s) = (self.position_m, self.light_speed_m_s);
        let patches = patches(position_m, self.spectrum, self.grid, speed_m_s)?;
        let each = patches.iter().map(|patch| self.at_patch(*patch));
        let scores = each.collect::<Result<Vec<f64>, DelayError>>()?;
        Ok(scores.iter().sum::<f64>() / scores.len().max(1) as f64)
    }

    fn at_patch(&self, grid: PlaneGrid) -> Result<f64, DelayError> {
        Ok(Self { grid, ..*self }.at(0.0)?.log_contrast)
    }

    fn view(&self) -> View<'_> {
        let frequency_hz = &self.spectrum.frequency_hz;
        View {
            position_m: self.position_m,
            grid: self.grid,
            middle_hz: 0.5
                * (frequency_hz.first().unwrap_or(&0.0) + frequency_hz.last().unwrap_or(&0.0)),
            light_speed_m_s: self.light_speed_m_s,
        }
    }

    /// The delay beyond that of the spectra at which the strongest echoes are sharpest.
    fn sharpest_target(
        &self,
        reach_s: f64,
        control: &Control<'_>,
    ) -> Result<Option<Sharpest>, DelayError> {
        let (position_m, speed_m_s) = (self.position_m, self.light_speed_m_s);
        let patches = patches(position_m, self.spectrum, self.grid, speed_m_s)?;
        let steps = (reach_s / FINE_STEP_S).round() as i32;
        let tried_s: Vec<f64> = (-steps..=steps)
            .map(|k| f64::from(k) * FINE_STEP_S)
            .collect();
        let mut scores = Vec::new();
        for later_s in &tried_s {
            control.check()?;
            let score = |patch: &PlaneGrid| {
                self.image(*later_s, *patch)
                    .map(|image| log_fourth_moment(&image))
            };
            scores.push(patches.iter().map(score).collect::<Result<Vec<_>, _>>()?);
        }
        Ok(sharpest(&tried_s, &scores))
    }
}

/// The image's rectangle with as many pixels as a search can afford.
fn search_grid(scene: &Scene, position_m: &[[f64; 3]]) -> Result<PlaneGrid, DelayError> {
    let fine = scene.around(position_m, scene.pixels.middle_m())?;
    let pixels = (CONTRIBUTIONS / position_m.len().max(1) as f64).clamp(PIXELS[0], PIXELS[1]);
    Ok(coarse(fine, pixels)?)
}

/// Log-likelihood of sharpness: each point against the sharpest, in standard deviations.
fn likelihood_of(points: &[ScanPoint]) -> DelayCurve {
    let sharpest = points
        .iter()
        .max_by(|a, b| a.log_contrast.total_cmp(&b.log_contrast));
    let below = |point: &ScanPoint| {
        let Some(best) = sharpest else {
            return 0.0;
        };
        let sigma = (point.sigma.hypot(best.sigma)).hypot(MODEL_SIGMA);
        let deviations = (best.log_contrast - point.log_contrast) / sigma;
        -0.5 * deviations * deviations
    };
    DelayCurve {
        delay_s: points.iter().map(|p| p.later_s).collect(),
        log_likelihood: points.iter().map(below).collect(),
    }
}

fn max_of(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The best delay of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Decided {
    index: usize,
    sigma_s: f64,
}

/// The one stretch of delays that agrees with the data, or why there is none.
fn decide(curve: &DelayCurve) -> Result<Decided, DelayError> {
    let log = &curve.log_likelihood;
    let best = best_of(log).unwrap_or_default();
    let ns = |k: usize| 1e9 * curve.delay_s[k];
    let stretch = stretch_about(log, best);
    let (first, last) = (stretch.start, stretch.end - 1);
    if ns(last) - ns(first) > 1e9 * WIDEST_S {
        return Err(DelayError::Vague {
            from_ns: ns(first),
            to_ns: ns(last),
        });
    }
    let rival = outside(log, &stretch);
    if let Some((k, below)) = rival
        && below < MARGIN
    {
        return Err(DelayError::Ambiguous {
            first_ns: ns(best),
            second_ns: ns(k),
            margin: below,
            needed: MARGIN,
        });
    }
    if best == 0 || best + 1 == log.len() {
        return Err(DelayError::AtEnd {
            at_ns: ns(best),
            from_ns: ns(0),
            to_ns: ns(log.len() - 1),
        });
    }
    // A normal log-likelihood falls by the margin within √(2·margin) standard deviations.
    let half_s = 0.5 * (curve.delay_s[last] - curve.delay_s[first]).max(STEP_S);
    Ok(Decided {
        index: best,
        sigma_s: half_s / (2.0 * MARGIN).sqrt(),
    })
}

/// The points about the best that stay within the margin.
fn stretch_about(log: &[f64], best: usize) -> std::ops::Range<usize> {
    let least = log[best] - MARGIN;
    let start = (0..best).rev().take_while(|k| log[*k] >= least).last();
    let end = (best..log.len()).take_while(|k| log[*k] >= least).last();
    start.unwrap_or(best)..end.unwrap_or(best) + 1
}

/// The best point outside a stretch, and how far it is below the best of all.
fn outside(log: &[f64], stretch: &std::ops::Range<usize>) -> Option<(usize, f64)> {
    (0..log.len())
        .filter(|k| !stretch.contains(k))
        .max_by(|a, b| log[*a].total_cmp(&log[*b]))
        .map(|k| (k, max_of(log) - log[k]))
}

/// The most likely other maximum (s), and how far it is below.
fn second_best(curve: &DelayCurve, best: usize) -> Option<(f64, f64)> {
    let log = &curve.log_likelihood;
    let stretch = stretch_about(log, best);
    let is_maximum = |k: &usize| {
        let (before, after) = (k.checked_sub(1), k + 1);
        before.is_none_or(|b| log[b] <= log[*k]) && log.get(after).is_none_or(|a| *a <= log[*k])
    };
    (0..log.len())
        .filter(|k| !stretch.contains(k))
        .filter(is_maximum)
        .max_by(|a, b| log[*a].total_cmp(&log[*b]))
        .map(|k| (curve.delay_s[k], log[best] - log[k]))
}

/// The delay in force beside those at which the image is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayCheck {
    /// The sharpest delay less the one in force (s).
    pub later_s: f64,
    /// Standard deviation of that (s).
    pub sigma_s: f64,
    /// How far the delay in force is from the nearest that agrees with the sharpest (s).
    pub outside_s: f64,
    /// Log-likelihood of the delay in force below the sharpest.
    pub below_best: f64,
}

/// How far about the delay in force it is checked, and the spacing of the delays tried (s).
const CHECKED_S: f64 = 8e-9;
const CHECK_STEP_S: f64 = 0.5e-9;
/// Contributions of traces to pixels in one image of a check.
const CHECK_CONTRIBUTIONS: f64 = 2e7;

/// Compares the delay in force of clean traces with those about it; none where the image gets
/// sharper up to the end of those.
///
/// # Errors
/// Data that the imaging operators refuse, cancellation.
pub fn check_delay(
    scan: DelayScan<'_>,
    control: &Control<'_>,
) -> Result<Option<DelayCheck>, DelayError> {
    if !scan.view().tells_delay() {
        return Ok(None);
    }
    let traces = scan.position_m.len().max(1) as f64;
    let pixels = (CHECK_CONTRIBUTIONS / traces).clamp(PIXELS[0], PIXELS[1]);
    let scan = DelayScan {
        grid: coarse(scan.grid, pixels)?,
        ..scan
    };
    let steps = (CHECKED_S / CHECK_STEP_S).round() as i32;
    let points = (-steps..=steps)
        .map(|k| {
            control.check()?;
            Ok(scan.at(f64::from(k) * CHECK_STEP_S)?)
        })
        .collect::<Result<Vec<_>, DelayError>>()?;
    let Some(check) = checked(&likelihood_of(&points)) else {
        return Ok(None);
    };
    // Contrast also changes as echoes move over the image: single targets must be sharp there, and
    // sharper than those of the image at the delay in force.
    if check.outside_s > CHECK_STEP_S {
        let spectrum = delayed(scan.spectrum, -check.later_s);
        let there = DelayScan {
            spectrum: &spectrum,
            ..scan
        };
        if there.sharpest_target(FINE_REACH_S, control)?.is_none()
            || there.target_contrast()? <= scan.target_contrast()?
        {
            return Ok(None);
        }
    }
    Ok(Some(check))
}

/// The point in the middle of a curve beside its best.
fn checked(curve: &DelayCurve) -> Option<DelayCheck> {
    let log = &curve.log_likelihood;
    let agreeing: Vec<f64> = (0..log.len())
        .filter(|k| log[*k] >= -MARGIN)
        .map(|k| curve.delay_s[k])
        .collect();
    let (first_s, last_s) = (*agreeing.first()?, *agreeing.last()?);
    let ends_s = [*curve.delay_s.first()?, *curve.delay_s.last()?];
    let best = best_of(log)?;
    if ends_s.contains(&first_s) || ends_s.contains(&last_s) {
        return None;
    }
    let nearest_s = agreeing
        .iter()
        .map(|d| d.abs())
        .fold(f64::INFINITY, f64::min);
    Some(DelayCheck {
        later_s: curve.delay_s[best],
        sigma_s: (0.5 * (last_s - first_s).max(CHECK_STEP_S)) / (2.0 * MARGIN).sqrt(),
        outside_s: nearest_s,
        below_best: -log[log.len() / 2],
    })
}

fn best_of(log: &[f64]) -> Option<usize> {
    (0..log.len()).max_by(|a, b| log[*a].total_cmp(&log[*b]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log-likelihood with normal maxima (delay in ns, deviation in ns, depth).
    fn curve(maxima: &[[f64; 3]]) -> DelayCurve {
        let delay_s: Vec<f64> = (0..141).map(|k| -1e-9 + f64::from(k) * STEP_S).collect();
        let value = |d: &f64| {
            let each = maxima
                .iter()
                .map(|[at, sigma, below]| -0.5 * ((d * 1e9 - at) / sigma).powi(2) - below);
            each.fold(f64::NEG_INFINITY, f64::max)
        };
        let log_likelihood: Vec<f64> = delay_s.iter().map(value).collect();
        let best = max_of(&log_likelihood);
        DelayCurve {
            log_likelihood: log_likelihood.iter().map(|v| v - best).collect(),
            delay_s,
        }
    }

    #[test]
    fn one_maximum_is_taken_with_its_deviation() {
        let decided = decide(&curve(&[[10.0, 0.2, 0.0], [14.0, 0.2, 9.0]])).unwrap();
        assert!((decided.sigma_s - 0.2e-9).abs() < 0.05e-9, "{decided:?}");
    }

    #[test]
    fn two_or_no_maxima_are_refused() {
        let two = curve(&[[10.0, 0.2, 0.0], [14.0, 0.2, 3.0]]);
        assert!(matches!(decide(&two), Err(DelayError::Ambiguous { .. })));
        let flat = curve(&[[10.0, 8.0, 0.0]]);
        assert!(matches!(decide(&flat), Err(DelayError::Vague { .. })));
        let rising = curve(&[[22.0, 1.0, 0.0]]);
        assert!(matches!(decide(&rising), Err(DelayError::AtEnd { .. })));
    }

    #[test]
    fn a_check_tells_how_far_off_the_delay_in_force_is() {
        // The middle of the curve is 9.5 ns.
        let about = |mut c: DelayCurve| {
            c.delay_s.iter_mut().for_each(|d| *d -= 9.5e-9);
            checked(&c)
        };
        let right = about(curve(&[[9.5, 0.2, 0.0]])).unwrap();
        assert!(right.outside_s < 0.1e-9 && right.below_best < 0.5);
        let wrong = about(curve(&[[16.5, 0.2, 0.0]])).unwrap();
        assert!((wrong.later_s - 7e-9).abs() < 0.1e-9, "{wrong:?}");
        assert!(wrong.outside_s > 6e-9 && wrong.below_best > 100.0);
        assert_eq!(about(curve(&[[22.0, 1.0, 0.0]])), None);
    }
}
