//! Delay and curvature of the echo of a buried point.

use std::f64::consts::TAU;

use acerra_imaging::ImagingError;
use acerra_imaging::refraction::{Ground, Ray};
use nalgebra::{Matrix3, Vector3, Vector4};
use num_complex::Complex64;
use rayon::prelude::*;

use super::leg::{depth_at, vertical};
use super::phases::{Phase, regress};
use crate::echoes::Echoes;
use crate::focus::underground::Underground;

/// Traces that an echo is summed over at most, spread evenly.
const MOST_TRACES: usize = 300;
/// Traces whose amplitude by spreading and transmission is below this share of the greatest are left out.
const LEAST_AMPLITUDE: f64 = 0.25;
/// Ratio of one permittivity that is tried to the one before.
const RATIO: f64 = 1.1;
/// Delays tried within half a resolution cell, to either side.
const LAGS: i32 = 8;
/// Places along each side of the image at which the clutter is measured.
const CLUTTER_A_SIDE: usize = 24;
/// Horizontal step of the search about a point, of the wavelength in the middle of the band.
const STEP_WAVELENGTHS: f64 = 0.06;
/// Probability that the strongest of all places of clutter exceeds the level of a point.
pub(super) const FALSE_ALARM: f64 = 0.01;

/// Parameters of the echo of a buried point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointEcho {
    /// Place by the permittivities in force (m).
    pub place_m: [f64; 3],
    /// Delay below the surface straight under the antenna, as one-way optical length Σ n t (m).
    pub delay_m: f64,
    /// Distance q = Σ t/n by which the centre of its hyperbola lies below the surface (m).
    pub curvature_m: f64,
    /// Standard deviation of that distance, by the phases along the hyperbola (m).
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
    /// A trial of the spacing of traces along lines; none where positions are as they are.
    pub stretch: Option<Stretch<'a>>,
}

/// A trial of the spacing of a track's traces along its lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch<'a> {
    /// First trace of the track, and the one after its last.
    pub traces: [usize; 2],
    /// Horizontal direction of each trace's line, of length one; of all tracks.
    pub along: &'a [[f64; 2]],
    /// Positions over true distances along the lines, and across them.
    pub factors: [f64; 2],
}

impl Stretch<'_> {
    /// Difference of a trace's assumed from its true distance `away_m` from a point, east and north (m).
    fn nearer_m(&self, trace: usize, away_m: [f64; 2]) -> [f64; 2] {
        let [east, north] = self.along[trace];
        let along_m = away_m[0] * east + away_m[1] * north;
        let across_m = away_m[1] * east - away_m[0] * north;
        let [along_m, across_m] = [
            (1.0 - 1.0 / self.factors[0]) * along_m,
            (1.0 - 1.0 / self.factors[1]) * across_m,
        ];
        [
            along_m * east - across_m * north,
            along_m * north + across_m * east,
        ]
    }
}

/// An echo that exceeds the clutter at its depth.
pub(crate) struct Distinct {
    seen: Seen,
    /// Place at which the sum of the echo's traces is greatest (m).
    place_m: [f64; 3],
    /// Delay below the surface, as one-way optical length (m).
    delay_m: f64,
    /// Clutter in its power.
    share: f64,
}

/// Traces that see a point. All have equal weight: the clutter fades with distance as the echo does.
pub(super) struct Seen {
    pub traces: Vec<usize>,
    /// Number of traces before they were thinned out.
    pub of: usize,
}

