//! Eq. (5): the image of one point, evaluated exactly at any place.

use num_complex::Complex64;

use crate::checks::{check_finite, check_length, check_places};
use crate::error::ImagingError;
use crate::kernel::dispatch::dispatch;
use crate::kernel::level::SimdLevel;
use crate::kernel::point_spread::{Band, Received, received, responses};
use crate::pulses::Pulses;

/// The point spread function of a flight, a band and pulse weights.
///
/// ```
/// use acerra_imaging::psf::PointSpread;
/// let track: Vec<[f64; 3]> = (0..601).map(|m| [-3.0 + 0.01 * m as f64, 0.0, 5.0]).collect();
/// let frequency_hz: Vec<f64> = (0..341).map(|n| 3.1e9 + 5e6 * n as f64).collect();
/// let spread = PointSpread::new(track, None, frequency_hz, 3e8)?;
/// let target = [0.0, 2.0, 0.0];
/// let peak = spread.response(target, target).norm();
/// let ghost = spread.response(target, [0.0, -2.0, 0.0]).norm();
/// assert!((ghost / peak - 1.0).abs() < 1e-12); // a straight track cannot distinguish left from right
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PointSpread {
    position_m: Vec<[f64; 3]>,
    weight: Vec<f64>,
    frequency_hz: Vec<f64>,
    light_speed_m_s: f64,
    comb: Option<Comb>,
}

/// Evenly spaced frequencies, whose sum has a closed form.
#[derive(Clone, Copy, Debug)]
struct Comb {
    centre_hz: f64,
    step_hz: f64,
    count: f64,
}

impl PointSpread {
    /// `position_m` are the antenna's places (east, north, up), `weight` one factor per pulse (all
    /// one when `None`), `frequency_hz` the frequencies of the sum.
    ///
    /// # Errors
    /// When there is no pulse or no frequency, lengths differ, or a number is not finite, a
    /// frequency or the speed of light not positive.
    pub fn new(
        position_m: Vec<[f64; 3]>,
        weight: Option<Vec<f64>>,
        frequency_hz: Vec<f64>,
        light_speed_m_s: f64,
    ) -> Result<Self, ImagingError> {
        if position_m.is_empty() {
            return Err(ImagingError::Empty { what: "position_m" });
        }
        if frequency_hz.is_empty() {
            return Err(ImagingError::Empty {
                what: "frequency_hz",
            });
        }
        let weight = weight.unwrap_or_else(|| vec![1.0; position_m.len()]);
        check_length("weight", position_m.len(), weight.len())?;
        check_places("position_m", &position_m)?;
        check_finite("weight", weight.iter().copied())?;
        let positive = |what, expected, found: f64| {
            if found.is_finite() && found > 0.0 {
                Ok(())
            } else {
                Err(ImagingError::OutOfRange {
                    what,
                    expected,
                    found,
                })
            }
        };
        for f in &frequency_hz {
            positive("frequency_hz", "above 0 Hz", *f)?;
        }
        positive("light_speed_m_s", "above 0 m/s", light_speed_m_s)?;
        let comb = comb_of(&frequency_hz);
        Ok(Self {
            position_m,
            weight,
            frequency_hz,
            light_speed_m_s,
            comb,
        })
    }

    /// The flight, band and weights of measured data.
    #[must_use]
    pub fn of(pulses: &Pulses<'_>) -> Self {
        let frequency_hz = pulses.frequency_hz().to_vec();
        Self {
            position_m: pulses.position_m().to_vec(),
            weight: pulses.weight().to_vec(),
            comb: comb_of(&frequency_hz),
            frequency_hz,
            light_speed_m_s: pulses.light_speed_m_s(),
        }
    }

    /// The antenna's places, m.
    pub fn position_m(&self) -> &[[f64; 3]] {
        &self.position_m
    }

    /// One weight per pulse.
    pub fn weight(&self) -> &[f64] {
        &self.weight
    }

