//! The transverse Mercator projection of the UTM zones.

use crate::geodesy::{Geodetic, WGS84_FLATTENING, WGS84_SEMI_MAJOR_AXIS_M};

/// The UTM zone of a place, 1 to 60, with the wider zones of southern Norway and Svalbard, and whether
/// it lies south of the equator.
///
/// ```
/// use acerra_geo::geodesy::Geodetic;
/// use acerra_geo::utm::utm_zone;
/// assert_eq!(utm_zone(&Geodetic::from_degrees(41.0, 14.2, 0.0)), (33, false));
/// assert_eq!(utm_zone(&Geodetic::from_degrees(60.4, 5.3, 0.0)), (32, false)); // Bergen
/// ```
#[must_use]
pub fn utm_zone(place: &Geodetic) -> (u8, bool) {
    let (latitude_deg, longitude_deg) = (place.latitude_deg(), place.longitude_deg());
    let east_deg = (longitude_deg + 180.0).rem_euclid(360.0);
    let regular = (east_deg / 6.0).floor().clamp(0.0, 59.0) as u8 + 1;
    let longitude_deg = east_deg - 180.0;
    let zone = if (56.0..64.0).contains(&latitude_deg) && (3.0..12.0).contains(&longitude_deg) {
        32
    } else if (72.0..84.0).contains(&latitude_deg) && (0.0..42.0).contains(&longitude_deg) {
        match longitude_deg {
            l if l < 9.0 => 31,
            l if l < 21.0 => 33,
            l if l < 33.0 => 35,
            _ => 37,
        }
    } else {
        regular
    };
    (zone, latitude_deg < 0.0)
}

