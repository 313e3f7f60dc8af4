//! The plan file: required resolution and area, available radar and drone.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PlanError;

/// A plan file with every default filled in.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// The ground to image.
    pub area: Area,
    /// Requirements on the image.
    pub want: Want,
    /// The radar.
    #[serde(default)]
    pub radar: Radar,
    /// The drone.
    #[serde(default)]
    pub drone: Drone,
}

/// `[area]`: the ground to image, taken as level unless a terrain is given.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// Corners in order, latitude and longitude (degrees).
    pub corners_deg: Vec<[f64; 2]>,
    /// Place of take-off and landing, latitude and longitude (degrees); by default the first corner.
    pub home_deg: Option<[f64; 2]>,
    /// Height of that place above the sea (m), which ground stations show.
    #[serde(default)]
    pub home_height_m: f64,
    /// Heights of the ground above the sea: GeoTIFF, ESRI ASCII or XYZ, relative to the plan file.
    /// Missions then keep their height above it, with further waypoints where it is uneven; home is
    /// as high as it says.
    pub terrain: Option<PathBuf>,
    /// The terrain's coordinates where its file does not say: `"EPSG:32633"`, ….
    pub terrain_crs: Option<String>,
    /// Direction of the lines, clockwise from north (degrees); by default that of the longest path through
    /// the area.
    pub heading_deg: Option<f64>,
}

/// `[want]`: requirements on the image.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Want {
    /// Along-track resolution (m), Eq. (6).
    pub along_m: f64,
    /// Across-track resolution (m), Eq. (9), everywhere in the area.
    pub across_m: f64,
    /// Radar cross-section of the weakest target to be seen (dB over 1 m²).
    #[serde(default = "default_rcs_dbsm")]
    pub rcs_dbsm: f64,
    /// Its signal-to-noise ratio in the image (dB).
    #[serde(default = "default_snr_db")]
    pub snr_db: f64,
    /// Largest ghost on the other side of the track, relative to its target; none: straight lines.
    pub ghost: Option<f64>,
}

const fn default_rcs_dbsm() -> f64 {
    -10.0
}

const fn default_snr_db() -> f64 {
    15.0
}

/// `[radar]`: by default the paper's PulsON P440, looking down.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Radar {
    /// Band (GHz).
    pub band_ghz: [f64; 2],
    /// Scans a second.
    pub scans_hz: f64,
    /// Transmitted power (dBm).
    pub power_dbm: f64,
    /// Noise figure of the receiver (dB).
    pub noise_figure_db: f64,
    /// Pulses that each scan adds up.
    pub pulses_per_scan: u32,
    /// Gain of each antenna along its axis (dBi).
    pub antenna_gain_dbi: f64,
    /// Full width of an antenna's beam at half power (degrees).
    pub beam_deg: f64,
    /// Longest range that is recorded (m).
    pub max_range_m: f64,
}

impl Default for Radar {
    fn default() -> Self {
        Self {
            band_ghz: [3.1, 4.8],
            scans_hz: 14.28,
            power_dbm: -13.0,
            noise_figure_db: 5.0,
            pulses_per_scan: 2_048,
            antenna_gain_dbi: 6.0,
            beam_deg: 90.0,
            max_range_m: 30.0,
        }
    }
}

/// `[drone]`: capabilities of the drone.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Drone {
    /// Lowest height above ground (m).
    pub min_height_m: f64,
    /// Greatest height above ground (m).
    pub max_height_m: f64,
    /// Slowest steady speed (m/s).
    pub min_speed_m_s: f64,
    /// Largest speed (m/s), also on transfers between lines.
    pub max_speed_m_s: f64,
    /// Speed along the lines (m/s); by default the largest that samples finely enough.
    pub speed_m_s: Option<f64>,
    /// Climb and descent (m/s).
    pub climb_m_s: f64,
    /// Sideways acceleration that keeps it steady (m/s²).
    pub lateral_acceleration_m_s2: f64,
    /// Time for a turn, in addition to the time for its path (s).
    pub turn_s: f64,
    /// Largest sideways deviation from a line (m).
    pub stray_m: f64,
    /// Time in the air on one battery (minutes).
    pub endurance_min: f64,
    /// Share of the battery reserved for the way home.
    pub reserve: f64,
    /// The model that missions for DJI name.
    pub dji_model: DjiModel,
}

impl Default for Drone {
    fn default() -> Self {
        Self {
            min_height_m: 3.0,
            max_height_m: 30.0,
            min_speed_m_s: 0.2,
            max_speed_m_s: 5.0,
            speed_m_s: None,
            climb_m_s: 1.0,
            lateral_acceleration_m_s2: 1.0,
            turn_s: 4.0,
            stray_m: 0.3,
            endurance_min: 15.0,
            reserve: 0.25,
            dji_model: DjiModel::default(),
        }
    }
}

