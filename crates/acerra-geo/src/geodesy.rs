//! The WGS84 ellipsoid, Earth-centred and geodetic coordinates, local east-north-up frames.

use crate::matrix::{
    Matrix3, Vector3, add, multiply_vector, rotate_covariance, subtract, transpose,
};

/// Semi-major axis of WGS84 (m).
pub const WGS84_SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;

/// Flattening of WGS84.
pub const WGS84_FLATTENING: f64 = 1.0 / 298.257_223_563;

/// First eccentricity squared, f (2 − f).
const ECCENTRICITY_SQUARED: f64 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING);

/// A place by latitude, longitude and height above the WGS84 ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodetic {
    /// Geodetic latitude, north positive (rad).
    pub latitude_rad: f64,
    /// Longitude, east positive (rad).
    pub longitude_rad: f64,
    /// Height above the ellipsoid (m), not above the sea.
    pub height_m: f64,
}

impl Geodetic {
    /// From degrees and metres.
    #[must_use]
    pub fn from_degrees(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Self {
        Self {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: longitude_deg.to_radians(),
            height_m,
        }
    }

    /// Latitude (°).
    #[must_use]
    pub fn latitude_deg(&self) -> f64 {
        self.latitude_rad.to_degrees()
    }

    /// Longitude (°).
    #[must_use]
    pub fn longitude_deg(&self) -> f64 {
        self.longitude_rad.to_degrees()
    }
}

/// Earth-centred, Earth-fixed coordinates (m) of a place.
///
/// ```
/// use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
/// let p = ecef_from_geodetic(&Geodetic::from_degrees(35.0, 140.0, 100.0));
/// assert!((p[0] + 4_006_802.166_763).abs() < 1e-6);
/// ```
#[must_use]
pub fn ecef_from_geodetic(place: &Geodetic) -> Vector3 {
    let (sin_lat, cos_lat) = place.latitude_rad.sin_cos();
    let (sin_lon, cos_lon) = place.longitude_rad.sin_cos();
    let n = WGS84_SEMI_MAJOR_AXIS_M / (1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
    let p = (n + place.height_m) * cos_lat;
    [
        p * cos_lon,
        p * sin_lon,
        (n * (1.0 - ECCENTRICITY_SQUARED) + place.height_m) * sin_lat,
    ]
}

/// Latitude, longitude and height of an Earth-centred, Earth-fixed point (m).
///
/// Bowring's iteration on the parametric latitude, until the latitude converges: accurate to 1e-12 rad and
/// 1e-8 m from 100 km inside the ellipsoid out to the satellites. On the axis the longitude is 0; at the
/// Earth's centre, where no normal is unique, the answer is a point below the equator.
#[must_use]
pub fn geodetic_from_ecef(pos_in_ecef_m: Vector3) -> Geodetic {
    let [x, y, z] = pos_in_ecef_m;
    let a = WGS84_SEMI_MAJOR_AXIS_M;
    let b = a * (1.0 - WGS84_FLATTENING);
    let second_eccentricity_squared = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED);
    let p = x.hypot(y);
    let longitude_rad = if p > 0.0 { y.atan2(x) } else { 0.0 };

    let mut latitude_rad = z.atan2(p * (1.0 - ECCENTRICITY_SQUARED));
    for _ in 0..8 {
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        let parametric = (b * sin_lat).atan2(a * cos_lat);
        let (s, c) = parametric.sin_cos();
        let next = (z + second_eccentricity_squared * b * s * s * s)
            .atan2(p - ECCENTRICITY_SQUARED * a * c * c * c);
        let step = (next - latitude_rad).abs();
        latitude_rad = next;
        if step < 1e-15 {
            break;
        }
    }
    let (sin_lat, cos_lat) = latitude_rad.sin_cos();
    // This form of the height has no pole where it divides by zero.
    let height_m =
        p * cos_lat + z * sin_lat - a * (1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat).sqrt();
    Geodetic {
        latitude_rad,
        longitude_rad,
        height_m,
    }
}

/// A local frame: x east, y north, z up, tangent to the ellipsoid's parallel surface at its origin.
///
/// ```
/// use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
/// let frame = EnuFrame::new(Geodetic::from_degrees(40.9, 14.2, 60.0));
/// let above = ecef_from_geodetic(&Geodetic::from_degrees(40.9, 14.2, 64.0));
/// let [east, north, up] = frame.enu_from_ecef(above);
/// assert!(east.abs() < 1e-8 && north.abs() < 1e-8 && (up - 4.0).abs() < 1e-8);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnuFrame {
    origin: Geodetic,
    origin_in_ecef_m: Vector3,
    enu_from_ecef: Matrix3,
}

