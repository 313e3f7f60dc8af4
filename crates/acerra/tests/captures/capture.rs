//! Random captures: a scene, the log of the radar, the positions, and what a user states.

use std::fmt::Write as _;
use std::path::Path;

use acerra_simulate::flight::GivenFlight;
use acerra_simulate::radar::{
    Clutter, CornerReflector, PointTarget, RadarModel, Receiver, corner_rcs_m2,
};
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;
use toml::Table;

use crate::motion::{CARRIERS, Carrier, Motion, attitude, side_looking_arm};
use crate::random::Random;

/// Wavelength of the middle of the band (m).
pub const WAVELENGTH_M: f64 = 0.0759;

/// A surveyed reflector.
#[derive(Clone, Copy, Debug)]
pub struct Reflector {
    /// True place (m).
    pub place_m: [f64; 3],
    /// Place as the user surveyed it (m).
    pub surveyed_m: [f64; 3],
    /// Whether the radar sees a reflector there.
    pub is_seen: bool,
    /// Whether the survey is grossly wrong.
    pub is_misplaced: bool,
}

/// A random capture, and its truth.
pub struct Capture {
    /// What it is like, in words.
    pub what: String,
    pub motion: Motion,
    pub reflectors: Vec<Reflector>,
    /// Standard deviation of the survey that the user states (m).
    pub survey_sigma_m: Option<f64>,
    pub delay_ns: f64,
    /// Lever arm on the level body: forward, left, up (m).
    pub arm_m: [f64; 3],
    stated_arm_m: [f64; 3],
    /// Error of the clock offset stated (s); none where it is left to the data.
    offset_error_s: Option<f64>,
    /// Standard deviation of the positions (m), and whether the file states it.
    position_sigma_m: f64,
    states_sigma: bool,
    scene: Scene,
    random: Random,
}

/// Shares of the captures: two reflectors, a reflector that is not seen, a misplaced one, a stronger scatterer, an
/// offset left to the data, a window that opens after the coupling.
const TWO: f64 = 0.5;
const UNSEEN: f64 = 0.1;
const MISPLACED: f64 = 0.12;
const STRONGER: f64 = 0.2;
const AUTO: f64 = 0.25;
const LATE: f64 = 0.15;
/// Time between positions (s).
const EVERY_S: f64 = 0.02;

impl Capture {
    /// The capture of a seed. Carriers take turns; everything else is drawn.
    pub fn of(seed: u64) -> Self {
        let mut random = Random::of(seed);
        let carrier = CARRIERS[usize::try_from(seed % 3).unwrap()];
        let motion = Motion::of(carrier, &mut random);
        let mut what = format!(
            "{}{} of {:.1} m at {:.2} m/s",
            carrier.name(),
            if motion.returns { " and back" } else { "" },
            motion.length_m,
            motion.speed_m_s
        );
        let mut scene = Scene::parse("[trajectory]\nfile = 'flown.csv'\n").unwrap();
        scene.seed = seed;
        let rcs_m2 = random.between(0.3_f64.ln(), 4.0_f64.ln()).exp();
        let survey_m = random.between(0.0, 0.03);
        let reflectors = reflectors(&motion, survey_m, &mut random);
        let _ = write!(what, ", {} reflectors", reflectors.len());
        for reflector in &reflectors {
            if reflector.is_seen {
                place(reflector.place_m, rcs_m2, &mut scene, &mut random);
            } else {
                what += ", one not seen";
            }
            what += if reflector.is_misplaced {
                ", one misplaced"
            } else {
                ""
            };
        }
        if random.happens(STRONGER) {
            let position_m = stronger(&motion, &reflectors, &mut random);
            scene.point.push(PointTarget {
                position_m,
                rcs_m2: rcs_m2 * random.between(2.0, 10.0),
            });
            what += ", a stronger scatterer";
        }
        clutter(&motion, rcs_m2, &mut scene, &mut random, &mut what);
        let nearest_m = reflectors
            .iter()
            .map(|r| r.place_m[1].hypot(r.place_m[2] - motion.height_m))
            .fold(f64::MAX, f64::min);
        let arm_m = match carrier {
            Carrier::Rail => [0.0; 3],
            _ => [0, 1, 2].map(|_| random.between(-0.12, 0.12)),
        };
        let stated_arm_m = match carrier {
            Carrier::Rail => [0.0; 3],
            _ => arm_m.map(|v| v + random.between(-0.003, 0.003)),
        };
        let delay_ns = random.between(7.0, 14.0);
        scene.radar.lever_arm_m = side_looking_arm(arm_m);
        scene.radar.delay_ns = delay_ns;
        scene.radar.antenna_beamwidth_deg = random.between(80.0, 140.0);
        scene.radar.scan_interval_s = match carrier {
            Carrier::Rail => 0.1,
            Carrier::Hand => 0.025,
            Carrier::Hall => 0.04,
        };
        scene.radar.noise_figure_db = random.between(5.0, 20.0);
        scene.radar.samples = 96 * 13;
        let over_echo_db = random.between(30.0, 50.0);
        scene.radar.coupling_db = coupling_db(
            &scene.radar,
            rcs_m2.sqrt() / nearest_m.powi(2),
            over_echo_db,
        );
        let offset_error_s = (!random.happens(AUTO)).then(|| random.between(-0.5, 0.5));
        what += if offset_error_s.is_none() {
            ", offset auto"
        } else {
            ""
        };
        let mut capture = Self {
            what,
            motion,
            reflectors,
            // An error evenly drawn up to a bound has a deviation of 1/√3 of it; stated rounded up.
            survey_sigma_m: random.happens(0.5).then_some(survey_m.max(0.005)),
            delay_ns,
            arm_m,
            stated_arm_m,
            offset_error_s,
            position_sigma_m: match carrier {
                Carrier::Rail | Carrier::Hand => random.between(0.0003, 0.001),
                Carrier::Hall => random.between(0.001, 0.003),
            },
            states_sigma: random.happens(0.5),
            scene,
            random,
        };
        if capture.random.happens(LATE) {
            let after_ns = capture.random.between(3.0, 6.0);
            capture.scene.radar.window_start_ns = delay_ns + after_ns;
            capture.what += ", window after the coupling";
        }
        capture
    }

