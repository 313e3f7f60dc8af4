//! What a change must pass.

use std::path::Path;

use anyhow::ensure;
use xtask::house::House;
use xtask::lines::Lines;

use crate::browser;
use crate::python;
use crate::release;
use crate::runner::{Runner, Step, TEST};
use crate::validation;

/// Seconds that CI gives each fuzz target.
const FUZZ_SECONDS: &str = "8";

/// All tests: the Rust suite, then the Python package, then the viewer in a browser.
pub fn test(runner: &Runner) -> anyhow::Result<()> {
    runner.run(&Step::new("tests", &TEST))?;
    python::test(runner)?;
    browser::test(runner)
}

/// Everything, in the order in which it fails fastest.
pub fn ci(runner: &Runner) -> anyhow::Result<()> {
    runner.run(&Step::new(
        "formatting",
        &["cargo", "fmt", "--all", "--", "--check"],
    ))?;
    let clippy = "cargo clippy --workspace --all-targets --locked -- -D warnings";
    runner.run(&Step::new("lints", &words(clippy)))?;
    let doc = "cargo doc --workspace --no-deps --locked";
    runner.run(&Step::new("documentation", &words(doc)).with("RUSTDOCFLAGS", "-D warnings"))?;
    licences(runner)?;
    minimum_rust(runner)?;
    other_systems(runner)?;
    release::package(runner)?;
    release::workflows(runner)?;
    test(runner)?;
    validation::run(runner)?;
    let seed = std::env::var("FUZZ_SEED").unwrap_or_else(|_| "1".to_owned());
    let seconds = std::env::var("FUZZ_SECONDS").unwrap_or_else(|_| FUZZ_SECONDS.to_owned());
    let fuzz = ["bash", "fuzz/run.sh", &seconds];
    runner.run(&Step::new("fuzzing, bounded", &fuzz).with("FUZZ_SEED", seed))?;
    runner.print_skipped();
    Ok(())
}

/// Licences and sources of every dependency, and advisories where the database can be had.
fn licences(runner: &Runner) -> anyhow::Result<()> {
    if !runner.succeeds(&["cargo", "deny", "--version"]) {
        runner.skip("licences", "cargo-deny is not installed here");
        return Ok(());
    }
    let check = "cargo deny --workspace check bans licenses sources";
    runner.run(&Step::new("licences and sources", &words(check)))?;
    if runner.succeeds(&["cargo", "deny", "fetch", "db"]) {
        let check = "cargo deny --workspace check advisories";
        runner.run(&Step::new("advisories", &words(check)))
    } else {
        runner.skip("advisories", "the database cannot be fetched here");
        Ok(())
    }
}

/// Builds with the oldest Rust that Cargo.toml declares, where that toolchain is installed.
fn minimum_rust(runner: &Runner) -> anyhow::Result<()> {
    const MINIMUM: &str = "1.90";
    let toolchain = format!("+{MINIMUM}");
    if runner.succeeds(&["cargo", &toolchain, "--version"]) {
        let build = ["cargo", &toolchain, "check", "--workspace", "--locked"];
        return runner.run(&Step::new("minimum Rust", &build));
    }
    let reason = format!(
        "toolchain {MINIMUM} is not installed here, clippy's incompatible_msrv has checked the \
         standard library's items"
    );
    runner.skip("minimum Rust", &reason);
    Ok(())
}

/// Systems other than this one that run the command: small computers that record, Windows and macOS.
const OTHER_SYSTEMS: [&str; 3] = [
    "aarch64-unknown-linux-musl",
    "x86_64-pc-windows-msvc",
    "aarch64-apple-darwin",
];

/// Checks the command for every other system whose standard library is installed.
fn other_systems(runner: &Runner) -> anyhow::Result<()> {
    let installed = std::process::Command::new("rustup")
        .args(["target", "list", "--installed"])
        .output()
        .map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
        .unwrap_or_default();
    for target in OTHER_SYSTEMS {
        if installed.lines().any(|line| line == target) {
            let check = format!("cargo check --package acerra --locked --target {target}");
            runner.run(&Step::new("another system", &words(&check)))?;
        } else {
            let reason = format!("not installed here (rustup target add {target})");
            runner.skip(target, &reason);
        }
    }
    Ok(())
}

/// Writes the validation book again: every table and picture of docs/validation.
pub fn book(runner: &Runner) -> anyhow::Result<()> {
    let pages = runner.root.join("docs/validation").display().to_string();
    let write = "cargo test --release --locked -p acerra -p acerra-gnss -p acerra-invert -- --ignored \
                 validation_book validation_ppk";
    runner.run(&Step::new("validation book", &words(write)).with("ACERRA_DOCS", pages))
}

/// Simulates and processes what the test program `test` of the command draws by seeds, and writes the program's page of
/// the book: minutes, so that only a quick draw is part of the suite.
pub fn drawn(runner: &Runner, test: &str) -> anyhow::Result<()> {
    let pages = runner.root.join("docs/validation").display().to_string();
    let mut write = TEST.to_vec();
    write.extend(["--test", test, "--", "--ignored", "--nocapture"]);
    runner.run(&Step::new("random logs", &write).with("ACERRA_DOCS", pages))
}

/// Tries every wrong setting, and writes its page of the book: half an hour, so that it is no part of [`ci`].
pub fn wrong_settings(runner: &Runner) -> anyhow::Result<()> {
    let pages = runner.root.join("docs/validation").display().to_string();
    let write = "cargo test --release --locked -p acerra --test wrong_settings -- --ignored";
    runner.run(&Step::new("wrong settings", &words(write)).with("ACERRA_DOCS", pages))
}

/// Prints the faults of the workspace, or of the checkout in `directory`, and the order of folders.
pub fn house(runner: &Runner, directory: Option<&str>) -> anyhow::Result<()> {
    let root = directory.map_or(runner.root.as_path(), Path::new);
    let house = House::read(root)?;
    let faults = house.faults();
    for fault in &faults {
        println!("{fault}");
    }
    ensure!(faults.is_empty(), "{} faults", faults.len());
    println!(
        "{} files, {} imports, no circle",
        house.files(),
        house.imports()
    );
    for (name, folders) in house.folders() {
        println!("{name}: {}", folders.join(" > "));
    }
    Ok(())
}

/// Prints the lines of code, documentation and tests of each crate's `src`.
pub fn lines(runner: &Runner, directory: Option<&str>) -> anyhow::Result<()> {
    let root = directory.map_or(runner.root.as_path(), Path::new);
    print!("{}", Lines::of_crates(root)?);
    Ok(())
}

fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}