/// Easting and northing (m) in a UTM zone, by Krüger's series to the sixth order in the third
/// flattening: to a nanometre within the zone and a millimetre 30° from its meridian (Karney 2011,
/// J. Geodesy 85, Eqs. (7)–(9), (11), (35)).
#[must_use]
pub fn utm_from_geodetic(place: &Geodetic, zone: u8, south: bool) -> [f64; 2] {
    const SCALE: f64 = 0.9996;
    let n = WGS84_FLATTENING / (2.0 - WGS84_FLATTENING);
    let n2 = n * n;
    let (n3, n4) = (n2 * n, n2 * n2);
    let (n5, n6) = (n4 * n, n4 * n2);
    let radius = WGS84_SEMI_MAJOR_AXIS_M / (1.0 + n) * (1.0 + n2 / 4.0 + n4 / 64.0 + n6 / 256.0);
    let alpha = [
        n / 2.0 - 2.0 / 3.0 * n2 + 5.0 / 16.0 * n3 + 41.0 / 180.0 * n4 - 127.0 / 288.0 * n5
            + 7891.0 / 37800.0 * n6,
        13.0 / 48.0 * n2 - 3.0 / 5.0 * n3 + 557.0 / 1440.0 * n4 + 281.0 / 630.0 * n5
            - 1_983_433.0 / 1_935_360.0 * n6,
        61.0 / 240.0 * n3 - 103.0 / 140.0 * n4
            + 15061.0 / 26880.0 * n5
            + 167_603.0 / 181_440.0 * n6,
        49561.0 / 161_280.0 * n4 - 179.0 / 168.0 * n5 + 6_601_661.0 / 7_257_600.0 * n6,
        34729.0 / 80640.0 * n5 - 3_418_889.0 / 1_995_840.0 * n6,
        212_378_941.0 / 319_334_400.0 * n6,
    ];
    let e = (WGS84_FLATTENING * (2.0 - WGS84_FLATTENING)).sqrt();
    let meridian_rad = (6.0 * f64::from(zone) - 183.0).to_radians();
    let lambda = place.longitude_rad - meridian_rad;
    let tau = place.latitude_rad.tan();
    let sigma = (e * (e * tau / tau.hypot(1.0)).atanh()).sinh();
    let conformal = tau * sigma.hypot(1.0) - sigma * tau.hypot(1.0);
    let xi0 = conformal.atan2(lambda.cos());
    let eta0 = (lambda.sin() / conformal.hypot(lambda.cos())).asinh();
    let (mut xi, mut eta) = (xi0, eta0);
    for (k, a) in alpha.iter().enumerate() {
        let order = 2.0 * (k + 1) as f64;
        xi += a * (order * xi0).sin() * (order * eta0).cosh();
        eta += a * (order * xi0).cos() * (order * eta0).sinh();
    }
    let false_northing_m = if south { 10_000_000.0 } else { 0.0 };
    [
        500_000.0 + SCALE * radius * eta,
        false_northing_m + SCALE * radius * xi,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zones_follow_the_grid_and_its_exceptions() {
        let zone = |lat, lon| utm_zone(&Geodetic::from_degrees(lat, lon, 0.0));
        assert_eq!(zone(0.0, -180.0), (1, false));
        assert_eq!(zone(-33.9, 18.4), (34, true));
        assert_eq!(zone(10.0, 180.0), (1, false));
        assert_eq!(zone(55.9, 5.0), (31, false));
        for (lon, expected) in [(8.9, 31), (9.0, 33), (21.0, 35), (33.0, 37), (42.0, 38)] {
            assert_eq!(zone(78.0, lon).0, expected);
        }
    }

    #[test]
    fn known_places() {
        // On the central meridian: easting 500 km; at the equator northing 0.
        let [e, n] = utm_from_geodetic(&Geodetic::from_degrees(0.0, 15.0, 0.0), 33, false);
        assert!((e - 500_000.0).abs() < 1e-6 && n.abs() < 1e-6);
        // The meridian arc to the pole, 10 001 965.7293 m, times 0.9996.
        let [_, n] = utm_from_geodetic(&Geodetic::from_degrees(90.0, 15.0, 0.0), 33, false);
        assert!((n - 0.9996 * 10_001_965.729_3).abs() < 1e-3, "{n}");
        // By PROJ 9.5.
        for (lat, lon, zone, south, expected) in [
            (41.0, 14.2, 33, false, [432_718.466_193, 4_539_065.232_625]),
            (-33.9, 18.4, 34, true, [259_583.221_660, 6_245_888.045_441]),
            (
                43.642_566_7,
                -79.387_138_9,
                17,
                false,
                [630_084.309_548, 4_833_438.552_512],
            ),
        ] {
            let found = utm_from_geodetic(&Geodetic::from_degrees(lat, lon, 0.0), zone, south);
            for (f, e) in found.iter().zip(expected) {
                assert!((f - e).abs() < 2e-6, "{found:?}");
            }
        }
        // South of the equator ten thousand kilometres are added.
        let [e1, n1] = utm_from_geodetic(&Geodetic::from_degrees(-33.9, 18.4, 0.0), 34, true);
        let [e2, n2] = utm_from_geodetic(&Geodetic::from_degrees(33.9, 18.4, 0.0), 34, false);
        assert!((e1 - e2).abs() < 1e-6 && (n1 + n2 - 10_000_000.0).abs() < 1e-6);
    }

    #[test]
    fn the_projection_is_conformal_with_the_scale_of_the_zone() {
        // Small steps north and east are at right angles and equally stretched.
        let at = |lat: f64, lon: f64| {
            utm_from_geodetic(&Geodetic::from_degrees(lat, lon, 0.0), 33, false)
        };
        let (lat, lon, d) = (41.0_f64, 14.2, 1e-6_f64);
        let e2 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING);
        let w = 1.0 - e2 * lat.to_radians().sin().powi(2);
        let north_m = d.to_radians() * WGS84_SEMI_MAJOR_AXIS_M * (1.0 - e2) / w.powf(1.5);
        let east_m = d.to_radians() * WGS84_SEMI_MAJOR_AXIS_M / w.sqrt() * lat.to_radians().cos();
        let (p, n, e) = (at(lat, lon), at(lat + d, lon), at(lat, lon + d));
        let north = [(n[0] - p[0]) / north_m, (n[1] - p[1]) / north_m];
        let east = [(e[0] - p[0]) / east_m, (e[1] - p[1]) / east_m];
        let (a, b) = (north[0].hypot(north[1]), east[0].hypot(east[1]));
        assert!(
            (a - b).abs() < 1e-6 && (0.9996..0.9998).contains(&a),
            "{a} {b}"
        );
        assert!((north[0] * east[0] + north[1] * east[1]).abs() < 1e-6);
    }
}
