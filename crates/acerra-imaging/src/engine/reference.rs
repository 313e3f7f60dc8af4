//! Reference implementation: the paper's sums in double precision, against which every faster path
//! is tested.

use crate::checks::{check_finite, check_length, check_places, check_positive};
use crate::error::ImagingError;
use crate::pulses::{Pulses, Spreading};
use crate::refraction::Ray;
pub use crate::vector::range_m;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A point scatterer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatterer {
    /// `[x, y, z]`, m.
    pub position_m: [f64; 3],
    /// Complex reflectivity.
    pub reflectivity: Complex64,
}

/// The image at `points_m`: Eq. (3) of Catapano et al. 2020,
/// σ̃(r) = Σ_m w_m Σ_n E(m, n) e^{+j4πf_n R/c} / R², R = |r − r_m|, one value a point. Where pulses have antennas
/// apart or a ground, 2R is the optical length of both ways along their rays, and 1/R² the product of their
/// amplitudes.
///
/// ```
/// use acerra_imaging::{Complex64, PulseArrays, Pulses, Spreading, reference};
/// let target = [0.3, 0.0, 0.0];
/// let position_m = [[0.0, -0.5, 5.0], [0.0, 0.5, 5.0]];
/// let frequency_hz = [3.1e9, 3.5e9, 4.8e9];
/// let scene = [reference::Scatterer { position_m: target, reflectivity: Complex64::new(1.0, 0.0) }];
/// let echo = reference::forward(&position_m, &frequency_hz, &scene, 3e8, Spreading::None)?;
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &echo,
///     weight: &[1.0, 1.0],
///     light_speed_m_s: 3e8,
/// })?;
/// let image = reference::adjoint(&pulses, &[target], Spreading::None)?;
/// assert!((image[0].re - 6.0).abs() < 1e-9); // all pulses and frequencies in phase
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
///
/// # Errors
/// A point that is not finite; with [`Spreading::InverseSquare`], one exactly at an antenna.
pub fn adjoint(
    pulses: &Pulses,
    points_m: &[[f64; 3]],
    spreading: Spreading,
) -> Result<Vec<Complex64>, ImagingError> {
    check_places("points_m", points_m)?;
    points_m
        .par_iter()
        .enumerate()
        .map(|(k, &point)| adjoint_at(pulses, point, spreading, k))
        .collect()
}

fn adjoint_at(
    pulses: &Pulses,
    point: [f64; 3],
    spreading: Spreading,
    index: usize,
) -> Result<Complex64, ImagingError> {
    if !pulses.is_plain() {
        return rays_at(pulses, point, spreading, index);
    }
    let mut sum = Complex64::ZERO;
    for (m, &antenna) in pulses.position_m().iter().enumerate() {
        let range = range_m(point, antenna);
        if range == 0.0 && spreading == Spreading::InverseSquare {
            return Err(ImagingError::ZeroRange {
                pulse: m,
                point: index,
            });
        }
        sum += pulse_at_range(pulses, m, range) * (pulses.weight()[m] * spreading.weight(range));
    }
    Ok(sum)
}

/// The image at a point seen by rays, of transmitters and receivers apart or through the ground:
/// Σ_m w_m a_t a_r Σ_n E(m, n) e^{+j2πf_n (P_t* + P_r*)/c}, P being the complex optical length Σ (n − jκ) ℓ of either
/// way at every frequency (see [`Ground`](crate::refraction::Ground)), P* its conjugate, and a its amplitude, 1/R in
/// air (1 without spreading).
fn rays_at(
    pulses: &Pulses,
    point: [f64; 3],
    spreading: Spreading,
    index: usize,
) -> Result<Complex64, ImagingError> {
    let mut sum = Complex64::ZERO;
    for m in 0..pulses.len() {
        let echo = Echo::of(pulses, m, point, spreading).ok_or(ImagingError::ZeroRange {
            pulse: m,
            point: index,
        })?;
        let mut profile = Complex64::ZERO;
        for (f, e) in pulses.frequency_hz().iter().zip(pulses.spectrum_of(m)) {
            profile += e * echo.at(pulses, *f).conj();
        }
        sum += profile * (pulses.weight()[m] * echo.amplitude);
    }
    Ok(sum)
}

/// The echo of a unit scatterer along rays.
struct Echo {
    rays: [Ray; 2],
    /// Product of the amplitudes of both ways, without absorption.
    amplitude: f64,
}

impl Echo {
    /// The echo of `pulse` from `point`; `None` where an antenna is at the point and the amplitude is
    /// infinite.
    fn of(pulses: &Pulses, pulse: usize, point: [f64; 3], spreading: Spreading) -> Option<Self> {
        let rays = pulses.rays(pulse, point);
        let amplitude = match spreading {
            Spreading::InverseSquare => rays[0].amplitude * rays[1].amplitude,
            Spreading::None => 1.0,
        };
        amplitude.is_finite().then_some(Self { rays, amplitude })
    }

