//! What a run leaves behind when it is interrupted, killed, or meets a disk, a path or a limit that
//! it did not expect.
#![cfg(unix)]
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // what is skipped is said

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const ACERRA: &str = env!("CARGO_BIN_EXE_acerra");

const SCENE: &str = "seed = 3\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n\
    [[corner]]\nposition_m = [3, 1.5, 0]\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n";

/// A simulated campaign in `folder`; returns its file.
fn campaign(folder: &Path) -> PathBuf {
    let scene = folder.join("scene.toml");
    fs::write(&scene, SCENE).unwrap();
    let logs = folder.join("logs");
    let output = Command::new(ACERRA)
        .arg("simulate")
        .arg(&scene)
        .arg("-o")
        .arg(&logs)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    logs.join("campaign.toml")
}

/// The same campaign with an image that takes a while.
fn long_campaign(campaign: &Path) -> PathBuf {
    let text = fs::read_to_string(campaign).unwrap();
    let long = text
        .lines()
        .map(|line| match line.split_once(" =") {
            Some(("x_m" | "y_m", _)) => format!("{} = [-8, 8]", &line[..3]),
            Some(("pixel_m", _)) => "pixel_m = 0.0035".to_owned(),
            _ => line.to_owned(),
        })
        .collect::<Vec<_>>()
        .join("\n");
    assert!(
        long.contains("[-8, 8]") && long.contains("0.0035"),
        "{long}"
    );
    let file = campaign.with_file_name("long.toml");
    fs::write(&file, long).unwrap();
    file
}

fn focus(campaign: &Path, products: &Path) -> Output {
    Command::new(ACERRA)
        .arg("focus")
        .arg(campaign)
        .arg("-o")
        .arg(products)
        .output()
        .unwrap()
}

/// Starts a run and waits until it writes aside in `products`.
fn started(campaign: &Path, products: &Path) -> Child {
    let mut child = Command::new(ACERRA)
        .arg("focus")
        .arg(campaign)
        .arg("-o")
        .arg(products)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for(&mut child, || !hidden(products).is_empty());
    child
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill")
        .args([format!("-{signal}"), child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
}

/// Whether this process ignores a signal, which its children then do too (Linux).
fn is_ignored_here(number: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (number - 1) & 1 == 1)
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

fn hidden(folder: &Path) -> Vec<String> {
    let mut names = names(folder);
    names.retain(|name| name.starts_with('.'));
    names
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn signals_end_a_run_in_order_and_leave_older_products() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let products = folder.path().join("products");
    assert!(focus(&campaign, &products).status.success());
    let (before, run) = (
        names(&products),
        fs::read(products.join("run.json")).unwrap(),
    );
    let long = long_campaign(&campaign);
    for (signal, number) in [("INT", 2), ("TERM", 15), ("HUP", 1)] {
        if is_ignored_here(number) {
            println!(
                "skipped: SIG{signal} is ignored where the tests run (nohup), and so by what they start"
            );
            continue;
        }
        let child = started(&long, &products);
        send(signal, &child);
        let output = child.wait_with_output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(128 + number), "{message}");
        assert!(
            message.contains(&format!("interrupted by SIG{signal}")),
            "{message}"
        );
        assert_eq!(names(&products), before);
        assert_eq!(fs::read(products.join("run.json")).unwrap(), run);
    }
}

/// Waits until `is_there` says so, while the child runs.
fn wait_for(child: &mut Child, is_there: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_there() {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing begins");
        assert!(child.try_wait().unwrap().is_none(), "over before it began");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn directories_made_on_the_way_go_with_an_interrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let long = long_campaign(&campaign(folder.path()));
    let made = folder.path().join("made");
    let mut child = Command::new(ACERRA)
        .arg("focus")
        .arg(&long)
        .arg("-o")
        .arg(made.join("deep/products"))
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let deep = made.join("deep");
    wait_for(&mut child, || deep.is_dir() && !hidden(&deep).is_empty());
    send("TERM", &child);
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert!(!made.exists());
}

#[test]
#[cfg(target_os = "linux")]
fn a_hang_up_that_is_to_be_ignored_is_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let products = folder.path().join("products");
    fs::create_dir(&products).unwrap();
    let script = "trap '' HUP; exec \"$1\" focus \"$2\" -o \"$3\"";
    let mut child = Command::new("sh")
        .args(["-c", script, "sh", ACERRA])
        .args([&campaign, &products])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_for(&mut child, || !hidden(&products).is_empty());
    send("HUP", &child);
    assert!(child.wait().unwrap().success());
    assert!(products.join("run.json").is_file());
}

#[test]
fn what_a_killed_run_leaves_is_removed_by_the_next_and_a_living_one_s_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let products = folder.path().join("products");
    assert!(focus(&campaign, &products).status.success());
    let before = names(&products);
    let long = long_campaign(&campaign);
    let mut killed = started(&long, &products);
    send("KILL", &killed);
    killed.wait().unwrap();
    assert_eq!(hidden(&products).len(), 1);
    assert!(focus(&campaign, &products).status.success());
    assert_eq!(names(&products), before);

    let living = started(&long, &products);
    let aside = hidden(&products);
    // Stopped, it lives on while another run comes and goes.
    send("STOP", &living);
    assert!(focus(&campaign, &products).status.success());
    assert_eq!(hidden(&products), aside);
    send("CONT", &living);
    send("TERM", &living);
    living.wait_with_output().unwrap();
    assert_eq!(names(&products), before);
}

