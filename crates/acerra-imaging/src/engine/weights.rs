//! Weights of contributions by spreading and incidence, and the double-precision sums that use them.

use crate::engine::level_law::{LawPoint, LevelLaw, transmitted};
use crate::engine::reference::pulse_at_range;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::incidence::IncidenceWeight;
use crate::kernel::cosine_power::CosinePower;
use crate::kernel::direct::job::{PixelWeight, TiltView};
use crate::kernel::level::SimdLevel;
use crate::kernel::profile::{DELAYS, even_sums};
use crate::pulses::{Pulses, Spreading};
use crate::refraction::{MAX_LAYERS, Ray};
use crate::vector::{dot, range_m};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Weights by range and incidence, the same for every frequency.
#[derive(Debug, Clone)]
pub(crate) struct Weights {
    pub spreading: Spreading,
    incidence: Option<(IncidenceWeight, Vec<f64>)>,
    /// Cosine of the angle from the vertical at which the edge of the limit begins.
    edge_below_cosine: f64,
    tilt: Option<Tilt>,
    /// Rays to a level plane below level ground: optical length and weight as functions of the distance.
    pub law: Option<LevelLaw>,
}

/// Antennas that do not look straight down.
#[derive(Debug, Clone)]
struct Tilt {
    /// Unit vectors in which they look.
    boresight: Vec<[f64; 3]>,
    /// Those divided by the heights above the plane, 1/m.
    per_metre: Vec<[f64; 3]>,
    power: CosinePower,
}

/// Least height that boresights are divided by, m: below it the pattern from the vertical is 0 all around.
const LEAST_HEIGHT_M: f64 = 1e-6;

impl Weights {
    /// # Errors
    /// Angles that have no meaning, or a weight by incidence over ground that is not level.
    pub fn new(
        pulses: &Pulses,
        grid: &ImageGrid,
        spreading: Spreading,
        incidence: Option<IncidenceWeight>,
    ) -> Result<Self, ImagingError> {
        let plane_z_m = grid.plane().origin_m[2];
        let height = |p: &[f64; 3]| (p[2] - plane_z_m).abs();
        let incidence = match incidence {
            None => None,
            Some(_) if !grid.is_level() => return Err(ImagingError::NotLevel),
            Some(weight) => {
                let height_m = pulses.position_m().iter().map(height).collect();
                Some((weight.checked()?, height_m))
            }
        };
        let tilt = match (&incidence, pulses.boresight()) {
            (Some((weight, height_m)), Some(boresight)) if weight.cosine_power > 0.0 => {
                let divided = |(b, h): (&[f64; 3], &f64)| b.map(|v| v / h.max(LEAST_HEIGHT_M));
                Some(Tilt {
                    boresight: boresight.to_vec(),
                    per_metre: boresight.iter().zip(height_m).map(divided).collect(),
                    power: CosinePower::new(weight.cosine_power),
                })
            }
            _ => None,
        };
        // The pattern of antennas apart weights both rays.
        let has_law = tilt.is_none() && (incidence.is_none() || !pulses.is_bistatic());
        let law = has_law.then(|| LevelLaw::new(pulses, grid)).flatten();
        let edge_begins = |(w, _): &(IncidenceWeight, _)| (w.max_rad - w.taper_rad).max(0.0).cos();
        Ok(Self {
            spreading,
            edge_below_cosine: incidence.as_ref().map_or(1.0, edge_begins),
            incidence,
            tilt,
            law,
        })
    }

    /// Those of the pulses `range`.
    pub fn slice(&self, range: Range<usize>) -> Self {
        let of_range = |(weight, height_m): &(IncidenceWeight, Vec<f64>)| {
            (*weight, height_m[range.clone()].to_vec())
        };
        Self {
            spreading: self.spreading,
            incidence: self.incidence.as_ref().map(of_range),
            edge_below_cosine: self.edge_below_cosine,
            tilt: self.tilt.as_ref().map(|tilt| Tilt {
                boresight: tilt.boresight[range.clone()].to_vec(),
                per_metre: tilt.per_metre[range.clone()].to_vec(),
                power: tilt.power,
            }),
            law: self.law.as_ref().map(|law| law.slice(range)),
        }
    }

    /// Whether weights depend on the direction of a ray.
    pub fn is_directed(&self) -> bool {
        self.incidence.is_some()
    }

