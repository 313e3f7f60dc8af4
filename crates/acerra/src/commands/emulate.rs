//! `acerra emulate`: the radio and the receiver, on this computer.

use std::io::{Cursor, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_gnss::ubx::frame::{Piece, pieces};
use acerra_radar::{Limits, RadarFile};
use acerra_record::emulate::{
    EmulatedRadio, EmulatedReceiver, EmulatorOptions, Impairments, PulseLine, Quality,
    ReceiverOptions, Recorded, World, with_solutions,
};
use acerra_simulate::scene::Scene;
use acerra_simulate::write::simulate_campaign;
use anyhow::Context;

use super::emulate_pps::{PpsArgs, Shared};
use super::values::{number_in, share};
use crate::interrupt;

/// Emulate the instruments: a radio that answers and scans, and a receiver that sends, out of a recording
/// or a simulated scene.
///
/// The radio listens on UDP, the receiver on TCP, and time begins when a client starts scans. Standard output
/// has a session file that records the instruments. Ends when everything is sent, or by Ctrl-C.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra emulate scene.toml -o ground > session.toml &
  acerra record session.toml -o flight
  acerra emulate scene.toml -o ground --receiver-latency-ms 60 --pps pulses > session.toml &
  acerra emulate flight.mrm --gnss rover.ubx --speed 10 --loss 0.01 --reboot-at 60")]
pub struct Args {
    /// A radar log of any kind that is read, or a scene file (TOML).
    #[arg(value_name = "LOG|SCENE.toml")]
    file: PathBuf,
    /// Directory for the data of a scene that the instruments do not send: the base's log, the truth.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// UBX log that the receiver sends; a scene has its own.
    #[arg(long, value_name = "FILE")]
    gnss: Option<PathBuf>,
    /// Solutions that the receiver of a scene sends in addition to its measurements: single, float or fixed.
    #[arg(long, value_name = "KIND")]
    solutions: Option<Quality>,
    /// Address and UDP port of the radio.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:21210")]
    radio: SocketAddr,
    /// Address and TCP port of the receiver.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:21211")]
    receiver: SocketAddr,
    /// Seconds of the flight in a second.
    #[arg(long, default_value_t = 1.0, value_parser = positive)]
    speed: f64,
    /// Frequency error of the radio's clock, in parts per million (positive: fast).
    #[arg(
        long,
        value_name = "PPM",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    drift_ppm: f64,
    /// Share of the radio's messages that are lost.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    loss: f64,
    /// Share that come twice.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    repetition: f64,
    /// Share of messages that are overtaken by those of the next 30 ms.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    reordering: f64,
    /// Mean of the delay of each message, exponentially distributed (ms).
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = share_of_a_minute)]
    jitter_ms: f64,
    /// Time at which the radio restarts (s); may be given several times.
    #[arg(long, value_name = "S")]
    reboot_at: Vec<f64>,
    /// World times from and to which the receiver has no fix (s); may be given several times.
    #[arg(long, value_name = "FROM,TO", value_parser = interval)]
    no_fix: Vec<[f64; 2]>,
    /// Wire the radio's pulse, one a scan, to the receiver's time-mark input (UBX-TIM-TM2).
    #[arg(long)]
    marks: bool,
    /// Share of the pulses that the receiver misses.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share, requires = "marks")]
    mark_loss: f64,
    /// Time that the receiver needs from an epoch to its first byte (ms); the session file does not state it.
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = share_of_a_minute)]
    receiver_latency_ms: f64,
    #[command(flatten)]
    pps: PpsArgs,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn positive(text: &str) -> Result<f64, String> {
    number_in(text, 0.001..=1000.0)
}

fn interval(text: &str) -> Result<[f64; 2], String> {
    let expected = || "expected two times, such as 10,15".to_owned();
    let (from, to) = text.split_once(',').ok_or_else(expected)?;
    let seconds = |text: &str| number_in(text.trim(), 0.0..=1e6).map_err(|_| expected());
    let interval = [seconds(from)?, seconds(to)?];
    (interval[0] < interval[1])
        .then_some(interval)
        .ok_or_else(expected)
}

fn share_of_a_minute(text: &str) -> Result<f64, String> {
    number_in(text, 0.0..=60_000.0)
}

