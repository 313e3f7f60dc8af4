//! Random flights: a scene, the receiver's positions, and the campaign that is right for them.

use std::fmt::Write as _;
use std::path::Path as FilePath;

use acerra_simulate::flight::GivenFlight;
use acerra_simulate::radar::{Clutter, CornerReflector, Ground, PointTarget};
use acerra_simulate::scene::{Record, Scene};
use acerra_simulate::write::simulate_campaign;
use toml::Table;

use crate::path::{Path, SHAPES, Shape};
use crate::random::{Random, Sway};

/// A random flight: what it is like, and its truth.
pub struct RandomFlight {
    /// What it is like, in words.
    pub what: String,
    /// Its reflectors: east, north, up (m).
    pub reflectors_m: Vec<[f64; 3]>,
    /// Where other things stand that are seen: west, east, south, north (m).
    pub clutter_m: Option<[f64; 4]>,
    path: Path,
    scene: Scene,
    has_attitude: bool,
    /// Until when the positions are float (s); never, where 0.
    float_s: f64,
    receiver: Random,
}

/// Shares of the flights that have no target, no take-off in the log, an attitude log, and clutter, in this order. The
/// last is the share of float starts among the flights with take-off.
const EMPTY: f64 = 0.1;
const WITHOUT_TAKEOFF: f64 = 0.25;
const WITH_ATTITUDE: f64 = 0.5;
const WITH_CLUTTER: f64 = 0.3;
const FLOAT_START: f64 = 0.3;