    /// Phase and absorption at a frequency: e^{−j2πf (P_t + P_r)/c}.
    fn at(&self, pulses: &Pulses, f: f64) -> Complex64 {
        let length = |ray: &Ray| {
            let dispersion = pulses.ground().map(|g| g.dispersion_m(f, &ray.soil_m));
            dispersion.unwrap_or(Complex64::ZERO) + ray.optical_m
        };
        let both = length(&self.rays[0]) + length(&self.rays[1]);
        (-Complex64::I * both * (2.0 * PI * f / pulses.light_speed_m_s())).exp()
    }
}

/// The data of point scatterers along the rays of `pulses`: antennas, ground, frequencies and weights are
/// used, spectra are not; `[M, N]` row-major. The exact adjoint of [`adjoint`] on the same pulses.
///
/// ```
/// use acerra_imaging::reference::{self, Scatterer};
/// use acerra_imaging::refraction::{Ground, Layer, Soil, Surface};
/// use acerra_imaging::{Complex64, PulseArrays, Pulses, Spreading};
/// let sand = Soil { relative_permittivity: 4.0, conductivity_s_m: 0.0 };
/// let ground = Ground::new(Surface::Level { z_m: 0.0 }, &[Layer::below_all(sand)], 1e9)?;
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &[[0.0, 0.0, 1.0]],
///     frequency_hz: &[1e9],
///     spectrum: &[Complex64::ZERO],
///     weight: &[1.0],
///     light_speed_m_s: 3e8,
/// })?
/// .with_ground(&ground)?;
/// let buried = Scatterer { position_m: [0.0, 0.0, -0.25], reflectivity: Complex64::ONE };
/// let echo = reference::forward_along_rays(&pulses, &[buried], Spreading::None)?;
/// // 1 m of air and 0.25 m of soil of index 2: 1.5 m, both ways 10 wavelengths of 0.3 m.
/// assert!((echo[0] - Complex64::ONE).norm() < 1e-9);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
///
/// # Errors
/// As [`forward`].
pub fn forward_along_rays(
    pulses: &Pulses,
    scatterers: &[Scatterer],
    spreading: Spreading,
) -> Result<Vec<Complex64>, ImagingError> {
    check_finite(
        "scatterers",
        scatterers
            .iter()
            .map(|s| s.position_m.iter().sum::<f64>() + s.reflectivity.re + s.reflectivity.im),
    )?;
    let row = |m: usize| {
        let mut row = vec![Complex64::ZERO; pulses.frequency_hz().len()];
        for (i, s) in scatterers.iter().enumerate() {
            let echo = Echo::of(pulses, m, s.position_m, spreading)
                .ok_or(ImagingError::ZeroRange { pulse: m, point: i })?;
            let amplitude = s.reflectivity * (pulses.weight()[m] * echo.amplitude);
            for (e, f) in row.iter_mut().zip(pulses.frequency_hz()) {
                *e += amplitude * echo.at(pulses, *f);
            }
        }
        Ok(row)
    };
    let rows: Result<Vec<_>, ImagingError> = (0..pulses.len()).into_par_iter().map(row).collect();
    Ok(rows?.concat())
}

/// Σ_n E(m, n) e^{+j4πf_n R/c} of one pulse, without weight or spreading.
#[must_use]
pub fn pulse_at_range(pulses: &Pulses, pulse: usize, range_m: f64) -> Complex64 {
    let delay = 4.0 * PI * range_m / pulses.light_speed_m_s();
    pulses
        .frequency_hz()
        .iter()
        .zip(pulses.spectrum_of(pulse))
        .map(|(f, e)| e * Complex64::cis(f * delay))
        .sum()
}

