//! The slow checks: RTKLIB parity, the engine's accuracy at full size, the validation book.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::{Context, ensure};

use crate::runner::{Runner, Step, TEST};

/// How the name of a slow check begins.
const MARK: &str = "fn validation_";

/// The programs that run longest: started first, so that none of them runs alone at the end.
const LONGEST: [&str; 4] = ["calibrate", "validation_book", "demo", "hostile"];

/// Programs that run at once: most leave a part of two processors idle.
const AT_ONCE: usize = 2;

/// Runs every test whose name begins with `validation_`, as the suite builds them: its profile optimises slow
/// code, so that no crate is built twice. Only the programs with such a test are run.
pub fn run(runner: &Runner) -> anyhow::Result<()> {
    let programs = programs(&runner.root)?;
    ensure!(!programs.is_empty(), "no test begins with `{MARK}`");
    let mut build = TEST.to_vec();
    build.extend(["--quiet", "--no-run"]);
    runner.run(&Step::new("programs of the validation", &build))?;
    println!("\n== validation: {}", programs.join(", "));
    let waiting = Mutex::new(programs.iter());
    let next = || waiting.lock().ok()?.next();
    let work = || -> anyhow::Result<()> {
        while let Some(program) = next() {
            let mut command = TEST.to_vec();
            command.extend(["--test", program, "--", "--ignored", "validation_"]);
            runner.run_quietly(&Step::new(program, &command))?;
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..AT_ONCE).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| {
            worker
                .join()
                .unwrap_or_else(|_| anyhow::bail!("a worker ended early"))
        })
    })
}

/// The integration tests that hold slow checks, by name, the longest first.
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
    let rank = |name: &String| LONGEST.iter().position(|long| long == name);
    names.sort_by_key(|name| (rank(name).unwrap_or(LONGEST.len()), name.clone()));
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
