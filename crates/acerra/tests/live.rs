//! `acerra emulate`, `live` and `focus` as a user runs them: the recording is whole, the final image is that of
//! `focus`, a recorded session is replayed.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

/// A short flight with receivers, recorded from take-off to landing.
const SCENE: &str = "seed = 3\nrecord = \"flight\"\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n[gnss]\n\
    [[corner]]\nposition_m = [3, 1.5, 0]\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n";

fn acerra() -> Command {
    Command::new(env!("CARGO_BIN_EXE_acerra"))
}

fn run(arguments: &[&str]) -> Output {
    acerra().args(arguments).output().unwrap()
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

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// An emulator of the scene, and the session file that it writes.
fn emulated(folder: &Path) -> (Running, String) {
    let radio = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr();
    let receiver = TcpListener::bind("127.0.0.1:0").unwrap().local_addr();
    let [radio, receiver] = [radio, receiver].map(|address| address.unwrap().to_string());
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let mut emulator = Running(
        acerra()
            .args(["emulate", &path(folder, "scene.toml")])
            .args(["-o", &path(folder, "ground"), "--solutions", "fixed"])
            .args(["--radio", &radio, "--receiver", &receiver])
            .args(["--speed", "4", "--drift-ppm", "20", "--loss", "0.002"])
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
    (emulator, session)
}

#[test]
fn a_flight_is_recorded_and_its_final_image_is_that_of_focus() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (emulator, session) = emulated(folder);
    let session = session.replace("[flight]\n", "[flight]\nstop_after_s = 11.0\n");
    fs::write(folder.join("session.toml"), session).unwrap();
    let flight = path(folder, "flight");
    let session = path(folder, "session.toml");
    let live = run(&["live", &session, "-o", &flight, "--no-open", "--quit"]);
    drop(emulator);
    let told = [&live.stdout, &live.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    println!("{}\n{}", told[0], told[1]);
    assert!(live.status.success());
    assert!(told[0].starts_with("http://127.0.0.1:"));

    let campaign = path(Path::new(&flight), "campaign.toml");
    let again = path(folder, "again");
    let focused = run(&["focus", &campaign, "-o", &again]);
    assert!(focused.status.success());
    let image = |products: &Path| fs::read(products.join("image.npz")).unwrap();
    let own = image(&Path::new(&flight).join("campaign-products"));
    assert!(
        own == image(Path::new(&again)),
        "the final image is that of focus"
    );

    // The recorded session once more; its campaign is left as it stands.
    let changed = fs::read_to_string(&campaign).unwrap() + "\n# worked on since\n";
    fs::write(&campaign, &changed).unwrap();
    let replayed = run(&[
        "live",
        &flight,
        "--no-open",
        "--no-final",
        "--quit",
        "--speed",
        "10",
    ]);
    assert!(replayed.status.success(), "{replayed:?}");
    assert_eq!(fs::read_to_string(&campaign).unwrap(), changed);
}

#[test]
fn what_cannot_be_watched_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(
        folder.join("session.toml"),
        "[radio]\naddress = \"127.0.0.1:9\"\n[live]\npixels = 3\n",
    )
    .unwrap();
    fs::create_dir(folder.join("empty")).unwrap();
    let (session, empty) = (path(folder, "session.toml"), path(folder, "empty"));
    for (arguments, expected) in [
        (
            vec!["live", &session, "-o", &empty],
            "unknown field `pixels`",
        ),
        (vec!["live", &session], "expected -o DIR"),
        (vec!["live", &empty, "-o", "x"], "expected no -o"),
        (vec!["live", &empty], "session.log"),
    ] {
        let refused = run(&arguments);
        let told = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(1), "{arguments:?}: {told}");
        assert!(told.contains(expected), "{arguments:?}: {told}");
    }
}
