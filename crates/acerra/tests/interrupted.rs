//! `acerra record`, `record --finish` and `live`, killed and on a disk that fills, at random moments: what the log holds
//! is recovered, and no file stands cut under its name.
//!
//! `INTERRUPTIONS=200 cargo test -p acerra --test interrupted -- --nocapture` tries as many of each;
//! `INTERRUPTIONS_SEED` draws others.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures, and why a test is skipped

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use acerra_record::log::{LogReader, RecordKind};
use acerra_record::session::{CAMPAIGN_NAME, CAPTURE_NAME, LOG_NAME, finish};

const ACERRA: &str = env!("CARGO_BIN_EXE_acerra");

/// A short flight with receivers, recorded from take-off to landing.
const SCENE: &str = "seed = 3\nrecord = \"flight\"\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n[gnss]\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.05\n";

/// Files that finishing a recording makes.
const MADE: [&str; 5] = [
    CAPTURE_NAME,
    CAMPAIGN_NAME,
    "rover.ubx",
    "radar.clock.json",
    "session.mcap",
];

/// Interruptions that run beside each other.
const WORKERS: u64 = 4;

fn number(variable: &str, default: u64) -> u64 {
    let text = std::env::var(variable).ok();
    text.map_or(default, |text| text.parse().unwrap())
}

/// Uniform from 0 to 1, for the `k`-th interruption (SplitMix64).
fn share(k: u64) -> f64 {
    let seed = number("INTERRUPTIONS_SEED", 1);
    let mut z = (seed << 32)
        .wrapping_add(k)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

/// Runs every interruption, some beside each other.
fn each(interrupt: impl Fn(u64) + Sync) {
    let next = AtomicU64::new(0);
    let count = number("INTERRUPTIONS", 6);
    std::thread::scope(|scope| {
        for _ in 0..WORKERS.min(count) {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::SeqCst);
                    if k >= count {
                        return;
                    }
                    interrupt(k);
                }
            });
        }
    });
}