    /// 1 everywhere.
    pub fn unit() -> Self {
        Self {
            spreading: Spreading::None,
            incidence: None,
            edge_below_cosine: 1.0,
            tilt: None,
            law: None,
        }
    }

    #[cfg(test)]
    pub fn spreading_alone(spreading: Spreading) -> Self {
        Self {
            spreading,
            ..Self::unit()
        }
    }

    /// Weight of what `pulse` sees at `range_m` in the direction `from_antenna_m`.
    pub fn at(&self, pulse: usize, range_m: f64, from_antenna_m: [f64; 3]) -> f64 {
        let spreading = self.spreading.weight(range_m);
        match (&self.incidence, &self.tilt) {
            (None, _) => spreading,
            (Some(_), None) => spreading * self.incidence_at(pulse, range_m),
            (Some((weight, height_m)), Some(tilt)) => {
                let range_m = range_m.max(1e-12);
                let vertical_rad = (height_m[pulse] / range_m).min(1.0).acos();
                let cosine = dot(tilt.boresight[pulse], from_antenna_m) / range_m;
                spreading * weight.edge(vertical_rad) * weight.pattern(cosine)
            }
        }
    }

    /// Weight of what `pulse` sees along two rays, without absorption: incidence and pattern count where they leave
    /// the antennas, as the geometric mean of both.
    fn along(&self, pulse: usize, rays: &[Ray; 2]) -> f64 {
        let spreading = match self.spreading {
            Spreading::InverseSquare => rays[0].amplitude * rays[1].amplitude,
            Spreading::None => 1.0,
        };
        let Some((weight, _)) = &self.incidence else {
            return spreading;
        };
        let departing = |ray: &Ray| {
            let vertical = -ray.departure[2];
            let cosine = match &self.tilt {
                Some(tilt) => dot(tilt.boresight[pulse], ray.departure),
                None => vertical,
            };
            weight.edge(vertical.clamp(-1.0, 1.0).acos()) * weight.pattern(cosine)
        };
        spreading * (departing(&rays[0]) * departing(&rays[1])).sqrt()
    }

    /// Weight of what a ray of the level law brings.
    pub fn of_law(&self, point: &LawPoint) -> f64 {
        let spreading = match self.spreading {
            Spreading::InverseSquare => point.amplitude * point.amplitude,
            Spreading::None => 1.0,
        };
        let incidence = self.incidence.as_ref().map_or(1.0, |(weight, _)| {
            let cosine = point.cosine.clamp(0.0, 1.0);
            weight.edge(cosine.acos()) * weight.pattern(cosine)
        });
        spreading * incidence * point.transmitted
    }

    /// The pattern of antennas that do not look straight down: tables hold that of ones that do.
    pub fn tilt(&self) -> Option<TiltView<'_>> {
        self.tilt.as_ref().map(|tilt| TiltView {
            per_metre: &tilt.per_metre,
            power: tilt.power,
        })
    }

    fn incidence_at(&self, pulse: usize, range_m: f64) -> f64 {
        let Some((weight, height_m)) = &self.incidence else {
            return 1.0;
        };
        let cosine = height_m[pulse] / range_m.max(1e-12);
        if cosine >= 1.0 {
            return 1.0;
        }
        // Angles are of use at the edge alone.
        let edge = if cosine >= self.edge_below_cosine {
            1.0
        } else {
            weight.edge(cosine.acos())
        };
        weight.pattern(cosine) * edge
    }

    /// The [`Weights::expansion`] that all pulses share; `None` where each has its own, or the weight is 1.
    pub fn shared_expansion(&self, bin: f64, bin_m: f64) -> Option<[f64; 4]> {
        match self.incidence {
            None => self.expansion(0, bin, bin_m),
            Some(_) => None,
        }
    }

    /// Powers 0 to 3 of δ of the weight at range (`bin` + δ)·`bin_m`, |δ| ≤ ½; `None` where it is 1
    /// everywhere.
    pub fn expansion(&self, pulse: usize, bin: f64, bin_m: f64) -> Option<[f64; 4]> {
        let spreading = match self.spreading {
            Spreading::None => None,
            Spreading::InverseSquare => {
                let e = 1.0 / bin;
                let scale = (e / bin_m) * (e / bin_m);
                Some([1.0, -2.0 * e, 3.0 * e * e, -4.0 * e * e * e].map(|g| g * scale))
            }
        };
        if self.incidence.is_none() {
            return spreading;
        }
        let at = |delta: f64| self.incidence_at(pulse, (bin + delta) * bin_m);
        let (before, here, after) = (at(-0.5), at(0.0), at(0.5));
        let incidence = [
            here,
            after - before,
            2.0 * (after + before - 2.0 * here),
            0.0,
        ];
        Some(spreading.map_or(incidence, |s| {
            std::array::from_fn(|k| (0..=k).map(|q| s[k - q] * incidence[q]).sum())
        }))
    }
}