impl Bench<'_> {
    /// Fits the hyperbola of the echo about a place of the image; none where no echo at the place exceeds the
    /// clutter, or where no permittivity from 1 to 100 maximises the coherent sum.
    pub fn fit(&self, place_m: [f64; 3]) -> Result<Option<PointEcho>, ImagingError> {
        let Some(Distinct {
            seen,
            place_m,
            delay_m,
            share,
        }) = self.distinct(place_m)?
        else {
            return Ok(None);
        };
        let Some(strongest) = self.strongest(&seen, place_m, delay_m)? else {
            return Ok(None);
        };
        let found = self.by_phases(strongest.factor, &seen, place_m, delay_m, share)?;
        Ok(found.map(|found| PointEcho {
            curvature_m: strongest.curvature_m.unwrap_or(found.curvature_m),
            ..found
        }))
    }

    /// The echo about a place of the image, where it exceeds the clutter at its depth by more than chance.
    pub fn distinct(&self, place_m: [f64; 3]) -> Result<Option<Distinct>, ImagingError> {
        let stated = self.ground(1.0)?;
        let surface_m = stated.surface().height_m([place_m[0], place_m[1]]);
        let seen = self.seen(&stated, place_m);
        let delay_m = vertical(&stated, surface_m - place_m[2]).delay_m - 0.5 * self.excess_path_m;
        if delay_m <= 0.0 || seen.traces.len() < 3 {
            return Ok(None);
        }
        let first = self.best_near(&stated, &seen, place_m, delay_m);
        let delay_m = delay_m + first.later_m;
        if delay_m <= 0.0 {
            return Ok(None);
        }
        let floor = self.clutter(&stated, &seen, first.place_m, delay_m);
        let most_chance = (self.places as f64 / FALSE_ALARM).ln();
        let is_distinct = floor > 0.0 && first.power >= most_chance * floor;
        Ok(is_distinct.then_some(Distinct {
            seen,
            place_m: first.place_m,
            delay_m,
            share: floor / first.power,
        }))
    }

    /// The factor of the permittivities at which the echo is strongest, and the curvature (m) by the powers about it; none
    /// where the first or the last factor tried is the strongest.
    fn strongest(
        &self,
        seen: &Seen,
        place_m: [f64; 3],
        delay_m: f64,
    ) -> Result<Option<Strongest>, ImagingError> {
        let factors = self.underground.factors(RATIO);
        let power = |factor: &f64| {
            let ground = self.ground(*factor)?;
            let curvature_m = vertical(&ground, depth_at(&ground, delay_m)).curvature_m;
            let power = self.best_near(&ground, seen, place_m, delay_m).power;
            Ok([curvature_m, power])
        };
        let curve: Vec<[f64; 2]> =
            (factors.par_iter().map(power)).collect::<Result<_, ImagingError>>()?;
        let top = (0..curve.len()).max_by(|a, b| curve[*a][1].total_cmp(&curve[*b][1]));
        let inside = top.filter(|top| *top > 0 && top + 1 < curve.len());
        Ok(inside.map(|top| Strongest {
            factor: factors[top],
            curvature_m: vertex(&curve, top),
        }))
    }

    /// Curvature of the hyperbola and its deviation (m), by the phases of the traces against their sum near a factor of
    /// the permittivities: the greatest power of the sum, with the deviation that the phases show which are left, and the
    /// share of `clutter` in the power.
    fn by_phases(
        &self,
        factor: f64,
        seen: &Seen,
        place_m: [f64; 3],
        delay_m: f64,
        clutter: f64,
    ) -> Result<Option<PointEcho>, ImagingError> {
        let (ground, other) = (self.ground(factor)?, self.ground(factor * RATIO)?);
        let best = self.best_near(&ground, seen, place_m, delay_m);
        let [x_m, y_m, _] = best.place_m;
        let surface_m = ground.surface().height_m([x_m, y_m]);
        let depths_m = [&ground, &other].map(|ground| depth_at(ground, delay_m));
        let [here, there] = depths_m.map(|depth_m| [x_m, y_m, surface_m - depth_m]);
        let curvature_m = vertical(&ground, depths_m[0]).curvature_m;
        let step_m = vertical(&other, depths_m[1]).curvature_m - curvature_m;
        let traces: Vec<Phase> = (seen.traces.par_iter())
            .map(|trace| {
                let rays = self.rays(&ground, *trace, here);
                let path_m = |rays: [Ray; 2]| rays[0].optical_m + rays[1].optical_m;
                let by_axis = |axis: usize| rays[0].gradient[axis] + rays[1].gradient[axis];
                let by_curvature =
                    (path_m(self.rays(&other, *trace, there)) - path_m(rays)) / step_m;
                Phase {
                    by: Vector4::new(1.0, by_axis(0), by_axis(1), by_curvature),
                    value: self.sum_at(&ground, *trace, here, best.later_m),
                }
            })
            .collect();
        let correction = regress(&traces, best.wavelength_m, clutter);
        Ok(correction.map(|[off_m, sigma_m]| PointEcho {
            place_m: [x_m, y_m, place_m[2]],
            delay_m: delay_m + best.later_m,
            curvature_m: curvature_m + off_m,
            sigma_m,
        }))
    }

    pub(super) fn ground(&self, factor: f64) -> Result<Ground, ImagingError> {
        let frequency_hz = &self.echoes.spectrum.frequency_hz;
        self.underground.scaled(factor).seen_at(frequency_hz)
    }

    /// The traces that see a place.
    pub(super) fn seen(&self, ground: &Ground, place_m: [f64; 3]) -> Seen {
        let all = self.echoes.aligned.position_m.len();
        let [first, end] = self.stretch.map_or([0, all], |stretch| stretch.traces);
        let amplitude: Vec<(usize, f64)> = (first..end)
            .into_par_iter()
            .map(|trace| {
                let [there, back] = self.rays(ground, trace, place_m);
                (trace, there.amplitude * back.amplitude)
            })
            .collect();
        let least = LEAST_AMPLITUDE * amplitude.iter().map(|a| a.1).fold(0.0, f64::max);
        let near = amplitude.into_iter().filter(|a| a.1 >= least);
        let near: Vec<usize> = near.map(|(trace, _)| trace).collect();
        let stride = near.len().div_ceil(MOST_TRACES).max(1);
        Seen {
            of: near.len(),
            traces: near.into_iter().step_by(stride).collect(),
        }
    }

    pub(super) fn rays(&self, ground: &Ground, trace: usize, place_m: [f64; 3]) -> [Ray; 2] {
        let aligned = self.echoes.aligned;
        // The places of the traces about the point are scaled, not the distance of the antennas from each other.
        let nearer_m = self.stretch.map_or([0.0; 2], |stretch| {
            let away_m = [0, 1].map(|k| aligned.position_m[trace][k] - place_m[k]);
            stretch.nearer_m(trace, away_m)
        });
        aligned
            .antennas_at_m(trace)
            .map(|[x_m, y_m, z_m]| ground.ray([x_m - nearer_m[0], y_m - nearer_m[1], z_m], place_m))
    }

    /// A trace with the echo of a place at a delay of zero, at each frequency.
    fn aligned(
        &self,
        ground: &Ground,
        trace: usize,
        place_m: [f64; 3],
    ) -> impl Iterator<Item = Complex64> {
        let spectrum = self.echoes.spectrum;
        let [there, back] = self.rays(ground, trace, place_m);
        let path_m = there.optical_m + back.optical_m + self.excess_path_m;
        let turn = TAU * path_m / self.echoes.light_speed_m_s;
        let values = spectrum
            .values
            .iter()
            .skip(trace * spectrum.frequency_hz.len());
        (values.zip(&spectrum.frequency_hz))
            .map(move |(value, f)| value * Complex64::from_polar(1.0, turn * f))
    }

    /// Sum over the frequencies of a trace with the echo of a place, which comes `later_m` (one way) after its geometry, at
    /// a delay of zero.
    pub(super) fn sum_at(
        &self,
        ground: &Ground,
        trace: usize,
        place_m: [f64; 3],
        later_m: f64,
    ) -> Complex64 {
        let later_s = 2.0 * later_m / self.echoes.light_speed_m_s;
        let values = self.aligned(ground, trace, place_m);
        (values.zip(&self.echoes.spectrum.frequency_hz))
            .map(|(value, f)| value * Complex64::from_polar(1.0, TAU * f * later_s))
            .sum()
    }

    /// Sum of the traces along the echo of a place, at each frequency.
    fn stack(&self, ground: &Ground, seen: &Seen, place_m: [f64; 3]) -> Vec<Complex64> {
        let mut sum = vec![Complex64::default(); self.echoes.spectrum.frequency_hz.len()];
        for trace in &seen.traces {
            for (sum, value) in sum.iter_mut().zip(self.aligned(ground, *trace, place_m)) {
                *sum += value;
            }
        }
        sum
    }

    /// Greatest power of the echo at this delay, within half a cell of it, over places within a step horizontally.
    pub(super) fn best_near(
        &self,
        ground: &Ground,
        seen: &Seen,
        place_m: [f64; 3],
        delay_m: f64,
    ) -> Best {
        let frequency_hz = &self.echoes.spectrum.frequency_hz;
        let middle_hz = frequency_hz.iter().sum::<f64>() / frequency_hz.len().max(1) as f64;
        let step_m = STEP_WAVELENGTHS * self.echoes.light_speed_m_s / middle_hz;
        let depth_m = depth_at(ground, delay_m);
        let at = |place_m: [f64; 2]| {
            let z_m = ground.surface().height_m(place_m) - depth_m;
            let place_m = [place_m[0], place_m[1], z_m];
            Best {
                place_m,
                ..self.peak(&self.stack(ground, seen, place_m))
            }
        };
        let mut best = at([place_m[0], place_m[1]]);
        for axis in (0..2).filter(|axis| self.extent_m[*axis][1] > self.extent_m[*axis][0]) {
            let at_offset = |off_m: f64| {
                let mut place_m = [best.place_m[0], best.place_m[1]];
                place_m[axis] += off_m;
                at(place_m)
            };
            let (before, after) = (at_offset(-step_m), at_offset(step_m));
            let bend = before.power - 2.0 * best.power + after.power;
            let toward = 0.5 * (before.power - after.power) / bend;
            let refined = (bend < 0.0).then(|| at_offset(step_m * toward.clamp(-1.0, 1.0)));
            for other in [before, after].into_iter().chain(refined) {
                if other.power > best.power {
                    best = other;
                }
            }
        }
        best
    }

    /// Greatest power of a stack within half a cell of its delay.
    fn peak(&self, stack: &[Complex64]) -> Best {
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
        let turned = self.turned(stack, later_s);
        let sum: Complex64 = turned.clone().sum();
        let frequency_hz = self.echoes.spectrum.frequency_hz.iter();
        let moment: Complex64 = turned.zip(frequency_hz).map(|(v, f)| v * f).sum();
        Best {
            place_m: [0.0; 3],
            power: sum.norm_sqr(),
            later_m: 0.5 * later_s * self.echoes.light_speed_m_s,
            wavelength_m: self.echoes.light_speed_m_s / (moment / sum).re,
        }
    }

    fn power(&self, stack: &[Complex64], lag_s: f64) -> f64 {
        self.turned(stack, lag_s).sum::<Complex64>().norm_sqr()
    }

    fn turned(&self, stack: &[Complex64], lag_s: f64) -> impl Iterator<Item = Complex64> + Clone {
        let frequency_hz = self.echoes.spectrum.frequency_hz.iter();
        (frequency_hz.zip(stack))
            .map(move |(f, value)| value * Complex64::from_polar(1.0, TAU * f * lag_s))
    }

    /// Resolution cell of the delay (s): the inverse of the band.
    fn cell_s(&self) -> f64 {
        let frequency_hz = &self.echoes.spectrum.frequency_hz;
        let [low, high] = [frequency_hz.first(), frequency_hz.last()].map(|f| f.copied());
        1.0 / (high.unwrap_or(1.0) - low.unwrap_or(0.0)).max(1.0)
    }

    /// Mean power of the clutter at this delay below the surface, for a place that is seen as `seen` is: by the median
    /// over the image, of which points are few.
    pub(super) fn clutter(
        &self,
        ground: &Ground,
        seen: &Seen,
        place_m: [f64; 3],
        delay_m: f64,
    ) -> f64 {
        let depth_m = depth_at(ground, delay_m);
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
        let mut per_trace: Vec<f64> = (places.into_par_iter().step_by(stride))
            .map(|[x_m, y_m]| {
                let z_m = ground.surface().height_m([x_m, y_m]) - depth_m;
                let place_m = [x_m, y_m, z_m];
                let own = self.seen(ground, place_m);
                let power = self.power(&self.stack(ground, &own, place_m), 0.0);
                power / own.traces.len().max(1) as f64
            })
            .collect();
        per_trace.sort_by(f64::total_cmp);
        let median = per_trace.get(per_trace.len() / 2).copied();
        // Powers of clutter are exponentially distributed.
        median.unwrap_or(0.0) / std::f64::consts::LN_2 * seen.traces.len() as f64
    }
}

