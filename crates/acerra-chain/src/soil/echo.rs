//! Delay and curvature of the echo of a buried point.

use std::f64::consts::TAU;

use acerra_imaging::ImagingError;
use acerra_imaging::refraction::{Ground, Ray};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::echoes::Echoes;
use crate::focus::underground::Underground;

/// Traces that an echo is summed over at most, spread evenly.
const MOST_TRACES: usize = 300;
/// Traces whose amplitude by spreading and transmission is below this share of the greatest are left out.
const LEAST_AMPLITUDE: f64 = 0.1;
/// Ratio of one permittivity that is tried to the one before.
const RATIO: f64 = 1.1;
/// Delays tried within half a resolution cell either way.
const LAGS: i32 = 8;
/// Places along each side of the image at which the clutter is measured.
const CLUTTER_A_SIDE: usize = 24;
/// Horizontal step of the search about a point, of the wavelength in the middle of the band.
const STEP_WAVELENGTHS: f64 = 0.06;
/// Probability that the strongest of all places of clutter is taken for a point.
const FALSE_ALARM: f64 = 0.01;

/// What the echo of a buried point shows, were it a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointEcho {
    /// Its place by the permittivities in force (m).
    pub place_m: [f64; 3],
    /// Delay below the surface straight under the antenna, as one-way optical length Σ n t (m).
    pub delay_m: f64,
    /// Distance q = Σ t/n by which the centre of its hyperbola lies below the surface (m).
    pub curvature_m: f64,
    /// Standard deviation of that distance by the clutter (m).
    pub sigma_m: f64,
}

/// Echoes below a ground, as they are compared with hyperbolas.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bench<'a> {
    pub echoes: Echoes<'a>,
    /// The ground with the permittivities in force.
    pub underground: &'a Underground,
    /// Two-way path by which the echo of the surface is later than its geometry (m).
    pub excess_path_m: f64,
    /// Horizontal rectangle of the image: from and to along x and y (m).
    pub extent_m: [[f64; 2]; 2],
    /// Places of the image that might hold a point.
    pub places: usize,
}

/// Traces and their amplitudes towards a point.
struct Seen {
    traces: Vec<usize>,
    amplitude: Vec<f64>,
}

