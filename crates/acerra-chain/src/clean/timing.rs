//! Zero-timing: fast time becomes the two-way delay 2R/c.

use acerra_radar::clean::{
    CleanError as Refused, SurfaceOptions, ZeroTiming as Timing, ZeroTimingResult, band_pass,
    zero_timing,
};
use acerra_radar::quality::direct_wave;
use acerra_radar::{Radargram, SPEED_OF_LIGHT_M_S};

use super::error::CleanError;
use super::options::CleanOptions;
use crate::choices::{Delay, ZeroTiming};
use crate::journal::warnings::Warnings;
use crate::position::aligned::Aligned;

/// Puts fast time to 2R/c.
pub(super) fn time(
    raw: Radargram,
    aligned: &Aligned,
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<ZeroTimingResult, CleanError> {
    let height_m = &aligned.height_m;
    let given_ns = options.delay_ns.and_then(Delay::given_ns);
    let delay_s = given_ns.map(|ns| ns * 1e-9);
    let method = match options.zero_timing {
        ZeroTiming::FirstTrace => {
            let mut options = SurfaceOptions::default();
            options.approximate_delay_s = delay_s;
            match height_m.first() {
                Some(first_m) if *first_m <= 0.0 && is_mostly_above_ground(height_m) => {
                    warnings.add(format!(
                        "zero-timing by the median of all traces: the first is {:.2} m below the ground of \
                         the image ([trajectory] origin_deg_m, [image] z_m)",
                        -first_m
                    ));
                    Timing::AllTraces(options)
                }
                _ => Timing::FirstTrace(options),
            }
        }
        ZeroTiming::DirectWave => {
            Timing::Delay(by_direct_wave_s(&raw, aligned, options, warnings)?)
        }
        ZeroTiming::None => delay_s.map_or(Timing::None, Timing::Delay),
        ZeroTiming::Shift { shift_ns } => Timing::Shift(shift_ns * 1e-9 - delay_s.unwrap_or(0.0)),
    };
    let timed = match (&method, options.surface_delay_s) {
        (Timing::FirstTrace(surface) | Timing::AllTraces(surface), Some(followed_s)) => {
            by_surface((raw, height_m), &method, (*surface, followed_s), warnings)
        }
        _ => zero_timing(raw, height_m, &method),
    }
    .map_err(CleanError::ZeroTiming)?;
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

/// Distance of one side lobe of the ground's echo from the next (s), in a band of 1.7 GHz.
const LOBE_S: f64 = 0.6e-9;

/// Zero-timing by the surface echo, where the delay of the echo that follows the height over the whole flight is known
/// (`followed_s`). A stronger object's echo may be taken for the surface's in the traces that are imaged: an echo farther
/// than a lobe from that delay is not the surface's.
fn by_surface(
    (raw, height_m): (Radargram, &[f64]),
    method: &Timing,
    (surface, followed_s): (SurfaceOptions, f64),
    warnings: &mut Warnings,
) -> Result<ZeroTimingResult, Refused> {
    match zero_timing(raw.clone(), height_m, method) {
        Ok(timed) => {
            let off_s = -timed.shift_s - followed_s;
            if off_s.abs() <= LOBE_S {
                return Ok(timed);
            }
            warnings.add(format!(
                "zero-timing by the echo that follows the height over the whole flight, at {:.2} ns: the strongest one \
                 is {:+.2} ns from it",
                1e9 * followed_s,
                1e9 * off_s
            ));
        }
        Err(Refused::NoSurface { .. }) => {}
        Err(refused) => return Err(refused),
    }
    let about = surface
        .with_approximate_delay_s(followed_s)
        .with_search_s(LOBE_S)
        .with_follow_s(LOBE_S);
    zero_timing(raw.clone(), height_m, &Timing::AllTraces(about))
        .or_else(|_| zero_timing(raw, height_m, &Timing::Delay(followed_s)))
}

/// Fast time at which range is zero as far as `options` give it without the echo of the surface (s): stated, or by the
/// direct wave.
///
/// # Errors
/// A direct wave that is not seen.
pub(crate) fn zero_s(
    raw: &Radargram,
    aligned: &Aligned,
    options: &CleanOptions,
) -> Result<Option<f64>, CleanError> {
    let given_s = (options.delay_ns.and_then(Delay::given_ns)).map(|ns| ns * 1e-9);
    Ok(match options.zero_timing {
        ZeroTiming::FirstTrace => given_s,
        ZeroTiming::None => Some(given_s.unwrap_or(0.0)),
        ZeroTiming::Shift { shift_ns } => Some(given_s.unwrap_or(0.0) - shift_ns * 1e-9),
        ZeroTiming::DirectWave => {
            let unheard = &mut Warnings::default();
            Some(by_direct_wave_s(raw, aligned, options, unheard)?)
        }
    })
}

/// Fast time at which range is zero by the direct wave between the antennas, within the band of the image (s).
fn by_direct_wave_s(
    raw: &Radargram,
    aligned: &Aligned,
    options: &CleanOptions,
    warnings: &mut Warnings,
) -> Result<f64, CleanError> {
    let mut apart_m: Vec<f64> = (aligned.antennas_from_place_m.iter())
        .map(|[t, r]| (0..3).map(|k| (t[k] - r[k]).powi(2)).sum::<f64>().sqrt())
        .collect();
    apart_m.sort_by(f64::total_cmp);
    let apart_m = (apart_m.get(apart_m.len() / 2).copied())
        .filter(|m| *m > 0.0)
        .ok_or(CleanError::OneAntenna)?;
    let ends = (options.frequency_hz.first()).zip(options.frequency_hz.last());
    let (low_hz, high_hz) = ends.map_or((0.0, 0.0), |(low, high)| (*low, *high));
    let in_band = if low_hz < high_hz {
        band_pass(raw.clone(), [low_hz, high_hz]).map_err(CleanError::Band)?
    } else {
        raw.clone()
    };
    let seen = direct_wave(&in_band).ok_or(CleanError::NoDirectWave {
        start_s: raw.fast_time_start_s,
    })?;
    // A quarter of a period shifts the phase of a trace's echoes against those of the others by as much.
    let most_s = 0.5 / (low_hz + high_hz);
    if seen.spread_s > most_s {
        warnings.add(format!(
            "the direct wave wanders by {:.2} ns from trace to trace: fast time is not the same in all of them, and one \
             zero for all blurs the image",
            1e9 * seen.spread_s
        ));
    }
    Ok(seen.fast_time_s - apart_m / SPEED_OF_LIGHT_M_S)
}

/// Whether the ground of the image may be right: most traces are above it.
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

    fn at_heights(height_m: &[f64]) -> Aligned {
        Aligned {
            height_m: height_m.to_vec(),
            ..Aligned::default()
        }
    }

    #[test]
    fn the_direct_wave_is_put_at_the_way_between_the_antennas() {
        // An echo that `radargram` would place on the ground 0.3 m below one antenna is the direct path
        // between two antennas 0.6 m apart.
        let raw = radargram(&[0.3; 20]);
        let mut aligned = at_heights(&[1.0; 20]);
        let options = CleanOptions {
            zero_timing: ZeroTiming::DirectWave,
            ..CleanOptions::default()
        };
        let warnings = &mut Warnings::default();
        let refused = time(raw.clone(), &aligned, &options, warnings);
        assert!(
            matches!(refused, Err(CleanError::OneAntenna)),
            "{refused:?}"
        );
        aligned.antennas_from_place_m = vec![[[0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]]; 20];
        let timed = time(raw.clone(), &aligned, &options, warnings).unwrap();
        assert!(
            (timed.shift_s + DELAY_S).abs() < 0.02e-9,
            "{:e}",
            timed.shift_s
        );
        assert!(warnings.said().is_empty(), "{:?}", warnings.said());
        let late = radargram(&[0.3; 20]).shifted(1e-9);
        let timed = time(late, &aligned, &options, warnings).unwrap();
        assert!((timed.shift_s + DELAY_S + 1e-9).abs() < 0.02e-9);
    }

    #[test]
    fn a_stronger_echo_is_not_taken_for_the_surface_where_the_height_tells_another() {
        // A reflector 4 ns behind the ground, ten times as strong.
        let height_m: Vec<f64> = (0..80).map(|m| 4.0 + 0.01 * f64::from(m)).collect();
        let ground = radargram(&height_m);
        let mix = |k: usize| {
            let late = (k % 900).checked_sub(66).map(|_| ground.samples.at(k - 66));
            (ground.samples.at(k).re + 10.0 * late.map_or(0.0, |v| v.re)) as f32
        };
        let samples = (0..80 * 900).map(mix).collect();
        let raw = Radargram::new(ground.time_s.clone(), 0.0, STEP_S, Samples::Real(samples));
        let raw = raw.unwrap();
        let aligned = at_heights(&height_m);
        let off_s = |surface_delay_s| {
            let options = CleanOptions {
                surface_delay_s,
                ..CleanOptions::default()
            };
            let mut warnings = Warnings::default();
            let timed = time(raw.clone(), &aligned, &options, &mut warnings).unwrap();
            (-timed.shift_s - DELAY_S, warnings.said().len())
        };
        let (misled_s, said) = off_s(None);
        assert!((misled_s - 66.0 * STEP_S).abs() < 0.1e-9, "{misled_s:e}");
        let (held_s, said_more) = off_s(Some(DELAY_S + 0.2e-9));
        assert!(held_s.abs() < 0.15e-9, "{held_s:e}");
        assert_eq!(said_more, said + 1);
    }

    #[test]
    fn a_stronger_echo_within_reach_of_the_side_lobes_counts_only_where_it_follows_the_height() {
        // A reflector ten times as strong as the ground, 1.5 to 2.6 ns behind it as the platform passes.
        let height_m: Vec<f64> = (0..80).map(|m| 4.0 + 0.01 * f64::from(m)).collect();
        let reflector_m: Vec<f64> = (0..80u32)
            .map(|m| f64::from(m) / 40.0 - 1.0)
            .zip(&height_m)
            .map(|(along, height_m)| height_m + 0.22 + 0.17 * along * along)
            .collect();
        let (ground, reflector) = (radargram(&height_m), radargram(&reflector_m));
        let mix = |k: usize| (ground.samples.at(k).re + 10.0 * reflector.samples.at(k).re) as f32;
        let samples = Samples::Real((0..80 * 900).map(mix).collect());
        let raw = Radargram::new(ground.time_s.clone(), 0.0, STEP_S, samples).unwrap();
        let off_s = |surface_delay_s| {
            let options = CleanOptions {
                surface_delay_s,
                ..CleanOptions::default()
            };
            let unheard = &mut Warnings::default();
            let timed = time(raw.clone(), &at_heights(&height_m), &options, unheard).unwrap();
            -timed.shift_s - DELAY_S
        };
        assert!(off_s(None) > 1e-9, "{:e}", off_s(None));
        let held_s = off_s(Some(DELAY_S + 0.1e-9));
        assert!(held_s.abs() < 0.15e-9, "{held_s:e}");
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
        let timed = time(
            radargram(&truth_m),
            &at_heights(&height_m),
            &options,
            &mut warnings,
        )
        .unwrap();
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
            &at_heights(&below),
            &options,
            &mut Warnings::default(),
        );
        assert!(
            matches!(refused, Err(CleanError::ZeroTiming(_))),
            "{refused:?}"
        );
    }
}