    /// The frequencies, Hz.
    pub fn frequency_hz(&self) -> &[f64] {
        &self.frequency_hz
    }

    /// The speed of light in use, m/s.
    pub fn light_speed_m_s(&self) -> f64 {
        self.light_speed_m_s
    }

    /// Lowest and highest frequency, Hz.
    pub fn band_hz(&self) -> (f64, f64) {
        self.frequency_hz
            .iter()
            .fold((f64::INFINITY, 0.0), |(low, high), f| {
                (low.min(*f), high.max(*f))
            })
    }

    /// Middle of the band, Hz.
    pub fn centre_hz(&self) -> f64 {
        let (low, high) = self.band_hz();
        0.5 * (low + high)
    }

    /// Eq. (5) with its sums: Σ_m w_m Σ_n e^{−j4πf_n(R_t−R)/c} / (R_t² R²), the value at `at_m` of
    /// the image of a unit point at `target_m`.
    ///
    /// Infinite where an antenna is exactly on one of the points.
    pub fn response(&self, target_m: [f64; 3], at_m: [f64; 3]) -> Complex64 {
        self.response_displaced(&self.position_m, target_m, at_m)
    }

    /// As [`Self::response`] for echoes received at `true_position_m` and focused with the places of this
    /// flight: the effect of a positioning error.
    ///
    /// Pulses beyond the shorter of both lists are ignored.
    pub fn response_displaced(
        &self,
        true_position_m: &[[f64; 3]],
        target_m: [f64; 3],
        at_m: [f64; 3],
    ) -> Complex64 {
        let level = SimdLevel::detect();
        let (range_m, factor) = dispatch!(level, s => received(
            s,
            true_position_m,
            &self.weight,
            target_m,
        ));
        let echoes = Received {
            range_m: &range_m,
            factor: &factor,
            phasor: &[],
        };
        self.sums(echoes, at_m)[0]
    }

    /// Range of a point from each pulse (m), and the pulse's weight over the square of the range.
    pub(crate) fn received(&self, target_m: [f64; 3]) -> (Vec<f64>, Vec<f64>) {
        let level = SimdLevel::detect();
        dispatch!(level, s => received(s, &self.position_m, &self.weight, target_m))
    }

    /// The image at `at_m` of the received pulses: once with the real factors, once with the complex ones.
    pub(crate) fn sums(&self, echoes: Received<'_>, at_m: [f64; 3]) -> [Complex64; 2] {
        let (level, band) = (SimdLevel::detect(), self.band());
        dispatch!(level, s => responses(s, &band, &self.position_m, echoes, at_m))
    }

    /// Σ_n e^{j4πf_n δ/c}: the contribution of one pulse at excess range δ = R − R_t (m).
    pub fn kernel(&self, excess_m: f64) -> Complex64 {
        self.band().kernel_at(excess_m)
    }

    fn band(&self) -> Band<'_> {
        let slowness_s_m = 2.0 / self.light_speed_m_s;
        match self.comb {
            Some(comb) => Band::Even {
                centre_per_m: slowness_s_m * comb.centre_hz,
                step_per_m: slowness_s_m * comb.step_hz,
                count: comb.count,
            },
            None => Band::Uneven {
                frequency_hz: &self.frequency_hz,
                slowness_s_m,
            },
        }
    }
}