impl Bench<'_> {
    /// Fits the hyperbola of the echo about a place of the image; none where no echo there exceeds the clutter, or
    /// where no permittivity from 1 to 100 makes its sum greatest.
    pub fn fit(&self, place_m: [f64; 3]) -> Result<Option<PointEcho>, ImagingError> {
        let stated = self.ground(1.0)?;
        let surface_m = stated.surface().height_m([place_m[0], place_m[1]]);
        let seen = self.seen(&stated, place_m);
        let delay_m = vertical(&stated, surface_m - place_m[2]).delay_m - 0.5 * self.excess_path_m;
        if delay_m <= 0.0 || seen.traces.len() < 3 {
            return Ok(None);
        }
        let first = self.best_near(&stated, &seen, place_m, delay_m);
        let place_m = first.place_m;
        let delay_m = delay_m + first.later_m;
        if delay_m <= 0.0 {
            return Ok(None);
        }
        let floor = self.clutter(&stated, &seen, place_m, delay_m);
        let most_chance = (self.places as f64 / FALSE_ALARM).ln();
        if floor <= 0.0 || first.power < most_chance * floor {
            return Ok(None);
        }
        let curve = self.curve(&seen, place_m, delay_m)?;
        Ok(vertex(&curve, floor).map(|[curvature_m, sigma_m]| PointEcho {
            place_m,
            delay_m,
            curvature_m,
            sigma_m,
        }))
    }

    /// Power of the echo for permittivities from 1 to 100, as (q, power), by rising permittivity.
    fn curve(
        &self,
        seen: &Seen,
        place_m: [f64; 3],
        delay_m: f64,
    ) -> Result<Vec<[f64; 2]>, ImagingError> {
        let factors = self.underground.factors(RATIO);
        factors
            .into_par_iter()
            .map(|factor| {
                let ground = self.ground(factor)?;
                let best = self.best_near(&ground, seen, place_m, delay_m);
                let depth_m = depth_at(&ground, delay_m);
                Ok([vertical(&ground, depth_m).curvature_m, best.power])
            })
            .collect()
    }

    fn ground(&self, factor: f64) -> Result<Ground, ImagingError> {
        let frequency_hz = &self.echoes.spectrum.frequency_hz;
        self.underground.scaled(factor).seen_at(frequency_hz)
    }

    /// The traces that see a place, and the two-way amplitude of each.
    fn seen(&self, ground: &Ground, place_m: [f64; 3]) -> Seen {
        let all = self.echoes.aligned.position_m.len();
        let amplitude: Vec<f64> = (0..all)
            .into_par_iter()
            .map(|trace| {
                let [there, back] = self.rays(ground, trace, place_m);
                there.amplitude * back.amplitude
            })
            .collect();
        let most = amplitude.iter().copied().fold(0.0, f64::max);
        let near: Vec<usize> = (0..all)
            .filter(|trace| amplitude[*trace] >= LEAST_AMPLITUDE * most)
            .collect();
        let stride = near.len().div_ceil(MOST_TRACES).max(1);
        let traces: Vec<usize> = near.into_iter().step_by(stride).collect();
        Seen {
            amplitude: traces.iter().map(|k| amplitude[*k] / most).collect(),
            traces,
        }
    }

    fn rays(&self, ground: &Ground, trace: usize, place_m: [f64; 3]) -> [Ray; 2] {
        let antennas_m = self.echoes.aligned.antennas_at_m(trace);
        antennas_m.map(|antenna_m| ground.ray(antenna_m, place_m))
    }

    /// Sum of the traces along the echo of a place, at each frequency.
    fn stack(&self, ground: &Ground, seen: &Seen, place_m: [f64; 3]) -> Vec<Complex64> {
        let spectrum = self.echoes.spectrum;
        let frequencies = spectrum.frequency_hz.len();
        let mut sum = vec![Complex64::default(); frequencies];
        for (trace, amplitude) in seen.traces.iter().zip(&seen.amplitude) {
            let [there, back] = self.rays(ground, *trace, place_m);
            let path_m = there.optical_m + back.optical_m + self.excess_path_m;
            let turn = TAU * path_m / self.echoes.light_speed_m_s;
            let own = spectrum.values.iter().skip(trace * frequencies);
            for ((sum, frequency_hz), value) in sum.iter_mut().zip(&spectrum.frequency_hz).zip(own)
            {
                *sum += value * Complex64::from_polar(*amplitude, turn * frequency_hz);
            }
        }
        sum
    }

    /// Greatest power of the echo at this delay, within half a cell of it, over places within a step horizontally.
    fn best_near(&self, ground: &Ground, seen: &Seen, place_m: [f64; 3], delay_m: f64) -> Best {
        let frequency_hz = &self.echoes.spectrum.frequency_hz;
        let middle_hz = frequency_hz.iter().sum::<f64>() / frequency_hz.len().max(1) as f64;
        let step_m = STEP_WAVELENGTHS * self.echoes.light_speed_m_s / middle_hz;
        let depth_m = depth_at(ground, delay_m);
        let at = |place_m: [f64; 2]| {
            let z_m = ground.surface().height_m(place_m) - depth_m;
            let place_m = [place_m[0], place_m[1], z_m];
            let (power, later_m) = self.peak(&self.stack(ground, seen, place_m));
            Best {
                place_m,
                power,
                later_m,
            }
        };
        let mut best = at([place_m[0], place_m[1]]);
        for axis in (0..2).filter(|axis| self.extent_m[*axis][1] > self.extent_m[*axis][0]) {
            let beside = |off_m: f64| {
                let mut place_m = [best.place_m[0], best.place_m[1]];
                place_m[axis] += off_m;
                at(place_m)
            };
            let (before, after) = (beside(-step_m), beside(step_m));
            let bend = before.power - 2.0 * best.power + after.power;
            let toward = 0.5 * (before.power - after.power) / bend;
            let refined = (bend < 0.0).then(|| beside(step_m * toward.clamp(-1.0, 1.0)));
            for other in [before, after].into_iter().chain(refined) {
                if other.power > best.power {
                    best = other;
                }
            }
        }
        best
    }

    /// Greatest power of a stack within half a cell of its delay, and by how much later that is, one way (m).
    fn peak(&self, stack: &[Complex64]) -> (f64, f64) {
        let cell_s = self.cell_s();
        let power: Vec<f64> = (-LAGS..=LAGS)
            .map(|k| self.power(stack, 0.5 * cell_s * f64::from(k) / f64::from(LAGS)))
            .collect();
        let top = (0..power.len())
            .max_by(|a, b| power[*a].total_cmp(&power[*b]))
            .unwrap_or(0);
        let toward = match (top.checked_sub(1), power.get(top + 1)) {
            (Some(before), Some(after)) => {
                let bend = power[before] - 2.0 * power[top] + after;
                0.5 * (power[before] - after) / bend.min(-f64::MIN_POSITIVE)
            }
            _ => 0.0,
        };
        let lags = top as f64 - f64::from(LAGS) + toward.clamp(-0.5, 0.5);
        let later_s = 0.5 * cell_s * lags / f64::from(LAGS);
        (power[top], 0.5 * later_s * self.echoes.light_speed_m_s)
    }

    fn power(&self, stack: &[Complex64], lag_s: f64) -> f64 {
        let frequency_hz = self.echoes.spectrum.frequency_hz.iter();
        let turned = (frequency_hz.zip(stack))
            .map(|(f, value)| value * Complex64::from_polar(1.0, TAU * f * lag_s));
        turned.sum::<Complex64>().norm_sqr()
    }

    /// Resolution cell of the delay (s): the inverse of the band.
    fn cell_s(&self) -> f64 {
        let frequency_hz = &self.echoes.spectrum.frequency_hz;
        let [low, high] = [frequency_hz.first(), frequency_hz.last()].map(|f| f.copied());
        1.0 / (high.unwrap_or(1.0) - low.unwrap_or(0.0)).max(1.0)
    }

    /// Mean power of the clutter at this delay below the surface, for a place that is seen as `seen` is: by the median
    /// over the image, of which points are few.
    fn clutter(&self, ground: &Ground, seen: &Seen, place_m: [f64; 3], delay_m: f64) -> f64 {
        let depth_m = depth_at(ground, delay_m);
        let energy = |seen: &Seen| seen.amplitude.iter().map(|a| a * a).sum::<f64>();
        let along = |axis: usize| {
            let [from_m, to_m] = self.extent_m[axis];
            let count = if to_m > from_m { CLUTTER_A_SIDE } else { 1 };
            (0..count).map(move |k| match count {
                1 => place_m[axis],
                _ => from_m + (to_m - from_m) * (k as f64 + 0.5) / count as f64,
            })
        };
        let places: Vec<[f64; 2]> = along(1)
            .flat_map(|y_m| along(0).map(move |x_m| [x_m, y_m]))
            .collect();
        let stride = places.len().div_ceil(8 * CLUTTER_A_SIDE).max(1);
        let mut per_energy: Vec<f64> = (places.into_par_iter().step_by(stride))
            .map(|[x_m, y_m]| {
                let z_m = ground.surface().height_m([x_m, y_m]) - depth_m;
                let place_m = [x_m, y_m, z_m];
                let own = self.seen(ground, place_m);
                let power = self.power(&self.stack(ground, &own, place_m), 0.0);
                power / energy(&own).max(f64::MIN_POSITIVE)
            })
            .collect();
        per_energy.sort_by(f64::total_cmp);
        let median = per_energy.get(per_energy.len() / 2).copied();
        // Powers of clutter are exponentially distributed.
        median.unwrap_or(0.0) / std::f64::consts::LN_2 * energy(seen)
    }
}

