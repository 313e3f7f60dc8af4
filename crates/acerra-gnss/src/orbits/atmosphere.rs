//! Signal delays in ionosphere and troposphere: Klobuchar, Saastamoinen, Niell.

use super::navigation::Klobuchar;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::GpsTime;
use std::f64::consts::PI;

/// Relative humidity assumed where the wet delay is modelled.
pub(crate) const RELATIVE_HUMIDITY: f64 = 0.7;

impl Klobuchar {
    /// Coefficients used when none are broadcast (those of a day in 2004).
    pub const FALLBACK: Self = Self {
        alpha: [1.118e-8, -7.451e-9, -5.961e-8, 1.192e-7],
        beta: [1.167e5, -2.294e5, -1.311e5, 1.049e6],
    };

    /// Whether every coefficient is zero, which means "not broadcast".
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.alpha.iter().chain(&self.beta).all(|&c| c == 0.0)
    }

    /// Ionospheric delay on L1 (m) at `place` and `t` for a satellite at this azimuth and
    /// elevation (rad). Zero below −1 km height or for elevations not above the horizon.
    ///
    /// Source: IS-GPS-200, figure 20-4.
    #[must_use]
    pub fn delay_l1_m(
        &self,
        t: GpsTime,
        place: &Geodetic,
        azimuth_rad: f64,
        elevation_rad: f64,
    ) -> f64 {
        if place.height_m < -1e3 || elevation_rad <= 0.0 {
            return 0.0;
        }
        let elevation = elevation_rad / PI;
        let psi = 0.0137 / (elevation + 0.11) - 0.022;
        let latitude = (place.latitude_rad / PI + psi * azimuth_rad.cos()).clamp(-0.416, 0.416);
        let longitude = place.longitude_rad / PI + psi * azimuth_rad.sin() / (latitude * PI).cos();
        let magnetic = latitude + 0.064 * ((longitude - 1.617) * PI).cos();
        let local = (43_200.0 * longitude + t.tow_s()).rem_euclid(86_400.0);
        let slant = 1.0 + 16.0 * (0.53 - elevation).powi(3);
        let cubic = |c: &[f64; 4]| c[0] + magnetic * (c[1] + magnetic * (c[2] + magnetic * c[3]));
        let amplitude = cubic(&self.alpha).max(0.0);
        let period = cubic(&self.beta).max(72_000.0);
        let x = 2.0 * PI * (local - 50_400.0) / period;
        let day = if x.abs() < 1.57 {
            amplitude * (1.0 + x * x * (-0.5 + x * x / 24.0))
        } else {
            0.0
        };
        SPEED_OF_LIGHT_M_S * slant * (5e-9 + day)
    }
}

/// Tropospheric delay (m) in the standard atmosphere, for a satellite at `elevation_rad`.
///
/// `humidity` is relative, 0–1. Zero outside −1…10 km of height or below the horizon. Source:
/// Saastamoinen (1972) with the standard atmosphere, which is continued below sea level: heights
/// above the ellipsoid are below zero along whole coasts.
#[must_use]
pub fn saastamoinen_m(place: &Geodetic, elevation_rad: f64, humidity: f64) -> f64 {
    if place.height_m < -1e3 || place.height_m > 1e4 || elevation_rad <= 0.0 {
        return 0.0;
    }
    let height = place.height_m;
    let pressure = 1_013.25 * (1.0 - 2.2557e-5 * height).powf(5.256_8);
    let temperature = 15.0 - 6.5e-3 * height + 273.16;
    let vapour = 6.108 * humidity * ((17.15 * temperature - 4_684.0) / (temperature - 38.45)).exp();
    let gravity = 1.0 - 0.002_66 * (2.0 * place.latitude_rad).cos() - 0.000_28 * height / 1e3;
    let hydrostatic = 0.002_276_8 * pressure / gravity;
    let wet = 0.002_277 * (1_255.0 / temperature + 0.05) * vapour;
    (hydrostatic + wet) / elevation_rad.sin()
}

/// The place, raised to height zero where it is lower: below height zero RTKLIB uses the atmosphere at height
/// zero.
pub(crate) fn not_below_zero_height(place: &Geodetic) -> Geodetic {
    Geodetic {
        height_m: place.height_m.max(0.0),
        ..*place
    }
}

/// Hydrostatic and wet mapping functions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapping {
    /// Slant over zenith delay of the hydrostatic part.
    pub hydrostatic: f64,
    /// Slant over zenith delay of the wet part.
    pub wet: f64,
}

/// Coefficients at 15°, 30°, 45°, 60°, 75° latitude.
struct NiellColumns([f64; 5]);

