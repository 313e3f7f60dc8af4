//! Tests of the viewer in a browser, where node, the packages and Chromium can be had.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;

use crate::runner::{Runner, Step};

/// Files of `browser/`: they run from a separate folder, next to the packages that they need.
const FILES: [&str; 18] = [
    "package.json",
    "package-lock.json",
    "tsconfig.json",
    "access.mjs",
    "harness.mjs",
    "look.mjs",
    "npz.mjs",
    "synthetic.mjs",
    "view.test.mjs",
    "flight.test.mjs",
    "volume.test.mjs",
    "terrain.test.mjs",
    "basemap.test.mjs",
    "report.test.mjs",
    "live.test.mjs",
    "live-flight.mjs",
    "live-bench.mjs",
    "bench.mjs",
];

/// Those of them that test.
const TESTS: [&str; 7] = [
    "view.test.mjs",
    "flight.test.mjs",
    "volume.test.mjs",
    "terrain.test.mjs",
    "basemap.test.mjs",
    "report.test.mjs",
    "live.test.mjs",
];

/// The programs that may be Chromium.
const CHROMIUM: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Checks the types of the page's modules and tests the viewer and the reports; each that cannot run is
/// named and skipped.
pub fn test(runner: &Runner) -> anyhow::Result<()> {
    let Some(place) = packages(runner)? else {
        return Ok(());
    };
    let compiler = place.join("node_modules/.bin/tsc").display().to_string();
    for project in ["crates/acerra-view/web", &place.display().to_string()] {
        let check = [compiler.as_str(), "-p", project];
        runner.run(&Step::new("types of the page", &check))?;
    }
    if !CHROMIUM
        .iter()
        .any(|name| runner.succeeds(&[name, "--version"]))
    {
        runner.skip("browser tests", "no Chromium is installed here");
        return Ok(());
    }
    // The Rust suite leaves the program behind: a separate build would have other features.
    let build = "cargo test --workspace --locked --no-run";
    let options = ["--test", "--test-concurrency=1"];
    node(runner, &place, (build, "debug"), (&options, &TESTS))
}

/// Measures the viewer in the browser.
pub fn bench(runner: &Runner) -> anyhow::Result<()> {
    match packages(runner)? {
        Some(place) => {
            let build = "cargo build --release --locked -p acerra";
            for script in ["live-bench.mjs", "bench.mjs"] {
                node(runner, &place, (build, "release"), (&[], &[script]))?;
            }
            Ok(())
        }
        None => Ok(()),
    }
}

/// Builds the program, into a folder of the target directory, and runs scripts of `browser/` with it.
fn node(
    runner: &Runner,
    place: &Path,
    (build, folder): (&str, &str),
    (options, scripts): (&[&str], &[&str]),
) -> anyhow::Result<()> {
    let build: Vec<&str> = build.split_whitespace().collect();
    runner.run(&Step::new("the program for the browser", &build))?;
    let scripts: Vec<String> = scripts
        .iter()
        .map(|script| place.join(script).display().to_string())
        .collect();
    let mut command = vec!["node"];
    command.extend(options);
    command.extend(scripts.iter().map(String::as_str));
    let program = runner.target().join(folder).join("acerra");
    let program = program.display().to_string();
    let shots = runner.target().join("browser-shots").display().to_string();
    // The first script makes the demonstration's runs, which all others use.
    let demo = runner.target().join("browser-demo");
    if demo.exists() {
        fs::remove_dir_all(&demo).with_context(|| demo.display().to_string())?;
    }
    runner.run(
        &Step::new("browser", &command)
            .with("ACERRA", program)
            .with("ACERRA_DEMO", demo.display().to_string())
            .with("ACERRA_SHOTS", shots),
    )
}

/// The folder of `browser/`'s files and packages; none, with a message of the reason, where they are not
/// available.
fn packages(runner: &Runner) -> anyhow::Result<Option<PathBuf>> {
    if !runner.succeeds(&["node", "--version"]) || !runner.succeeds(&["npm", "--version"]) {
        runner.skip("browser tests", "node and npm are not installed here");
        return Ok(None);
    }
    let place = runner.target().join("browser");
    fs::create_dir_all(&place).with_context(|| place.display().to_string())?;
    for name in FILES {
        let from = runner.root.join("browser").join(name);
        fs::copy(&from, place.join(name)).with_context(|| from.display().to_string())?;
    }
    let install = Command::new("npm")
        .args(["ci", "--no-audit", "--no-fund"])
        .current_dir(&place)
        .output()
        .context("npm")?;
    if install.status.success() {
        return Ok(Some(place));
    }
    let reason = String::from_utf8_lossy(&install.stderr);
    runner.skip(
        "browser tests",
        &format!("the packages cannot be installed here\n{reason}"),
    );
    Ok(None)
}
