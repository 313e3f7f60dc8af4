//! Measured data, the input of the imaging operators.

use crate::checks::{check_finite, check_length, check_places, check_positive};
use crate::error::ImagingError;
use crate::refraction::{Ground, Ray};
use crate::vector::{norm, range_m};
use num_complex::Complex64;

/// Speed of light in vacuum, m/s.
pub const SPEED_OF_LIGHT_M_S: f64 = 299_792_458.0;

/// Weight of a contribution from range R by spreading of the wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spreading {
    /// 1/R², as in Eqs. (1) and (3) of Catapano et al. 2020.
    #[default]
    InverseSquare,
    /// No weight: pure phase, as in most published backprojection benchmarks.
    None,
}

impl Spreading {
    /// The weight at `range_m`.
    #[inline]
    #[must_use]
    pub fn weight(self, range_m: f64) -> f64 {
        match self {
            Self::InverseSquare => 1.0 / (range_m * range_m),
            Self::None => 1.0,
        }
    }
}

/// The arrays that [`Pulses`] borrow, by name.
#[derive(Debug, Clone, Copy)]
pub struct PulseArrays<'a> {
    /// Antenna phase centres, `[M]` of `[x, y, z]` in metres.
    pub position_m: &'a [[f64; 3]],
    /// Frequencies, `[N]`, Hz.
    pub frequency_hz: &'a [f64],
    /// Spectra, `[M, N]` row-major.
    pub spectrum: &'a [Complex64],
    /// Weight of each pulse in the sum, `[M]`; 1 for the plain sum over traces.
    pub weight: &'a [f64],
    /// Speed of light, m/s.
    pub light_speed_m_s: f64,
}

/// Measured data: a spectrum and an antenna position for every pulse, borrowed.
///
/// ```
/// use acerra_imaging::{Complex64, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S};
/// let position_m = [[0.0, -1.0, 5.0], [0.0, 1.0, 5.0]];
/// let frequency_hz = [3.1e9, 3.105e9, 3.110e9];
/// let spectrum = [Complex64::new(1.0, 0.0); 6];
/// let weight = [1.0; 2];
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &spectrum,
///     weight: &weight,
///     light_speed_m_s: SPEED_OF_LIGHT_M_S,
/// })?;
/// assert_eq!(pulses.len(), 2);
/// assert!((pulses.frequency_step_hz().unwrap() - 5e6).abs() < 1.0);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Pulses<'a> {
    position_m: &'a [[f64; 3]],
    frequency_hz: &'a [f64],
    spectrum: &'a [Complex64],
    weight: &'a [f64],
    light_speed_m_s: f64,
    boresight: Option<&'a [[f64; 3]]>,
    antennas: Option<Antennas<'a>>,
    ground: Option<&'a Ground>,
}

/// Transmitter and receiver of every pulse.
#[derive(Debug, Clone, Copy)]
struct Antennas<'a> {
    transmitter_m: &'a [[f64; 3]],
    receiver_m: &'a [[f64; 3]],
}

/// Largest accepted distance of transmitter and receiver from [`Pulses::position_m`], m.
const FARTHEST_ANTENNA_M: f64 = 100.0;

impl<'a> Pulses<'a> {
    /// Checks and borrows the data.
    ///
    /// # Errors
    /// Empty or mismatched arrays, values that are not finite, a frequency or speed that is not
    /// positive.
    pub fn new(arrays: PulseArrays<'a>) -> Result<Self, ImagingError> {
        let PulseArrays {
            position_m,
            frequency_hz,
            spectrum,
            weight,
            light_speed_m_s,
        } = arrays;
        if position_m.is_empty() {
            return Err(ImagingError::Empty { what: "position_m" });
        }
        if frequency_hz.is_empty() {
            return Err(ImagingError::Empty {
                what: "frequency_hz",
            });
        }
        check_length("weight", position_m.len(), weight.len())?;
        check_length(
            "spectrum",
            position_m.len().saturating_mul(frequency_hz.len()),
            spectrum.len(),
        )?;
        check_places("position_m", position_m)?;
        check_finite("frequency_hz", frequency_hz.iter().copied())?;
        check_finite("spectrum", spectrum.iter().map(|v| v.re + v.im))?;
        check_finite("weight", weight.iter().copied())?;
        for f in frequency_hz {
            check_positive("frequency_hz", "above 0 Hz", *f)?;
        }
        check_positive("light_speed_m_s", "above 0 m/s", light_speed_m_s)?;
        Ok(Self {
            position_m,
            frequency_hz,
            spectrum,
            weight,
            light_speed_m_s,
            boresight: None,
            antennas: None,
            ground: None,
        })
    }

