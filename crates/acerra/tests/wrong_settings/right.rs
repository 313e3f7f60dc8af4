//! Twenty random flights with right settings: no false alarm, and no wrong image without a word.

use std::fmt::Write as _;
use std::path::Path;

use acerra::demo::TRACKS;
use acerra_imaging::resolution::displacement_m;
use acerra_simulate::flight::GivenFlight;
use acerra_simulate::scene::{Record, Scene};
use toml::{Table, Value};

use crate::subjects::{Truth, simulate_into, truth_of};
use crate::verdict::{self, Run};

/// Numbers from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "53 bits are held exactly")]
        let share = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        low + share * (high - low)
    }
}

/// A random flight, in words, and its scene.
pub struct RandomFlight {
    /// What it is like.
    pub what: String,
    scene: Scene,
    height_m: f64,
    offset_m: f64,
}

/// Largest error of the clock offset (s).
const OFFSET_S: f64 = 5e-3;

impl RandomFlight {
    /// The flight of a seed; files that its scene needs are written into `folder`.
    pub fn of(seed: u64, folder: &Path) -> Self {
        let mut random = Random(seed);
        let mut scene = TRACKS[1].on_track().unwrap();
        scene.seed = seed;
        let height_m = random.between(4.0, 12.0);
        let offset_m = random.between(1.0, 4.0);
        let mut what = format!("{height_m:.1} m high, {offset_m:.1} m beside");
        let gnss = scene.gnss.as_mut().unwrap();
        let flight = scene.flight.as_mut().unwrap();
        flight.height_m = height_m;
        flight.track_start_m[1] = -offset_m;
        flight.track_end_m[1] = -offset_m;
        flight.ground_time_s = random.between(40.0, 90.0);
        if seed.is_multiple_of(2) {
            scene.record = Record::Flight;
            what += ", with take-off";
        }
        if seed % 5 == 1 {
            // Too short and too noisy to fix the ambiguities.
            flight.ground_time_s = 5.0;
            gnss.rover.phase_multipath_m = 0.02;
            gnss.rover.code_multipath_m = 3.0;
            what += ", float positions";
        }
        if seed % 5 == 2 {
            scene.radar.coupling_db = scene.radar.dynamic_range_db + 10.0;
            what += ", saturated coupling";
        }
        if seed % 5 == 3 {
            // A quartz without compensation.
            scene.radar.clock_drift_ppm = 30.0;
            gnss.rover.clock_drift = 5e-6;
            what += ", drifting clock";
        }
        if seed % 4 == 3 {
            scene.trajectory = Some(curved(folder, height_m, offset_m));
            scene.flight = None;
            what += ", curved";
        }
        Self {
            what,
            scene,
            height_m,
            offset_m,
        }
    }

    /// Simulates and processes the flight with its clock offset to be found, and judges the result:
    /// a word, how far the offset is off, and what else there is to say.
    pub fn judged(&self, folder: &Path, pixel_m: f64) -> (&'static str, String, String) {
        simulate_into(folder, &self.scene);
        let text = std::fs::read_to_string(folder.join("campaign.toml")).unwrap();
        let mut campaign: Table = text.parse().unwrap();
        let trajectory = campaign["trajectory"].as_table_mut().unwrap();
        let auto = Value::String("auto".to_owned());
        trajectory.insert("time_offset_s".to_owned(), auto);
        let image = campaign["image"].as_table_mut().unwrap();
        image.insert("pixel_m".to_owned(), Value::Float(pixel_m));
        let run = verdict::run(&campaign, folder);
        let offset_s = truth_of(folder)["time_offset_s"].as_f64().unwrap();
        self.verdict(&run, offset_s)
    }

    fn verdict(&self, run: &Run, offset_s: f64) -> (&'static str, String, String) {
        let targets = match &run.targets {
            Err(message) if run.contradicts => {
                return ("ALARM", String::new(), message.clone());
            }
            Err(message) => return ("refused", String::new(), message.clone()),
            Ok(targets) => targets,
        };
        let [found_s, sigma_s] = run.time_offset_s.unwrap();
        let off_s = found_s - offset_s;
        let is_stated = off_s.abs() <= 3.0 * sigma_s;
        let wrong_m = self.truth().wrong(targets, targets);
        let off = format!("offset {:+.1} ± {:.1} ms", 1e3 * off_s, 1e3 * sigma_s);
        let details = format!("{off}; {wrong_m:?}; {:?}", run.doubts);
        let is_close = off_s.abs() <= OFFSET_S;
        let word = match (wrong_m, is_close, is_stated) {
            (None, true, _) => "right",
            (None, _, true) => "right within its deviation",
            // A warning that tells of something else is no doubt of the image.
            _ if !run.is_doubted => "WRONG",
            _ => "doubted",
        };
        (word, off, details)
    }

    fn truth(&self) -> Truth {
        // Eq. (14) for 3 cm of height, as carrier-phase positions may err, and half a cell.
        let across_m = displacement_m(self.height_m, self.offset_m, 0.03);
        Truth {
            target_m: self
                .scene
                .corner
                .iter()
                .map(|c| [c.position_m[0], c.position_m[1]])
                .collect(),
            tolerance_m: [0.10, across_m.unwrap().unwrap_or(0.0).max(0.35)],
        }
    }
}

/// An arc of 40 m radius past the reflectors, with take-off and landing.
fn curved(folder: &Path, height_m: f64, offset_m: f64) -> GivenFlight {
    const RADIUS_M: f64 = 40.0;
    const SPEED_M_S: f64 = 1.5;
    const STEP_S: f64 = 0.05;
    const GROUND_S: f64 = 60.0;
    const LENGTH_M: f64 = 24.0;
    let climb_s = height_m;
    let track_s = LENGTH_M / SPEED_M_S;
    let duration_s = 2.0 * GROUND_S + 2.0 * climb_s + track_s;
    // Smooth between 0 and 1.
    let eased = |share: f64| {
        let x = share.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    let mut text = String::from("time_s,x_m,y_m,z_m\n");
    let mut time_s = 0.0;
    while time_s <= duration_s {
        let up = eased((time_s - GROUND_S) / climb_s);
        let down = eased((time_s - GROUND_S - climb_s - track_s) / climb_s);
        let along_m = SPEED_M_S * (time_s - GROUND_S - climb_s).clamp(0.0, track_s);
        let angle = (along_m - 0.5 * LENGTH_M) / RADIUS_M;
        let (x, y) = (
            9.0 + RADIUS_M * angle.sin(),
            -offset_m - RADIUS_M * (1.0 - angle.cos()),
        );
        let z = 0.4 + (height_m - 0.4) * (up - down);
        let _ = writeln!(text, "{time_s:.3},{x:.5},{y:.5},{z:.5}");
        time_s += STEP_S;
    }
    std::fs::create_dir_all(folder).unwrap();
    let file = folder.join("arc.csv");
    std::fs::write(&file, text).unwrap();
    let start_s = GROUND_S + climb_s;
    GivenFlight {
        file,
        on_track_s: Some([start_s, start_s + track_s]),
    }
}
