//! `cargo xtask NAME`: see `cargo xtask help`.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod browser;
mod checks;
mod gallery;
mod install;
mod python;
mod release;
mod runner;
mod site;
mod validation;

use std::process::ExitCode;

use runner::Runner;

const HELP: &str = "\
cargo xtask test                 all tests: the Rust suite, the Python package, the viewer in a browser
cargo xtask test-python          the Python package alone
cargo xtask test-browser         the viewer in a browser alone
cargo xtask bench-browser        the viewer's times in a browser
cargo xtask ci                   everything a change must pass: what .ci/run calls
cargo xtask gallery              the guide's gallery again, by the commands of its page
cargo xtask site                 guide and reference of the libraries as one static site, target/site
cargo xtask install [--debug]    installs the program and runs its demonstration with nothing else at hand
cargo xtask workflows            the workflow files, by actionlint
cargo xtask containers           the Docker image and the conda package, where their tools are
cargo xtask package              every crate as it is published, by its size
cargo xtask validate             slow checks: RTKLIB parity, the engine at full size, the book
cargo xtask book                 writes docs/validation again
cargo xtask validate flights     random flights with right settings, and their page of the book
cargo xtask validate captures    random side-looking captures, calibrated, and their page of the book
cargo xtask wrong-settings       the table of wrong settings, again
cargo xtask ground-scenes [NAME…] full-wave scenes of the validation book again, minutes each
cargo xtask fuzz [SECONDS] [TARGET…]
                                 every fuzz target for so many seconds (20), from the seeds
cargo xtask bench-peers          Acerra beside numba, NumPy and torchbp, in one run
cargo xtask house [DIR]          circles among files, imports between folders and crates that point upwards
cargo xtask lines [DIR]          lines of code, documentation and tests in each crate's src
";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let task = arguments.next().unwrap_or_default();
    let rest: Vec<String> = arguments.collect();
    let outcome = Runner::in_workspace().and_then(|runner| match task.as_str() {
        "test" => checks::test(&runner),
        "test-python" => python::test(&runner),
        "test-browser" => browser::test(&runner),
        "bench-browser" => browser::bench(&runner),
        "ci" => checks::ci(&runner),
        "gallery" => gallery::write(&runner),
        "site" => site::write(&runner),
        "install" => install::test(&runner, &rest),
        "workflows" => release::workflows(&runner),
        "containers" => release::containers(&runner),
        "package" => release::package(&runner),
        "validate" if rest == ["flights"] || rest == ["captures"] => {
            checks::drawn(&runner, &rest[0])
        }
        "validate" => validation::run(&runner),
        "book" => checks::book(&runner),
        "wrong-settings" => checks::wrong_settings(&runner),
        "ground-scenes" => {
            let folder = runner.root.join("docs/validation/ground");
            xtask::ground::write(&folder, &rest, |line| println!("{line}"))
        }
        "fuzz" => runner.script("fuzz/run.sh", &rest),
        "bench-peers" => runner.script("crates/acerra-imaging/benches/peers/run.sh", &rest),
        "house" => checks::house(&runner, rest.first().map(String::as_str)),
        "lines" => checks::lines(&runner, rest.first().map(String::as_str)),
        "" | "help" | "--help" => {
            print!("{HELP}");
            Ok(())
        }
        other => anyhow::bail!("{other}: expected one of these\n{HELP}"),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}