    /// These echoes at other positions.
    pub(crate) fn moved<'t>(&self, position_m: &'t [[f64; 3]]) -> Result<Pulses<'t>, ImagingError>
    where
        'a: 't,
    {
        check_length("position_m", self.len(), position_m.len())?;
        check_places("position_m", position_m)?;
        Ok(Pulses {
            position_m,
            ..*self
        })
    }

    /// These pulses with separate transmitter and receiver, `[M]` of `[x, y, z]` in metres each: the path of
    /// an echo is the sum of the paths to both. The positions remain the reference of tracks and resolution,
    /// in the middle of both.
    ///
    /// # Errors
    /// Other numbers of places than pulses, places that are not finite or more than 100 m from the position.
    ///
    /// ```
    /// # use acerra_imaging::{Complex64, ImagingError, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S};
    /// # let spectrum = [Complex64::new(1.0, 0.0)];
    /// # let pulses = Pulses::new(PulseArrays {
    /// #     position_m: &[[0.0, 0.0, 5.0]],
    /// #     frequency_hz: &[3.1e9],
    /// #     spectrum: &spectrum,
    /// #     weight: &[1.0],
    /// #     light_speed_m_s: SPEED_OF_LIGHT_M_S,
    /// # })?;
    /// let (transmitter_m, receiver_m) = ([[-0.03, 0.0, 5.0]], [[0.03, 0.0, 5.0]]);
    /// let apart = pulses.with_antennas(&transmitter_m, &receiver_m)?;
    /// assert_eq!(apart.antennas_m(0), [transmitter_m[0], receiver_m[0]]);
    /// # Ok::<(), ImagingError>(())
    /// ```
    pub fn with_antennas(
        self,
        transmitter_m: &'a [[f64; 3]],
        receiver_m: &'a [[f64; 3]],
    ) -> Result<Self, ImagingError> {
        for (what, places) in [("transmitter_m", transmitter_m), ("receiver_m", receiver_m)] {
            check_length(what, self.len(), places.len())?;
            check_places(what, places)?;
            for (place, position) in places.iter().zip(self.position_m) {
                let found = range_m(*place, *position);
                if found > FARTHEST_ANTENNA_M {
                    return Err(ImagingError::OutOfRange {
                        what: "distance of an antenna from the position (m)",
                        expected: "at most 100",
                        found,
                    });
                }
            }
        }
        let antennas = Some(Antennas {
            transmitter_m,
            receiver_m,
        });
        Ok(Self { antennas, ..self })
    }

    /// These pulses over ground: rays to points below its surface are refracted.
    ///
    /// # Errors
    /// An antenna less than a millimetre above the surface.
    pub fn with_ground(self, ground: &'a Ground) -> Result<Self, ImagingError> {
        for pulse in 0..self.len() {
            for antenna_m in self.antennas_m(pulse) {
                ground.check_antenna(antenna_m)?;
            }
        }
        let ground = Some(ground);
        Ok(Self { ground, ..self })
    }

    /// The ground below which rays are refracted.
    #[must_use]
    pub fn ground(&self) -> Option<&'a Ground> {
        self.ground
    }

    /// Whether transmitter and receiver are separate.
    #[must_use]
    pub fn is_bistatic(&self) -> bool {
        self.antennas.is_some()
    }

    /// Transmitter and receiver of a pulse, m: both at the position for monostatic pulses.
    #[must_use]
    pub fn antennas_m(&self, pulse: usize) -> [[f64; 3]; 2] {
        match self.antennas {
            Some(a) => [a.transmitter_m[pulse], a.receiver_m[pulse]],
            None => [self.position_m[pulse]; 2],
        }
    }

    /// Transmitters and receivers of all pulses; `None` for monostatic pulses.
    #[must_use]
    pub fn antennas(&self) -> Option<[&'a [[f64; 3]]; 2]> {
        self.antennas.map(|a| [a.transmitter_m, a.receiver_m])
    }

    /// Antenna positions, `[M]` a list, m: one list for monostatic pulses, two for bistatic ones.
    pub(crate) fn antenna_places_m(&self) -> impl Iterator<Item = &'a [[f64; 3]]> + use<'a> {
        let [first, second] = match self.antennas {
            Some(a) => [a.transmitter_m, a.receiver_m].map(Some),
            None => [Some(self.position_m), None],
        };
        first.into_iter().chain(second)
    }

    /// Vectors from transmitter and receiver of a pulse to a point, m, and the number of separate antennas.
    pub(crate) fn antennas_to_m(&self, pulse: usize, point_m: [f64; 3]) -> ([[f64; 3]; 2], usize) {
        let from_m = |a: [f64; 3]| std::array::from_fn(|axis| point_m[axis] - a[axis]);
        let antennas = 1 + usize::from(self.is_bistatic());
        (self.antennas_m(pulse).map(from_m), antennas)
    }

    /// Greatest distance of an antenna from the middle of transmitter and receiver, m; zero for monostatic
    /// pulses.
    pub(crate) fn half_apart_m(&self) -> f64 {
        let half_m = |a: &Antennas| {
            (a.transmitter_m.iter().zip(a.receiver_m))
                .map(|(t, r)| 0.5 * range_m(*t, *r))
                .fold(0.0, f64::max)
        };
        self.antennas.as_ref().map_or(0.0, half_m)
    }

    /// The rays from the transmitter and from the receiver to a point.
    #[must_use]
    pub fn rays(&self, pulse: usize, point_m: [f64; 3]) -> [Ray; 2] {
        let ray = |antenna_m| match self.ground {
            Some(ground) => ground.ray(antenna_m, point_m),
            None => Ray::straight(antenna_m, point_m),
        };
        match self.antennas {
            Some(_) => self.antennas_m(pulse).map(ray),
            None => [ray(self.position_m[pulse]); 2],
        }
    }

    /// Whether the path of every echo is twice the distance from the position.
    pub(crate) fn is_plain(&self) -> bool {
        self.antennas.is_none() && self.ground.is_none()
    }

    /// These pulses with the antenna's boresight at each, `[M]` unit vectors in the axes of the positions.
    /// The angles of a weight by the antenna's pattern count from the boresight, which is straight down by
    /// default.
    ///
    /// # Errors
    /// The number of directions differs from that of pulses, or a direction's length from 1 by more than 10⁻⁶.
    ///
    /// ```
    /// # use acerra_imaging::{Complex64, ImagingError, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S};
    /// # let spectrum = [Complex64::new(1.0, 0.0)];
    /// # let pulses = Pulses::new(PulseArrays {
    /// #     position_m: &[[0.0, 0.0, 5.0]],
    /// #     frequency_hz: &[3.1e9],
    /// #     spectrum: &spectrum,
    /// #     weight: &[1.0],
    /// #     light_speed_m_s: SPEED_OF_LIGHT_M_S,
    /// # })?;
    /// let looks = [[0.6, 0.0, -0.8]];
    /// assert_eq!(pulses.with_boresight(&looks)?.boresight(), Some(&looks[..]));
    /// assert!(pulses.with_boresight(&[[0.0, 0.0, -2.0]]).is_err());
    /// # Ok::<(), ImagingError>(())
    /// ```
    pub fn with_boresight(self, boresight: &'a [[f64; 3]]) -> Result<Self, ImagingError> {
        check_length("boresight", self.len(), boresight.len())?;
        for found in boresight.iter().map(|b| norm(*b)) {
            if found.is_nan() || (found - 1.0).abs() > 1e-6 {
                return Err(ImagingError::OutOfRange {
                    what: "length of a boresight",
                    expected: "1",
                    found,
                });
            }
        }
        let boresight = Some(boresight);
        Ok(Self { boresight, ..self })
    }

    /// Boresight of the antenna at each pulse, `[M]` unit vectors; `None` for straight down.
    #[must_use]
    pub fn boresight(&self) -> Option<&'a [[f64; 3]]> {
        self.boresight
    }

    /// These pulses with the boresight straight down.
    #[must_use]
    pub fn without_boresight(self) -> Self {
        Self {
            boresight: None,
            ..self
        }
    }

    /// Number of pulses M, at least 1.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.position_m.len()
    }

    /// Antenna phase centres, `[M]` of `[x, y, z]` in metres.
    #[must_use]
    pub fn position_m(&self) -> &'a [[f64; 3]] {
        self.position_m
    }

    /// Frequencies, `[N]`, Hz.
    #[must_use]
    pub fn frequency_hz(&self) -> &'a [f64] {
        self.frequency_hz
    }

    /// All spectra, `[M, N]` row-major.
    #[must_use]
    pub fn spectrum(&self) -> &'a [Complex64] {
        self.spectrum
    }

    /// The spectrum of one pulse, `[N]`.
    #[must_use]
    pub fn spectrum_of(&self, pulse: usize) -> &'a [Complex64] {
        let n = self.frequency_hz.len();
        &self.spectrum[pulse * n..(pulse + 1) * n]
    }

    /// Weight of each pulse in the sum, `[M]`.
    #[must_use]
    pub fn weight(&self) -> &'a [f64] {
        self.weight
    }

    /// Speed of light in use, m/s.
    #[must_use]
    pub fn light_speed_m_s(&self) -> f64 {
        self.light_speed_m_s
    }

    /// The step of evenly spaced, rising frequencies; `None` for a single frequency or where one
    /// departs from the even grid by more than 10⁻⁹ of the highest.
    #[must_use]
    pub fn frequency_step_hz(&self) -> Option<f64> {
        let f = self.frequency_hz;
        if f.len() < 2 {
            return None;
        }
        let step = (f[f.len() - 1] - f[0]) / (f.len() - 1) as f64;
        let worst = self.frequency_unevenness_hz(step);
        let top = f.iter().copied().fold(0.0, f64::max);
        (step > 0.0 && worst <= 1e-9 * top).then_some(step)
    }

    /// Largest departure from f₀ + n·step, Hz.
    pub(crate) fn frequency_unevenness_hz(&self, step: f64) -> f64 {
        let f = self.frequency_hz;
        f.iter()
            .enumerate()
            .map(|(n, v)| (v - (f[0] + n as f64 * step)).abs())
            .fold(0.0, f64::max)
    }

    /// These pulses with other weights, `[M]`.
    ///
    /// # Errors
    /// A wrong number of weights, or a weight that is not finite.
    pub fn with_weight(self, weight: &'a [f64]) -> Result<Self, ImagingError> {
        check_length("weight", self.len(), weight.len())?;
        check_finite("weight", weight.iter().copied())?;
        Ok(Self { weight, ..self })
    }

    /// The pulses `range`, borrowed from the same arrays (the sub-aperture of a look).
    ///
    /// # Errors
    /// An empty range, or one that ends beyond the last pulse.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Result<Self, ImagingError> {
        if range.is_empty() {
            return Err(ImagingError::Empty {
                what: "pulse range",
            });
        }
        if range.end > self.len() {
            return Err(ImagingError::Length {
                what: "pulse range",
                expected: self.len(),
                found: range.end,
            });
        }
        let n = self.frequency_hz.len();
        Ok(Self {
            position_m: &self.position_m[range.clone()],
            spectrum: &self.spectrum[range.start * n..range.end * n],
            weight: &self.weight[range.clone()],
            boresight: self.boresight.map(|all| &all[range.clone()]),
            antennas: self.antennas.map(|a| Antennas {
                transmitter_m: &a.transmitter_m[range.clone()],
                receiver_m: &a.receiver_m[range],
            }),
            ..*self
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_data_are_refused_with_the_place() {
        let p = [[0.0; 3]; 2];
        let f = [1e9, 2e9];
        let s = [Complex64::new(1.0, 0.0); 4];
        let w = [1.0; 2];
        let good = PulseArrays {
            position_m: &p,
            frequency_hz: &f,
            spectrum: &s,
            weight: &w,
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
        };
        assert!(Pulses::new(good).is_ok());
        assert_eq!(
            Pulses::new(PulseArrays {
                spectrum: &s[..3],
                ..good
            })
            .unwrap_err(),
            ImagingError::Length {
                what: "spectrum",
                expected: 4,
                found: 3
            }
        );
        let mut bad = s;
        bad[2].im = f64::NAN;
        assert_eq!(
            Pulses::new(PulseArrays {
                spectrum: &bad,
                ..good
            })
            .unwrap_err(),
            ImagingError::NotFinite {
                what: "spectrum",
                index: 2
            }
        );
        assert!(
            Pulses::new(PulseArrays {
                position_m: &[],
                spectrum: &[],
                weight: &[],
                ..good
            })
            .is_err()
        );
        assert!(
            Pulses::new(PulseArrays {
                frequency_hz: &[1e9, 0.0],
                ..good
            })
            .is_err()
        );
        assert!(
            Pulses::new(PulseArrays {
                light_speed_m_s: 0.0,
                ..good
            })
            .is_err()
        );
        assert!(
            Pulses::new(PulseArrays {
                light_speed_m_s: f64::INFINITY,
                ..good
            })
            .is_err()
        );
    }

    #[test]
    fn evenness_is_recognised() {
        let p = [[0.0, 0.0, 1.0]];
        let s = [Complex64::new(1.0, 0.0); 4];
        let w = [1.0];
        let even: Vec<f64> = (0..4).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
        let step = |f: &[f64]| {
            Pulses::new(PulseArrays {
                position_m: &p,
                frequency_hz: f,
                spectrum: &s[..f.len()],
                weight: &w,
                light_speed_m_s: 3e8,
            })
            .unwrap()
            .frequency_step_hz()
        };
        assert!((step(&even).unwrap() - 5e6).abs() < 1e-3);
        assert_eq!(step(&[1e9, 1.1e9, 1.25e9]), None);
        assert_eq!(step(&[1.1e9, 1e9]), None);
        assert_eq!(step(&[1e9]), None);
    }
}