/// Where an echo has its greatest power.
#[derive(Clone, Copy)]
struct Best {
    place_m: [f64; 3],
    power: f64,
    /// By how much later than asked for, one way (m).
    later_m: f64,
}

/// What a vertical leg into the ground adds: to the delay, and to the distance of the hyperbola's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertical {
    /// Optical length Σ n t (m).
    pub delay_m: f64,
    /// Σ t/n (m).
    pub curvature_m: f64,
    /// Refractive index where it ends.
    pub index: f64,
}

/// The vertical leg to a depth below the surface.
pub(crate) fn vertical(ground: &Ground, depth_m: f64) -> Vertical {
    let mut leg = Vertical {
        delay_m: 0.0,
        curvature_m: 0.0,
        index: 1.0,
    };
    let mut left_m = depth_m;
    for layer in ground.layers() {
        let index = layer.soil.refractive_index(ground.ray_frequency_hz()).re;
        let within_m = left_m.min(layer.thickness_m);
        leg.delay_m += index * within_m;
        leg.curvature_m += within_m / index;
        leg.index = index;
        left_m -= within_m;
        if left_m <= 0.0 {
            break;
        }
    }
    leg
}

/// Depth below the surface at a delay straight down (m).
pub(crate) fn depth_at(ground: &Ground, delay_m: f64) -> f64 {
    let (mut left_m, mut depth_m) = (delay_m, 0.0);
    for layer in ground.layers() {
        let index = layer.soil.refractive_index(ground.ray_frequency_hz()).re;
        let within_m = (left_m / index).min(layer.thickness_m);
        depth_m += within_m;
        left_m -= index * within_m;
        if left_m <= 0.0 {
            break;
        }
    }
    depth_m
}

