//! Parameters of the simulated radar and its scene.

use acerra_settings::{Rule, ValueError, check, each, rules, within};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[radar]` of a scene file: a PulsON P440 looking down.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RadarModel {
    /// Band of the pulse (GHz).
    pub band_ghz: [f64; 2],
    /// Share of the band over which its edges fall off (0: rectangular spectrum).
    pub band_taper: f64,
    /// Start of the fast-time window (ns).
    pub window_start_ns: f64,
    /// Samples of a scan, a multiple of 96 as the radio has it; 61.035 ps apart.
    pub samples: usize,
    /// Time between scans (s).
    pub scan_interval_s: f64,
    /// Frequency error of the radio's clock relative to the GNSS's (parts per million): its stamps gain on
    /// the trajectory by this rate.
    pub clock_drift_ppm: f64,
    /// Pulse integration index: 2^PII pulses are added up in each sample.
    pub integration_index: u16,
    /// Transmit gain index as the radio logs it.
    pub transmit_gain_index: u8,
    /// Transmitted power (dBm); the paper's is −13 at most.
    pub transmit_power_dbm: f64,
    /// Noise figure of the receiver (dB).
    pub noise_figure_db: f64,
    /// Root mean square of the noise, in counts, at the integration index in use.
    pub noise_counts: f64,
    /// Largest count over the noise (dB); larger ones are clipped.
    pub dynamic_range_db: f64,
    /// Fast time at which range is zero (ns): cables, antennas, the radio itself.
    pub delay_ns: f64,
    /// Standard deviation of each scan's common timing error (ps).
    pub timing_jitter_ps: f64,
    /// Level of the direct coupling between the antennas below the transmitted power (dB).
    pub coupling_db: f64,
    /// Share of the radio's packets that are lost on the way to the computer.
    pub lost_packets: f64,
    /// Phase centre from the positioned point: forward, left, up (m).
    pub lever_arm_m: [f64; 3],
    /// Gain of each antenna along its axis (dBi).
    pub antenna_gain_dbi: f64,
    /// Full width of an antenna's beam at half power (degrees).
    pub antenna_beamwidth_deg: f64,
}

impl Default for RadarModel {
    fn default() -> Self {
        Self {
            band_ghz: [3.1, 4.8],
            band_taper: 0.1,
            window_start_ns: 5.0,
            samples: 1632,
            scan_interval_s: 0.07,
            clock_drift_ppm: 0.0,
            integration_index: 11,
            transmit_gain_index: 63,
            transmit_power_dbm: -13.0,
            noise_figure_db: 5.0,
            noise_counts: 20.0,
            dynamic_range_db: 75.0,
            delay_ns: 10.0,
            timing_jitter_ps: 0.5,
            coupling_db: 40.0,
            lost_packets: 0.0,
            lever_arm_m: [0.0; 3],
            antenna_gain_dbi: 6.0,
            antenna_beamwidth_deg: 90.0,
        }
    }
}

/// `[[point]]`: an isotropic scatterer.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PointTarget {
    /// East, north, up (m).
    pub position_m: [f64; 3],
    /// Radar cross-section (m²).
    pub rcs_m2: f64,
}

/// `[[corner]]`: a trihedral corner reflector.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CornerReflector {
    /// Apex: east, north, up (m).
    pub position_m: [f64; 3],
    /// Length of the edges that meet in the apex (m).
    #[serde(default = "default_edge_m")]
    pub edge_m: f64,
    /// Where it looks: degrees clockwise from north.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Where it looks: degrees above the horizon.
    #[serde(default = "default_elevation_deg")]
    pub elevation_deg: f64,
}

/// `[ground]`: the surface z = 0.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Amplitude reflection coefficient of the mirror-like echo straight below.
    pub reflection: f64,
    /// Backscatter coefficient of the roughness (dB); each facet has a random phase.
    pub backscatter_db: f64,
    /// Facets per square metre that model the roughness (0: smooth).
    pub facets_per_m2: f64,
    /// Facets lie within this distance of the track (m).
    pub extent_m: f64,
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            reflection: 0.3,
            backscatter_db: -28.0,
            facets_per_m2: 4.0,
            extent_m: 12.0,
        }
    }
}

/// `[[clutter]]`: an extended object, such as an awning, as a box of random scatterers.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Clutter {
    /// East, north, up of one corner (m).
    pub from_m: [f64; 3],
    /// East, north, up of the opposite corner (m).
    pub to_m: [f64; 3],
    /// Scatterers in it.
    pub scatterers: usize,
    /// Radar cross-sections added up (m²).
    pub rcs_m2: f64,
}

fn default_edge_m() -> f64 {
    0.4
}

fn default_elevation_deg() -> f64 {
    90.0
}

/// Everything that the radar sees.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RadarScene {
    /// Points.
    pub point: Vec<PointTarget>,
    /// Corner reflectors.
    pub corner: Vec<CornerReflector>,
    /// The surface; absent for targets in free space.
    pub ground: Option<Ground>,
    /// Extended objects.
    pub clutter: Vec<Clutter>,
}

impl RadarModel {
    /// Refuses radars that cannot be.
    ///
    /// # Errors
    /// The first impossible value.
    pub fn check(&self) -> Result<(), ValueError> {
        let [low, high] = self.band_ghz;
        let is_ordered = high > low && high < 8.1;
        let band = [
            Rule::range("band_ghz", low, 0.1..=8.0, "0.1 to 8 GHz"),
            Rule::new(
                "band_ghz",
                is_ordered,
                "an upper edge above the lower, below 8.1",
                high,
            ),
        ];
        check("radar", &band)?;
        let rules = rules!(self as "{}" {
            band_taper: within(0.0..=1.0) => "0 to 1",
            window_start_ns: within(-100.0..=2e6) => "-100 to 2e6",
            samples: |n| *n > 0 && n.is_multiple_of(96) && *n <= 96 * 350 => "a multiple of 96, at most 33600",
            scan_interval_s: within(1e-3..=100.0) => "0.001 to 100",
            clock_drift_ppm: within(-1e4..=1e4) => "-10000 to 10000",
            integration_index: within(6..=15) => "6 to 15",
            noise_counts: within(0.0..=1e6) => "0 to 1e6",
            dynamic_range_db: within(10.0..=120.0) => "10 to 120",
            delay_ns: within(0.0..=1e5) => "0 to 1e5",
            timing_jitter_ps: within(0.0..=1e3) => "0 to 1000",
            lost_packets: within(0.0..=0.9) => "0 to 0.9",
            antenna_beamwidth_deg: within(5.0..=170.0) => "5 to 170",
            transmit_power_dbm: within(-80.0..=60.0) => "-80 to 60",
            coupling_db: within(0.0..=400.0) => "0 to 400",
            noise_figure_db: within(0.0..=60.0) => "0 to 60",
            antenna_gain_dbi: within(-30.0..=40.0) => "-30 to 40",
            transmit_gain_index: within(0..=63) => "0 to 63",
        });
        check("radar", &rules)?;
        let lengths = each(|v: &f64| v.abs() < 100.0);
        let arm = rules!(self as "{:?}" { lever_arm_m: lengths => "lengths below 100 m" });
        check("radar", &arm)
    }
}

impl RadarScene {
    /// Refuses scenes that cannot be.
    ///
    /// # Errors
    /// The first impossible value.
    pub fn check(&self) -> Result<(), ValueError> {
        let near = || each(|v: &f64| v.abs() < 1e5);
        let positive = |v: &f64| *v > 0.0 && *v < 1e9;
        for p in &self.point {
            let place = rules!(p as "{:?}" { position_m: near() => "within 100 km" });
            check("point", &place)?;
            check(
                "point",
                &rules!(p as "{}" { rcs_m2: positive => "above 0" }),
            )?;
        }
        for c in &self.corner {
            let place = rules!(c as "{:?}" { position_m: near() => "within 100 km" });
            check("corner", &place)?;
            let rules = rules!(c as "{}" {
                edge_m: |edge| *edge > 0.0 && *edge < 100.0 => "0 to 100 m",
                azimuth_deg: within(-360.0..=360.0) => "-360 to 360",
                elevation_deg: within(-90.0..=90.0) => "-90 to 90",
            });
            check("corner", &rules)?;
        }
        for c in &self.clutter {
            let box_m = rules!(c as "{:?}" {
                from_m: near() => "within 100 km",
                to_m: near() => "within 100 km",
            });
            check("clutter", &box_m)?;
            let rules = rules!(c as "{}" {
                scatterers: within(1..=1_000_000) => "1 to a million",
                rcs_m2: positive => "above 0",
            });
            check("clutter", &rules)?;
        }
        if let Some(g) = &self.ground {
            let rules = rules!(g as "{}" {
                reflection: within(-1.0..=1.0) => "-1 to 1",
                backscatter_db: within(-100.0..=100.0) => "-100 to 100",
                facets_per_m2: within(0.0..=1e4) => "0 to 10000",
                extent_m: within(0.0..=1e3) => "0 to 1000 m",
            });
            check("ground", &rules)?;
        }
        Ok(())
    }
}
