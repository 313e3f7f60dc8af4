//! Height of a target between the slices of a volume.

use crate::engine::reference;
use crate::error::ImagingError;
use crate::pulses::{Pulses, Spreading};
use std::f64::consts::TAU;

/// Most steps from the slice of the maximum.
const MOST_STEPS: usize = 24;

/// Height (m) at which a point above or below (x, y) of `place_m` is likeliest, about the height of `place_m`, in steps
/// of `step_m` within `limits_m` and by a parabola between them.
///
/// Eq. (3) weights each echo by 1/R². Within a resolution cell the image is therefore greater at pixels nearer to the
/// antennas, and its maximum is displaced towards them, by 2σ²/R for a cell of the standard deviation σ: 1 cm for a
/// band of 2 GHz at 0.3 m. The likelihood of a point is greatest where |σ̃|/‖a‖ is, a being the weighted response of a
/// point at the pixel.
///
/// # Errors
/// A place that is not finite.
///
/// ```
/// use acerra_imaging::metrics::likeliest_height_m;
/// use acerra_imaging::reference::{self, Scatterer};
/// use acerra_imaging::{Complex64, PulseArrays, Pulses, Spreading};
/// let position_m: Vec<[f64; 3]> = (0..41).map(|m| [0.02 * (m - 20) as f64, 0.0, 0.4]).collect();
/// let frequency_hz: Vec<f64> = (0..40).map(|n| 1e9 + 25e6 * n as f64).collect();
/// let point = Scatterer { position_m: [0.0, 0.0, 0.1], reflectivity: Complex64::ONE };
/// let spreading = Spreading::InverseSquare;
/// let spectrum = reference::forward(&position_m, &frequency_hz, &[point], 3e8, spreading)?;
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &spectrum,
///     weight: &[1.0; 41],
///     light_speed_m_s: 3e8,
/// })?;
/// let height_m = likeliest_height_m(&pulses, [0.0, 0.0, 0.12], 0.01, [0.0, 0.3])?;
/// assert!((height_m - 0.1).abs() < 1e-3);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn likeliest_height_m(
    pulses: &Pulses,
    place_m: [f64; 3],
    step_m: f64,
    [lowest_m, highest_m]: [f64; 2],
) -> Result<f64, ImagingError> {
    let [x_m, y_m, start_m] = place_m;
    // Amplitudes jump at the surface of the ground.
    let surface_m = pulses.ground().map(|g| g.surface().height_m([x_m, y_m]));
    let is_allowed = |z_m: f64| {
        let is_across = surface_m.is_some_and(|s| (z_m < s) != (start_m < s));
        (lowest_m..=highest_m).contains(&z_m) && !is_across
    };
    let level = |k: i32| -> Result<f64, ImagingError> {
        let point_m = [x_m, y_m, start_m + f64::from(k) * step_m];
        if !is_allowed(point_m[2]) {
            return Ok(f64::NEG_INFINITY);
        }
        match reference::adjoint(pulses, &[point_m], Spreading::InverseSquare) {
            Ok(values) => Ok(values[0].norm() / response_norm(pulses, point_m)),
            // An antenna is there.
            Err(ImagingError::ZeroRange { .. }) => Ok(f64::NEG_INFINITY),
            Err(error) => Err(error),
        }
    };
    let mut at = 0;
    let mut levels = [level(-1)?, level(0)?, level(1)?];
    for _ in 0..MOST_STEPS {
        let [below, here, above] = levels;
        if above > here && above >= below {
            at += 1;
            levels = [here, above, level(at + 1)?];
        } else if below > here {
            at -= 1;
            levels = [level(at - 1)?, below, here];
        } else {
            break;
        }
    }
    let [below, here, above] = levels;
    let curvature = below + above - 2.0 * here;
    let vertex = match curvature < 0.0 && curvature.is_finite() {
        true => (0.5 * (below - above) / curvature).clamp(-0.5, 0.5),
        false => 0.0,
    };
    Ok(start_m + (f64::from(at) + vertex) * step_m)
}

