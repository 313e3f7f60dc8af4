//! A synthetic GPS constellation.

use super::lnav;
use acerra_geo::time::GpsTime;
use acerra_gnss::{Ephemeris, KeplerEphemeris, Klobuchar, Navigation, SatelliteId, System};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Ephemerides are issued on every even hour (s).
const ISSUE_S: i64 = 7200;

/// Shift of the satellites along their plane from one plane to the next (turns): over Europe the
/// position dilution above 15° is then below 7 for 99 % of the time; other shifts leave holes.
const PHASING: f64 = 0.14;

/// Satellites in each of the six planes.
const PLANES: [usize; 6] = [5, 5, 5, 5, 5, 6];

/// A healthy constellation of 31 GPS satellites in six planes, with ephemerides broadcast about `start` and
/// for `duration_s` after it, rounded as in the navigation message.
///
/// Orbits resemble GPS orbits: inclination 55°, semi-major axis 26 560 km, eccentricity up to
/// 0.015, perturbation terms of the usual size; successive issues describe one and the same orbit.
#[must_use]
pub fn constellation(start: GpsTime, duration_s: f64, seed: u64) -> Navigation {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    let first_issue = (start.seconds() + ISSUE_S / 2).div_euclid(ISSUE_S) * ISSUE_S;
    let end = start + duration_s.clamp(0.0, 86_400.0);
    let last_issue = (end.seconds() + ISSUE_S / 2).div_euclid(ISSUE_S) * ISSUE_S;
    let node_of_first_plane = rng.random_range(0.0..TAU);
    let mut ephemerides = Vec::new();
    // PRN 4 is left unused, as it long was.
    let mut numbers = (1..=32).filter(|prn| *prn != 4);
    for (plane, count) in PLANES.into_iter().enumerate() {
        for slot in 0..count {
            let Some(satellite) = numbers
                .next()
                .and_then(|n| SatelliteId::new(System::Gps, n))
            else {
                continue;
            };
            let node = node_of_first_plane + TAU * plane as f64 / 6.0;
            let latitude = TAU * (slot as f64 / count as f64 + plane as f64 * PHASING);
            let orbit = orbit(satellite, node, latitude, first_issue, &mut rng);
            let mut issue = first_issue;
            while issue <= last_issue {
                ephemerides.push(Ephemeris::Kepler(lnav::quantised(&at_issue(&orbit, issue))));
                issue += ISSUE_S;
            }
        }
    }
    let mut navigation = Navigation {
        ephemerides,
        klobuchar: Some(IONOSPHERE),
        ..Navigation::default()
    };
    navigation.normalise();
    navigation
}

/// A mid-latitude day of moderate solar activity, in numbers that the message can hold.
const IONOSPHERE: Klobuchar = Klobuchar {
    alpha: [
        12.0 / (1 << 30) as f64,
        2.0 / (1 << 27) as f64,
        -1.0 / (1 << 24) as f64,
        -2.0 / (1 << 24) as f64,
    ],
    beta: [
        45.0 * 2048.0,
        4.0 * 16_384.0,
        -2.0 * 65_536.0,
        -6.0 * 65_536.0,
    ],
};

fn orbit(
    satellite: SatelliteId,
    node: f64,
    latitude: f64,
    issue: i64,
    rng: &mut ChaCha8Rng,
) -> KeplerEphemeris {
    let mut about = |middle: f64, spread: f64| middle + spread * rng.random_range(-1.0..1.0);
    let perigee_rad = about(0.0, 3.1);
    let toe = GpsTime::new(issue, 0.0);
    KeplerEphemeris {
        satellite,
        iode: 0,
        iodc: 0,
        health: 0,
        data_source: 1,
        accuracy_m: 2.4,
        toc: toe,
        toe,
        transmission_time: toe,
        toe_seconds_of_week: toe.tow_s(),
        sqrt_semi_major_axis: about(5153.65, 0.06),
        eccentricity: about(0.008, 0.007),
        inclination_rad: about(0.9599, 0.015),
        ascending_node_rad: node + about(0.0, 0.06),
        perigee_rad,
        mean_anomaly_rad: latitude - perigee_rad + about(0.0, 0.12),
        mean_motion_correction_rad_s: about(4.6e-9, 5e-10),
        ascending_node_rate_rad_s: about(-8.1e-9, 3e-10),
        inclination_rate_rad_s: about(0.0, 4e-10),
        latitude_correction_rad: [about(0.0, 4e-6), about(6e-6, 4e-6)],
        radius_correction_m: [about(240.0, 90.0), about(0.0, 80.0)],
        inclination_correction_rad: [about(0.0, 1.5e-7), about(0.0, 1.5e-7)],
        clock: [about(0.0, 4e-4), about(0.0, 8e-12), 0.0],
        group_delay_s: [about(-5e-9, 8e-9), 0.0],
    }
}

/// This orbit and clock, described for another time of issue.
fn at_issue(orbit: &KeplerEphemeris, issue: i64) -> KeplerEphemeris {
    const MU: f64 = 3.986_005e14;
    let toe = GpsTime::new(issue, 0.0);
    let dt = toe.seconds_since(orbit.toe);
    let motion =
        (MU / orbit.sqrt_semi_major_axis.powi(6)).sqrt() + orbit.mean_motion_correction_rad_s;
    // The longitude of the node refers to the start of the week: between weeks the Earth rotates.
    let weeks = (toe.week() - orbit.toe.week()) as f64;
    let earth = 7.292_115_146_7e-5 * 604_800.0 * weeks;
    let number = issue.div_euclid(ISSUE_S);
    KeplerEphemeris {
        iode: number.rem_euclid(256) as u32,
        iodc: number.rem_euclid(1024) as u32,
        toc: toe,
        toe,
        // Sent from an hour before its time of ephemeris on.
        transmission_time: toe - (ISSUE_S / 2) as f64,
        toe_seconds_of_week: toe.tow_s(),
        mean_anomaly_rad: orbit.mean_anomaly_rad + motion * dt,
        ascending_node_rad: orbit.ascending_node_rad + orbit.ascending_node_rate_rad_s * dt - earth,
        inclination_rad: orbit.inclination_rad + orbit.inclination_rate_rad_s * dt,
        clock: [orbit.clock[0] + orbit.clock[1] * dt, orbit.clock[1], 0.0],
        ..*orbit
    }
}
