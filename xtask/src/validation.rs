//! The slow checks: RTKLIB parity, the engine's accuracy at full size, the validation book.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

use crate::runner::{Runner, Step};

/// How the name of a slow check begins.
const MARK: &str = "fn validation_";

/// Runs every test whose name begins with `validation_`, as the suite builds them: its profile optimises
/// whatever takes time, so that nothing is built twice. Only the programs that hold one are run.
pub fn run(runner: &Runner) -> anyhow::Result<()> {
    let programs = programs(&runner.root)?;
    ensure!(!programs.is_empty(), "no test begins with `{MARK}`");
    let mut command = vec!["cargo", "test", "--workspace", "--locked"];
    for program in &programs {
        command.extend(["--test", program]);
    }
    command.extend(["--", "--ignored", "validation_"]);
    runner.run(&Step::new("validation", &command))
}

/// The integration tests that hold slow checks, by name.
fn programs(root: &Path) -> anyhow::Result<Vec<String>> {
    let mut names = Vec::new();
    for package in entries(&root.join("crates"))? {
        let tests = package.join("tests");
        if !tests.is_dir() {
            continue;
        }
        for test in entries(&tests)? {
            let is_program =
                test.extension().is_some_and(|e| e == "rs") || test.join("main.rs").is_file();
            if is_program && holds_check(&test)? {
                let name = test.file_stem().context("a test without a name")?;
                names.push(name.to_string_lossy().into_owned());
            }
        }
    }
    names.sort();
    names.dedup();
    Ok(names)
}

/// Whether a source, or one of a folder's, holds a slow check.
fn holds_check(place: &Path) -> anyhow::Result<bool> {
    if place.is_dir() {
        for entry in entries(place)? {
            if holds_check(&entry)? {
                return Ok(true);
            }
        }
        return Ok(false);
    }
    let is_source = place.extension().is_some_and(|e| e == "rs");
    Ok(is_source && fs::read_to_string(place)?.contains(MARK))
}

fn entries(directory: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let read = fs::read_dir(directory).with_context(|| directory.display().to_string())?;
    read.map(|entry| Ok(entry?.path())).collect()
}
