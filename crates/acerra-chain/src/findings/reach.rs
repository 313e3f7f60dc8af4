//! The finding on the depth that echoes come from at all: below it, absorption leaves less than the noise of the log.
//!
//! The surface calibrates the radar. It reflects the power share r² as a mirror does, so that an object of 1 m² at the
//! depth d has (1 − r²)²·4h²/(4π r² (h + d/n)⁴)·e^{−4αd} of the power of the surface's echo, by the radar equation: h the
//! height, n the refractive index of the soil, α its decay of amplitude.

use std::f64::consts::PI;

use acerra_imaging::metrics::Target;
use acerra_imaging::refraction::Layer;
use acerra_radar::Radargram;

use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::Prepared;

/// Power over the noise's from which an echo is visible (13 dB).
const SHOWS: f64 = 20.0;
/// Depths that are tried reach this far, in steps (m).
const DEEPEST_M: f64 = 20.0;
const STEP_M: f64 = 0.005;
/// Parts of the window of fast time, of which the quietest counts as noise.
const PARTS: usize = 8;
/// Half of the window in which the surface's echo is strongest, in resolution cells: it may be off its geometry.
const SURFACE_CELLS: f64 = 4.0;

/// Judges the depths of the targets by the loss in the soil; no finding above ground, where no log holds
/// traces, and where a log holds no noise.
pub(super) fn weigh(prepared: &Prepared, focused: &Focused, targets: &[Target]) -> Option<Finding> {
    let underground = focused.underground.as_ref()?;
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let (low_hz, high_hz) = (*frequency_hz.first()?, *frequency_hz.last()?);
    let mut best: Option<f64> = None;
    for track in &prepared.tracks {
        let traces = &track.cleaned.as_ref()?.raw;
        let heights_m = prepared.aligned.height_m.get(track.range.clone())?;
        let band_hz = high_hz - low_hz;
        let snr = surface_over_noise(traces, heights_m, band_hz, prepared.scene.light_speed_m_s)?;
        // Traces add up, and so do the samples of a pulse.
        let a_pulse = (1.0 / (2.0 * band_hz * traces.fast_time_step_s)).max(1.0);
        let height_m = heights_m.iter().sum::<f64>() / heights_m.len().max(1) as f64;
        let gain = traces.traces as f64 * a_pulse;
        let reach_m = reach_m(snr * gain, height_m, &underground.layers, low_hz);
        best = Some(best.map_or(reach_m, |best| best.max(reach_m)));
    }
    let surface_m = |target: &Target| match underground.is_uneven {
        true => prepared.scene.ground.below_m(target.x_m, target.y_m),
        false => underground.surface_z_m,
    };
    let depths_m = targets.iter().map(|target| surface_m(target) - target.z_m);
    depth_reach(best?, &depths_m.collect::<Vec<_>>()).into()
}

