//! From a satellite to an antenna: geometry, clocks and atmosphere.

use super::model::GnssModel;
use super::setting::Setting;
use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::GpsTime;
use acerra_gnss::{Ephemeris, Klobuchar, SPEED_OF_LIGHT_M_S, SatelliteId, System, saastamoinen_m};

const EARTH_ROTATION_RAD_S: f64 = 7.292_115_146_7e-5;

/// A satellite whose truth is one ephemeris for the whole simulation, so that its signal has no
/// seams where a new issue begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Satellite {
    pub id: SatelliteId,
    pub ephemeris: Ephemeris,
    pub group_delay_s: f64,
}

/// The healthy GPS satellites of the setting's navigation data, each with its ephemeris nearest to
/// the middle of the simulation and no older than broadcasting allows.
pub(super) fn satellites(setting: &Setting<'_>) -> Vec<Satellite> {
    let middle = setting.start + 0.5 * setting.duration_s;
    let distance = |e: &Ephemeris| e.toe().seconds_since(middle).abs();
    let mut chosen: Vec<Satellite> = Vec::new();
    for ephemeris in &setting.navigation.ephemerides {
        let Ephemeris::Kepler(kepler) = ephemeris else {
            continue;
        };
        let id = kepler.satellite;
        if id.system() != System::Gps || !ephemeris.is_healthy() || distance(ephemeris) > 7200.0 {
            continue;
        }
        let new = Satellite {
            id,
            ephemeris: *ephemeris,
            group_delay_s: kepler.group_delay_s[0],
        };
        match chosen.iter_mut().find(|s| s.id == id) {
            Some(old) if distance(ephemeris) < distance(&old.ephemeris) => *old = new,
            Some(_) => {}
            None => chosen.push(new),
        }
    }
    chosen.sort_by_key(|s| s.id);
    chosen
}

/// Everything above the receivers.
pub(super) struct Sky<'a> {
    pub model: &'a GnssModel,
    pub satellites: &'a [Satellite],
    pub klobuchar: Option<Klobuchar>,
}

/// Propagation between a satellite and an antenna at one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub elevation_rad: f64,
    /// Geometric range minus the satellite's clock, plus its group delay, plus the troposphere (m): the terms
    /// common to code and phase.
    pub common_m: f64,
    /// Delay of the ionosphere on L1 (m): added to the code, taken from the phase.
    pub ionosphere_m: f64,
}

impl Sky<'_> {
    /// The link from `satellite` to an antenna at `antenna_ecef_m` that receives at GPS time `t`.
    pub fn link(&self, satellite: &Satellite, t: GpsTime, antenna_ecef_m: [f64; 3]) -> Link {
        let mut delay_s = 0.075;
        let mut toward = [0.0; 3];
        let mut range_m = 0.0;
        let mut clock_s = 0.0;
        // Each round gains a factor of 10⁵ (the range rate over the speed of light).
        for _ in 0..5 {
            let state = satellite.ephemeris.orbit_at(t - delay_s);
            clock_s = state.clock_s;
            // While the signal travels the Earth turns: the place of transmission, in the axes of
            // the moment of reception.
            let (sin, cos) = (EARTH_ROTATION_RAD_S * delay_s).sin_cos();
            let [x, y, z] = state.position_ecef_m;
            let place = [x * cos + y * sin, y * cos - x * sin, z];
            toward = [0, 1, 2].map(|i| place[i] - antenna_ecef_m[i]);
            range_m = toward.iter().map(|v| v * v).sum::<f64>().sqrt();
            delay_s = range_m / SPEED_OF_LIGHT_M_S;
        }
        let frame = EnuFrame::from_ecef(antenna_ecef_m);
        let [east, north, up] = frame.enu_vector_from_ecef(toward);
        let elevation_rad = (up / range_m).asin();
        let azimuth_rad = east.atan2(north);
        let place = frame.origin();
        let ionosphere_m = self.ionosphere_m(t, place, azimuth_rad, elevation_rad);
        let troposphere_m = if self.model.humidity < 0.0 {
            0.0
        } else {
            saastamoinen_m(place, elevation_rad, self.model.humidity)
        };
        Link {
            elevation_rad,
            common_m: range_m - SPEED_OF_LIGHT_M_S * (clock_s - satellite.group_delay_s)
                + troposphere_m,
            ionosphere_m,
        }
    }

    fn ionosphere_m(&self, t: GpsTime, place: &Geodetic, azimuth: f64, elevation: f64) -> f64 {
        let coefficients = self.klobuchar.unwrap_or(Klobuchar::FALLBACK);
        if self.model.ionosphere_scale == 0.0 {
            return 0.0;
        }
        self.model.ionosphere_scale * coefficients.delay_l1_m(t, place, azimuth, elevation)
    }
}