/// A child that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Emulated instruments, and the session file that records them for as long as `stop_after_s`.
fn instruments(folder: &Path, stop_after_s: f64) -> (Running, PathBuf) {
    let radio = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr();
    let receiver = TcpListener::bind("127.0.0.1:0").unwrap().local_addr();
    let [radio, receiver] = [radio, receiver].map(|address| address.unwrap().to_string());
    let scene = folder.join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    let mut emulator = Running(
        Command::new(ACERRA)
            .arg("emulate")
            .arg(&scene)
            .arg("-o")
            .arg(folder.join("ground"))
            .args(["--radio", &radio, "--receiver", &receiver])
            .args(["--solutions", "fixed", "--speed", "4"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let output = emulator.0.stdout.take().unwrap();
    let mut session = String::new();
    for line in BufReader::new(output).lines() {
        session += &(line.unwrap() + "\n");
        // The last key of the last table.
        if session.contains("origin_deg_m") {
            break;
        }
    }
    let stop = format!("[flight]\nstop_after_s = {stop_after_s}\n");
    let file = folder.join("session.toml");
    fs::write(&file, session.replace("[flight]\n", &stop)).unwrap();
    (emulator, file)
}

/// `record` and `live` in turn, into `directory`.
fn recording(k: u64, session: &Path, directory: &Path) -> Vec<String> {
    let [session, directory] = [session, directory].map(|path| path.display().to_string());
    let mut arguments = vec![session, "-o".to_owned(), directory];
    if k.is_multiple_of(2) {
        arguments.insert(0, "record".to_owned());
    } else {
        arguments.insert(0, "live".to_owned());
        arguments.extend(["--no-open", "--no-final", "--quit"].map(str::to_owned));
    }
    arguments
}

/// Scans and bytes of the receiver in a log without damage; none where there is no log yet.
fn in_log(directory: &Path) -> Option<(u64, u64)> {
    let file = fs::File::open(directory.join(LOG_NAME)).ok()?;
    if file.metadata().unwrap().len() == 0 {
        return None;
    }
    let mut reader = LogReader::new(file).unwrap();
    let (mut scans, mut bytes) = (0, 0);
    while let Some(record) = reader.next_record().unwrap() {
        match record.kind {
            RecordKind::Radio if record.payload.len() == 1452 => scans += 1,
            RecordKind::Gnss => bytes += record.payload.len() as u64,
            _ => {}
        }
    }
    assert_eq!(reader.damage().damaged_places, 0);
    Some((scans, bytes))
}

/// Makes the files of an interrupted recording, and compares them with its log.
fn check_recovered(label: &str, directory: &Path) -> u64 {
    let Some((messages, gnss_bytes)) = in_log(directory) else {
        return 0;
    };
    let finished = match finish(directory) {
        Ok(finished) => finished,
        // Before the settings reached the disk there is nothing to make.
        Err(error) => {
            assert_eq!(messages, 0, "{label}: {error}");
            return 0;
        }
    };
    assert_eq!(finished.gnss_bytes, gnss_bytes, "{label}");
    // Three messages are a scan; that of the first and that of the last may be a part.
    let scans = finished.scans + finished.incomplete_scans;
    assert!(
        messages <= 3 * scans && 3 * finished.scans <= messages,
        "{label}"
    );
    if finished.scans > 0 {
        let capture = fs::File::open(directory.join(CAPTURE_NAME)).unwrap();
        let limits = acerra_radar::Limits::default();
        let log = acerra_radar::mrm::read_mrm(BufReader::new(capture), &limits).unwrap();
        assert_eq!(log.scans.len() as u64, finished.scans, "{label}");
    }
    finished.scans
}

#[test]
fn a_killed_recording_is_recovered() {
    let scans = AtomicU64::new(0);
    each(|k| {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let (_emulator, session) = instruments(folder, 20.0);
        let flight = folder.join("flight");
        let mut recorder = Command::new(ACERRA)
            .args(recording(k, &session, &flight))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs_f64(0.05 + 4.0 * share(k)));
        recorder.kill().unwrap();
        recorder.wait().unwrap();
        let found = check_recovered(&format!("kill {k}"), &flight);
        scans.fetch_add(found, Ordering::SeqCst);
    });
    println!("{} scans recovered", scans.into_inner());
}

/// A recording of a few seconds in `folder`, with its files.
fn recorded(folder: &Path) -> PathBuf {
    let (_emulator, session) = instruments(folder, 3.0);
    let flight = folder.join("flight");
    let output = Command::new(ACERRA)
        .arg("record")
        .arg(&session)
        .arg("-o")
        .arg(&flight)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    flight
}

fn finishing(directory: &Path) -> Command {
    let mut command = Command::new(ACERRA);
    command
        .arg("record")
        .arg("--finish")
        .arg(directory)
        .arg("--mcap");
    command
}

/// The files that are made, by name; none for those that are absent.
fn made(directory: &Path) -> [Option<Vec<u8>>; MADE.len()] {
    MADE.map(|name| fs::read(directory.join(name)).ok())
}

/// No file is there that is neither absent nor whole.
fn check_whole_or_absent(label: &str, directory: &Path, whole: &[Option<Vec<u8>>; MADE.len()]) {
    for ((name, found), whole) in MADE.iter().zip(made(directory)).zip(whole) {
        assert!(found.is_none() || found == *whole, "{label}: {name} is cut");
    }
}

/// A copy of a recording's log alone.
fn copy_of_log(flight: &Path, folder: &Path) -> PathBuf {
    let copy = folder.join("copy");
    fs::create_dir(&copy).unwrap();
    fs::copy(flight.join(LOG_NAME), copy.join(LOG_NAME)).unwrap();
    copy
}

#[test]
fn files_are_whole_or_absent_where_finishing_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let flight = recorded(folder.path());
    let begin = Instant::now();
    let output = finishing(&flight).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let whole_run_s = begin.elapsed().as_secs_f64();
    let whole = made(&flight);
    assert!(whole[0].as_ref().unwrap().len() > 100_000 && whole[2].is_some() && whole[4].is_some());
    each(|k| {
        let folder = tempfile::tempdir().unwrap();
        let copy = copy_of_log(&flight, folder.path());
        let mut child = finishing(&copy)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs_f64(1.5 * whole_run_s * share(k)));
        child.kill().unwrap();
        child.wait().unwrap();
        check_whole_or_absent(&format!("kill {k}"), &copy, &whole);
        let output = finishing(&copy).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(made(&copy) == whole, "kill {k}");
    });
}