/// What is to be sent.
struct Flight {
    scans: Recorded,
    rover: Option<Vec<u8>>,
    /// GPS seconds of the week at the first scan, where they are known.
    first_scan_tow_s: Option<f64>,
    /// Height of the track above the ground (m), where a scene states it.
    height_m: Option<f64>,
    /// Tables of the campaign.
    campaign: toml::Table,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read, ports that are taken.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let stop = interrupt::stop_in_order();
    let at = || format!("{}", args.file.display());
    let is_scene = args.file.extension().is_some_and(|e| e == "toml");
    let mut flight = match (&args.output, is_scene) {
        (Some(folder), true) => simulated(args, folder).with_context(at)?,
        (None, true) => anyhow::bail!("{}: a scene needs -o DIR for the base's log", at()),
        (_, false) if args.solutions.is_some() => {
            anyhow::bail!("{}: only a scene gives the positions for --solutions", at())
        }
        (_, false) => recorded(&args.file).with_context(at)?,
    };
    if let Some(file) = &args.gnss {
        let log = std::fs::read(file).with_context(|| file.display().to_string())?;
        flight.rover = Some(log);
    }
    let pps_file = args.pps.path()?;
    let session = session_of(args, &flight, pps_file.as_deref());
    let world = World::new(args.speed);
    let times = Times::of(&flight);
    let pulses = args
        .marks
        .then(|| PulseLine::new(args.mark_loss, args.seed));
    let shared = Shared {
        world: &world,
        starts_at: times.world_begins,
        no_fix_s: &args.no_fix,
        seed: args.seed,
    };
    let _pps = args.pps.start(pps_file.as_deref(), &shared)?;
    let receiver = match flight.rover {
        Some(log) => {
            let options = ReceiverOptions {
                starts_at: times.world_begins,
                latency_s: 1e-3 * args.receiver_latency_ms,
                no_fix_s: args.no_fix.clone(),
                pulses: pulses.clone(),
                ..ReceiverOptions::new(world.clone())
            };
            let receiver = EmulatedReceiver::start(args.receiver, log, options);
            Some(receiver.with_context(|| format!("receiver at {}", args.receiver))?)
        }
        None => None,
    };
    let options = EmulatorOptions {
        drift_ppm: args.drift_ppm,
        world: Some((world, times.first_scan_s)),
        impairments: Impairments {
            loss: args.loss,
            repetition: args.repetition,
            reordering: args.reordering,
            held_back_s: 0.03,
            delay_s: 0.0,
            jitter_s: 1e-3 * args.jitter_ms,
            seed: args.seed,
        },
        pulses,
        reboot_at_s: args.reboot_at.clone(),
        ..EmulatorOptions::default()
    };
    let radio = EmulatedRadio::start(args.radio, Box::new(flight.scans), options)
        .with_context(|| format!("radio at {}", args.radio))?;
    write!(out, "{session}")?;
    out.flush()?;
    while !stop.load(Ordering::SeqCst) {
        std::thread::sleep(Duration::from_millis(100));
        let is_sent = receiver.as_ref().is_none_or(EmulatedReceiver::is_finished);
        if radio.counts().exhausted && is_sent {
            // A client may still ask for the radio's state, and stop it.
            std::thread::sleep(Duration::from_secs(2));
            break;
        }
    }
    let counts = radio.counts();
    writeln!(
        out,
        "# {} scans; {} messages, {} lost, {} repeated, {} held back; {} restarts",
        counts.scans,
        counts.channel.messages,
        counts.channel.lost,
        counts.channel.repeated,
        counts.channel.held_back,
        counts.reboots
    )?;
    Ok(())
}

/// The instruments' logs of a scene; the other files are written to `folder`.
fn simulated(args: &Args, folder: &Path) -> anyhow::Result<Flight> {
    let file = &args.file;
    let text = std::fs::read_to_string(file)?;
    let own = file.parent().unwrap_or_else(|| Path::new(""));
    let scene = Scene::parse(&text)?.resolved_in(own);
    let simulated = simulate_campaign(&scene)?;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let folder = std::path::absolute(folder)?;
    let mut capture = Vec::new();
    let mut rover = None;
    let mut campaign = toml::Table::new();
    for log in simulated.files {
        match log.name.as_str() {
            "radar.mrm" => capture = log.bytes,
            "rover.ubx" => rover = Some(log.bytes),
            // The same as the UBX log.
            "rover.obs" => {}
            "campaign.toml" => campaign = toml::from_str(&String::from_utf8(log.bytes)?)?,
            name => {
                let path = folder.join(name);
                std::fs::write(&path, log.bytes).with_context(|| path.display().to_string())?;
            }
        }
    }
    if let (Some(quality), Some(log)) = (args.solutions, &mut rover) {
        let (flight, frame, start) = (scene.fly()?, scene.frame(), scene.start()?);
        let place = |time: GpsTime| {
            let pose = flight.pose_at(time.seconds_since(start));
            Some(frame.ecef_from_enu(pose.position_m))
        };
        *log = with_solutions(log, place, quality, args.seed);
    }
    let scans = Recorded::from_capture(&capture).context("the simulated capture")??;
    campaign.remove("radar");
    place_files(&mut campaign, &folder);
    if rover.is_some()
        && let Some(toml::Value::Table(trajectory)) = campaign.get_mut("trajectory")
    {
        // Contents of the recording.
        trajectory.remove("time_offset_s");
    }
    Ok(Flight {
        scans,
        rover,
        first_scan_tow_s: Some(simulated.summary.time_offset_s),
        height_m: scene.flight.as_ref().map(|flight| flight.height_m),
        campaign,
    })
}