impl NiellColumns {
    fn at(&self, latitude_deg: f64) -> f64 {
        let index = (latitude_deg / 15.0) as usize;
        match index {
            0 => self.0[0],
            1..=4 => {
                let share = latitude_deg / 15.0 - index as f64;
                self.0[index - 1] * (1.0 - share) + self.0[index] * share
            }
            _ => self.0[4],
        }
    }
}

const AVERAGE: [NiellColumns; 3] = [
    NiellColumns([
        1.2769934e-3,
        1.2683230e-3,
        1.2465397e-3,
        1.2196049e-3,
        1.2045996e-3,
    ]),
    NiellColumns([
        2.9153695e-3,
        2.9152299e-3,
        2.9288445e-3,
        2.9022565e-3,
        2.9024912e-3,
    ]),
    NiellColumns([
        62.610505e-3,
        62.837393e-3,
        63.721774e-3,
        63.824265e-3,
        64.258455e-3,
    ]),
];
const AMPLITUDE: [NiellColumns; 3] = [
    NiellColumns([0.0, 1.2709626e-5, 2.6523662e-5, 3.4000452e-5, 4.1202191e-5]),
    NiellColumns([0.0, 2.1414979e-5, 3.0160779e-5, 7.2562722e-5, 11.723375e-5]),
    NiellColumns([0.0, 9.0128400e-5, 4.3497037e-5, 84.795348e-5, 170.37206e-5]),
];
const WET: [NiellColumns; 3] = [
    NiellColumns([
        5.8021897e-4,
        5.6794847e-4,
        5.8118019e-4,
        5.9727542e-4,
        6.1641693e-4,
    ]),
    NiellColumns([
        1.4275268e-3,
        1.5138625e-3,
        1.4572752e-3,
        1.5007428e-3,
        1.7599082e-3,
    ]),
    NiellColumns([
        4.3472961e-2,
        4.6729510e-2,
        4.3908931e-2,
        4.4626982e-2,
        5.4736038e-2,
    ]),
];
const HEIGHT: [f64; 3] = [2.53e-5, 5.49e-3, 1.14e-3];

/// Niell's mapping functions at one place and time, ready for any elevation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Niell {
    hydrostatic: [f64; 3],
    wet: [f64; 3],
    height_km: f64,
    valid: bool,
}

impl Niell {
    /// Prepares the coefficients of `place` at `t`. Source: Niell (1996), doi:10.1029/95JB03048.
    #[must_use]
    pub fn new(t: GpsTime, place: &Geodetic) -> Self {
        let latitude_deg = place.latitude_rad.to_degrees();
        let calendar = t.to_calendar();
        let seconds = f64::from(calendar.hour) * 3_600.0
            + f64::from(calendar.minute) * 60.0
            + calendar.second_f64();
        let day = f64::from(calendar.day_of_year()) + seconds / 86_400.0;
        let southern = if latitude_deg < 0.0 { 0.5 } else { 0.0 };
        let season = (2.0 * PI * ((day - 28.0) / 365.25 + southern)).cos();
        let latitude = latitude_deg.abs();
        Self {
            hydrostatic: std::array::from_fn(|k| {
                AVERAGE[k].at(latitude) - AMPLITUDE[k].at(latitude) * season
            }),
            wet: std::array::from_fn(|k| WET[k].at(latitude)),
            height_km: place.height_m / 1e3,
            valid: (-1.0..=20.0).contains(&(place.height_m / 1e3)),
        }
    }

    /// The mapping at an elevation (rad); zero below the horizon or outside −1…20 km.
    #[must_use]
    pub fn at(&self, elevation_rad: f64) -> Mapping {
        if !self.valid || elevation_rad <= 0.0 {
            return Mapping {
                hydrostatic: 0.0,
                wet: 0.0,
            };
        }
        let sin = elevation_rad.sin();
        let height = (1.0 / sin - continued_fraction(sin, HEIGHT)) * self.height_km;
        Mapping {
            hydrostatic: continued_fraction(sin, self.hydrostatic) + height,
            wet: continued_fraction(sin, self.wet),
        }
    }
}