/// ‖a‖ of a point: the weighted amplitudes of its echoes, absorption at the middle of the band.
fn response_norm(pulses: &Pulses, point_m: [f64; 3]) -> f64 {
    let frequency_hz = pulses.frequency_hz();
    let middle_hz = frequency_hz.iter().sum::<f64>() / frequency_hz.len().max(1) as f64;
    let per_m = TAU * middle_hz / pulses.light_speed_m_s();
    let power = |m: usize| {
        let ways = pulses.rays(m, point_m).map(|ray| {
            let lost_m = pulses
                .ground()
                .map_or(0.0, |g| g.dispersion_m(middle_hz, &ray.soil_m).im);
            ray.amplitude * (per_m * lost_m).exp()
        });
        pulses.weight()[m] * (ways[0] * ways[1]).powi(2)
    };
    (0..pulses.len()).map(power).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::reference::{Scatterer, forward_along_rays};
    use crate::pulses::PulseArrays;
    use crate::refraction::{Ground, Layer, Soil, Surface};
    use num_complex::Complex64;

    const STEP_M: f64 = 0.005;

    /// Forty-one pulses 0.3 m above zero, transmitter and receiver 6 cm apart.
    struct Flight {
        /// Middle, transmitter, and receiver.
        places_m: [Vec<[f64; 3]>; 3],
        frequency_hz: Vec<f64>,
        weight: Vec<f64>,
        ground: Option<Ground>,
    }

    impl Flight {
        fn new(ground: Option<Ground>, weights: [f64; 2]) -> Self {
            let places_m = |ahead_m: f64| -> Vec<[f64; 3]> {
                let along_m = |m: i32| 0.02 * f64::from(m - 20) + ahead_m;
                (0..41).map(|m| [along_m(m), 0.0, 0.3]).collect()
            };
            Self {
                places_m: [0.0, -0.03, 0.03].map(places_m),
                frequency_hz: (0..40).map(|n| 0.8e9 + 30e6 * f64::from(n)).collect(),
                weight: (0..41).map(|m| weights[m % 2]).collect(),
                ground,
            }
        }

        fn pulses<'a>(&'a self, spectrum: &'a [Complex64]) -> Pulses<'a> {
            let [position_m, sent_m, received_m] = &self.places_m;
            let pulses = Pulses::new(PulseArrays {
                position_m,
                frequency_hz: &self.frequency_hz,
                spectrum,
                weight: &self.weight,
                light_speed_m_s: 3e8,
            });
            let pulses = pulses.unwrap().with_antennas(sent_m, received_m).unwrap();
            match &self.ground {
                Some(ground) => pulses.with_ground(ground).unwrap(),
                None => pulses,
            }
        }

        /// Likeliest height of a point, found from 3 cm above it, and that of the image's maximum in steps.
        fn heights_m(&self, target_m: [f64; 3]) -> [f64; 2] {
            let empty = vec![Complex64::ZERO; 41 * 40];
            let point = Scatterer {
                position_m: target_m,
                reflectivity: Complex64::I,
            };
            let spreading = Spreading::InverseSquare;
            let echoes = forward_along_rays(&self.pulses(&empty), &[point], spreading).unwrap();
            let pulses = self.pulses(&echoes);
            let [x_m, y_m, z_m] = target_m;
            let limits_m = [z_m - 0.1, z_m + 0.1];
            let likeliest_m =
                likeliest_height_m(&pulses, [x_m, y_m, z_m + 0.03], STEP_M, limits_m).unwrap();
            let at_m = |k: i32| z_m + STEP_M * f64::from(k);
            let modulus = |k: &i32| {
                let value = reference::adjoint(&pulses, &[[x_m, y_m, at_m(*k)]], spreading);
                value.unwrap()[0].norm()
            };
            let maximum = (-10..=10).max_by(|a, b| modulus(a).total_cmp(&modulus(b)));
            [likeliest_m, at_m(maximum.unwrap())]
        }
    }

    /// The image's maximum is a centimetre nearer to the antennas than the point; the likeliest height is not.
    #[test]
    fn a_point_near_the_antennas_has_its_height() {
        for weights in [[1.0, 1.0], [0.3, 1.7]] {
            let [likeliest_m, maximum_m] = Flight::new(None, weights).heights_m([0.02, 0.0, 0.0]);
            assert!(likeliest_m.abs() < 5e-4, "{likeliest_m}");
            assert!(maximum_m > 8e-3, "{maximum_m}");
        }
    }

    #[test]
    fn a_buried_point_has_its_depth_and_stays_below_the_surface() {
        let soil = Soil {
            relative_permittivity: 6.0,
            conductivity_s_m: 0.02,
        };
        let surface = Surface::Level { z_m: 0.0 };
        let ground = Ground::new(surface, &[Layer::below_all(soil)], 1.4e9).unwrap();
        let flight = Flight::new(Some(ground), [1.0; 2]);
        let [likeliest_m, maximum_m] = flight.heights_m([0.02, 0.0, -0.08]);
        assert!((likeliest_m + 0.08).abs() < 1e-3, "{likeliest_m}");
        assert!(maximum_m > -0.077, "{maximum_m}");
        // From 3 cm above a point 2 cm deep, that is, in air.
        let [likeliest_m, _] = flight.heights_m([0.02, 0.0, -0.02]);
        assert!(likeliest_m >= 0.0, "{likeliest_m}");
    }
}