/// Pulses with their weights: what every engine sums.
#[derive(Debug, Clone)]
pub(crate) struct WeightedPulses<'a> {
    pub pulses: Pulses<'a>,
    pub weights: Weights,
    /// The step of even frequencies, Hz.
    step_hz: Option<f64>,
    /// What a metre in each layer adds to the optical length at every frequency, `[N]`; empty without losses.
    dispersion: Arc<[[Complex64; MAX_LAYERS]]>,
}

/// The way of an echo from transmitter to point to receiver.
struct Way {
    /// Half of its optical length, m: the range in air.
    half_m: f64,
    /// Half of its length in each layer of ground, m.
    soil_m: [f64; MAX_LAYERS],
    /// Weight of the pulse and of the contribution, without absorption.
    factor: f64,
}

/// Frequencies after which a recurrent phasor is computed afresh, so that it stays exact.
const RENEW: usize = 32;

/// Pulses of a segment: sums of segments are added, so that several threads share a point.
const SEGMENT: usize = 64;

/// Σ_n E(m, n) e^{+j4πf_n R/c} for frequencies `step_hz` apart.
pub(crate) fn profile_at(pulses: &Pulses, pulse: usize, range_m: f64, step_hz: f64) -> Complex64 {
    profiles_at(pulses, pulse, &[range_m; DELAYS], step_hz)[0]
}

/// The same at several ranges.
fn profiles_at(
    pulses: &Pulses,
    pulse: usize,
    ranges_m: &[f64; DELAYS],
    step_hz: f64,
) -> [Complex64; DELAYS] {
    let slowness_s_m = 2.0 / pulses.light_speed_m_s();
    let start_hz = pulses.frequency_hz()[0];
    let delays_s = ranges_m.map(|range| slowness_s_m * range);
    even_sums(
        SimdLevel::detect(),
        pulses.spectrum_of(pulse),
        [start_hz, step_hz],
        &delays_s,
    )
}

/// What a metre in each layer adds to the optical length at every frequency, `[N]`; empty without losses.
fn dispersion(pulses: &Pulses) -> Arc<[[Complex64; MAX_LAYERS]]> {
    let Some(ground) = pulses.ground().filter(|ground| ground.is_lossy()) else {
        return Arc::new([]);
    };
    let of_layer = |f: f64, k: usize| {
        let mut metre = [0.0; MAX_LAYERS];
        metre[k] = 1.0;
        ground.dispersion_m(f, &metre)
    };
    let at = |f: &f64| std::array::from_fn(|k| of_layer(*f, k));
    pulses.frequency_hz().iter().map(at).collect()
}

impl<'a> WeightedPulses<'a> {
    pub fn new(pulses: Pulses<'a>, weights: Weights) -> Self {
        Self {
            step_hz: pulses.frequency_step_hz(),
            dispersion: dispersion(&pulses),
            pulses,
            weights,
        }
    }

    /// The pulses `range`, borrowed from the same arrays, with their weights.
    ///
    /// # Errors
    /// An empty range, or one that ends beyond the last pulse.
    pub fn slice(&self, range: Range<usize>) -> Result<WeightedPulses<'a>, ImagingError> {
        Ok(WeightedPulses {
            pulses: self.pulses.slice(range.clone())?,
            weights: self.weights.slice(range),
            step_hz: self.step_hz,
            dispersion: Arc::clone(&self.dispersion),
        })
    }
}

