//! The vector between two antennas on one vehicle, and the resulting attitude.

use acerra_geo::geodesy::EnuFrame;

/// The vector from a moving base's antenna to the rover's, at the rover's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Baseline {
    /// The base's antenna (ECEF, m) from the base's codes, accurate to metres.
    pub base_position_ecef_m: [f64; 3],
    /// Vector from the base's to the rover's antenna (ECEF, m), by carrier phase where ambiguities are fixed.
    pub vector_ecef_m: [f64; 3],
    /// Covariance of the vector (ECEF, m²).
    pub covariance_ecef_m2: [[f64; 3]; 3],
}

/// Direction and length of a baseline, with standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineAttitude {
    /// Azimuth from north over east of the direction from base to rover (rad, 0 to 2π).
    pub heading_rad: f64,
    /// Standard deviation of the heading (rad).
    pub heading_sigma_rad: f64,
    /// Elevation of the direction above the horizon (rad).
    pub pitch_rad: f64,
    /// Standard deviation of the pitch (rad).
    pub pitch_sigma_rad: f64,
    /// Length (m).
    pub length_m: f64,
    /// Standard deviation of the length (m).
    pub length_sigma_m: f64,
}

impl Baseline {
    /// Axes at the base's antenna.
    pub(crate) fn frame(&self) -> EnuFrame {
        EnuFrame::from_ecef(self.base_position_ecef_m)
    }

    /// The vector in the base's local axes: east, north, up (m).
    #[must_use]
    pub fn enu_m(&self) -> [f64; 3] {
        self.frame().enu_vector_from_ecef(self.vector_ecef_m)
    }

    /// Covariance of the vector in these axes (m²).
    #[must_use]
    pub fn enu_covariance_m2(&self) -> [[f64; 3]; 3] {
        self.frame()
            .enu_covariance_from_ecef(&self.covariance_ecef_m2)
    }

    /// Length (m).
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.vector_ecef_m.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Direction and length; `None` for a baseline without a horizontal part, which has no heading.
    ///
    /// Standard deviations are propagated linearly from the vector's covariance, which is valid up to about a
    /// tenth of a radian.
    ///
    /// ```
    /// use acerra_geo::geodesy::EnuFrame;
    /// use acerra_gnss::Baseline;
    /// let base_position_ecef_m = [4_641_950.0, 1_393_058.0, 4_133_281.0];
    /// let frame = EnuFrame::from_ecef(base_position_ecef_m);
    /// let sigma_m2 = [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 4e-4]];
    /// let baseline = Baseline {
    ///     base_position_ecef_m,
    ///     vector_ecef_m: frame.ecef_vector_from_enu([1.0, 0.0, 0.0]),
    ///     covariance_ecef_m2: frame.ecef_covariance_from_enu(&sigma_m2),
    /// };
    /// let attitude = baseline.attitude().unwrap();
    /// assert!((attitude.heading_rad.to_degrees() - 90.0).abs() < 1e-9);
    /// // 1 cm across one metre; 2 cm in height.
    /// assert!((attitude.heading_sigma_rad - 0.01).abs() < 1e-9);
    /// assert!((attitude.pitch_sigma_rad - 0.02).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn attitude(&self) -> Option<BaselineAttitude> {
        let [e, n, u] = self.enu_m();
        let covariance = self.enu_covariance_m2();
        let level2 = e * e + n * n;
        let level = level2.sqrt();
        let length2 = level2 + u * u;
        let length = length2.sqrt();
        if level.is_nan() || level <= 1e-3 * length || level == 0.0 {
            return None;
        }
        let sigma = |slope: [f64; 3]| {
            let mut variance = 0.0;
            for (i, a) in slope.iter().enumerate() {
                for (j, b) in slope.iter().enumerate() {
                    variance += a * covariance[i][j] * b;
                }
            }
            variance.max(0.0).sqrt()
        };
        Some(BaselineAttitude {
            heading_rad: e.atan2(n).rem_euclid(std::f64::consts::TAU),
            heading_sigma_rad: sigma([n / level2, -e / level2, 0.0]),
            pitch_rad: u.atan2(level),
            pitch_sigma_rad: sigma([
                -u * e / (level * length2),
                -u * n / (level * length2),
                level / length2,
            ]),
            length_m: length,
            length_sigma_m: sigma([e / length, n / length, u / length]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn baseline(enu_m: [f64; 3]) -> Baseline {
        let base_position_ecef_m = [3_774_093.7, -601_662.6, 5_089_328.1];
        let frame = EnuFrame::from_ecef(base_position_ecef_m);
        let covariance = [
            [4e-4, -1e-5, 2e-5],
            [-1e-5, 9e-4, -3e-5],
            [2e-5, -3e-5, 25e-4],
        ];
        Baseline {
            base_position_ecef_m,
            vector_ecef_m: frame.ecef_vector_from_enu(enu_m),
            covariance_ecef_m2: frame.ecef_covariance_from_enu(&covariance),
        }
    }

    /// Standard deviations are compared with numerical derivatives.
    #[test]
    fn deviations_are_those_of_the_derivatives() {
        let place = [-1.1, 0.7, 0.4];
        let found = baseline(place).attitude().unwrap();
        let covariance = baseline(place).enu_covariance_m2();
        let values = |enu: [f64; 3]| {
            let a = baseline(enu).attitude().unwrap();
            [a.heading_rad, a.pitch_rad, a.length_m]
        };
        let step = 1e-5;
        let slopes: Vec<[f64; 3]> = (0..3)
            .map(|k| {
                let (mut up, mut down) = (place, place);
                up[k] += step;
                down[k] -= step;
                let (a, b) = (values(up), values(down));
                std::array::from_fn(|q| (a[q] - b[q]) / (2.0 * step))
            })
            .collect();
        let expected: [f64; 3] = std::array::from_fn(|q| {
            let mut variance = 0.0;
            for i in 0..3 {
                for j in 0..3 {
                    variance += slopes[i][q] * covariance[i][j] * slopes[j][q];
                }
            }
            variance.sqrt()
        });
        let sigmas = [
            found.heading_sigma_rad,
            found.pitch_sigma_rad,
            found.length_sigma_m,
        ];
        for (sigma, expected) in sigmas.iter().zip(expected) {
            assert!((sigma - expected).abs() < 1e-6, "{sigma} {expected}");
        }
        assert!((found.heading_rad.to_degrees() - 302.471_192).abs() < 1e-5);
        assert!((found.length_m - 1.363_818).abs() < 1e-6);
    }

    #[test]
    fn an_upright_baseline_has_no_heading() {
        assert_eq!(baseline([0.0, 0.0, 1.0]).attitude(), None);
        assert_eq!(baseline([0.0; 3]).attitude(), None);
    }
}
