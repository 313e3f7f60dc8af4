//! Zero-timing: fast time becomes the two-way delay 2R/c.

use acerra_radar::Radargram;
use acerra_radar::clean::{SurfaceOptions, ZeroTiming as Timing, ZeroTimingResult, zero_timing};

use super::error::CleanError;
use super::options::CleanOptions;
use crate::choices::{Delay, ZeroTiming};
use crate::journal::warnings::Warnings;

/// Puts fast time to 2R/c.
pub(super) fn time(
    raw: Radargram,
    height_m: &[f64],
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<ZeroTimingResult, CleanError> {
    let given_ns = options.delay_ns.and_then(Delay::given_ns);
    let delay_s = given_ns.map(|ns| ns * 1e-9);
    let method = match options.zero_timing {
        ZeroTiming::FirstTrace => {
            let mut options = SurfaceOptions::default();
            options.approximate_delay_s = delay_s;
            match height_m.first() {
                Some(first_m) if *first_m <= 0.0 && is_mostly_above_ground(height_m) => {
                    warnings.add(format!(
                        "zero-timing by the median of all traces: the first stands {:.2} m below the ground of the \
                         image ([trajectory] origin_deg_m, [image] z_m)",
                        -first_m
                    ));
                    Timing::AllTraces(options)
                }
                _ => Timing::FirstTrace(options),
            }
        }
        ZeroTiming::None => delay_s.map_or(Timing::None, Timing::Delay),
        ZeroTiming::Shift { shift_ns } => Timing::Shift(shift_ns * 1e-9 - delay_s.unwrap_or(0.0)),
    };
    let timed = zero_timing(raw, height_m, &method).map_err(CleanError::ZeroTiming)?;
    if let Some(residual_s) = timed.median_residual_s
        && residual_s.abs() > 0.3e-9
    {
        warnings.add(format!(
            "the surface echo lies {:+.2} ns from 2h/c in the median of the traces: zero-timing, \
             heights or the image plane are off by {:.0} mm",
            residual_s * 1e9,
            residual_s.abs() * 0.15e12
        ));
    }
    Ok(timed)
}

/// Whether the ground of the image may be right: most traces stand above it.
fn is_mostly_above_ground(height_m: &[f64]) -> bool {
    2 * height_m.iter().filter(|h| **h > 0.0).count() > height_m.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_radar::Samples;

    const STEP_S: f64 = 61e-12;
    const DELAY_S: f64 = 9.5e-9;

    /// Echoes of the ground from some heights, noise-free, at the radar's sampling.
    fn radargram(height_m: &[f64]) -> Radargram {
        let sample = |h: f64, k: usize| {
            let t_s = k as f64 * STEP_S - DELAY_S - 2.0 * h / 299_792_458.0;
            let carrier = (std::f64::consts::TAU * 3.95e9 * t_s).cos();
            (1e3 * carrier * (-(t_s / 0.3e-9).powi(2)).exp()) as f32
        };
        let samples = (height_m.iter())
            .flat_map(|h| (0..900).map(move |k| sample(*h, k)))
            .collect();
        let time_s = (0..height_m.len()).map(|m| 0.1 * m as f64).collect();
        Radargram::new(time_s, 0.0, STEP_S, Samples::Real(samples)).unwrap()
    }

    #[test]
    fn a_first_trace_below_the_ground_is_zero_timed_by_the_others() {
        // A log from take-off whose first heights are 0.3 m too low.
        let truth_m: Vec<f64> = (0..120)
            .map(|m| (0.2 + 0.1 * f64::from(m)).min(4.0) + 0.02 * (0.7 * f64::from(m)).sin())
            .collect();
        let mut height_m = truth_m.clone();
        height_m[..3].iter_mut().for_each(|h| *h -= 0.3);
        assert!(height_m[0] < 0.0);
        let mut warnings = Warnings::default();
        let options = CleanOptions::default();
        let timed = time(radargram(&truth_m), &height_m, &options, &mut warnings).unwrap();
        assert!(
            (timed.shift_s + DELAY_S).abs() < 0.03e-9,
            "{:e}",
            timed.shift_s
        );
        let said = warnings.said();
        assert!(said[0].contains("median of all traces"), "{said:?}");
        // A ground above the whole flight is refused as before.
        let below: Vec<f64> = truth_m.iter().map(|h| h - 5.0).collect();
        let refused = time(
            radargram(&truth_m),
            &below,
            &options,
            &mut Warnings::default(),
        );
        assert!(
            matches!(refused, Err(CleanError::ZeroTiming(_))),
            "{refused:?}"
        );
    }
}
