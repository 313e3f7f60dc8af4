//! The echo of the surface, from which delays below it are counted.

use std::f64::consts::TAU;

use acerra_radar::clean::spectrum_at;
use num_complex::Complex64;

use crate::clean::surface_path_m;
use crate::prepare::Prepared;

/// Largest distance of the surface's echo from its geometry in the search, in resolution cells and as a share
/// of its path.
const REACH_CELLS: f64 = 4.0;
const REACH_OF_PATH: f64 = 0.25;
/// Steps of the search in a cell.
const STEPS_A_CELL: f64 = 16.0;
/// Least power of that echo over the median within the search.
const LEAST_RATIO: f64 = 4.0;

/// Two-way path by which the echo of the surface comes later than its geometry (m): the error of the zero of
/// fast time, and the length of the pulse. None where no log holds traces or no such echo is seen.
pub(crate) fn excess_path_m(prepared: &Prepared) -> Option<f64> {
    let aligned = &prepared.aligned;
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let path_m = surface_path_m(aligned, &prepared.scene.ground);
    let light_m_s = prepared.scene.light_speed_m_s;
    let mut stack = vec![Complex64::default(); frequency_hz.len()];
    for track in &prepared.tracks {
        let raw = spectrum_at(&track.cleaned.as_ref()?.raw, frequency_hz).ok()?;
        let own = path_m.get(track.range.clone())?;
        for (values, path_m) in raw.values.chunks(frequency_hz.len()).zip(own) {
            for ((sum, value), f) in stack.iter_mut().zip(values).zip(frequency_hz) {
                *sum += value * Complex64::from_polar(1.0, TAU * f * path_m / light_m_s);
            }
        }
    }
    let cell_m = light_m_s / (frequency_hz.last()? - frequency_hz.first()?);
    let least_path_m = path_m.iter().copied().fold(f64::INFINITY, f64::min);
    let reach_m = (REACH_CELLS * cell_m).min(REACH_OF_PATH * least_path_m);
    let power_at = |excess_m: f64| {
        let turned = (stack.iter().zip(frequency_hz))
            .map(|(v, f)| v * Complex64::from_polar(1.0, TAU * f * excess_m / light_m_s));
        turned.sum::<Complex64>().norm_sqr()
    };
    strongest(power_at, reach_m, cell_m / STEPS_A_CELL)
}

/// The place of the greatest power within a reach, where it is a maximum clearly above the others.
fn strongest(power_at: impl Fn(f64) -> f64, reach_m: f64, step_m: f64) -> Option<f64> {
    let steps = (reach_m / step_m).floor() as i32;
    let tried: Vec<[f64; 2]> = (-steps..=steps)
        .map(|k| step_m * f64::from(k))
        .map(|excess_m| [excess_m, power_at(excess_m)])
        .collect();
    let top = (0..tried.len()).max_by(|a, b| tried[*a][1].total_cmp(&tried[*b][1]))?;
    let (before, after) = (tried.get(top.checked_sub(1)?)?, tried.get(top + 1)?);
    let [at_m, most] = tried[top];
    let mut powers: Vec<f64> = tried.iter().map(|t| t[1]).collect();
    powers.sort_by(f64::total_cmp);
    let bend = before[1] - 2.0 * most + after[1];
    let toward = 0.5 * (before[1] - after[1]) / bend.min(-f64::MIN_POSITIVE);
    (most >= LEAST_RATIO * powers[powers.len() / 2])
        .then_some(at_m + step_m * toward.clamp(-0.5, 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_delay_is_found_between_steps_and_none_at_an_end() {
        let pulse = |at_m: f64| move |m: f64| (-((m - at_m) / 0.05).powi(2)).exp();
        let found = strongest(pulse(0.087), 0.6, 0.01).unwrap();
        assert!((found - 0.087).abs() < 1e-3, "{found}");
        assert_eq!(strongest(pulse(0.9), 0.6, 0.01), None);
        assert_eq!(strongest(|_| 1.0, 0.6, 0.01), None);
    }
}