impl RandomFlight {
    /// The flight of a seed. Shapes take turns; everything else is drawn.
    pub fn of(seed: u64) -> Self {
        let mut random = Random::of(seed);
        let shape = SHAPES[usize::try_from(seed % 6).unwrap()];
        let height_m = random.between(2_f64.ln(), 25_f64.ln()).exp();
        let wind_m_s = random.between(0.0, 8.0);
        let path = Path::of(shape, height_m, wind_m_s, &mut random);
        let mut what = format!(
            "{}, {height_m:.1} m high, wind {wind_m_s:.0} m/s",
            shape.name()
        );
        let mut scene = Scene::parse(
            "[flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [9, 0]\nheight_m = 4\ntrack_duration_s = 9\n",
        )
        .unwrap();
        scene.flight = None;
        scene.seed = seed;
        scene.ground = Some(Ground {
            reflection: random.between(0.05, 0.3),
            backscatter_db: random.between(-32.0, -26.0),
            facets_per_m2: 2.0,
            extent_m: 6.0,
        });
        let reflectors_m = if random.happens(EMPTY) {
            what += ", no target";
            Vec::new()
        } else {
            reflectors(shape, &path, &mut scene, &mut random)
        };
        if !reflectors_m.is_empty() {
            let _ = write!(what, ", {} reflectors", reflectors_m.len());
        }
        let clutter_m = random.happens(WITH_CLUTTER).then(|| {
            what += ", clutter";
            clutter(&path, &mut scene, &mut random)
        });
        let up_m = random.between(-0.4, 0.0);
        scene.radar.lever_arm_m = if random.happens(0.5) {
            [random.between(-0.25, 0.25), random.between(-0.2, 0.2), up_m]
        } else {
            [0.0, 0.0, up_m]
        };
        let arm_m = scene
            .radar
            .lever_arm_m
            .iter()
            .map(|v| v * v)
            .sum::<f64>()
            .sqrt();
        let _ = write!(what, ", arm {arm_m:.2} m");
        scene.radar.scan_interval_s = 0.05;
        scene.radar.delay_ns = random.between(8.0, 14.0);
        scene.radar.coupling_db = random.between(35.0, 50.0);
        let far_m = (1.2 * height_m).hypot(0.7 * path.length_m.min(25.0)) + 4.0;
        let samples = (far_m / 0.15 + scene.radar.delay_ns) / 0.061_035;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few thousand"
        )]
        let blocks = (samples / 96.0).ceil() as usize;
        scene.radar.samples = 96 * blocks;
        let has_attitude = random.happens(WITH_ATTITUDE);
        what += if has_attitude { ", attitude log" } else { "" };
        let mut float_s = 0.0;
        if random.happens(WITHOUT_TAKEOFF) {
            what += ", no take-off";
        } else {
            scene.record = Record::Flight;
            if random.happens(FLOAT_START) {
                float_s = path.ground_s - random.between(1.0, 4.0);
                what += ", float start";
            }
        }
        Self {
            what,
            reflectors_m,
            clutter_m,
            path,
            scene,
            has_attitude,
            float_s,
            receiver: random,
        }
    }

    /// Writes the logs into a folder; gives the campaign, and the true clock offset (s).
    pub fn written(&mut self, folder: &FilePath) -> (Table, f64) {
        std::fs::create_dir_all(folder).unwrap();
        let file = folder.join("flown.csv");
        std::fs::write(&file, self.truth_csv()).unwrap();
        self.scene.trajectory = Some(GivenFlight {
            file,
            on_track_s: Some(self.path.recorded_s()),
        });
        let simulated = simulate_campaign(&self.scene).unwrap();
        for file in &simulated.files {
            std::fs::write(folder.join(&file.name), &file.bytes).unwrap();
        }
        let positions = self.positions_csv(self.scene.start().unwrap().tow_s());
        std::fs::write(folder.join("positions.csv"), positions).unwrap();
        let campaign = self.campaign();
        std::fs::write(folder.join("campaign.toml"), campaign.to_string()).unwrap();
        (campaign, simulated.summary.time_offset_s)
    }

    /// A campaign with right settings, its clock offset left to the data.
    fn campaign(&self) -> Table {
        let [x_m, y_m] = self.extent_m();
        let [forward_m, left_m, up_m] = self.scene.radar.lever_arm_m;
        format!(
            "[radar]\nfile = 'radar.mrm'\n\
             [trajectory]\nfile = 'positions.csv'\ntime_offset_s = 'auto'\n\
             lever_arm_m = [{forward_m:.3}, {left_m:.3}, {up_m:.3}]\n\
             [image]\nband_ghz = [3.1, 4.8]\nx_m = {x_m:?}\ny_m = {y_m:?}\npixel_m = 0.03\n"
        )
        .parse()
        .unwrap()
    }

    /// What the image holds: the reflectors and two metres about them, or the middle of the track.
    fn extent_m(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|i| {
            let places = self.reflectors_m.iter().map(|p| p[i]);
            let (low, high) = places.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            if low > high {
                [-3.0, 3.0]
            } else {
                [(low - 2.0).round(), (high + 2.0).round()]
            }
        })
    }

    /// How far a place of the image is from a true one: along and across the track where that is nearest (m).
    pub fn off_m(&self, found_m: [f64; 2], place_m: [f64; 3]) -> [f64; 2] {
        let (sin, cos) = self.nearest_of_track(place_m).1.sin_cos();
        let [x, y] = [0, 1].map(|i| found_m[i] - place_m[i]);
        [x * sin + y * cos, x * cos - y * sin]
    }

    /// Resolution cell at a place: along and across the track (m).
    pub fn cell_m(&self, place_m: [f64; 3], range_cell_m: f64, wavelength_m: f64) -> [f64; 2] {
        let (nearest_m, _) = self.nearest_of_track(place_m);
        let level_m = (nearest_m[0] - place_m[0]).hypot(nearest_m[1] - place_m[1]);
        let range_m = level_m.hypot(nearest_m[2]);
        let aperture_m = self.path.length_m.min(2.0 * range_m);
        let along_m = 0.5 * wavelength_m * range_m / aperture_m;
        [
            along_m.max(range_cell_m),
            range_cell_m * range_m / level_m.max(0.1 * range_m),
        ]
    }

    /// The point of the track nearest to a place, and the course there (rad clockwise from north).
    fn nearest_of_track(&self, place_m: [f64; 3]) -> ([f64; 3], f64) {
        let steps = 400_u32;
        let nearest = (0..=steps)
            .map(|k| {
                self.path
                    .on_corners(self.path.length_m * f64::from(k) / f64::from(steps))
            })
            .min_by(|a, b| {
                let away = |p: &[f64; 3]| (p[0] - place_m[0]).hypot(p[1] - place_m[1]);
                away(&a.0).total_cmp(&away(&b.0))
            });
        nearest.unwrap()
    }

    fn truth_csv(&self) -> String {
        let mut text = String::from("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n");
        for time_s in steps(self.path.duration_s(), 0.05) {
            let pose = self.path.at(time_s);
            let [x, y, z] = pose.position_m;
            let [qw, qx, qy, qz] = pose.attitude.quaternion();
            let _ = writeln!(
                text,
                "{time_s:.3},{x:.5},{y:.5},{z:.5},{qw:.7},{qx:.7},{qy:.7},{qz:.7}"
            );
        }
        text
    }

    /// What the receiver says, ten times a second: errors that last a minute and such that do not, with the
    /// deviations that it states; of float ambiguities decimetres, with a jump where they are fixed.
    fn positions_csv(&mut self, start_s: f64) -> String {
        const FIXED_M: [f64; 3] = [0.005, 0.005, 0.010];
        const NOISE_M: [f64; 3] = [0.0015, 0.0015, 0.003];
        const FLOAT_M: [f64; 3] = [0.3, 0.3, 0.6];
        let random = &mut self.receiver;
        let lasting = FIXED_M.map(|sigma| Sway::of(sigma, [30.0, 240.0], random));
        let drifting = FLOAT_M.map(|sigma| Sway::of(sigma, [6.0, 60.0], random));
        let heading_rad = random.normal(0.017);
        let mut text = String::from("time_s,x_m,y_m,z_m,sd_x_m,sd_y_m,sd_z_m,q");
        text += if self.has_attitude {
            ",qw,qx,qy,qz\n"
        } else {
            "\n"
        };
        for time_s in steps(self.path.duration_s(), 0.1) {
            let pose = self.path.at(time_s);
            let is_float = time_s < self.float_s;
            let _ = write!(text, "{:.3}", start_s + time_s);
            for i in 0..3 {
                let float_m = if is_float {
                    drifting[i].at(time_s) + random.normal(0.02)
                } else {
                    0.0
                };
                let error_m = lasting[i].at(time_s) + random.normal(NOISE_M[i]) + float_m;
                let _ = write!(text, ",{:.4}", pose.position_m[i] + error_m);
            }
            for i in 0..3 {
                let stated_m = if is_float {
                    FLOAT_M[i]
                } else {
                    FIXED_M[i].hypot(NOISE_M[i])
                };
                let _ = write!(text, ",{stated_m:.4}");
            }
            text += if is_float { ",2" } else { ",1" };
            if self.has_attitude {
                let [w, x, y, z] = pose.attitude.quaternion();
                // About the vertical, as a compass errs.
                let (s, c) = (0.5 * heading_rad).sin_cos();
                let q = [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w];
                let _ = write!(text, ",{:.6},{:.6},{:.6},{:.6}", q[0], q[1], q[2], q[3]);
            }
            text.push('\n');
        }
        text
    }
}

