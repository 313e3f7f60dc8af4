//! Satellite positions and clocks from broadcast ephemerides.

use super::glonass::GlonassNodes;
use super::navigation::{Ephemeris, KeplerEphemeris, SbasEphemeris};
use super::state::{EARTH_ROTATION_CGCS_RAD_S, EARTH_ROTATION_RAD_S, OrbitRates, OrbitState};
use crate::observations::satellite::System;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use acerra_geo::time::GpsTime;

const MU_GPS: f64 = 3.986_005_0e14;
const MU_GALILEO: f64 = 3.986_004_418e14;
/// Step of the forward difference that gives velocities (s).
const VELOCITY_STEP_S: f64 = 1e-3;

impl Ephemeris {
    /// Position and clock at GPS time `t`.
    ///
    /// Source: IS-GPS-200 (20.3.3.4.3), Galileo OS SIS ICD, BeiDou ICD (geostationary satellites
    /// in their tilted frame) and GLONASS ICD (fourth-order Runge–Kutta in 60 s steps).
    #[must_use]
    pub fn orbit_at(&self, t: GpsTime) -> OrbitState {
        match self {
            Self::Kepler(e) => kepler(e, t),
            Self::Glonass(e) => GlonassNodes::default().orbit_at(e, t),
            Self::Sbas(e) => sbas(e, t),
        }
    }

    /// Velocity and clock drift at `t`, by forward difference over a millisecond.
    #[must_use]
    pub fn rates_at(&self, t: GpsTime) -> OrbitRates {
        rates(&self.orbit_at(t), &self.orbit_at(t + VELOCITY_STEP_S))
    }

    /// Clock at satellite time `t`, without relativity (s): the correction from the satellite's time stamp to
    /// GPS time.
    #[must_use]
    pub fn clock_without_relativity_s(&self, t: GpsTime) -> f64 {
        let (reference, [a0, a1, a2]) = match self {
            Self::Kepler(e) => (e.toc, e.clock),
            Self::Glonass(e) => (e.toe, [e.clock_offset_s, e.clock_rate, 0.0]),
            Self::Sbas(e) => (e.toe, [e.clock_offset_s, e.clock_rate, 0.0]),
        };
        let delta = t.seconds_since(reference);
        let mut x = delta;
        for _ in 0..2 {
            x = delta - (a0 + a1 * x + a2 * x * x);
        }
        a0 + a1 * x + a2 * x * x
    }
}

/// Rates between two states that are [`VELOCITY_STEP_S`] apart.
fn rates(a: &OrbitState, b: &OrbitState) -> OrbitRates {
    OrbitRates {
        velocity_ecef_m_s: std::array::from_fn(|k| {
            (b.position_ecef_m[k] - a.position_ecef_m[k]) / VELOCITY_STEP_S
        }),
        clock_rate: (b.clock_s - a.clock_s) / VELOCITY_STEP_S,
    }
}

/// An ephemeris for repeated evaluation.
pub(crate) struct Broadcast {
    pub ephemeris: Ephemeris,
    nodes: GlonassNodes,
}

impl From<Ephemeris> for Broadcast {
    fn from(ephemeris: Ephemeris) -> Self {
        Self {
            ephemeris,
            nodes: GlonassNodes::default(),
        }
    }
}

impl Broadcast {
    /// As [`Ephemeris::orbit_at`], and with rates as [`Ephemeris::rates_at`] where requested.
    pub(crate) fn state_at(
        &self,
        t: GpsTime,
        with_rates: bool,
    ) -> (OrbitState, Option<OrbitRates>) {
        let state = self.orbit_at(t);
        let rates = with_rates.then(|| rates(&state, &self.orbit_at(t + VELOCITY_STEP_S)));
        (state, rates)
    }

    fn orbit_at(&self, t: GpsTime) -> OrbitState {
        match &self.ephemeris {
            Ephemeris::Glonass(e) => self.nodes.orbit_at(e, t),
            other => other.orbit_at(t),
        }
    }
}

