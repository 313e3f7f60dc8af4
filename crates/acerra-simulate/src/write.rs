//! From a scene to its logs and the campaign file that processes them.

use std::fmt::Write as _;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use acerra_gnss::input::Limits;
use acerra_gnss::{Navigation, read_navigation};
use acerra_radar::mrm::{CONFIG_BYTES, Framing, RadarConfig, SCAN_MESSAGE_BYTES, write_mrm};
use acerra_radar::{DEFAULT_STEP_BINS, Scan};
use acerra_settings::ValueError;
use serde_json::json;
use thiserror::Error;

use super::flight::Flight;
use super::gnss::{GnssError, GnssModel, Setting, constellation, navigation_to_rinex, simulate};
use super::radar::{lost_packets, simulate_scans};
use super::scene::{OffsetTold, Record, Scene, SceneError};

/// The simulation's truth, for comparison.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Scans that the radar made.
    pub scans: usize,
    /// Messages of the radar that were lost.
    pub lost_messages: usize,
    /// GNSS epochs of the rover; 0 where the trajectory itself was written.
    pub gnss_epochs: usize,
    /// Trajectory time minus radar time (s).
    pub time_offset_s: f64,
}

/// A file of a simulated campaign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogFile {
    /// Its name in the campaign's folder.
    pub name: String,
    /// What it holds.
    pub bytes: Vec<u8>,
}

/// The files of a simulated campaign, and the simulation's truth.
#[derive(Clone, Debug)]
pub struct SimulatedCampaign {
    /// `radar.mrm`, the GNSS logs (or `trajectory.csv` where the scene has none), `campaign.toml`,
    /// `scene.toml`, and the truth in `truth-trajectory.csv` and `truth.json`.
    pub files: Vec<LogFile>,
    /// Counts and the true clock offset.
    pub summary: Simulated,
}

