//! The command line: what is accepted, how failures are said, which exit code they get.

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::commands;

/// From raw drone radar and GNSS logs to a focused, measured, georeferenced image of the ground.
#[derive(Debug, Parser)]
#[command(
    name = "acerra",
    version,
    propagate_version = true,
    arg_required_else_help = true
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Calibrate(commands::calibrate::Args),
    Demo(commands::demo::Args),
    Focus(commands::focus::Args),
    Info(commands::info::Args),
    Ppk(commands::ppk::Args),
    Plan(commands::plan::Args),
    Psf(commands::psf::Args),
    Resolution(commands::resolution::Args),
    Simulate(commands::simulate::Args),
}

/// Parses the arguments, runs the command, and turns its outcome into an exit code:
/// 0 success, 1 the work failed, 2 wrong usage. A closed output pipe is success.
#[must_use]
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let code = if error.use_stderr() { 2 } else { 0 };
            // A closed pipe while printing the help is no failure of ours.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let mut out = io::BufWriter::new(io::stdout().lock());
    let outcome = match cli.command {
        Command::Calibrate(args) => commands::calibrate::run(&args, &mut out),
        Command::Demo(args) => commands::demo::run(&args, &mut out),
        Command::Focus(args) => commands::focus::run(&args, &mut out),
        Command::Info(args) => commands::info::run(&args, &mut out),
        Command::Ppk(args) => commands::ppk::run(&args, &mut out),
        Command::Plan(args) => commands::plan::run(&args, &mut out),
        Command::Psf(args) => commands::psf::run(&args, &mut out),
        Command::Resolution(args) => commands::resolution::run(&args, &mut out),
        Command::Simulate(args) => commands::simulate::run(&args, &mut out),
    };
    let outcome = outcome.and_then(|()| Ok(out.flush()?));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            // Nothing is left to tell if stderr is closed too.
            let _ = writeln!(io::stderr(), "acerra: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<io::Error>()
            .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
