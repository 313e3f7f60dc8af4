//! Tests of the Python package, where Python and the packages can be had.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;

use crate::runner::{Runner, Step};

/// Where the package stands.
const PACKAGE: &str = "crates/acerra-python";

/// Packages that its tests need in addition.
const PACKAGES: &str = "maturin numpy xarray pandas scipy matplotlib pylops pytest hypothesis mypy \
                        pandas-stubs scipy-stubs types-tqdm h5py segyio scikit-rf readgssi dask[distributed] zarr moto[server] \
                        obstore nbclient nbformat ipykernel netCDF4 h5netcdf tqdm joblib pyproj rioxarray";

/// Builds the wheel, installs it into a separate environment, and runs types and tests; where no environment
/// is available, a message says so and the step is skipped.
pub fn test(runner: &Runner) -> anyhow::Result<()> {
    let Some(python) = environment(runner) else {
        return Ok(());
    };
    let python = python.display().to_string();
    let wheels = runner.target().join("wheels");
    // No file of an older build may be found.
    let _ = std::fs::remove_dir_all(&wheels);
    let wheels_text = wheels.display().to_string();
    let manifest = format!("{PACKAGE}/Cargo.toml");
    let build = [
        &python,
        "-m",
        "maturin",
        "build",
        "--profile",
        "dev",
        "--locked",
        "--quiet",
        "--manifest-path",
        &manifest,
        "--out",
        &wheels_text,
    ];
    runner.run(&Step::new("the wheel", &build))?;
    let install = [
        &python,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--force-reinstall",
        "--no-index",
        "--find-links",
        &wheels_text,
        "acerra",
    ];
    runner.run(&Step::new("its installation", &install))?;
    stranger(runner, &wheels)?;
    let script = format!("{PACKAGE}/tests/run.sh");
    let program = runner.target().join("debug/acerra").display().to_string();
    let tests = ["bash", &script, &python];
    runner.run(&Step::new("types and tests of the package", &tests).with("ACERRA_BINARY", program))
}

/// The guide's first script in an environment with only the wheel and its dependencies, and reading of its
/// files by other programs.
fn stranger(runner: &Runner, wheels: &Path) -> anyhow::Result<()> {
    let environment = runner.target().join("stranger");
    // No file of an older wheel may be found.
    let _ = std::fs::remove_dir_all(&environment);
    let wheel = std::fs::read_dir(wheels)?
        .flatten()
        .map(|entry| entry.path())
        .find(|path| path.extension().is_some_and(|e| e == "whl"))
        .context("the wheel")?;
    let python = environment.join("bin/python");
    let mut install = Command::new(&python);
    install
        .args(["-m", "pip", "install", "--quiet"])
        .arg(format!("{}[netcdf]", wheel.display()))
        .args(["scipy", "rasterio"]);
    let made = succeeds(
        Command::new("python3")
            .args(["-m", "venv"])
            .arg(&environment),
    );
    if !made || !succeeds(&mut install) {
        let reason = "its packages cannot be installed here";
        runner.skip("a stranger's script", reason);
        return Ok(());
    }
    let folder = environment.join("folder");
    std::fs::create_dir_all(&folder)?;
    // Nothing of this machine's environment helps, the home is empty.
    let home = format!("HOME={}", folder.display());
    let [python, script, guide] = [
        python,
        runner.root.join(PACKAGE).join("tests/stranger.py"),
        runner.root.join("docs/guide/src/python.md"),
    ]
    .map(|path| path.display().to_string());
    let run = ["env", "-i", &home, &python, "-I", &script, &guide];
    runner.run(&Step::new("a stranger's script", &run).within(folder))
}

/// The interpreter of an environment with all packages; none, with a message of the reason, where it is not
/// available.
fn environment(runner: &Runner) -> Option<PathBuf> {
    let is_new_enough = "import sys, venv; sys.exit(sys.version_info < (3, 10))";
    if !runner.succeeds(&["python3", "-c", is_new_enough]) {
        runner.skip(
            "Python package",
            "no python3 of 3.10 or later with venv is installed here",
        );
        return None;
    }
    let place = runner.target().join("python");
    let python = place.join("bin/python");
    let made =
        python.is_file() || succeeds(Command::new("python3").args(["-m", "venv"]).arg(&place));
    let install = || {
        succeeds(
            Command::new(&python)
                .args(["-m", "pip", "install", "--quiet"])
                .args(PACKAGES.split_whitespace()),
        )
    };
    if made && install() {
        return Some(python);
    }
    runner.skip("Python package", "the packages cannot be installed here");
    None
}

fn succeeds(command: &mut Command) -> bool {
    command.status().is_ok_and(|status| status.success())
}