fn steps(duration_s: f64, step_s: f64) -> impl Iterator<Item = f64> {
    (0_u32..)
        .map(move |k| f64::from(k) * step_s)
        .take_while(move |t| *t <= duration_s)
}

/// One to four reflectors on one side of the track, 1.2 m apart at least; inside it, of a circle.
fn reflectors(shape: Shape, path: &Path, scene: &mut Scene, random: &mut Random) -> Vec<[f64; 3]> {
    let wanted = 1 + usize::try_from(random.one_of(4)).unwrap();
    let half_m = 0.3 * path.length_m.min(20.0);
    let near_m = (0.15 * path.height_m).max(0.8);
    let mut places_m: Vec<[f64; 3]> = Vec::new();
    for _ in 0..200 {
        let place_m = match shape {
            Shape::Circle => {
                let (middle_m, _) = path.on_corners(0.25 * path.length_m);
                let (opposite_m, _) = path.on_corners(0.75 * path.length_m);
                let radius_m = 0.5 * (middle_m[0] - opposite_m[0]).abs();
                let reach_m = 0.4 * radius_m;
                let north_m = middle_m[1] + random.between(-reach_m, reach_m);
                [random.between(-reach_m, reach_m), north_m, 0.0]
            }
            Shape::Grid => {
                let x_m = random.between(-0.3, 0.3) * path.length_m / 3.5;
                [x_m, random.between(-0.5, 0.5) * path.height_m - 2.0, 0.0]
            }
            _ => {
                let far_m = near_m + 0.35 * path.height_m;
                [
                    random.between(-half_m, half_m),
                    random.between(near_m, far_m),
                    0.0,
                ]
            }
        };
        let away = |other: &[f64; 3]| (other[0] - place_m[0]).hypot(other[1] - place_m[1]);
        if places_m.iter().all(|other| away(other) > 1.2) {
            places_m.push(place_m);
        }
        if places_m.len() == wanted {
            break;
        }
    }
    for place_m in &places_m {
        if matches!(shape, Shape::Circle | Shape::Grid) {
            scene.point.push(PointTarget {
                position_m: *place_m,
                rcs_m2: random.between(6.0, 12.0),
            });
        } else {
            // A user turns a reflector towards the track.
            let off_m = place_m[1];
            scene.corner.push(CornerReflector {
                position_m: *place_m,
                edge_m: random.between(0.35, 0.45),
                azimuth_deg: 180.0,
                elevation_deg: path.height_m.atan2(off_m).to_degrees(),
            });
        }
    }
    places_m
}

/// A row of things to the north, beyond the reflectors; what box of the ground it covers.
fn clutter(path: &Path, scene: &mut Scene, random: &mut Random) -> [f64; 4] {
    let x_m = random.between(-0.4, 0.4) * path.length_m.min(20.0);
    let y_m = random.between(0.6, 1.0) * path.height_m + 3.0;
    scene.clutter.push(Clutter {
        from_m: [x_m - 1.5, y_m, 0.0],
        to_m: [x_m + 1.5, y_m + 1.5, 1.5],
        scatterers: 120,
        rcs_m2: random.between(2.0, 30.0),
    });
    [x_m - 2.5, x_m + 2.5, y_m - 1.0, y_m + 3.5]
}