/// Place at which the power of a hyperbola's sum is greatest.
struct Strongest {
    factor: f64,
    /// By a parabola through the powers, where they fall slowly enough for one.
    curvature_m: Option<f64>,
}

/// Steps to either side of the greatest power, and least share of that power, over which a parabola is laid:
/// clutter ripples the powers, more where the powers fall less.
const HALF_WIDTH: usize = 3;
const LEAST_POWER: f64 = 0.8;

/// Maximum of a parabola by least squares through the powers about the greatest; none where the powers fall
/// within fewer steps on either side than the parabola needs.
pub(super) fn vertex(curve: &[[f64; 2]], top: usize) -> Option<f64> {
    let about = curve.get(top.checked_sub(HALF_WIDTH)?..=top + HALF_WIDTH)?;
    let [at, most] = curve[top];
    if about.iter().any(|[_, power]| *power < LEAST_POWER * most) {
        return None;
    }
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for [q, power] in about {
        let t = q / at - 1.0;
        let powers = Vector3::new(1.0, t, t * t);
        normal += powers * powers.transpose();
        right += power / most * powers;
    }
    let [_, slope, bend] = (normal.try_inverse()? * right).into();
    (bend < 0.0).then(|| at * (1.0 - 0.5 * slope / bend))
}

/// Place at which an echo has its greatest power.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub place_m: [f64; 3],
    pub power: f64,
    /// Excess delay over the requested delay, one way (m).
    pub later_m: f64,
    /// Wavelength in air by which its phase turns with the path (m).
    pub wavelength_m: f64,
}