impl WeightedPulses<'_> {
    /// Whether frequencies are evenly spaced.
    pub fn is_even(&self) -> bool {
        self.step_hz.is_some()
    }

    /// The weight that tables do not hold, as the kernels of imaging read it.
    pub fn pixel_weight(&self) -> Option<PixelWeight<'_>> {
        let tilt = || self.weights.tilt().map(PixelWeight::Tilt);
        self.has_two_spreadings()
            .then_some(PixelWeight::Ways)
            .or_else(tilt)
    }

    /// Whether the ways there and back spread by themselves: a contribution weighs 1/(R_t R_r), of which tables hold
    /// 1/S² at the mean S of both ranges.
    pub fn has_two_spreadings(&self) -> bool {
        self.pulses.is_bistatic() && self.weights.spreading == Spreading::InverseSquare
    }

    /// Number of pulses.
    pub fn len(&self) -> usize {
        self.pulses.len()
    }

    /// Weight of a pulse times that of its contribution at a point.
    pub fn factor(&self, pulse: usize, range_m: f64, point_m: [f64; 3]) -> f64 {
        let p = self.pulses.position_m()[pulse];
        let from_antenna_m = std::array::from_fn(|axis| point_m[axis] - p[axis]);
        self.pulses.weight()[pulse] * self.weights.at(pulse, range_m, from_antenna_m)
    }

    /// Weighted contributions of one pulse at [`DELAYS`] points at most, in double precision; the rest of the
    /// values has no meaning.
    pub fn contributions(&self, pulse: usize, points_m: &[[f64; 3]]) -> [Complex64; DELAYS] {
        if !self.pulses.is_plain() {
            return self.contributions_along_rays(pulse, points_m);
        }
        let antenna_m = self.pulses.position_m()[pulse];
        let mut ranges_m = [0.0; DELAYS];
        for (range, point) in ranges_m.iter_mut().zip(points_m) {
            *range = range_m(antenna_m, *point);
        }
        let mut values = self.profiles(pulse, &ranges_m, points_m.len());
        for (value, (range, point)) in values.iter_mut().zip(ranges_m.iter().zip(points_m)) {
            *value *= self.factor(pulse, *range, *point);
        }
        values
    }

    fn contributions_along_rays(&self, pulse: usize, points_m: &[[f64; 3]]) -> [Complex64; DELAYS] {
        let ways: Vec<Way> = (points_m.iter())
            .map(|point_m| self.way(pulse, *point_m))
            .collect();
        let mut half_ways_m = [0.0; DELAYS];
        for (half_m, way) in half_ways_m.iter_mut().zip(&ways) {
            *half_m = way.half_m;
        }
        let mut values = self.profiles(pulse, &half_ways_m, ways.len());
        for (value, way) in values.iter_mut().zip(&ways) {
            if way.soil_m[0] > 0.0 && !self.dispersion.is_empty() {
                *value = (self.pulses.spectrum_of(pulse).iter().enumerate())
                    .map(|(n, e)| e * self.echo_of(way, n).conj())
                    .sum();
            }
            *value *= way.factor;
        }
        values
    }

    /// Σ_n E(m, n) e^{+j4πf_n R/c} of a pulse at the first `count` of some ranges; the rest has no meaning.
    fn profiles(
        &self,
        pulse: usize,
        ranges_m: &[f64; DELAYS],
        count: usize,
    ) -> [Complex64; DELAYS] {
        if let Some(step_hz) = self.step_hz {
            return profiles_at(&self.pulses, pulse, ranges_m, step_hz);
        }
        let mut profiles = [Complex64::ZERO; DELAYS];
        for (profile, range) in profiles.iter_mut().zip(ranges_m).take(count) {
            *profile = pulse_at_range(&self.pulses, pulse, *range);
        }
        profiles
    }

    fn way(&self, pulse: usize, point_m: [f64; 3]) -> Way {
        self.way_of(pulse, &self.pulses.rays(pulse, point_m))
    }

    fn way_of(&self, pulse: usize, rays: &[Ray; 2]) -> Way {
        let [down, back] = rays;
        Way {
            half_m: 0.5 * (down.optical_m + back.optical_m),
            soil_m: std::array::from_fn(|k| 0.5 * (down.soil_m[k] + back.soil_m[k])),
            factor: self.pulses.weight()[pulse] * self.weights.along(pulse, rays),
        }
    }

    /// Phase and absorption of the echo of a way at frequency `n`.
    fn echo_of(&self, way: &Way, n: usize) -> Complex64 {
        let wavenumber = 4.0 * PI * self.pulses.frequency_hz()[n] / self.pulses.light_speed_m_s();
        let mut length = Complex64::new(way.half_m, 0.0);
        if let Some(of_metre) = self.dispersion.get(n) {
            for (of_metre, soil) in of_metre.iter().zip(way.soil_m) {
                length += of_metre * soil;
            }
        }
        (-Complex64::I * length * wavenumber).exp()
    }

    /// Half the optical length of an echo's way, m, its weight with the absorption at the frequency of the rays, and the
    /// change of the half length where the point moves by `step_m`: what tables over frequencies need, exact where
    /// losses do not depend on frequency.
    pub fn half_way(&self, pulse: usize, point_m: [f64; 3], step_m: [f64; 3]) -> [f64; 3] {
        let rays = self.pulses.rays(pulse, point_m);
        let moved_m = 0.5 * (dot(rays[0].gradient, step_m) + dot(rays[1].gradient, step_m));
        let [half_m, weight] = self.half_way_along(pulse, &rays);
        [half_m, weight, moved_m]
    }

    /// Length and weight of [`WeightedPulses::half_way`] along the rays from transmitter and receiver.
    pub fn half_way_along(&self, pulse: usize, rays: &[Ray; 2]) -> [f64; 2] {
        let [half_m, weight] = self.along_rays(pulse, rays);
        [half_m, self.pulses.weight()[pulse] * weight]
    }

    /// Those without the weight of the pulse.
    pub fn along_rays(&self, pulse: usize, [down, back]: &[Ray; 2]) -> [f64; 2] {
        let soil_m = std::array::from_fn(|k| 0.5 * (down.soil_m[k] + back.soil_m[k]));
        let transmitted = self.pulses.ground().map_or(1.0, |ground| {
            transmitted(ground, &soil_m, self.pulses.light_speed_m_s())
        });
        let weight = self.weights.along(pulse, &[*down, *back]);
        [
            0.5 * (down.optical_m + back.optical_m),
            weight * transmitted,
        ]
    }

    /// Eq. (3) at points in double precision; once cancelled, values have no meaning.
    pub fn adjoint_at(
        &self,
        points_m: &[[f64; 3]],
        is_cancelled: impl Fn() -> bool + Sync,
    ) -> Vec<Complex64> {
        let segments = self.len().div_ceil(SEGMENT);
        let of_segment = |some: &[[f64; 3]], k: usize| {
            if is_cancelled() {
                return [Complex64::ZERO; DELAYS];
            }
            let mut sums = [Complex64::ZERO; DELAYS];
            for pulse in k * SEGMENT..((k + 1) * SEGMENT).min(self.len()) {
                for (sum, value) in sums.iter_mut().zip(self.contributions(pulse, some)) {
                    *sum += value;
                }
            }
            sums
        };
        points_m
            .par_chunks(DELAYS)
            .flat_map_iter(|some| {
                let of_segments: Vec<_> = (0..segments)
                    .into_par_iter()
                    .map(|k| of_segment(some, k))
                    .collect();
                (0..some.len()).map(move |at| of_segments.iter().map(|sums| sums[at]).sum())
            })
            .collect()
    }

    /// Adds to `spectrum` `[N]` what a scatterer at `point_m` returns to `pulse`: Eq. (1) in double
    /// precision, times the weights.
    pub fn add_echo(
        &self,
        pulse: usize,
        point_m: [f64; 3],
        reflectivity: Complex64,
        spectrum: &mut [Complex64],
    ) {
        if !self.pulses.is_plain() {
            let way = self.way(pulse, point_m);
            for (n, e) in spectrum.iter_mut().enumerate() {
                *e += reflectivity * way.factor * self.echo_of(&way, n);
            }
            return;
        }
        let range = range_m(self.pulses.position_m()[pulse], point_m);
        let amplitude = reflectivity * self.factor(pulse, range, point_m);
        let delay = 4.0 * PI * range / self.pulses.light_speed_m_s();
        let f = self.pulses.frequency_hz();
        let Some(step_hz) = self.step_hz else {
            for (e, f) in spectrum.iter_mut().zip(f) {
                *e += amplitude * Complex64::cis(-f * delay);
            }
            return;
        };
        // Phasors of successive frequencies side by side, each ahead by as many frequencies at a time.
        let advance = Complex64::cis(-step_hz * delay);
        let [two, three] = [advance * advance, advance * advance * advance];
        let ahead = two * two;
        for (spectrum, f) in spectrum.chunks_mut(RENEW).zip(f.chunks(RENEW)) {
            let first = amplitude * Complex64::cis(-f[0] * delay);
            let mut phasors = [first, first * advance, first * two, first * three];
            for spectrum in spectrum.chunks_mut(phasors.len()) {
                for (e, phasor) in spectrum.iter_mut().zip(&mut phasors) {
                    *e += *phasor;
                    *phasor *= ahead;
                }
            }
        }
    }
}
