//! Content of a release: every crate as crates.io accepts it.

use std::path::Path;

use anyhow::{Context, ensure};

use crate::runner::{Runner, Step};

/// Most bytes that crates.io takes of a crate.
const MOST_BYTES: u64 = 10_000_000;

/// Packages every crate that is published, in the order of their dependencies, and measures it.
///
/// No compilation: the tests have compiled the same files. A dependency without a version, a missing readme
/// or a file outside the crate that its manifest names fails here.
pub fn package(runner: &Runner) -> anyhow::Result<()> {
    let folder = runner.target().join("package");
    // Crates of an older version are not measured.
    let _ = std::fs::remove_dir_all(&folder);
    let package = "cargo package --workspace --exclude acerra-python --exclude xtask --no-verify --locked \
                   --allow-dirty --quiet";
    let package: Vec<&str> = package.split_whitespace().collect();
    runner.run(&Step::new("crates to publish", &package))?;
    let crates = sizes(&folder)?;
    for (name, bytes) in &crates {
        ensure!(
            *bytes <= MOST_BYTES,
            "{name}: expected at most {MOST_BYTES} bytes, found {bytes}"
        );
    }
    let members = std::fs::read_dir(runner.root.join("crates"))?.count();
    // All but the Python package, which is published as a wheel.
    ensure!(
        crates.len() + 1 == members,
        "expected {} crates, found {}",
        members - 1,
        crates.len()
    );
    let (name, bytes) = crates
        .iter()
        .max_by_key(|(_, bytes)| *bytes)
        .context("a crate")?;
    println!(
        "{} crates, the largest {name} with {bytes} bytes",
        crates.len()
    );
    Ok(())
}

/// Names and sizes (bytes) of the packaged crates in a folder.
fn sizes(folder: &Path) -> anyhow::Result<Vec<(String, u64)>> {
    let mut crates = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".crate") {
            crates.push((name, entry.metadata()?.len()));
        }
    }
    Ok(crates)
}
