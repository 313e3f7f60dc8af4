//! A flight over one target, its run, and a server that shows it.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{Read, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use acerra_chain::{Control, Journal};
use acerra_products::run_campaign;
use acerra_radar::{NeutralContent, Radargram, Samples, npz::write_npz};
use acerra_view::{Server, ServerOptions};
use serde_json::Value;

pub const LIGHT_M_S: f64 = 299_792_458.0;
pub const TARGET_M: [f64; 3] = [5.0, 4.0, 0.0];
pub const TRACES: usize = 120;
pub const SAMPLES: usize = 960;
pub const STEP_S: f64 = 61.035e-12;
const INTERVAL_S: f64 = 0.02;

pub fn place(trace: usize) -> [f64; 3] {
    [
        0.2 * (0.05 * trace as f64).sin(),
        0.04 * trace as f64 + 1.6,
        5.0,
    ]
}

/// Echoes of a target: Gaussian pulses about 3.95 GHz.
fn radargram() -> Radargram {
    let echo = |trace: usize| {
        let away = place(trace)
            .iter()
            .zip(TARGET_M)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>();
        let range_m = away.sqrt();
        move |n: usize| {
            let t = n as f64 * STEP_S - 2.0 * range_m / LIGHT_M_S;
            (1e3 * (-(t / 0.4e-9).powi(2)).exp() * (TAU * 3.95e9 * t).cos()) as f32
        }
    };
    let samples = (0..TRACES)
        .flat_map(|trace| (0..SAMPLES).map(echo(trace)))
        .collect();
    let time_s = (0..TRACES).map(|k| INTERVAL_S * k as f64).collect();
    Radargram::new(time_s, 0.0, STEP_S, Samples::Real(samples)).unwrap()
}

/// Sides and heights of the image on which the target stands in the middle.
const PLANE: &str = "x_m = [3.5, 6.5]\ny_m = [2.5, 5.5]\nz_m = 0.0\npixel_m = 0.01\n";

/// Flies, and leaves a run in `folder`/products.
pub fn run_in(folder: &Path) -> PathBuf {
    run_with(folder, PLANE)
}

/// Flies, and leaves a run of an image of these sides and heights in `folder`/products.
pub fn run_with(folder: &Path, image: &str) -> PathBuf {
    let log = File::create(folder.join("flight.npz")).unwrap();
    write_npz(log, &NeutralContent::Radargram(radargram()), None).unwrap();
    let mut csv = "# origin_deg_m: 40.9596 14.3696 75.0\n\
                   # second_zero_gps_week_tow_s: 2400 302400.25\n\
                   time_s,x_m,y_m,z_m\n"
        .to_owned();
    for k in 0..TRACES {
        let [x, y, z] = place(k);
        writeln!(csv, "{},{x},{y},{z}", INTERVAL_S * k as f64).unwrap();
    }
    fs::write(folder.join("flight.csv"), csv).unwrap();
    let campaign = format!(
        "[radar]\nfile = 'flight.npz'\ndelay_ns = 0.0\nselect = 'all'\n\
         [trajectory]\nfile = 'flight.csv'\ntime_offset_s = 0.0\n\
         [preprocess]\nbackground = 'none'\ngate_ns = 'none'\n\
         [image]\n{image}\
         weight = 'trace'\n[checks]\ncontradictions = 'warn'\n[products]\nformats = []\n"
    );
    let file = folder.join("flight.toml");
    fs::write(&file, campaign).unwrap();
    let products = folder.join("products");
    run_campaign(
        &file,
        &products,
        &mut Journal::default(),
        &Control::default(),
    )
    .unwrap();
    products
}

/// The folder of a flight whose run all tests share that change nothing of it.
pub fn shared() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("view-run");
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        run_in(&folder);
        folder
    })
}

/// A server, stopped when it goes out of scope.
pub struct Serving {
    /// `127.0.0.1:PORT`.
    pub host: String,
    /// `/TOKEN`.
    pub base: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// An answer.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Pairs of single-precision numbers.
    pub fn pairs(&self) -> Vec<[f32; 2]> {
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let pairs = self.body.chunks_exact(8);
        pairs.map(|b| [number(b), number(&b[4..])]).collect()
    }
}

impl Serving {
    pub fn start(directories: Vec<PathBuf>) -> Self {
        let server = Server::open(&ServerOptions {
            directories,
            ..ServerOptions::default()
        })
        .unwrap();
        let rest = server.address().strip_prefix("http://").unwrap().to_owned();
        let (host, token) = rest.split_once('/').unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            server.run(move || flag.load(Ordering::Relaxed)).unwrap();
        });
        Self {
            host: host.to_owned(),
            base: format!("/{}", token.trim_end_matches('/')),
            stop,
            thread: Some(thread),
        }
    }

    /// Sends a request as it stands, and reads the answer.
    pub fn send(&self, request: &str) -> Answer {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(60)))
            .unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        Answer {
            status: head.split(' ').nth(1).unwrap().parse().unwrap(),
            head,
            body: bytes[end + 4..].to_vec(),
        }
    }

    pub fn get(&self, path: &str) -> Answer {
        let (base, host) = (&self.base, &self.host);
        self.send(&format!(
            "GET {base}{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
        ))
    }

    pub fn post(&self, path: &str, body: &str) -> Answer {
        let (base, host, length) = (&self.base, &self.host, body.len());
        self.send(&format!(
            "POST {base}{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\
             Content-Type: application/json\r\nContent-Length: {length}\r\n\r\n{body}"
        ))
    }

    /// Waits until the logs of run 0 are read.
    pub fn engine(&self) -> Value {
        let start = Instant::now();
        loop {
            let status = self.get("/api/run/0/engine").json();
            if status["state"] == "ready" || status["state"] == "failed" {
                return status;
            }
            assert!(start.elapsed() < Duration::from_secs(120), "{status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
