//! What flight is wanted.

use acerra_settings::{Rule, ValueError, check, each, rules, within};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[flight]` of a scene file: one straight track, flown by hand.
///
/// The craft rests at its take-off point, climbs, flies along the track's line with a run-in and a run-out,
/// descends and rests again. Positions are those of the positioned point (the GNSS antenna), east, north, up.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FlightModel {
    /// Start of the track over ground, east and north (m).
    pub track_start_m: [f64; 2],
    /// End of the track over ground, east and north (m).
    pub track_end_m: [f64; 2],
    /// Mean height of the track (m).
    pub height_m: f64,
    /// Time from one end of the track to the other (s).
    pub track_duration_s: f64,
    /// Standard deviation of the wander along, across and up (m).
    #[serde(default = "default_wander_m")]
    pub wander_m: [f64; 3],
    /// Time over which the wander forgets itself (s).
    #[serde(default = "default_wander_time_s")]
    pub wander_time_s: f64,
    /// Standard deviation of roll, pitch and heading (degrees).
    #[serde(default = "default_tilt_deg")]
    pub tilt_deg: [f64; 3],
    /// Time on the ground before take-off and after landing (s).
    #[serde(default = "default_ground_time_s")]
    pub ground_time_s: f64,
    /// Height of the positioned point while the craft is on the ground (m).
    #[serde(default = "default_ground_height_m")]
    pub ground_height_m: f64,
    /// Length of the run-in and the run-out (m).
    #[serde(default = "default_run_in_m")]
    pub run_in_m: f64,
    /// Climbing and sinking speed (m/s).
    #[serde(default = "default_climb_m_s")]
    pub climb_m_s: f64,
}

impl FlightModel {
    /// Length of the track (m).
    #[must_use]
    pub fn track_length_m(&self) -> f64 {
        let [dx, dy] = [0, 1].map(|i| self.track_end_m[i] - self.track_start_m[i]);
        dx.hypot(dy)
    }

    /// Refuses flights that no craft can fly.
    ///
    /// # Errors
    /// The first impossible value.
    pub fn check(&self) -> Result<(), ValueError> {
        let length = self.track_length_m();
        let speed = length / self.track_duration_s;
        let ground_m = self.ground_height_m;
        let track = [
            Rule::range(
                "track_end_m",
                length,
                0.1..=1e5,
                "a track of 0.1 m to 100 km",
            ),
            Rule::range(
                "track_duration_s",
                self.track_duration_s,
                0.1..=1e5,
                "0.1 to 100000 s",
            ),
            Rule::range(
                "track_duration_s",
                speed,
                0.01..=100.0,
                "a speed of 0.01 to 100 m/s",
            ),
        ];
        check("flight", &track)?;
        let rules = rules!(self as "{}" {
            height_m: |m| *m > ground_m && *m < 1e5 => "above ground_height_m and below 100 km",
            ground_height_m: within(0.0..=100.0) => "0 to 100 m",
            wander_time_s: within(0.2..=1e4) => "0.2 to 10000 s",
            ground_time_s: within(0.0..=1e5) => "0 to 100000 s",
            run_in_m: within(0.0..=1e4) => "0 to 10 km",
            climb_m_s: within(0.05..=50.0) => "0.05 to 50 m/s",
        });
        check("flight", &rules)?;
        let rules = rules!(self as "{:?}" {
            wander_m: each(within(0.0..=0.3 * self.height_m)) => "0 to 0.3 of the height",
            tilt_deg: each(within(0.0..=20.0)) => "0 to 20 degrees",
        });
        check("flight", &rules)
    }
}

fn default_wander_m() -> [f64; 3] {
    [0.1, 0.08, 0.05]
}

fn default_wander_time_s() -> f64 {
    1.5
}

fn default_tilt_deg() -> [f64; 3] {
    [1.5, 1.5, 3.0]
}

fn default_ground_time_s() -> f64 {
    5.0
}

fn default_ground_height_m() -> f64 {
    0.4
}

fn default_run_in_m() -> f64 {
    2.0
}

fn default_climb_m_s() -> f64 {
    1.0
}