fn kepler(e: &KeplerEphemeris, t: GpsTime) -> OrbitState {
    let system = e.satellite.system();
    let (mu, rotation) = match system {
        System::Galileo => (MU_GALILEO, EARTH_ROTATION_RAD_S),
        System::Beidou => (MU_GALILEO, EARTH_ROTATION_CGCS_RAD_S),
        _ => (MU_GPS, EARTH_ROTATION_RAD_S),
    };
    let axis = e.sqrt_semi_major_axis * e.sqrt_semi_major_axis;
    let tk = t.seconds_since(e.toe);
    let motion = (mu / (axis * axis * axis)).sqrt() + e.mean_motion_correction_rad_s;
    let mean = e.mean_anomaly_rad + motion * tk;
    let mut anomaly = mean;
    for _ in 0..30 {
        let (sin, cos) = anomaly.sin_cos();
        let step = (anomaly - e.eccentricity * sin - mean) / (1.0 - e.eccentricity * cos);
        anomaly -= step;
        if step.abs() <= 1e-13 {
            break;
        }
    }
    let (sin_anomaly, cos_anomaly) = anomaly.sin_cos();
    let latitude = ((1.0 - e.eccentricity * e.eccentricity).sqrt() * sin_anomaly)
        .atan2(cos_anomaly - e.eccentricity)
        + e.perigee_rad;
    let (sin2, cos2) = (2.0 * latitude).sin_cos();
    let corrected = |[cosine, sine]: [f64; 2]| -> f64 { sine * sin2 + cosine * cos2 };
    let u = latitude + corrected(e.latitude_correction_rad);
    let radius = axis * (1.0 - e.eccentricity * cos_anomaly) + corrected(e.radius_correction_m);
    let inclination =
        e.inclination_rad + e.inclination_rate_rad_s * tk + corrected(e.inclination_correction_rad);
    let (sin_u, cos_u) = u.sin_cos();
    let (x, y) = (radius * cos_u, radius * sin_u);
    let (sin_i, cos_i) = inclination.sin_cos();
    let in_plane = |node: f64| {
        let (sin_o, cos_o) = node.sin_cos();
        [
            x * cos_o - y * cos_i * sin_o,
            x * sin_o + y * cos_i * cos_o,
            y * sin_i,
        ]
    };
    let toe = e.toe_seconds_of_week;
    let position_ecef_m = if is_beidou_geostationary(e) {
        let [gx, gy, gz] =
            in_plane(e.ascending_node_rad + e.ascending_node_rate_rad_s * tk - rotation * toe);
        let (sin_t, cos_t) = (-5f64).to_radians().sin_cos();
        let (sin_w, cos_w) = (rotation * tk).sin_cos();
        let (ty, tz) = (gy * cos_t + gz * sin_t, -gy * sin_t + gz * cos_t);
        [gx * cos_w + ty * sin_w, -gx * sin_w + ty * cos_w, tz]
    } else {
        in_plane(
            e.ascending_node_rad + (e.ascending_node_rate_rad_s - rotation) * tk - rotation * toe,
        )
    };
    let dt = t.seconds_since(e.toc);
    let relativity = 2.0 * (mu * axis).sqrt() * e.eccentricity * sin_anomaly
        / (SPEED_OF_LIGHT_M_S * SPEED_OF_LIGHT_M_S);
    OrbitState {
        position_ecef_m,
        clock_s: e.clock[0] + e.clock[1] * dt + e.clock[2] * dt * dt - relativity,
    }
}

fn is_beidou_geostationary(e: &KeplerEphemeris) -> bool {
    e.satellite.system() == System::Beidou && matches!(e.satellite.number(), 1..=5 | 59..=63)
}