/// Models of DJI that fly missions of WPML.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
pub enum DjiModel {
    /// Matrice 300 RTK.
    #[serde(rename = "M300 RTK")]
    M300Rtk,
    /// Matrice 350 RTK.
    #[default]
    #[serde(rename = "M350 RTK")]
    M350Rtk,
    /// Matrice 30.
    #[serde(rename = "M30")]
    M30,
    /// Mavic 3 Enterprise.
    #[serde(rename = "Mavic 3E")]
    Mavic3E,
}

impl PlanFile {
    /// The plan with paths relative to a folder.
    #[must_use]
    pub fn resolved_in(mut self, folder: &Path) -> Self {
        if let Some(terrain) = &mut self.area.terrain {
            *terrain = folder.join(&*terrain);
        }
        self
    }

    /// Reads a plan from the text of its file.
    ///
    /// # Errors
    /// Unknown keys, values of the wrong form, impossible values.
    ///
    /// ```
    /// use acerra_flightplan::PlanFile;
    /// let text = "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2003], [40.9002, 14.2003]]\n\
    ///             [want]\nalong_m = 0.05\nacross_m = 0.4\n";
    /// assert_eq!(PlanFile::parse(text)?.radar.scans_hz, 14.28);
    /// let error = PlanFile::parse(&text.replace("0.05", "-0.05")).unwrap_err();
    /// assert_eq!(error.to_string(), "[want] along_m: expected 0.001 to 100 m, found -0.05");
    /// # Ok::<(), acerra_flightplan::PlanError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, PlanError> {
        let plan: Self = acerra_settings::parse(text)?;
        plan.check()?;
        Ok(plan)
    }

    /// Whether every value is possible by itself.
    ///
    /// # Errors
    /// [`PlanError::Value`] for the first that is not.
    pub fn check(&self) -> Result<(), PlanError> {
        let Self {
            area,
            want,
            radar,
            drone,
        } = self;
        let value = |table, key, expected, found: String| {
            Err(PlanError::Value {
                table,
                key,
                expected,
                found,
            })
        };
        if area.terrain_crs.is_some() && area.terrain.is_none() {
            let expected = "a file, as terrain_crs is given";
            return value("area", "terrain", expected, "none".to_owned());
        }
        if area.corners_deg.len() < 3 {
            let found = area.corners_deg.len().to_string();
            return value("area", "corners_deg", "three corners or more", found);
        }
        for (key, [latitude, longitude]) in area
            .corners_deg
            .iter()
            .map(|c| ("corners_deg", *c))
            .chain(area.home_deg.map(|h| ("home_deg", h)))
        {
            if !(latitude.abs() <= 85.0 && longitude.abs() <= 180.0) {
                let expected = "latitudes of −85° to 85° and longitudes of −180° to 180°";
                return value("area", key, expected, format!("[{latitude}, {longitude}]"));
            }
        }
        let heading = area.heading_deg.unwrap_or(0.0);
        let ghost = want.ghost.unwrap_or(0.5);
        let speed = drone.speed_m_s.unwrap_or(1.0);
        #[rustfmt::skip]
        let ranges = [
            ("area", "home_height_m", area.home_height_m, -500.0, 9_000.0, "−500 to 9000 m"),
            ("area", "heading_deg", heading, -360.0, 360.0, "−360° to 360°"),
            ("want", "along_m", want.along_m, 1e-3, 100.0, "0.001 to 100 m"),
            ("want", "across_m", want.across_m, 1e-3, 100.0, "0.001 to 100 m"),
            ("want", "rcs_dbsm", want.rcs_dbsm, -80.0, 80.0, "−80 to 80 dBsm"),
            ("want", "snr_db", want.snr_db, 0.0, 80.0, "0 to 80 dB"),
            ("want", "ghost", ghost, 0.05, 1.0, "0.05 to 1"),
            ("radar", "band_ghz", radar.band_ghz[0], 0.05, 100.0, "0.05 to 100 GHz, low then high"),
            ("radar", "band_ghz", radar.band_ghz[1], 0.05, 100.0, "0.05 to 100 GHz, low then high"),
            ("radar", "scans_hz", radar.scans_hz, 0.1, 1e5, "0.1 to 100000 Hz"),
            ("radar", "power_dbm", radar.power_dbm, -60.0, 60.0, "−60 to 60 dBm"),
            ("radar", "noise_figure_db", radar.noise_figure_db, 0.0, 40.0, "0 to 40 dB"),
            ("radar", "pulses_per_scan", radar.pulses_per_scan.into(), 1.0, 1e9, "1 or more"),
            ("radar", "antenna_gain_dbi", radar.antenna_gain_dbi, -20.0, 40.0, "−20 to 40 dBi"),
            ("radar", "beam_deg", radar.beam_deg, 5.0, 170.0, "5° to 170°"),
            ("radar", "max_range_m", radar.max_range_m, 0.5, 1e5, "0.5 to 100000 m"),
            ("drone", "min_height_m", drone.min_height_m, 0.5, 1e4, "0.5 to 10000 m"),
            ("drone", "max_height_m", drone.max_height_m, 0.5, 1e4, "0.5 to 10000 m"),
            ("drone", "min_speed_m_s", drone.min_speed_m_s, 0.01, 100.0, "0.01 to 100 m/s"),
            ("drone", "max_speed_m_s", drone.max_speed_m_s, 0.01, 100.0, "0.01 to 100 m/s"),
            ("drone", "speed_m_s", speed, 0.01, 100.0, "0.01 to 100 m/s"),
            ("drone", "climb_m_s", drone.climb_m_s, 0.05, 50.0, "0.05 to 50 m/s"),
            ("drone", "lateral_acceleration_m_s2", drone.lateral_acceleration_m_s2, 0.01, 20.0, "0.01 to 20 m/s²"),
            ("drone", "turn_s", drone.turn_s, 0.0, 600.0, "0 to 600 s"),
            ("drone", "stray_m", drone.stray_m, 0.0, 50.0, "0 to 50 m"),
            ("drone", "endurance_min", drone.endurance_min, 0.5, 1e4, "0.5 to 10000 minutes"),
            ("drone", "reserve", drone.reserve, 0.0, 0.9, "0 to 0.9"),
        ];
        for (table, key, found, least, most, expected) in ranges {
            if !(least..=most).contains(&found) {
                return value(table, key, expected, found.to_string());
            }
        }
        let [low, high] = radar.band_ghz;
        if high <= low {
            let expected = "a band of some width: low, then high (GHz)";
            return value("radar", "band_ghz", expected, format!("[{low}, {high}]"));
        }
        for (low, high, key, expected) in [
            (
                drone.min_height_m,
                drone.max_height_m,
                "max_height_m",
                "at least min_height_m",
            ),
            (
                drone.min_speed_m_s,
                drone.max_speed_m_s,
                "max_speed_m_s",
                "at least min_speed_m_s",
            ),
        ] {
            if high < low {
                return value("drone", key, expected, format!("{high}, below {low}"));
            }
        }
        if drone
            .speed_m_s
            .is_some_and(|v| v < drone.min_speed_m_s || v > drone.max_speed_m_s)
        {
            let expected = "a speed between min_speed_m_s and max_speed_m_s";
            return value("drone", "speed_m_s", expected, speed.to_string());
        }
        Ok(())
    }
}