/// Marini's continued fraction, normalised to 1 at the zenith.
fn continued_fraction(sin: f64, [a, b, c]: [f64; 3]) -> f64 {
    (1.0 + a / (1.0 + b / (1.0 + c))) / (sin + a / (sin + b / (sin + c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST_IONOSPHERE: Klobuchar = Klobuchar {
        alpha: [0.2e-7, -0.8e-8, -0.5e-7, 0.1e-6],
        beta: [0.2e6, 0.2e6, -0.1e6, -0.1e7],
    };

    fn places() -> [Geodetic; 3] {
        [
            Geodetic::from_degrees(35.0, 140.0, 100.0),
            Geodetic::from_degrees(-80.0, -170.0, 1_000.0),
            Geodetic::from_degrees(10.0, 30.0, 0.0),
        ]
    }

    #[test]
    fn klobuchar_agrees_with_reference_values() {
        let rows = [
            (1, 0, 60.0, 75.0, 6.735_905_320_994_38),
            (1, 1, 60.0, 75.0, 3.568_953_821_973_87),
            (1, 2, 60.0, 75.0, 3.807_164_356_551_61),
            (13, 0, 60.0, 75.0, 5.217_969_545_854_52),
            (22, 0, 60.0, 75.0, 5.901_905_392_647_77),
            (1, 0, 190.0, 3.0, 21.634_541_512_363_2),
            (1, 0, 350.0, 60.0, 7.338_442_788_225_61),
            (1, 0, 0.0, 90.0, 6.583_397_114_006_94),
        ];
        for (hour, place, azimuth, elevation, expected) in rows {
            let t = GpsTime::from_week_tow(1_410, 172_800.0 + f64::from(hour) * 3_600.0);
            let (az, el) = (f64::to_radians(azimuth), f64::to_radians(elevation));
            let found = TEST_IONOSPHERE.delay_l1_m(t, &places()[place], az, el);
            assert!(
                (found - expected).abs() < 1e-8,
                "{hour} {place}: {found} {expected}"
            );
        }
        let t = GpsTime::from_week_tow(1_410, 0.0);
        assert_eq!(TEST_IONOSPHERE.delay_l1_m(t, &places()[0], 0.0, 0.0), 0.0);
    }

    #[test]
    fn saastamoinen_agrees_with_reference_values() {
        let rows = [
            (0, 75.0, 0.5, 2.447_998_701_440_88),
            (0, 3.0, 0.5, 45.180_891_650_616_3),
            (1, 75.0, 0.5, 2.172_958_172_981_52),
        ];
        for (place, elevation, humidity, expected) in rows {
            let found = saastamoinen_m(&places()[place], f64::to_radians(elevation), humidity);
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
        assert!((saastamoinen_m(&places()[0], PI / 2.0, 0.0) - 2.281_883_026).abs() < 1e-9);
        assert!((saastamoinen_m(&places()[0], PI / 2.0, 0.7) - 2.397_666_025).abs() < 1e-9);
        let high = Geodetic::from_degrees(35.0, 140.0, 1e5);
        let low = Geodetic::from_degrees(35.0, 140.0, -2e3);
        assert_eq!(saastamoinen_m(&high, 1.0, 0.5), 0.0);
        assert_eq!(saastamoinen_m(&low, 1.0, 0.5), 0.0);
        assert_eq!(saastamoinen_m(&places()[0], -0.1, 0.5), 0.0);
    }

    /// Air at sea level weighs 12 Pa per metre, and 1 hPa delays by 2.28 mm at the zenith.
    #[test]
    fn the_zenith_delay_falls_steadily_from_the_dead_sea_upwards() {
        let zenith_m =
            |height_m| saastamoinen_m(&Geodetic::from_degrees(31.5, 35.5, height_m), PI / 2.0, 0.0);
        for (height_m, expected) in [(-420.0, 2.86e-4), (-100.0, 2.77e-4), (0.0, 2.74e-4)] {
            let per_m = (zenith_m(height_m - 5.0) - zenith_m(height_m + 5.0)) / 10.0;
            assert!((per_m / expected - 1.0).abs() < 0.03, "{height_m}: {per_m}");
        }
    }

    #[test]
    fn niell_agrees_with_reference_values() {
        let t = GpsTime::from_week_tow(1_410, 172_800.0 + 6.0 * 3_600.0);
        let rows = [
            (0, 75.0, 1.035_184_526_466_435, 1.035_233_787_448_654),
            (0, 3.0, 14.643_271_711_748_2, 16.455_045_694_559_484),
            (0, 60.0, 1.154_226_397_147_367, 1.154_481_126_139_61),
            (0, 90.0, 1.0, 1.0),
            (1, 75.0, 1.035_186_155_749_051, 1.035_230_548_304_367),
            (2, 75.0, 1.035_181_919_429_758, 1.035_233_200_318_21),
        ];
        for (place, elevation, hydrostatic, wet) in rows {
            let found = Niell::new(t, &places()[place]).at(f64::to_radians(elevation));
            assert!(
                (found.hydrostatic - hydrostatic).abs() < 1e-8,
                "{found:?} {hydrostatic}"
            );
            assert!((found.wet - wet).abs() < 1e-8, "{found:?} {wet}");
        }
        let late = acerra_geo::time::Calendar::new(2030, 12, 31, 23, 59, 59.0).unwrap();
        let found = Niell::new(GpsTime::from_calendar(&late), &places()[0]).at(75f64.to_radians());
        assert!((found.hydrostatic - 1.035_184_415_128_022).abs() < 1e-8);
    }
}