#[test]
fn products_that_a_newer_run_does_not_make_go() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let products = folder.path().join("products");
    let looks = campaign.with_file_name("looks.toml");
    fs::write(
        &looks,
        fs::read_to_string(&campaign)
            .unwrap()
            .replace("[image]\n", "[image]\nlooks = 2\n"),
    )
    .unwrap();
    assert!(focus(&looks, &products).status.success());
    assert!(products.join("looks.npz").is_file() && products.join("multilook.png").is_file());
    for name in names(&products) {
        let known = acerra_products::names::PRODUCTS.contains(&name.as_str());
        assert!(known, "{name} is missing in the list of products");
    }
    fs::write(products.join("notes.txt"), "mine").unwrap();
    fs::write(products.join("volume.png"), "mine").unwrap();
    assert!(focus(&campaign, &products).status.success());
    assert!(!products.join("looks.npz").exists() && !products.join("multilook.png").exists());
    assert!(products.join("notes.txt").is_file() && products.join("volume.png").is_file());
}

/// Runs `focus` with `products` on a small file system of its own; its output ends with what lies
/// there afterwards. None where that cannot be mounted.
fn on_own_file_system(campaign: &Path, products: &Path, options: &str) -> Option<(Output, String)> {
    fs::create_dir_all(products).unwrap();
    let script = "mount -t tmpfs -o \"$1\" tmpfs \"$2\" || exit 99\n\
                  case \"$1\" in *ro*) ;; *) echo old > \"$2/image.png\" ;; esac\n\
                  \"$3\" -q focus \"$4\" -o \"$2\"\ncode=$?\nls -A \"$2\"\nexit $code";
    let output = Command::new("unshare")
        .args(["-r", "-m", "sh", "-c", script, "sh", options])
        .args([products, Path::new(ACERRA), campaign])
        .output();
    match output {
        Ok(output)
            if output.status.code() != Some(99) && !text(&output.stderr).contains("unshare") =>
        {
            let left = text(&output.stdout);
            Some((output, left))
        }
        _ => {
            println!("skipped: no file system can be mounted here");
            None
        }
    }
}

#[test]
fn products_go_to_a_mount_point() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let mounted = folder.path().join("mounted");
    let Some((output, left)) = on_own_file_system(&campaign, &mounted, "size=64m") else {
        return;
    };
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        left.contains("run.json") && !left.contains(".acerra"),
        "{left}"
    );
}

#[test]
fn a_full_disk_is_said_and_older_products_stay() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let mounted = folder.path().join("mounted");
    let Some((output, left)) = on_own_file_system(&campaign, &mounted, "size=200k") else {
        return;
    };
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("No space left on device"), "{message}");
    assert_eq!(left, "image.png\n");
}

#[test]
fn a_read_only_directory_is_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let mounted = folder.path().join("mounted");
    let Some((output, left)) = on_own_file_system(&campaign, &mounted, "ro") else {
        return;
    };
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("mounted: cannot write here"), "{message}");
    assert_eq!(left, "");
}

#[test]
fn odd_paths_are_paths() {
    let folder = tempfile::tempdir().unwrap();
    for name in [&b"caf\xe9"[..], b"two words", b"line\nbreak", b"-dash"] {
        let odd = folder.path().join(OsStr::from_bytes(name));
        fs::create_dir(&odd).unwrap();
        let campaign = campaign(&odd);
        let products = odd.join("products");
        let output = focus(&campaign, &products);
        assert!(
            output.status.success(),
            "{name:?}: {}",
            text(&output.stderr)
        );
        let run = fs::read(products.join("run.json")).unwrap();
        let run: serde_json::Value = serde_json::from_slice(&run).unwrap();
        let file = run["inputs"][0]["path"].as_str().unwrap();
        assert!(file.ends_with("campaign.toml"), "{file}");
    }
}

#[test]
fn an_input_is_not_overwritten_by_a_product() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let logs = campaign.parent().unwrap();
    let trajectory = fs::read(logs.join("trajectory.csv")).unwrap();
    let output = focus(&campaign, logs);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("trajectory.csv: is an input and would be overwritten"),
        "{message}"
    );
    assert_eq!(fs::read(logs.join("trajectory.csv")).unwrap(), trajectory);
}

#[test]
fn a_limit_on_memory_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let long = long_campaign(&campaign);
    let products = folder.path().join("products");
    // 82 MB of pixels do not fit into what the process has left of its address space.
    let script = "ulimit -v \"$1\" && exec \"$2\" focus \"$3\" -o \"$4\"";
    let output = Command::new("sh")
        .args(["-c", script, "sh", "140000", ACERRA])
        .args([&long, &products])
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("MB of memory") && message.contains("pixel_m = "),
        "{message}"
    );
    assert!(!products.exists());
}
