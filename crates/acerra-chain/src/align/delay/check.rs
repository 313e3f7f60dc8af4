//! Comparison of the delay in force with the delays at which the image is sharp.

use rayon::prelude::*;

use super::curve::{DelayCurve, MARGIN, best_of};
use super::echo_power::StrongestEcho;
use super::error::DelayError;
use super::scan::{DelayScan, ScanPoint, delayed, log_contrast};
use super::view::{View, middle_hz};
use crate::control::Control;
use crate::echoes::sharpen::{coarse, patches};

/// Comparison of the delay in force with the delays at which the image is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayCheck {
    /// The sharpest delay less the one in force (s).
    pub later_s: f64,
    /// Standard deviation of the difference (s).
    pub sigma_s: f64,
    /// Distance of the delay in force from the nearest delay that agrees with the sharpest (s).
    pub outside_s: f64,
    /// Log-likelihood of the delay in force below the sharpest.
    pub below_best: f64,
}

/// Range of delays tried about the delay in force, and their spacing (s).
const CHECKED_S: f64 = 8e-9;
const STEP_S: f64 = 0.5e-9;
/// Contributions of traces to pixels in one image of a check.
const CONTRIBUTIONS: f64 = 2e7;
/// Least and largest number of pixels of an image.
const PIXELS: [f64; 2] = [20_000.0, 150_000.0];
/// Standard deviation of a log contrast by errors of positions and antenna, in addition to the clutter's: a
/// tenth.
const MODEL_SIGMA: f64 = 0.1;

/// Compares the delay in force of clean traces with neighbouring delays; `None` where the image gets sharper
/// up to the end of the delays tried.
///
/// # Errors
/// Data that the imaging operators refuse, cancellation.
pub fn check_delay(
    scan: DelayScan<'_>,
    control: &Control<'_>,
) -> Result<Option<DelayCheck>, DelayError> {
    if !scan.view().determines_delay() {
        return Ok(None);
    }
    let traces = scan.position_m.len().max(1) as f64;
    let pixels = (CONTRIBUTIONS / traces).clamp(PIXELS[0], PIXELS[1]);
    let scan = DelayScan {
        grid: coarse(scan.grid, pixels)?,
        ..scan
    };
    let steps = (CHECKED_S / STEP_S).round() as i32;
    let searched = scan.searched();
    let looks = searched.delays(scan.grid, scan.reach_m(CHECKED_S))?;
    let points: Vec<ScanPoint> = (-steps..=steps)
        .into_par_iter()
        .map(|k| {
            control.check()?;
            let later_s = f64::from(k) * STEP_S;
            let image = scan.tabulated_image(&looks, later_s, scan.grid)?;
            Ok(ScanPoint::of(later_s, &image))
        })
        .collect::<Result<_, DelayError>>()?;
    let Some(check) = checked(&likelihood_of(&points)) else {
        return Ok(None);
    };
    // Contrast also changes as echoes move over the image and overlap with their ghosts. Single targets must
    // therefore be sharp at the other delay too, and sharper and stronger than the targets of the image at
    // the delay in force, since their echoes add up there.
    if check.outside_s > STEP_S {
        let spectrum = delayed(scan.spectrum, -check.later_s);
        let there = DelayScan {
            spectrum: &spectrum,
            ..scan
        };
        if there.sharpest_targets(control)?.is_none() {
            return Ok(None);
        }
        let ([contrast, power], [before, power_before]) = (there.targets()?, scan.targets()?);
        if contrast <= before || power <= power_before {
            return Ok(None);
        }
    }
    Ok(Some(check))
}

/// Log-likelihood of sharpness: the difference of each delay from the sharpest, in standard deviations.
fn likelihood_of(points: &[ScanPoint]) -> DelayCurve {
    let sharpest = points
        .iter()
        .max_by(|a, b| a.log_contrast.total_cmp(&b.log_contrast));
    let below = |point: &ScanPoint| {
        let Some(best) = sharpest else {
            return 0.0;
        };
        let sigma = point.sigma.hypot(best.sigma).hypot(MODEL_SIGMA);
        let deviations = (best.log_contrast - point.log_contrast) / sigma;
        -0.5 * deviations * deviations
    };
    DelayCurve {
        delay_s: points.iter().map(|p| p.later_s).collect(),
        log_likelihood: points.iter().map(below).collect(),
    }
}

/// The middle point of a curve and its best point.
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
        sigma_s: (0.5 * (last_s - first_s).max(STEP_S)) / (2.0 * MARGIN).sqrt(),
        outside_s: nearest_s,
        below_best: -log[log.len() / 2],
    })
}

impl<'a> DelayScan<'a> {
    /// The strongest targets, each on a separate patch: the mean log contrast, and the logarithm of the power
    /// of the strongest.
    fn targets(&self) -> Result<[f64; 2], DelayError> {
        let (position_m, speed_m_s) = (self.position_m, self.light_speed_m_s);
        let patches = patches(position_m, self.spectrum, self.grid, speed_m_s)?;
        let (mut contrast, mut log_power) = (0.0, f64::NEG_INFINITY);
        for patch in &patches {
            let image = self.image(0.0, *patch)?;
            contrast += log_contrast(&image);
            log_power = log_power.max(StrongestEcho::of(&image, *patch)?.log_power);
        }
        Ok([contrast / patches.len().max(1) as f64, log_power])
    }

    fn view(&self) -> View<'a> {
        View {
            position_m: self.position_m,
            grid: self.grid,
            middle_hz: middle_hz(&self.spectrum.frequency_hz),
            light_speed_m_s: self.light_speed_m_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::tests::curve;
    use super::*;

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