/// Steps to either side of the greatest power over which its curvature is taken.
const HALF_WIDTH: usize = 3;

/// Place and deviation of the maximum of a curve of powers over a mean power of clutter, whose logarithm of
/// likelihood is their ratio; none where the maximum lies at an end or is none.
fn vertex(curve: &[[f64; 2]], floor: f64) -> Option<[f64; 2]> {
    let top = (0..curve.len()).max_by(|a, b| curve[*a][1].total_cmp(&curve[*b][1]))?;
    if top == 0 || top + 1 >= curve.len() {
        return None;
    }
    // A parabola by least squares about the maximum, in q.
    let from = top.saturating_sub(HALF_WIDTH);
    let to = (top + HALF_WIDTH + 1).min(curve.len());
    let [q0, p0] = curve[top];
    let scale = (curve[from][0] - curve[to - 1][0]).abs();
    let mut normal = [[0.0; 3]; 3];
    let mut right = [0.0; 3];
    for [q, p] in &curve[from..to] {
        let t = (q - q0) / scale;
        let powers = [1.0, t, t * t];
        for i in 0..3 {
            right[i] += powers[i] * (p - p0) / floor;
            for j in 0..3 {
                normal[i][j] += powers[i] * powers[j];
            }
        }
    }
    let [_, slope, bend] = solved(normal, right)?;
    if bend >= 0.0 {
        return None;
    }
    let at = (-0.5 * slope / bend).clamp(-1.0, 1.0);
    Some([q0 + scale * at, scale / (-2.0 * bend).sqrt()])
}

/// Solution of three equations, by Cramer's rule.
fn solved(matrix: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let det = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = det(&matrix);
    let replaced = |column: usize| {
        let mut m = matrix;
        for row in 0..3 {
            m[row][column] = right[row];
        }
        det(&m) / whole
    };
    (whole.abs() > 1e-12).then(|| [0, 1, 2].map(replaced))
}

#[cfg(test)]
mod tests {
    use acerra_imaging::refraction::{Layer, Soil, Surface};

    use super::*;

    #[test]
    fn depths_and_delays_of_layers_are_inverse() {
        let soil = |relative_permittivity| Soil {
            relative_permittivity,
            conductivity_s_m: 0.0,
        };
        let top = Layer {
            soil: soil(4.0),
            thickness_m: 0.1,
        };
        let layers = [top, Layer::below_all(soil(9.0))];
        let ground = Ground::new(Surface::Level { z_m: 0.0 }, &layers, 1e9).unwrap();
        let leg = vertical(&ground, 0.3);
        assert!((leg.delay_m - (0.2 + 0.6)).abs() < 1e-12);
        assert!((leg.curvature_m - (0.05 + 0.2 / 3.0)).abs() < 1e-12);
        assert_eq!(leg.index, 3.0);
        assert!((depth_at(&ground, leg.delay_m) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn the_deviation_of_a_parabola_is_that_of_its_likelihood() {
        // Power over clutter of 50 − (q − 0.08)²/(2 · 0.01²).
        let curve: Vec<[f64; 2]> = (0..20)
            .map(|k| {
                let q = 0.2 / 1.1_f64.powi(k);
                [q, 7.0 * (50.0 - 0.5 * ((q - 0.08) / 0.01).powi(2))]
            })
            .collect();
        let [q, sigma] = vertex(&curve, 7.0).unwrap();
        assert!((q - 0.08).abs() < 1e-9 && (sigma - 0.01).abs() < 1e-9, "{q} {sigma}");
        assert_eq!(vertex(&curve[..3], 7.0), None);
    }
}