    /// Writes the logs into a folder; gives the true clock offset (s).
    pub fn write(&mut self, folder: &Path) -> f64 {
        std::fs::create_dir_all(folder).unwrap();
        let file = folder.join("flown.csv");
        std::fs::write(&file, self.csv(0.0, false)).unwrap();
        self.scene.trajectory = Some(GivenFlight {
            file,
            on_track_s: None,
        });
        let simulated = simulate_campaign(&self.scene).unwrap();
        for file in simulated.files.iter().filter(|f| f.name == "radar.mrm") {
            std::fs::write(folder.join(&file.name), &file.bytes).unwrap();
        }
        let start_s = self.scene.start().unwrap().tow_s();
        std::fs::write(folder.join("positions.csv"), self.csv(start_s, true)).unwrap();
        simulated.summary.time_offset_s
    }

    /// The campaign as a user has it before calibration.
    pub fn stated(&self, true_offset_s: f64) -> Table {
        let offset = self.offset_error_s.map_or("'auto'".to_owned(), |error_s| {
            format!("{:.3}", true_offset_s + error_s)
        });
        self.campaign("", &offset, self.stated_arm_m)
    }

    /// The campaign with right settings.
    pub fn right(&self, true_offset_s: f64) -> Table {
        let delay = format!("delay_ns = {:.4}\n", self.delay_ns);
        self.campaign(&delay, &format!("{true_offset_s:.4}"), self.arm_m)
    }

    fn campaign(&self, delay: &str, offset: &str, arm_m: [f64; 3]) -> Table {
        let [x_m, y_m] = [0, 1].map(|i| {
            let places = self.reflectors.iter().map(|r| r.place_m[i]);
            let (low, high) = places.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            [(low - 1.0).floor(), (high + 1.0).ceil()]
        });
        let z_m = self.reflectors[0].place_m[2];
        format!(
            "[radar]\nfile = 'radar.mrm'\n{delay}\
             [trajectory]\nfile = 'positions.csv'\ntime_offset_s = {offset}\nlever_arm_m = {arm_m:.3?}\n\
             [preprocess]\ngate_ns = 'none'\n\
             [image]\nband_ghz = [3.1, 4.8]\nx_m = {x_m:?}\ny_m = {y_m:?}\nz_m = {z_m:.3}\npixel_m = 0.03\n"
        )
        .parse()
        .unwrap()
    }

    /// Positions as CSV: the truth for the simulator, or what the user's system says from `start_s` on.
    fn csv(&mut self, start_s: f64, measured: bool) -> String {
        let has_attitude = !measured || self.motion.carrier != Carrier::Rail;
        let states_sigma = measured && self.states_sigma;
        let mut text = String::from("time_s,x_m,y_m,z_m");
        text += if states_sigma {
            ",sd_x_m,sd_y_m,sd_z_m"
        } else {
            ""
        };
        text += if has_attitude { ",qw,qx,qy,qz\n" } else { "\n" };
        let count = (self.motion.duration_s() / EVERY_S).ceil() as u32;
        for k in 0..=count {
            let time_s = f64::from(k) * EVERY_S;
            let (position_m, turn) = self.motion.at(time_s);
            let _ = write!(text, "{:.3}", start_s + time_s);
            for v in position_m {
                let error_m = if measured {
                    self.random.normal(self.position_sigma_m)
                } else {
                    0.0
                };
                let _ = write!(text, ",{:.5}", v + error_m);
            }
            if states_sigma {
                text += &format!(",{:.5}", self.position_sigma_m).repeat(3);
            }
            if has_attitude {
                for q in attitude(turn, !measured) {
                    let _ = write!(text, ",{q:.7}");
                }
            }
            text.push('\n');
        }
        text
    }