/// Reason why a scene could not be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimulateError {
    /// A scene that cannot be.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A radar that cannot be.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// A file that the scene names cannot be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// Why.
        source: io::Error,
    },
    /// The navigation file that the scene names holds none.
    #[error("[gnss] navigation: {path}: {source}")]
    Navigation {
        /// The file.
        path: String,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// Receivers that cannot be.
    #[error("[gnss]: {0}")]
    Gnss(#[from] GnssError),
    /// A scan that the radar's format cannot hold.
    #[error("radar.mrm: {0}")]
    Capture(#[from] io::Error),
    /// A scene that TOML cannot hold.
    #[error("the scene: {0}")]
    Serialize(#[from] toml::ser::Error),
}

/// Simulates `scene`: every file that its instruments would have written.
///
/// # Errors
/// A scene that cannot be, or a file it names that cannot be read.
pub fn simulate_campaign(scene: &Scene) -> Result<SimulatedCampaign, SimulateError> {
    let flight = scene.fly()?;
    let span_s = match scene.record {
        Record::Track => flight.on_track_s,
        Record::Flight => [0.0, flight.duration_s()],
    };
    let scans = simulate_scans(
        &scene.radar,
        &scene.radar_scene(),
        &flight,
        span_s,
        scene.seed,
    )?;
    let mut files = Files::default();
    let (capture, lost_messages) = capture(scene, &scans)?;
    files.add("radar.mrm", capture);

    let start = scene.start()?;
    let time_offset_s = start.tow_s() + span_s[0];
    let gnss_epochs = match &scene.gnss {
        Some(model) => gnss_logs(scene, model, &flight, &mut files)?,
        None => {
            files.add("trajectory.csv", track_csv(&flight, start.tow_s(), 0.05));
            0
        }
    };
    files.add("campaign.toml", campaign(scene, time_offset_s));
    scene_files(scene, &mut files)?;
    files.add(
        "truth-trajectory.csv",
        track_csv(&flight, start.tow_s(), 0.02),
    );
    let truth = truth(scene, &flight, span_s, time_offset_s);
    files.add("truth.json", format!("{truth:#}\n"));
    Ok(SimulatedCampaign {
        files: files.0,
        summary: Simulated {
            scans: scans.len(),
            lost_messages,
            gnss_epochs,
            time_offset_s,
        },
    })
}

/// The files so far.
#[derive(Default)]
struct Files(Vec<LogFile>);

impl Files {
    fn add(&mut self, name: &str, bytes: impl Into<Vec<u8>>) {
        self.0.push(LogFile {
            name: name.to_owned(),
            bytes: bytes.into(),
        });
    }
}

/// Adds the logs of rover and base and the navigation file; returns the rover's epochs.
fn gnss_logs(
    scene: &Scene,
    model: &GnssModel,
    flight: &Flight,
    files: &mut Files,
) -> Result<usize, SimulateError> {
    let start = scene.start()?;
    let duration_s = flight.duration_s();
    let navigation = match &model.navigation {
        Some(file) => read_satellites(file)?,
        None => constellation(start, duration_s, scene.seed),
    };
    let setting = Setting {
        frame: scene.frame(),
        start,
        duration_s,
        rover_m: &|time_s| flight.pose_at(time_s).position_m,
        base_m: scene.base_m,
        navigation: &navigation,
        seed: scene.seed,
    };
    let logs = simulate(model, &setting)?;
    files.add("rover.obs", logs.rover.to_rinex("ROVER"));
    files.add("base.obs", logs.base.to_rinex("BASE"));
    files.add("rover.ubx", logs.rover.to_ubx(&navigation));
    files.add("base.ubx", logs.base.to_ubx(&navigation));
    files.add("broadcast.nav", navigation_to_rinex(&navigation));
    Ok(logs.rover.epochs.len())
}

/// Adds the scene with the files that it needs, so that it can be simulated again from where it
/// lies.
fn scene_files(scene: &Scene, files: &mut Files) -> Result<(), SimulateError> {
    let mut scene = scene.clone();
    let mut keep = |file: &mut PathBuf, stem: &str| -> Result<(), SimulateError> {
        let bytes = std::fs::read(&*file).map_err(|source| SimulateError::Read {
            path: file.display().to_string(),
            source,
        })?;
        let ending = file.extension().map(|e| e.to_string_lossy().into_owned());
        let name = ending.map_or(stem.to_owned(), |ending| format!("{stem}.{ending}"));
        files.add(&name, bytes);
        *file = name.into();
        Ok(())
    };
    if let Some(given) = &mut scene.trajectory {
        keep(&mut given.file, "given-trajectory")?;
    }
    if let Some(file) = scene.gnss.as_mut().and_then(|g| g.navigation.as_mut()) {
        keep(file, "given-navigation")?;
    }
    files.add("scene.toml", toml::to_string(&scene)?);
    Ok(())
}

/// The satellites of a navigation file.
fn read_satellites(path: &Path) -> Result<Navigation, SimulateError> {
    let failed = |source: Box<dyn std::error::Error + Send + Sync>| SimulateError::Navigation {
        path: path.display().to_string(),
        source,
    };
    let file = File::open(path).map_err(|error| failed(error.into()))?;
    let (navigation, _) =
        read_navigation(file, Limits::default()).map_err(|error| failed(error.into()))?;
    Ok(navigation)
}

/// The capture, without the messages that get lost.
fn capture(scene: &Scene, scans: &[Scan]) -> Result<(Vec<u8>, usize), SimulateError> {
    let radar = &scene.radar;
    let window = scans.first().map(|scan| scan.window);
    let config = RadarConfig {
        node_id: 1,
        scan_start_ps: window.map_or(0, |w| w.start_ps),
        scan_stop_ps: window.map_or(0, |w| w.stop_ps),
        scan_resolution_bins: DEFAULT_STEP_BINS,
        integration_index: radar.integration_index,
        segment_samples: [0; 4],
        segment_integration: [0; 4],
        antenna_mode: 2,
        transmit_gain: radar.transmit_gain_index,
        code_channel: 0,
        persist: 0,
    };
    let whole = write_mrm(Vec::new(), Framing::Bare, Some(&config), scans)?;
    let (head, messages) = whole.split_at(CONFIG_BYTES);
    let lost = lost_packets(radar, messages.len() / SCAN_MESSAGE_BYTES, scene.seed);
    let mut kept = head.to_vec();
    for (message, lost) in messages.chunks(SCAN_MESSAGE_BYTES).zip(&lost) {
        if !lost {
            kept.extend_from_slice(message);
        }
    }
    Ok((kept, lost.iter().filter(|lost| **lost).count()))
}

/// The positioned point over the flight, in seconds of the GPS week.
fn track_csv(flight: &Flight, start_tow_s: f64, step_s: f64) -> String {
    let mut csv = String::from("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n");
    let mut k = 0_u32;
    while f64::from(k) * step_s <= flight.duration_s() {
        let pose = flight.pose_at(f64::from(k) * step_s);
        let [x, y, z] = pose.position_m;
        let [qw, qx, qy, qz] = pose.attitude.quaternion();
        let time_s = start_tow_s + f64::from(k) * step_s;
        let _ = writeln!(
            csv,
            "{time_s:.3},{x:.5},{y:.5},{z:.5},{qw:.7},{qx:.7},{qy:.7},{qz:.7}"
        );
        k += 1;
    }
    csv
}

fn campaign(scene: &Scene, time_offset_s: f64) -> String {
    let image = &scene.image;
    let [latitude, longitude, height_m] = scene.origin_deg_m;
    let positions = if scene.gnss.is_some() {
        let [x, y, z] = scene.frame().ecef_from_enu(scene.base_m);
        format!(
            "[gnss]\nrover = \"rover.obs\"\nbase = \"base.obs\"\nnavigation = \"broadcast.nav\"\n\
             base_ecef_m = [{x:.4}, {y:.4}, {z:.4}]\n"
        )
    } else {
        String::new()
    };
    let file = if scene.gnss.is_some() {
        ""
    } else {
        "file = \"trajectory.csv\"\n"
    };
    let offset = match scene.time_offset {
        OffsetTold::Exact => time_offset_s.to_string(),
        OffsetTold::Auto => "\"auto\"".to_owned(),
    };
    let [forward, left, up] = scene.radar.lever_arm_m;
    format!(
        "# Written by acerra simulate.\n[radar]\nfile = \"radar.mrm\"\n\n{positions}\n\
         [trajectory]\n{file}time_offset_s = {offset}\n\
         lever_arm_m = [{forward:?}, {left:?}, {up:?}]\n\
         origin_deg_m = [{latitude:?}, {longitude:?}, {height_m:?}]\n\n\
         [image]\nband_ghz = [{:?}, {:?}]\nx_m = [{:?}, {:?}]\ny_m = [{:?}, {:?}]\n\
         pixel_m = {:?}\n",
        scene.radar.band_ghz[0],
        scene.radar.band_ghz[1],
        image.x_m[0],
        image.x_m[1],
        image.y_m[0],
        image.y_m[1],
        image.pixel_m
    )
}

fn truth(
    scene: &Scene,
    flight: &Flight,
    span_s: [f64; 2],
    time_offset_s: f64,
) -> serde_json::Value {
    let places: Vec<[f64; 3]> = scene
        .corner
        .iter()
        .map(|c| c.position_m)
        .chain(scene.point.iter().map(|p| p.position_m))
        .collect();
    json!({
        "targets_m": places,
        "on_track_s": flight.on_track_s,
        "recorded_s": span_s,
        "time_offset_s": time_offset_s,
        "delay_ns": scene.radar.delay_ns,
        "base_m": scene.base_m,
    })
}
