//! Tests of the Python package, where Python and the packages can be had.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::runner::{Runner, Step};

/// Where the package stands.
const PACKAGE: &str = "crates/acerra-python";

/// What its tests need beside itself.
const PACKAGES: &str = "maturin numpy xarray pandas scipy matplotlib pylops pytest hypothesis mypy \
                        pandas-stubs scipy-stubs types-tqdm h5py segyio scikit-rf dask[distributed] zarr moto[server] obstore \
                        nbclient nbformat ipykernel netCDF4 h5netcdf \
                        h5py";

/// Builds the wheel, installs it into an environment of its own, and runs types and tests; where that
/// cannot be had, it is said and skipped.
pub fn test(runner: &Runner) -> anyhow::Result<()> {
    let Some(python) = environment(runner) else {
        return Ok(());
    };
    let python = python.display().to_string();
    let wheels = target(runner).join("wheels");
    // Of an older build nothing shall be found.
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
    let script = format!("{PACKAGE}/tests/run.sh");
    let program = target(runner).join("debug/acerra").display().to_string();
    let tests = ["bash", &script, &python];
    runner.run(&Step::new("types and tests of the package", &tests).with("ACERRA_BINARY", program))
}

/// The interpreter of an environment with all packages; none, with the reason said, where it cannot be
/// had.
fn environment(runner: &Runner) -> Option<PathBuf> {
    let is_new_enough = "import sys, venv; sys.exit(sys.version_info < (3, 10))";
    if !runner.succeeds(&["python3", "-c", is_new_enough]) {
        runner.skip(
            "Python package",
            "no python3 of 3.10 or later with venv is installed here",
        );
        return None;
    }
    let place = target(runner).join("python");
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

fn target(runner: &Runner) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(&runner.root).join("target"), PathBuf::from)
}