    /// Resolution cell at a place: along and across the way (m).
    pub fn cell_m(&self, place_m: [f64; 3]) -> [f64; 2] {
        const RANGE_CELL_M: f64 = 0.088;
        let range_m = place_m[1].hypot(place_m[2] - self.motion.height_m);
        let along_m = 0.5 * WAVELENGTH_M * range_m / self.motion.length_m.min(2.0 * range_m);
        [
            along_m.max(RANGE_CELL_M),
            RANGE_CELL_M * range_m / place_m[1],
        ]
    }
}

/// One or two reflectors to the side, of one height, and their survey.
fn reflectors(motion: &Motion, survey_m: f64, random: &mut Random) -> Vec<Reflector> {
    let wanted = if random.happens(TWO) { 2 } else { 1 };
    let z_m = random.between(0.3, 1.3).min(motion.height_m);
    let mut all: Vec<Reflector> = Vec::new();
    while all.len() < wanted {
        let half_m = 0.4 * motion.length_m;
        let place_m = [
            random.between(-half_m, half_m),
            random.between(2.0, 8.0_f64.min(2.0 + 1.5 * motion.length_m)),
            z_m,
        ];
        if all.iter().any(|r| away_m(r.place_m, place_m) < 1.0) {
            continue;
        }
        let surveyed_m = place_m.map(|v| v + random.between(-survey_m, survey_m));
        all.push(Reflector {
            place_m,
            surveyed_m,
            is_seen: true,
            is_misplaced: false,
        });
    }
    let last = all.len() - 1;
    if random.happens(UNSEEN) {
        all[last].is_seen = false;
    } else if random.happens(MISPLACED) {
        let (sin, cos) = random.between(0.0, std::f64::consts::TAU).sin_cos();
        let by_m = random.between(0.7, 2.5);
        all[last].surveyed_m[0] += by_m * sin;
        all[last].surveyed_m[1] += by_m * cos;
        all[last].is_misplaced = true;
    }
    all
}

fn away_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A corner that looks at the middle of the way, or a sphere.
fn place(position_m: [f64; 3], rcs_m2: f64, scene: &mut Scene, random: &mut Random) {
    if random.happens(0.5) {
        scene.point.push(PointTarget { position_m, rcs_m2 });
        return;
    }
    scene.corner.push(CornerReflector {
        position_m,
        edge_m: (rcs_m2 / corner_rcs_m2(1.0, WAVELENGTH_M)).powf(0.25),
        azimuth_deg: (-position_m[0]).atan2(-position_m[1]).to_degrees(),
        elevation_deg: 5.0,
    });
}

/// A place that is nobody's.
fn stronger(motion: &Motion, reflectors: &[Reflector], random: &mut Random) -> [f64; 3] {
    loop {
        let half_m = 0.5 * motion.length_m;
        let place_m = [
            random.between(-half_m, half_m),
            random.between(1.5, 8.0),
            random.between(0.2, 1.5),
        ];
        if reflectors.iter().all(|r| away_m(r.place_m, place_m) > 0.8) {
            return place_m;
        }
    }
}

/// Scatterers about the reflectors, and the walls of a hall.
fn clutter(
    motion: &Motion,
    rcs_m2: f64,
    scene: &mut Scene,
    random: &mut Random,
    what: &mut String,
) {
    let count = usize::try_from(random.one_of(201)).unwrap();
    let below_db = random.between(8.0, 25.0);
    let each_m2 = rcs_m2 * 10.0_f64.powf(-0.1 * below_db);
    let east_m = 0.5 * motion.length_m + 3.0;
    let mut add = |from_m, to_m, scatterers: usize| {
        if scatterers > 0 {
            scene.clutter.push(Clutter {
                from_m,
                to_m,
                scatterers,
                rcs_m2: scatterers as f64 * each_m2,
            });
        }
    };
    if motion.carrier == Carrier::Hall {
        let walls = count / 4;
        add([-east_m, 8.5, 0.0], [east_m, 8.8, 4.0], 2 * walls);
        add([-east_m, 0.0, 0.0], [0.3 - east_m, 8.5, 4.0], walls);
        add([east_m, 0.0, 0.0], [east_m + 0.3, 8.5, 4.0], walls);
    } else {
        add([-east_m, 1.0, 0.0], [east_m, 9.0, 2.5], count);
    }
    let _ = write!(what, ", {count} scatterers {below_db:.0} dB below");
}

/// The coupling that is so far above an echo of a strength (1/m).
fn coupling_db(radar: &RadarModel, strength: f64, over_echo_db: f64) -> f64 {
    let mut whole = radar.clone();
    whole.coupling_db = 0.0;
    let direct = Receiver::new(&whole).coupling()[0].strength;
    (20.0 * (direct / strength).log10() - over_echo_db).max(0.0)
}