/// Runs a program on a file system of its own of so many kilobytes, mounted at `disk` with what `from` holds; what is
/// there at the end is left in `to`. None where no file system can be mounted.
fn on_a_disk(kilobytes: u64, from: &Path, to: &Path, arguments: &[String]) -> Option<Output> {
    let disk = to.join("disk");
    fs::create_dir(&disk).unwrap();
    let script = "mount -t tmpfs -o size=\"$1\"k none \"$2\" && cp -r \"$3\"/. \"$2\" || exit 77\n\
                  to=$4; disk=$2; shift 4\n\
                  \"$@\"; code=$?\n\
                  cp -r \"$disk\" \"$to\"/left && exit $code";
    let output = Command::new("unshare")
        .args([
            "--user",
            "--map-root-user",
            "--mount",
            "sh",
            "-c",
            script,
            "sh",
        ])
        .arg(kilobytes.to_string())
        .arg(&disk)
        .arg(from)
        .arg(to)
        .arg(ACERRA)
        .args(arguments)
        .output()
        .ok()?;
    // 1 is also the answer of a refused unshare, which leaves nothing.
    to.join("left").exists().then_some(output)
}

#[test]
fn a_recording_on_a_disk_that_fills_is_recovered() {
    let [scans, full, skipped] = [const { AtomicU64::new(0) }; 3];
    each(|k| {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let (_emulator, session) = instruments(folder, 8.0);
        let flight = folder.join("disk").join("flight");
        let empty = folder.join("empty");
        fs::create_dir(&empty).unwrap();
        let kilobytes = 32 + (2_000.0 * share(k)) as u64;
        let arguments = recording(k, &session, &flight);
        let Some(output) = on_a_disk(kilobytes, &empty, folder, &arguments) else {
            println!("skipped: no file system can be mounted here (unshare, tmpfs)");
            skipped.fetch_add(1, Ordering::SeqCst);
            return;
        };
        let told = text(&output.stderr);
        let label = format!("{kilobytes} kB, {}: {told}", arguments[0]);
        // Emulated instruments that a busy machine delays may send less than the disk holds.
        if !output.status.success() {
            assert_eq!(output.status.code(), Some(1), "{label}");
            assert!(told.contains("the disk is full"), "{label}");
            full.fetch_add(1, Ordering::SeqCst);
        }
        let found = check_recovered(&label, &folder.join("left").join("flight"));
        scans.fetch_add(found, Ordering::SeqCst);
    });
    let (full, skipped) = (full.into_inner(), skipped.into_inner());
    assert!(full > 0 || skipped > 0, "no disk was full");
    println!("{} scans recovered", scans.into_inner());
}

#[test]
fn files_are_whole_or_absent_where_the_disk_fills_while_finishing() {
    let folder = tempfile::tempdir().unwrap();
    let flight = recorded(folder.path());
    let output = finishing(&flight).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let whole = made(&flight);
    let bytes: usize = whole.iter().flatten().map(Vec::len).sum();
    let log_bytes = fs::metadata(flight.join(LOG_NAME)).unwrap().len();
    let refused = AtomicU64::new(0);
    each(|k| {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let copy = copy_of_log(&flight, folder);
        // From no space at all to more than the files take.
        let kilobytes = (log_bytes + (1.1 * bytes as f64 * share(k)) as u64) / 1024 + 32;
        let disk = folder.join("disk").display().to_string();
        let arguments = ["record", "--finish", &disk, "--mcap"].map(str::to_owned);
        let Some(output) = on_a_disk(kilobytes, &copy, folder, &arguments) else {
            println!("skipped: no file system can be mounted here (unshare, tmpfs)");
            return;
        };
        let label = format!("{kilobytes} kB: {}", text(&output.stderr));
        let left = folder.join("left");
        check_whole_or_absent(&label, &left, &whole);
        if output.status.success() {
            assert!(made(&left) == whole, "{label}");
        } else {
            assert_eq!(output.status.code(), Some(1), "{label}");
            refused.fetch_add(1, Ordering::SeqCst);
            assert_eq!(in_log(&left), in_log(&flight), "{label}");
            let again = finishing(&left).output().unwrap();
            assert!(again.status.success() && made(&left) == whole, "{label}");
        }
    });
    println!("{} disks were full", refused.into_inner());
}