#[cfg(test)]
mod tests {
    use acerra_radar::Spectrum;

    use super::*;
    use crate::position::aligned::Aligned;

    #[test]
    fn a_parabola_through_rippled_powers_has_the_maximum_of_their_trend() {
        let curve: Vec<[f64; 2]> = (0..30)
            .map(|k| {
                let q = 0.3 / 1.1_f64.powi(k);
                let ripple = 2e-3 * f64::from(k % 2);
                [q, 7.0 * (1.0 - 0.5 * ((q - 0.08) / 0.2).powi(2) + ripple)]
            })
            .collect();
        let top = (0..30)
            .max_by(|a, b| curve[*a][1].total_cmp(&curve[*b][1]))
            .unwrap();
        let found = vertex(&curve, top).unwrap();
        assert!((found - 0.08).abs() < 8e-3, "{found}");
        assert_eq!(vertex(&curve, 1), None);
        let narrow: Vec<[f64; 2]> = curve.iter().map(|[q, p]| [*q, p.powi(100)]).collect();
        assert_eq!(vertex(&narrow, top), None);
    }

    /// A flight over points below a level surface: its echoes, and noise of this amplitude in every value.
    fn flight(points: &[[f64; 3]], ground: &Ground, noise: f64, seed: u64) -> (Aligned, Spectrum) {
        let position_m: Vec<[f64; 3]> = (0..90)
            .map(f64::from)
            .map(|k| [0.025 * k, 0.0, 0.9 + 0.04 * (0.2 * k).sin()])
            .collect();
        let frequency_hz: Vec<f64> = (0..81).map(|k| 0.5e9 + 25e6 * f64::from(k)).collect();
        let mut state = seed;
        let mut uniform = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let mut values = Vec::new();
        for antenna_m in &position_m {
            let rays: Vec<Ray> = points.iter().map(|p| ground.ray(*antenna_m, *p)).collect();
            for f in &frequency_hz {
                let echoes = rays.iter().map(|ray| {
                    let turn = -TAU * f * 2.0 * ray.optical_m / 299_792_458.0;
                    Complex64::from_polar(ray.amplitude * ray.amplitude, turn)
                });
                let modulus = noise * (-uniform().ln()).sqrt();
                let clutter = Complex64::from_polar(modulus, TAU * uniform());
                values.push(echoes.sum::<Complex64>() + clutter);
            }
        }
        let aligned = Aligned {
            position_m,
            ..Aligned::default()
        };
        let spectrum = Spectrum {
            time_s: vec![0.0; 90],
            frequency_hz,
            values,
        };
        (aligned, spectrum)
    }