impl EnuFrame {
    /// The frame about a place.
    #[must_use]
    pub fn new(origin: Geodetic) -> Self {
        Self::about(origin, ecef_from_geodetic(&origin))
    }

    /// The frame about an Earth-centred, Earth-fixed point (m).
    #[must_use]
    pub fn from_ecef(origin_in_ecef_m: Vector3) -> Self {
        Self::about(geodetic_from_ecef(origin_in_ecef_m), origin_in_ecef_m)
    }

    fn about(origin: Geodetic, origin_in_ecef_m: Vector3) -> Self {
        let (sin_lat, cos_lat) = origin.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = origin.longitude_rad.sin_cos();
        let enu_from_ecef = [
            [-sin_lon, cos_lon, 0.0],
            [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
        ];
        Self {
            origin,
            origin_in_ecef_m,
            enu_from_ecef,
        }
    }

    /// Place of the frame.
    #[must_use]
    pub const fn origin(&self) -> &Geodetic {
        &self.origin
    }

    /// Where the frame is, Earth-centred, Earth-fixed (m).
    #[must_use]
    pub const fn origin_in_ecef_m(&self) -> Vector3 {
        self.origin_in_ecef_m
    }

    /// The rotation that turns Earth-fixed axes into east, north, up.
    #[must_use]
    pub const fn rotation_enu_from_ecef(&self) -> &Matrix3 {
        &self.enu_from_ecef
    }

    /// A point's coordinates in this frame (m).
    #[must_use]
    pub fn enu_from_ecef(&self, pos_in_ecef_m: Vector3) -> Vector3 {
        self.enu_vector_from_ecef(subtract(pos_in_ecef_m, self.origin_in_ecef_m))
    }

    /// Earth-centred, Earth-fixed coordinates (m) of a point of this frame.
    #[must_use]
    pub fn ecef_from_enu(&self, pos_in_enu_m: Vector3) -> Vector3 {
        add(
            self.ecef_vector_from_enu(pos_in_enu_m),
            self.origin_in_ecef_m,
        )
    }

    /// A point's coordinates in this frame (m).
    #[must_use]
    pub fn enu_from_geodetic(&self, place: &Geodetic) -> Vector3 {
        self.enu_from_ecef(ecef_from_geodetic(place))
    }

    /// Latitude, longitude and height of a point of this frame.
    #[must_use]
    pub fn geodetic_from_enu(&self, pos_in_enu_m: Vector3) -> Geodetic {
        geodetic_from_ecef(self.ecef_from_enu(pos_in_enu_m))
    }

    /// A direction, velocity or baseline turned into east, north, up.
    #[must_use]
    pub fn enu_vector_from_ecef(&self, vector_in_ecef: Vector3) -> Vector3 {
        multiply_vector(&self.enu_from_ecef, vector_in_ecef)
    }

    /// A direction, velocity or baseline turned into Earth-fixed axes.
    #[must_use]
    pub fn ecef_vector_from_enu(&self, vector_in_enu: Vector3) -> Vector3 {
        multiply_vector(&transpose(&self.enu_from_ecef), vector_in_enu)
    }

    /// A covariance of Earth-fixed coordinates turned into east, north, up.
    #[must_use]
    pub fn enu_covariance_from_ecef(&self, covariance_in_ecef: &Matrix3) -> Matrix3 {
        rotate_covariance(&self.enu_from_ecef, covariance_in_ecef)
    }

    /// A covariance of east, north, up turned into Earth-fixed axes.
    #[must_use]
    pub fn ecef_covariance_from_enu(&self, covariance_in_enu: &Matrix3) -> Matrix3 {
        rotate_covariance(&transpose(&self.enu_from_ecef), covariance_in_enu)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{IDENTITY, multiply};

    #[test]
    fn published_points() {
        let g = geodetic_from_ecef([-3_517_319.770_1, 4_131_667.916_1, 3_341_265.122_7]);
        assert!((g.latitude_deg() - 31.796_021_375).abs() < 1e-8);
        assert!((g.longitude_deg() - 130.407_999_17).abs() < 1e-8);
        assert!((g.height_m - 68.863_206).abs() < 1e-4);
        let p = ecef_from_geodetic(&Geodetic::from_degrees(35.0, 140.0, 100.0));
        for (got, want) in p
            .iter()
            .zip([-4_006_802.166_763, 3_362_106.220_331, 3_637_924.267_022])
        {
            assert!((got - want).abs() < 1e-6);
        }
        let frame = EnuFrame::new(Geodetic::from_degrees(35.0, 140.0, 0.0));
        let v = frame.enu_vector_from_ecef([0.3, 0.4, 0.5]);
        for (got, want) in v.iter().zip([-0.499_254, 0.393_916, 0.309_152]) {
            assert!((got - want).abs() < 1e-6);
        }
    }

    #[test]
    fn returns_everywhere_from_pole_to_pole_and_out_to_the_satellites() {
        for latitude in (-90..=90).step_by(3) {
            for longitude in (-180..180).step_by(30) {
                for height_m in [-100_000.0, -430.0, 0.0, 8_848.0, 400e3, 20_200e3, 36_000e3] {
                    let g = Geodetic::from_degrees(latitude.into(), longitude.into(), height_m);
                    let p = ecef_from_geodetic(&g);
                    let back = geodetic_from_ecef(p);
                    assert!(
                        (back.latitude_rad - g.latitude_rad).abs() < 1e-12,
                        "{g:?} {back:?}"
                    );
                    assert!((back.height_m - g.height_m).abs() < 2e-8, "{g:?} {back:?}");
                    let again = ecef_from_geodetic(&back);
                    assert!(
                        p.iter().zip(again).all(|(a, b)| (a - b).abs() < 5e-8),
                        "{g:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn poles_and_centre_are_finite() {
        let pole = geodetic_from_ecef([0.0, 0.0, 6_356_752.314_245]);
        assert!((pole.latitude_deg() - 90.0).abs() < 1e-9 && pole.height_m.abs() < 1e-3);
        assert_eq!(pole.longitude_rad, 0.0);
        let centre = geodetic_from_ecef([0.0; 3]);
        assert!(centre.height_m.is_finite() && centre.latitude_rad.is_finite());
    }

    #[test]
    fn frames_turn_there_and_back() {
        let frame = EnuFrame::new(Geodetic::from_degrees(-33.0, 151.0, 12.0));
        let unit = multiply(
            frame.rotation_enu_from_ecef(),
            &transpose(frame.rotation_enu_from_ecef()),
        );
        for (row, want) in unit.iter().zip(IDENTITY) {
            assert!(row.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-15));
        }
        let p = [12.5, -300.0, 41.0];
        let back = frame.enu_from_ecef(frame.ecef_from_enu(p));
        assert!(p.iter().zip(back).all(|(a, b)| (a - b).abs() < 3e-9));
        // A standard deviation of 3 m upwards is a standard deviation of 3 m along the radius.
        let up = [[0.0; 3], [0.0; 3], [0.0, 0.0, 9.0]];
        let ecef = frame.ecef_covariance_from_enu(&up);
        assert!((ecef[0][0] + ecef[1][1] + ecef[2][2] - 9.0).abs() < 1e-14);
        let enu = frame.enu_covariance_from_ecef(&ecef);
        assert!((enu[2][2] - 9.0).abs() < 1e-14 && enu[0][1] == enu[1][0]);
    }
}