/// Names the files of a simulated campaign where they lie; the rover's log is still to be recorded.
fn place_files(campaign: &mut toml::Table, folder: &Path) {
    for (table, key) in [
        ("gnss", "base"),
        ("gnss", "navigation"),
        ("trajectory", "file"),
    ] {
        let value = campaign.get_mut(table).and_then(|t| t.get_mut(key));
        if let Some(toml::Value::String(path)) = value {
            *path = folder.join(&*path).display().to_string();
        }
    }
    if let Some(toml::Value::Table(gnss)) = campaign.get_mut("gnss") {
        gnss.remove("rover");
    }
}

/// The scans of a radar log, byte for byte where it is a capture.
fn recorded(file: &Path) -> anyhow::Result<Flight> {
    let bytes = std::fs::read(file)?;
    let scans = match Recorded::from_capture(&bytes) {
        Some(scans) => scans?,
        None => match acerra_radar::read(Cursor::new(bytes), &Limits::default())? {
            RadarFile::Log(log) => Recorded::from_log(&log)?,
            RadarFile::Neutral(_) => {
                anyhow::bail!("expected a log of scans, found a neutral NPZ file, which has none")
            }
        },
    };
    Ok(Flight {
        scans,
        rover: None,
        first_scan_tow_s: None,
        height_m: None,
        campaign: toml::Table::new(),
    })
}

/// Start times of the world and of its instruments.
struct Times {
    /// GPS time at the world's beginning: that of the first epoch where the first scan's is unknown.
    world_begins: Option<GpsTime>,
    /// World time of the first scan (s).
    first_scan_s: f64,
}

impl Times {
    fn of(flight: &Flight) -> Self {
        let log = flight.rover.as_deref().unwrap_or_default();
        let first = pieces(log).find_map(|piece| match piece {
            Piece::Frame(frame) => epoch_time(&frame),
            _ => None,
        });
        let (Some(first), Some(tow_s)) = (first, flight.first_scan_tow_s) else {
            return Self {
                world_begins: first,
                first_scan_s: 0.0,
            };
        };
        let after_s = tow_s - first.tow_s();
        if after_s >= 0.0 {
            return Self {
                world_begins: Some(first),
                first_scan_s: after_s,
            };
        }
        let start = GpsTime::from_week_tow(0, first.tow_s());
        let week = (first.seconds_since(start) / 604_800.0).round() as i64;
        Self {
            world_begins: Some(GpsTime::from_week_tow(week, tow_s)),
            first_scan_s: 0.0,
        }
    }
}

/// The session file that records the emulated instruments.
fn session_of(args: &Args, flight: &Flight, pps: Option<&Path>) -> String {
    let config = flight.scans.config();
    let mut text = format!(
        "# Written by acerra emulate.\n[radio]\naddress = \"{}\"\nwindow_ps = [{}, {}]\n\
         integration_index = {}\nantenna_mode = {}\ntransmit_gain = {}\ncode_channel = {}\n\
         # Emulated scans take no time.\nlatency_ms = 0.0\nlatency_sigma_ms = 0.0\nmark_delay_ms = 0.0\n",
        args.radio,
        config.scan_start_ps,
        config.scan_stop_ps,
        config.integration_index.clamp(6, 15),
        config.antenna_mode,
        config.transmit_gain,
        config.code_channel
    );
    if flight.rover.is_some() {
        text.push_str(&format!("\n[gnss]\naddress = \"{}\"\n", args.receiver));
        if args.receiver_latency_ms == 0.0 {
            text.push_str("latency_sigma_ms = 0.0\n");
        }
        if let Some(path) = pps {
            let path = toml::Value::from(path.display().to_string());
            text.push_str(&format!("pps = {path}\n"));
        }
    }
    if let Some(height_m) = flight.height_m {
        // Scans of the climb are not imaged.
        text.push_str(&format!("\n[flight]\nheight_m = {height_m:?}\n"));
    }
    for (name, table) in &flight.campaign {
        let entries = toml::to_string(table).unwrap_or_default();
        text.push_str(&format!("\n[campaign.{name}]\n{entries}"));
    }
    text
}