    fn fitted(aligned: &Aligned, spectrum: &Spectrum, near_m: [f64; 3]) -> Option<PointEcho> {
        let underground = Underground::of_soil(9.0);
        let bench = Bench {
            echoes: Echoes {
                spectrum,
                aligned,
                light_speed_m_s: 299_792_458.0,
            },
            underground: &underground,
            excess_path_m: 0.0,
            extent_m: [[0.3, 2.0], [0.0, 0.0]],
            places: 10_000,
            stretch: None,
        };
        bench.fit(near_m).unwrap()
    }

    #[test]
    fn points_have_the_delay_and_the_curvature_of_their_depth_whatever_is_stated() {
        let ground = Underground::of_soil(6.0).seen_at(&[1.5e9]).unwrap();
        let point = [1.1, 0.0, -0.2];
        let (aligned, spectrum) = flight(&[point], &ground, 1e-4, 1);
        // Seen at a permittivity of 9, the point appears higher.
        let near = [1.11, 0.0, -0.2 * (6.0_f64 / 9.0).sqrt() - 0.005];
        let found = fitted(&aligned, &spectrum, near).unwrap();
        assert!(
            (found.delay_m - 0.2 * 6.0_f64.sqrt()).abs() < 2e-3,
            "{found:?}"
        );
        assert!(
            (found.curvature_m - 0.2 / 6.0_f64.sqrt()).abs() < 1e-3,
            "{found:?}"
        );
        assert!((found.place_m[0] - 1.1).abs() < 3e-3, "{found:?}");
    }