fn comb_of(frequency_hz: &[f64]) -> Option<Comb> {
    let (first, last) = (frequency_hz[0], frequency_hz[frequency_hz.len() - 1]);
    let count = frequency_hz.len() as f64;
    let step_hz = if count > 1.0 {
        (last - first) / (count - 1.0)
    } else {
        0.0
    };
    let even = frequency_hz
        .iter()
        .enumerate()
        .all(|(n, f)| (f - (first + n as f64 * step_hz)).abs() <= 1e-9 * f.abs());
    even.then_some(Comb {
        centre_hz: 0.5 * (first + last),
        step_hz,
        count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::range_m;
    use std::f64::consts::TAU;

    #[test]
    fn closed_form_is_the_sum() {
        let even: Vec<f64> = (0..17).map(|n| 3.1e9 + 1e8 * f64::from(n)).collect();
        let comb = PointSpread::new(vec![[0.0; 3]], None, even.clone(), 3e8).unwrap();
        assert!(comb.comb.is_some());
        let mut uneven = even.clone();
        uneven[3] += 100.0;
        let sum = PointSpread::new(vec![[0.0; 3]], None, uneven, 3e8).unwrap();
        assert!(sum.comb.is_none());
        // 1.5 m is the unambiguous range of a 100 MHz step.
        for excess in [0.0, 1e-12, 0.013, -0.4, 1.5, 1.5 + 1e-11, 3.0, 2.9] {
            let difference = (comb.kernel(excess) - sum.kernel(excess)).norm();
            assert!(difference < 1e-4, "{excess}: {difference}");
        }
    }

    /// The sum over pulses and frequencies, term by term.
    fn summed(
        spread: &PointSpread,
        truth: &[[f64; 3]],
        target: [f64; 3],
        at: [f64; 3],
    ) -> Complex64 {
        let pulses = spread.position_m.iter().zip(truth).zip(&spread.weight);
        pulses
            .map(|((believed, truth), weight)| {
                let (there, here) = (range_m(*truth, target), range_m(*believed, at));
                let turns = 2.0 * (here - there) / spread.light_speed_m_s;
                let band = spread.frequency_hz.iter();
                let sum: Complex64 = band.map(|f| Complex64::cis(TAU * turns * f)).sum();
                sum * weight / (there * here).powi(2)
            })
            .sum()
    }

    #[test]
    fn responses_are_the_sums_at_every_number_of_pulses() {
        let even: Vec<f64> = (0..41).map(|n| 3.1e9 + 4e7 * f64::from(n)).collect();
        let mut uneven = even.clone();
        uneven[3] += 1e6;
        let (target, at) = ([0.3, 2.0, 0.1], [0.31, 2.05, 0.0]);
        for frequency_hz in [even, uneven] {
            for pulses in [1, 7, 8, 9, 61] {
                let track: Vec<[f64; 3]> = (0..pulses)
                    .map(|m| [0.02 * f64::from(m), 0.1, 5.0 + 0.01 * f64::from(m)])
                    .collect();
                let truth: Vec<[f64; 3]> =
                    track.iter().map(|p| [p[0], p[1] + 0.01, p[2]]).collect();
                let weight = (0..pulses).map(|m| 1.0 + 0.1 * f64::from(m)).collect();
                let spread =
                    PointSpread::new(track, Some(weight), frequency_hz.clone(), 3e8).unwrap();
                let found = spread.response_displaced(&truth, target, at);
                let expected = summed(&spread, &truth, target, at);
                let scale = spread.response(target, target).norm();
                assert!(
                    (found - expected).norm() < 1e-11 * scale,
                    "{pulses}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn impossible_flights_are_refused() {
        let new = |p: Vec<[f64; 3]>, f: Vec<f64>, c| PointSpread::new(p, None, f, c);
        assert!(matches!(
            new(vec![], vec![1e9], 3e8),
            Err(ImagingError::Empty { what: "position_m" })
        ));
        assert!(matches!(
            new(vec![[0.0; 3]], vec![], 3e8),
            Err(ImagingError::Empty { .. })
        ));
        assert!(new(vec![[f64::NAN, 0.0, 0.0]], vec![1e9], 3e8).is_err());
        assert!(new(vec![[0.0; 3]], vec![-1e9], 3e8).is_err());
        assert!(new(vec![[0.0; 3]], vec![1e9], 0.0).is_err());
        assert!(PointSpread::new(vec![[0.0; 3]], Some(vec![]), vec![1e9], 3e8).is_err());
    }
}