/// The data of point scatterers: Eq. (1) of the same paper in its discrete form, E(m, n) = Σ_i σ_i e^{−j4πf_n
/// R/c} / R²; `[M, N]` row-major.
///
/// With unit pulse weights this is the exact adjoint of [`adjoint`].
///
/// # Errors
/// Values that are not finite, a speed that is not positive; with [`Spreading::InverseSquare`], a
/// scatterer exactly at an antenna.
pub fn forward(
    position_m: &[[f64; 3]],
    frequency_hz: &[f64],
    scatterers: &[Scatterer],
    light_speed_m_s: f64,
    spreading: Spreading,
) -> Result<Vec<Complex64>, ImagingError> {
    check_places("position_m", position_m)?;
    check_finite("frequency_hz", frequency_hz.iter().copied())?;
    check_finite(
        "scatterers",
        scatterers
            .iter()
            .map(|s| s.position_m.iter().sum::<f64>() + s.reflectivity.re + s.reflectivity.im),
    )?;
    check_positive("light_speed_m_s", "above 0 m/s", light_speed_m_s)?;
    let rows: Result<Vec<Vec<Complex64>>, ImagingError> = position_m
        .par_iter()
        .enumerate()
        .map(|(m, &antenna)| {
            let mut row = vec![Complex64::ZERO; frequency_hz.len()];
            for (i, s) in scatterers.iter().enumerate() {
                let range = range_m(s.position_m, antenna);
                if range == 0.0 && spreading == Spreading::InverseSquare {
                    return Err(ImagingError::ZeroRange { pulse: m, point: i });
                }
                let delay = 4.0 * PI * range / light_speed_m_s;
                let amplitude = s.reflectivity * spreading.weight(range);
                for (e, f) in row.iter_mut().zip(frequency_hz) {
                    *e += amplitude * Complex64::cis(-f * delay);
                }
            }
            Ok(row)
        })
        .collect();
    Ok(rows?.concat())
}

/// Relative L2 difference ‖a − b‖ / ‖b‖ of an image from the reference `b`.
///
/// # Errors
/// Arrays of different lengths.
pub fn relative_l2(image: &[Complex64], reference: &[Complex64]) -> Result<f64, ImagingError> {
    check_length("image", reference.len(), image.len())?;
    let power = |v: &Complex64| v.norm_sqr();
    let difference: f64 = image
        .iter()
        .zip(reference)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    Ok((difference / reference.iter().map(power).sum::<f64>()).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulses::PulseArrays;

    #[test]
    fn adjoint_and_forward_are_adjoint() {
        let antennas = [[0.1, -0.4, 4.0], [0.0, 0.5, 5.0], [0.2, 0.0, 0.0]];
        let f = [3.1e9, 3.4e9, 4.0e9, 4.8e9];
        let points = [[1.0, 0.0, 0.0], [0.5, -2.0, 0.3]];
        let sigma = [Complex64::new(0.3, -1.0), Complex64::new(2.0, 0.1)];
        let scene: Vec<_> = points
            .iter()
            .zip(sigma)
            .map(|(&position_m, reflectivity)| Scatterer {
                position_m,
                reflectivity,
            })
            .collect();
        let data: Vec<_> = (0..12)
            .map(|k| Complex64::new((k as f64).sin(), (2.0 * k as f64).cos()))
            .collect();
        let modelled = forward(&antennas, &f, &scene, 3e8, Spreading::InverseSquare).unwrap();
        let pulses = Pulses::new(PulseArrays {
            position_m: &antennas,
            frequency_hz: &f,
            spectrum: &data,
            weight: &[1.0; 3],
            light_speed_m_s: 3e8,
        })
        .unwrap();
        let image = adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
        let left: Complex64 = modelled.iter().zip(&data).map(|(a, b)| a.conj() * b).sum();
        let right: Complex64 = sigma.iter().zip(&image).map(|(a, b)| a.conj() * b).sum();
        assert!(
            (left - right).norm() < 1e-12 * left.norm(),
            "{left} {right}"
        );
    }

    #[test]
    fn an_echo_has_the_phase_and_weight_of_its_range() {
        let antenna = [[0.0, 0.0, 3.0]];
        let scene = [Scatterer {
            position_m: [4.0, 0.0, 0.0],
            reflectivity: Complex64::new(1.0, 0.0),
        }];
        let echo = forward(&antenna, &[1e9], &scene, 3e8, Spreading::InverseSquare).unwrap();
        // R = 5 m, 4πfR/c = 4π·50/3 rad: 33⅓ cycles.
        let expected = Complex64::cis(-2.0 * PI / 3.0) / 25.0;
        assert!((echo[0] - expected).norm() < 1e-12);
    }

    #[test]
    fn a_point_at_the_antenna_is_refused_only_where_the_weight_diverges() {
        let p = [[1.0, 2.0, 3.0]];
        let e = [Complex64::new(1.0, 0.0)];
        let pulses = Pulses::new(PulseArrays {
            position_m: &p,
            frequency_hz: &[1e9],
            spectrum: &e,
            weight: &[1.0],
            light_speed_m_s: 3e8,
        })
        .unwrap();
        assert_eq!(
            adjoint(&pulses, &p, Spreading::InverseSquare).unwrap_err(),
            ImagingError::ZeroRange { pulse: 0, point: 0 }
        );
        assert_eq!(adjoint(&pulses, &p, Spreading::None).unwrap()[0], e[0]);
    }
}
