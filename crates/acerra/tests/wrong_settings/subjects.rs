//! The campaigns that the table makes wrong: both tracks of the demonstration, and a real flight
//! where its data are present.

use std::path::{Path, PathBuf};

use acerra::demo::TRACKS;
use acerra_imaging::resolution::displacement_m;
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;
use toml::{Table, Value};

use crate::edit::Settings;
use crate::trajectories::Distortion;

/// A right campaign, and what its image shows.
pub struct Subject {
    /// What it is called.
    pub name: &'static str,
    /// Folder of its logs.
    pub folder: PathBuf,
    /// Its campaign.
    pub settings: Settings,
    /// Its reflectors.
    pub truth: Truth,
}

/// Reflectors, and how near to them an image must show them.
#[derive(Clone, Debug)]
pub struct Truth {
    /// East and north (m).
    pub target_m: Vec<[f64; 2]>,
    /// Tolerance to the east and to the north: along and across the track (m).
    pub tolerance_m: [f64; 2],
}

/// Tolerance along the track: a few resolution cells (m).
const ALONG_M: f64 = 0.10;
/// Tolerance across the track, where the resolution is coarser (m).
const ACROSS_M: f64 = 0.35;
/// Height error that positions by carrier phase may have (m).
const HEIGHT_ERROR_M: f64 = 0.03;

/// The subjects' folders, as long as they are in use.
pub struct Subjects {
    /// The subjects.
    pub all: Vec<Subject>,
    _folder: tempfile::TempDir,
}

impl Subjects {
    /// Simulates the logs of the demonstration's tracks that are wanted, those of another day, and
    /// finds the real flight.
    pub fn new(pixel_m: f64, is_wanted: impl Fn(&str) -> bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut all = Vec::new();
        let heights_m = [4.0, 10.0];
        let wanted = TRACKS
            .iter()
            .zip(heights_m)
            .filter(|(t, _)| is_wanted(t.name));
        for (track, height_m) in wanted {
            let home = folder.path().join(track.name).join("flight");
            let scene = track.on_track().unwrap();
            simulate_into(&home, &scene);
            let other = TRACKS.iter().find(|t| t.name != track.name).unwrap();
            simulate_into(&home.join("../other"), &other.on_track().unwrap());
            let mut day = scene.clone();
            day.start_gpst[2] += 1;
            simulate_into(&home.join("../day"), &day);
            Distortion::write_all(&home);
            all.push(demo_subject(track.name, home, &scene, height_m, pixel_m));
        }
        if is_wanted("hall") {
            all.extend(hall(pixel_m));
        }
        Self {
            all,
            _folder: folder,
        }
    }
}

/// Writes the logs of a scene.
pub fn simulate_into(folder: &Path, scene: &Scene) {
    std::fs::create_dir_all(folder).unwrap();
    for file in simulate_campaign(scene).unwrap().files {
        std::fs::write(folder.join(&file.name), &file.bytes).unwrap();
    }
}

/// What `truth.json` says.
pub fn truth_of(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn demo_subject(
    name: &'static str,
    folder: PathBuf,
    scene: &Scene,
    height_m: f64,
    pixel_m: f64,
) -> Subject {
    let text = std::fs::read_to_string(folder.join("campaign.toml")).unwrap();
    let mut campaign: Table = text.parse().unwrap();
    let truth = truth_of(&folder);
    let mut set = |section: &str, key: &str, value: Value| {
        let table = campaign[section].as_table_mut().unwrap();
        table.insert(key.to_owned(), value);
    };
    let floats = |v: &[f64]| Value::Array(v.iter().map(|v| Value::Float(*v)).collect());
    let offset_s = truth["time_offset_s"].as_f64().unwrap();
    set("trajectory", "time_offset_s", Value::Float(offset_s));
    set("trajectory", "origin_deg_m", floats(&scene.origin_deg_m));
    set("image", "x_m", floats(&scene.image.x_m));
    set("image", "y_m", floats(&scene.image.y_m));
    set("image", "pixel_m", Value::Float(pixel_m));
    let known = format!(
        "[radar]\ndelay_ns = {:.3}\n[image]\nz_m = 0.0\nlight_speed_m_s = 299792458.0\n",
        scene.radar.delay_ns
    );
    // Eq. (14): what the height error moves a target at nadir by.
    let nadir_m = displacement_m(height_m, 0.0, HEIGHT_ERROR_M)
        .unwrap()
        .unwrap_or(0.0);
    let is_nadir = name == "track-1";
    Subject {
        name,
        folder,
        settings: Settings {
            campaign,
            known: known.parse().unwrap(),
        },
        truth: Truth {
            target_m: scene
                .corner
                .iter()
                .map(|c| [c.position_m[0], c.position_m[1]])
                .collect(),
            tolerance_m: [ALONG_M, if is_nadir { nadir_m } else { ACROSS_M }],
        },
    }
}

/// Surveyed place of the real flight's reflector: east, north (m).
const SURVEYED_M: [f64; 2] = [1.793, 1.810];
/// How far from its surveyed place, three days earlier, the reflector is imaged (m).
const SURVEY_TOLERANCE_M: f64 = 0.25;

fn hall(pixel_m: f64) -> Option<Subject> {
    let folder = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/uav-flight-2019"
    ));
    if !folder.exists() {
        eprintln!("skipped: {} is absent", folder.display());
        return None;
    }
    let campaign = format!(
        "[radar]\nfile = 'flight.mrm'\ndelay_ns = 11.5\nselect = 'moving'\n[trajectory]\n\
         file = 'platform-mocap.csv'\ntime_offset_s = 6.521\nlever_arm_m = [0.0, 0.0, 0.0]\n\
         [preprocess]\ngate_ns = 'none'\n\
         [image]\nx_m = [0, 4]\ny_m = [0, 4]\npixel_m = {pixel_m}\nweight = 'path'\n"
    );
    let known = "[image]\nz_m = 0.0\nlight_speed_m_s = 299792458.0\n";
    Some(Subject {
        name: "hall",
        folder: folder.to_owned(),
        settings: Settings {
            campaign: campaign.parse().unwrap(),
            known: known.parse().unwrap(),
        },
        truth: Truth {
            target_m: vec![SURVEYED_M],
            tolerance_m: [SURVEY_TOLERANCE_M; 2],
        },
    })
}