fn sbas(e: &SbasEphemeris, t: GpsTime) -> OrbitState {
    let dt = t.seconds_since(e.toe);
    OrbitState {
        position_ecef_m: std::array::from_fn(|k| {
            e.position_ecef_m[k]
                + e.velocity_ecef_m_s[k] * dt
                + e.acceleration_ecef_m_s2[k] * dt * dt / 2.0
        }),
        clock_s: e.clock_offset_s + e.clock_rate * dt,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::satellite::SatelliteId;
    use crate::orbits::navigation::GlonassEphemeris;

    /// An ephemeris without any correction, for tests to fill in.
    fn blank(satellite: &str, reference: GpsTime) -> KeplerEphemeris {
        KeplerEphemeris {
            satellite: satellite.parse().unwrap(),
            iode: 0,
            iodc: 0,
            health: 0,
            data_source: 0,
            accuracy_m: 2.4,
            toc: reference,
            toe: reference,
            transmission_time: reference,
            toe_seconds_of_week: 0.0,
            sqrt_semi_major_axis: 0.0,
            eccentricity: 0.0,
            inclination_rad: 0.0,
            ascending_node_rad: 0.0,
            perigee_rad: 0.0,
            mean_anomaly_rad: 0.0,
            mean_motion_correction_rad_s: 0.0,
            ascending_node_rate_rad_s: 0.0,
            inclination_rate_rad_s: 0.0,
            latitude_correction_rad: [0.0; 2],
            radius_correction_m: [0.0; 2],
            inclination_correction_rad: [0.0; 2],
            clock: [0.0; 3],
            group_delay_s: [0.0; 2],
        }
    }

    fn gps() -> KeplerEphemeris {
        KeplerEphemeris {
            toe_seconds_of_week: 518_400.0,
            sqrt_semi_major_axis: 5_153.696_329_120,
            eccentricity: 1.308_864_122_260e-2,
            inclination_rad: 0.936_522_708_033_0,
            ascending_node_rad: 0.563_589_871_757_0,
            perigee_rad: -1.804_738_833_410,
            mean_anomaly_rad: 2.666_824_890_220,
            mean_motion_correction_rad_s: 5.031_281_169_470e-9,
            ascending_node_rate_rad_s: -7.899_615_184_210e-9,
            inclination_rate_rad_s: -1.746_501_276_930e-10,
            radius_correction_m: [216.5, 21.906_25],
            latitude_correction_rad: [1.093_372_702_600e-6, 7.616_356_015_210e-6],
            inclination_correction_rad: [1.303_851_604_460e-7, -1.024_454_832_080e-7],
            clock: [-1.360_527_239_740e-4, -3.387_867_764_100e-11, 0.0],
            ..blank("G07", GpsTime::from_week_tow(1_316, 518_400.0))
        }
    }

    fn glonass_vector() -> GlonassEphemeris {
        let toe = GpsTime::from_week_tow(2_111, 345_618.0);
        GlonassEphemeris {
            satellite: SatelliteId::new(System::Glonass, 1).unwrap(),
            channel: 1,
            health: 0,
            age_days: 0,
            toe,
            transmission_time: toe,
            position_ecef_m: [7_164_901.855_469, 9_075_965.332_031, 22_776_057.128_910],
            velocity_ecef_m_s: [-1_541.807_175, 2_697.941_780, -595.667_839],
            acceleration_ecef_m_s2: [0.0, 0.0, -2.793_967_724e-6],
            clock_offset_s: 5.156_919_360_161e-5,
            clock_rate: 9.094_947_017_729e-13,
        }
    }

    fn assert_orbit(e: &Ephemeris, after_s: f64, expected_m: [f64; 3], clock_s: f64) {
        let found = e.orbit_at(e.toe() + after_s);
        for (k, expected) in expected_m.into_iter().enumerate() {
            let difference = found.position_ecef_m[k] - expected;
            assert!(difference.abs() < 1e-3, "axis {k}: {difference} m");
        }
        assert!(
            (found.clock_s - clock_s).abs() < 1e-15,
            "clock {}",
            found.clock_s - clock_s
        );
    }

    #[test]
    fn gps_orbit_and_clock() {
        let e = Ephemeris::Kepler(gps());
        let expected = [1_769_099.983_5, 16_339_860.171_9, 21_304_891.542_6];
        assert_orbit(&e, 3_600.5, expected, -1.361_732_141_203_912e-4);
        let plain = e.clock_without_relativity_s(e.toe() + 3_600.5);
        assert!((plain - -1.361_747_041_574_599e-4).abs() < 1e-15);
    }

    #[test]
    fn galileo_orbit_and_clock() {
        let e = KeplerEphemeris {
            sqrt_semi_major_axis: 5_440.609_678_268,
            eccentricity: 4.602_586_850_524e-4,
            inclination_rad: 0.996_378_118_279_4,
            ascending_node_rad: -2.709_625_186_034,
            perigee_rad: 0.475_520_036_803_9,
            mean_anomaly_rad: 2.362_656_254_939,
            mean_motion_correction_rad_s: 2.481_174_779_460e-9,
            ascending_node_rate_rad_s: -5.246_647_115_340e-9,
            inclination_rate_rad_s: -9.571_827_276_455e-11,
            radius_correction_m: [103.718_75, -114.25],
            latitude_correction_rad: [-5.280_598_998_070e-6, 1.181_103_289_127e-5],
            inclination_correction_rad: [5.587_935_447_693e-9, 1.117_587_089_539e-8],
            clock: [
                1.208_602_101_542e-3,
                1.435_154_217_688e-10,
                -1.734_723_475_977e-18,
            ],
            ..blank("E01", GpsTime::from_week_tow(2_253, 0.0))
        };
        let expected = [28_573_121.146_3, 7_518_031.672_9, 1_980_482.669_4];
        assert_orbit(
            &Ephemeris::Kepler(e),
            1_800.25,
            expected,
            1.208_859_872_844_495e-3,
        );
    }

    #[test]
    fn beidou_geostationary_orbit_and_clock() {
        let e = KeplerEphemeris {
            sqrt_semi_major_axis: 6_493.427_572_250,
            eccentricity: 9.936_444_694_176e-4,
            inclination_rad: 9.668_201_905_702e-2,
            ascending_node_rad: -2.882_541_571_964,
            perigee_rad: 0.806_514_689_522_7,
            mean_anomaly_rad: -2.276_315_006_914,
            mean_motion_correction_rad_s: -1.458_632_186_457e-9,
            ascending_node_rate_rad_s: 2.436_887_220_420e-9,
            inclination_rate_rad_s: 5.035_924_052_165e-10,
            radius_correction_m: [-553.609_375, -461.015_625],
            latitude_correction_rad: [-1.513_492_316_008e-5, 1.792_376_860_976e-5],
            inclination_correction_rad: [-1.122_243_702_412e-7, -7.543_712_854_385e-8],
            clock: [3.543_496_131_897e-4, 6.295_142_185_309e-11, 0.0],
            ..blank("C03", GpsTime::from_bdt_week_sow(897, 0.0))
        };
        let expected = [-14_749_429.715_9, 39_521_336.022_1, -687_434.454_5];
        assert_orbit(
            &Ephemeris::Kepler(e),
            1_234.5,
            expected,
            3.544_296_658_868_178e-4,
        );
    }

    #[test]
    fn beidou_medium_orbit_and_clock() {
        let e = KeplerEphemeris {
            toe_seconds_of_week: 345_600.0,
            sqrt_semi_major_axis: 5_282.604_581_833,
            eccentricity: 1.844_592_625_275e-3,
            inclination_rad: 0.989_901_020_688_0,
            ascending_node_rad: 1.881_335_077_935,
            perigee_rad: -2.140_277_960_677,
            mean_anomaly_rad: 2.788_824_577_715,
            mean_motion_correction_rad_s: 3.427_642_775_080e-9,
            ascending_node_rate_rad_s: -6.878_857_960_617e-9,
            inclination_rate_rad_s: 3.325_138_505_366e-10,
            radius_correction_m: [324.171_875, 91.093_75],
            latitude_correction_rad: [4.462_897_777_557e-6, 2.653_803_676_367e-6],
            inclination_correction_rad: [2.793_967_723_846e-9, -7.124_617_695_808e-8],
            clock: [-4.495_864_268_392e-4, -2.413_269_584_167e-11, 0.0],
            ..blank("C11", GpsTime::from_bdt_week_sow(755, 345_600.0))
        };
        let expected = [-13_944_469.394_2, 17_236_198.542_0, 17_030_425.740_9];
        assert_orbit(
            &Ephemeris::Kepler(e),
            1_234.5,
            expected,
            -4.496_170_159_780_333e-4,
        );
    }

    #[test]
    fn glonass_orbit_and_clock() {
        let e = Ephemeris::Glonass(glonass_vector());
        let expected = [6_151_322.399_5, 10_973_168.983_2, 22_226_566.164_1];
        assert_orbit(&e, 700.0, expected, 5.156_983_024_790_124e-5);
    }

    #[test]
    fn an_ephemeris_asked_often_says_the_same() {
        let e = Ephemeris::Glonass(glonass_vector());
        let often = Broadcast::from(e);
        for after_s in [
            0.0, 1e-10, 59.9, 60.0, 60.000_5, 899.999, -0.25, -60.0, -1_799.3, 1_800.1, 7_200.5,
        ] {
            let t = e.toe() + after_s;
            let (state, rates) = often.state_at(t, true);
            assert_eq!(
                (state, rates),
                (e.orbit_at(t), Some(e.rates_at(t))),
                "{after_s}"
            );
        }
    }

    #[test]
    fn velocity_is_the_derivative_of_position() {
        for e in [
            Ephemeris::Kepler(gps()),
            Ephemeris::Glonass(glonass_vector()),
        ] {
            let t = e.toe() + 600.0;
            let velocity = e.rates_at(t).velocity_ecef_m_s;
            let (a, b) = (e.orbit_at(t - 1.0), e.orbit_at(t + 1.0));
            for (k, v) in velocity.into_iter().enumerate() {
                let central = (b.position_ecef_m[k] - a.position_ecef_m[k]) / 2.0;
                assert!((v - central).abs() < 1e-2, "{v} {central}");
            }
        }
    }
}