    #[test]
    fn curvatures_scatter_as_their_deviations_say() {
        let ground = Underground::of_soil(9.0).seen_at(&[1.5e9]).unwrap();
        let point = [1.1, 0.0, -0.2];
        let scatter: Vec<f64> = (0..24)
            .filter_map(|seed| {
                let (aligned, spectrum) = flight(&[point], &ground, 1.5, 77 + seed);
                let found = fitted(&aligned, &spectrum, point)?;
                Some((found.curvature_m - 0.2 / 3.0) / found.sigma_m)
            })
            .collect();
        assert!(scatter.len() > 20, "{}", scatter.len());
        let rms = (scatter.iter().map(|z| z * z).sum::<f64>() / scatter.len() as f64).sqrt();
        assert!((0.6..1.4).contains(&rms), "{rms} {scatter:?}");
        assert!(scatter.iter().all(|z| z.abs() < 3.5), "{scatter:?}");
    }

    #[test]
    fn noise_is_no_point() {
        let ground = Underground::of_soil(9.0).seen_at(&[1.5e9]).unwrap();
        let (aligned, spectrum) = flight(&[], &ground, 1.0, 5);
        for x_m in [0.5, 0.9, 1.3, 1.7] {
            assert_eq!(fitted(&aligned, &spectrum, [x_m, 0.0, -0.2]), None);
        }
    }
}