impl Radar {
    /// Lowest and highest frequency (Hz).
    #[must_use]
    pub fn band_hz(&self) -> [f64; 2] {
        self.band_ghz.map(|f| 1e9 * f)
    }

    /// Middle of the band (Hz).
    #[must_use]
    pub fn centre_hz(&self) -> f64 {
        let [low, high] = self.band_hz();
        0.5 * (low + high)
    }

    /// Width of the band (Hz).
    #[must_use]
    pub fn bandwidth_hz(&self) -> f64 {
        let [low, high] = self.band_hz();
        high - low
    }

    /// Half of the beam (rad).
    #[must_use]
    pub fn half_beam_rad(&self) -> f64 {
        (0.5 * self.beam_deg).to_radians()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2003], [40.9002, 14.2003]]\n\
                        [want]\nalong_m = 0.05\nacross_m = 0.4\n";

    #[test]
    fn what_is_impossible_is_named() {
        assert!(PlanFile::parse(GOOD).is_ok());
        for (more, want) in [
            (
                "[radar]\nband_ghz = [4.8, 3.1]\n",
                "[radar] band_ghz: expected a band of some width",
            ),
            (
                "[radar]\nband_ghz = [3.1, 3.1]\n",
                "[radar] band_ghz: expected a band of some width",
            ),
            (
                "[radar]\nbandwidth = 3\n",
                "line 7, column 1: unknown field `bandwidth`",
            ),
            (
                "[radar]\nscans_hz = nan\n",
                "[radar] scans_hz: expected 0.1 to 100000 Hz, found NaN",
            ),
            (
                "[drone]\nmin_height_m = -4\n",
                "[drone] min_height_m: expected 0.5 to 10000 m, found -4",
            ),
            (
                "[drone]\nmin_height_m = 40\n",
                "[drone] max_height_m: expected at least min_height_m",
            ),
            (
                "[drone]\nspeed_m_s = 9\n",
                "[drone] speed_m_s: expected a speed between",
            ),
            (
                "[drone]\nreserve = 1\n",
                "[drone] reserve: expected 0 to 0.9, found 1",
            ),
        ] {
            let error = PlanFile::parse(&format!("{GOOD}{more}"))
                .expect_err(more)
                .to_string();
            assert!(error.starts_with(want), "{error}");
        }
        let two = GOOD.replace(", [40.9002, 14.2003]", "");
        let error = PlanFile::parse(&two).expect_err("two corners").to_string();
        assert_eq!(
            error,
            "[area] corners_deg: expected three corners or more, found 2"
        );
        let swapped = GOOD.replace("[40.9, 14.2]", "[140.9, 14.2]");
        assert!(PlanFile::parse(&swapped).is_err());
    }
}