fn depth_reach(reach_m: f64, depths_m: &[f64]) -> Finding {
    let deeper = depths_m
        .iter()
        .filter(|depth_m| **depth_m > reach_m)
        .count();
    let verdict = if deeper > 0 {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let keys = "[ground] conductivity_s_m, relative_permittivity";
    let more = if reach_m >= DEEPEST_M {
        "more than "
    } else {
        ""
    };
    let reach = format!(
        "by the stated conductivity and the noise of the log an object of 1 m² is visible down to \
         {more}{reach_m:.2} m at the lowest frequency of the band; an empty image deeper than that is no \
         evidence"
    );
    Finding::judged("depth_reach", reach_m, "m", verdict).because(match verdict {
        Verdict::Agrees => format!("{reach}; no target is deeper ({keys})"),
        Verdict::Doubtful | Verdict::Contradicts => format!(
            "{reach}; {deeper} of {} targets are deeper: noise, echoes along other paths, or a soil that \
             absorbs less ({keys})",
            depths_m.len()
        ),
    })
}

/// Depth down to which an object of 1 m² shows (m): `snr` is the power of the surface's echo over the noise after all
/// traces are added up, `frequency_hz` that at which the soil absorbs least.
fn reach_m(snr: f64, height_m: f64, layers: &[Layer], frequency_hz: f64) -> f64 {
    let Some(top) = layers.first() else {
        return DEEPEST_M;
    };
    let index = top.soil.relative_permittivity.sqrt();
    let reflected = ((index - 1.0) / (index + 1.0)).powi(2).max(1e-6);
    let transmitted = 1.0 - reflected;
    let mut optical_m = 0.0;
    let mut decay = 0.0;
    let (mut layer, mut bottom_m) = (0, top.thickness_m);
    let mut depth_m = 0.0;
    while depth_m < DEEPEST_M {
        depth_m += STEP_M;
        while depth_m > bottom_m && layer + 1 < layers.len() {
            layer += 1;
            bottom_m += layers[layer].thickness_m;
        }
        let index = layers[layer].soil.refractive_index(frequency_hz);
        optical_m += STEP_M / index.re;
        decay += 2.0 * PI * frequency_hz / 299_792_458.0 * -index.im * STEP_M;
        let away_m = height_m + optical_m;
        let spread = 4.0 * height_m.powi(2) / (4.0 * PI * reflected * away_m.powi(4));
        let power = snr * transmitted.powi(2) * spread * (-4.0 * decay).exp();
        if power < SHOWS {
            return depth_m - STEP_M;
        }
    }
    DEEPEST_M
}

/// Power of the surface's echo over the noise's, in a trace: the noise is the difference of neighbouring
/// traces, at its quietest fast times.
fn surface_over_noise(
    traces: &Radargram,
    heights_m: &[f64],
    band_hz: f64,
    light_speed_m_s: f64,
) -> Option<f64> {
    let count = traces.samples_per_trace;
    let part = count.div_ceil(PARTS).max(1);
    let at = |k: usize, i: usize| traces.samples.at(k * count + i);
    let noise = (0..PARTS)
        .filter_map(|p| {
            let range = (p * part).min(count)..((p + 1) * part).min(count);
            let differences = (1..traces.traces).flat_map(|k| {
                range
                    .clone()
                    .map(move |i| (at(k, i) - at(k - 1, i)).norm_sqr())
            });
            let (sum, number) = differences.fold((0.0, 0), |(sum, n), d| (sum + d, n + 1));
            (sum > 0.0).then(|| 0.5 * sum / f64::from(number))
        })
        .min_by(f64::total_cmp)?;
    let half_s = SURFACE_CELLS / band_hz;
    let mut peaks: Vec<f64> = (heights_m.iter().take(traces.traces).enumerate())
        .map(|(k, height_m)| {
            let at_s = 2.0 * height_m / light_speed_m_s;
            let is_near = |i: &usize| {
                let fast_s = traces.fast_time_start_s + *i as f64 * traces.fast_time_step_s;
                (fast_s - at_s).abs() <= half_s
            };
            (0..count)
                .filter(is_near)
                .map(|i| at(k, i).norm_sqr())
                .fold(0.0, f64::max)
        })
        .collect();
    peaks.sort_by(f64::total_cmp);
    let peak = *peaks.get(peaks.len() / 2)?;
    (peak > 0.0).then_some(peak / noise)
}

#[cfg(test)]
mod tests {
    use acerra_imaging::refraction::Soil;

    use super::*;

    fn soil(relative_permittivity: f64, conductivity_s_m: f64) -> Vec<Layer> {
        vec![Layer::below_all(Soil {
            relative_permittivity,
            conductivity_s_m,
        })]
    }

    /// Depth depends on the loss: 60 dB more of the radar move the limit deeper by 60 dB over the two-way
    /// loss of a metre, less the spreading loss.
    #[test]
    fn the_reach_follows_the_loss_of_the_soil() {
        // α = σ/2 · 376.73/n: 4.7 Np/m for 0.05 S/m and n = 2, 82 dB two-way a metre.
        let clay = soil(4.0, 0.05);
        let [shallow_m, deep_m] = [1e6, 1e12].map(|snr| reach_m(snr, 1.0, &clay, 1e9));
        let by_m = deep_m - shallow_m;
        assert!((0.55..0.73).contains(&by_m), "{shallow_m} {deep_m}");
        let sand_m = reach_m(1e6, 1.0, &soil(4.0, 0.001), 1e9);
        assert!(sand_m > 5.0 * shallow_m, "{sand_m} {shallow_m}");
        // A lossy layer below stops echoes that pass the top layer.
        let wet = Layer {
            thickness_m: 0.1,
            ..soil(4.0, 0.001)[0]
        };
        let layered_m = reach_m(1e6, 1.0, &[wet, soil(16.0, 1.0)[0]], 1e9);
        assert!((0.1..0.3).contains(&layered_m), "{layered_m}");
    }

    #[test]
    fn targets_below_the_reach_are_doubtful() {
        assert_eq!(depth_reach(0.3, &[0.1, 0.29]).verdict, Verdict::Agrees);
        let found = depth_reach(0.3, &[0.1, 0.35]);
        assert_eq!(found.verdict, Verdict::Doubtful);
        assert!(found.explanation.contains("1 of 2 targets are deeper"));
    }
}
