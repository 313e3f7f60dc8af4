//! The command line: what is accepted, how failures are said, which exit code they get.

use std::io::{self, Write};
use std::process::ExitCode;

use acerra_products::PlainWriter;
use anyhow::Context;
use clap::{CommandFactory, Parser, Subcommand};

use crate::terminal::{Verbosity, set_verbosity};
use crate::{commands, interrupt, terminal};

/// From raw drone radar and GNSS logs to a focused, measured, georeferenced image of the ground.
#[derive(Debug, Parser)]
#[command(
    name = "acerra",
    version,
    propagate_version = true,
    arg_required_else_help = true,
    after_help = "Examples:
  acerra demo
  acerra init flight.mrm rover.ubx base.ubx -o flight.toml
  acerra focus flight.toml
  acerra help focus"
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Say only what fails or makes the result doubtful: no progress, no notes, no summary.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Say what each stage costs.
    #[arg(short, long, global = true)]
    verbose: bool,
}

impl Cli {
    fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        }
    }
}

#[derive(Debug, Subcommand)]
enum Command {
    Calibrate(commands::calibrate::Args),
    Completions(commands::completions::Args),
    Convert(commands::convert::Args),
    Demo(commands::demo::Args),
    Emulate(commands::emulate::Args),
    Focus(commands::focus::Args),
    Info(commands::info::Args),
    Init(commands::init::Args),
    Live(commands::live::Args),
    Man(commands::man::Args),
    Merge(commands::merge::Args),
    Ppk(Box<commands::ppk::Args>),
    Plan(commands::plan::Args),
    Psf(Box<commands::psf::Args>),
    Record(commands::record::Args),
    Resolution(commands::resolution::Args),
    Schema(commands::schema::Args),
    Simulate(commands::simulate::Args),
    View(commands::view::Args),
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
    set_verbosity(cli.verbosity());
    let outcome = prepare_process().and_then(|()| run(cli.command));
    interrupt::wait_if_ending();
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::fail(&error);
            ExitCode::FAILURE
        }
    }
}

/// Handlers for signals, and threads: what fails here fails under a limit on memory or processes.
fn prepare_process() -> anyhow::Result<()> {
    interrupt::end_on_signals().context("cannot handle signals")?;
    rayon::ThreadPoolBuilder::new()
        .build_global()
        .context("cannot start threads")
}

fn run(command: Command) -> anyhow::Result<()> {
    let mut out = PlainWriter::new(io::BufWriter::new(io::stdout().lock()));
    match command {
        Command::Completions(args) => commands::completions::run(&args, Cli::command(), &mut out),
        Command::Convert(args) => commands::convert::run(&args, &mut out),
        Command::Calibrate(args) => commands::calibrate::run(&args, &mut out),
        Command::Demo(args) => commands::demo::run(&args, &mut out),
        Command::Emulate(args) => commands::emulate::run(&args, &mut out),
        Command::Focus(args) => commands::focus::run(&args, &mut out),
        Command::Info(args) => commands::info::run(&args, &mut out),
        Command::Init(args) => commands::init::run(&args, &mut out),
        Command::Live(args) => commands::live::run(&args, &mut out),
        Command::Man(args) => commands::man::run(&args, Cli::command(), &mut out),
        Command::Merge(args) => commands::merge::run(&args, &mut out),
        Command::Ppk(args) => commands::ppk::run(&args, &mut out),
        Command::Plan(args) => commands::plan::run(&args, &mut out),
        Command::Psf(args) => commands::psf::run(&args, &mut out),
        Command::Record(args) => commands::record::run(&args, &mut out),
        Command::Resolution(args) => commands::resolution::run(&args, &mut out),
        Command::Schema(args) => commands::schema::run(&args, &mut out),
        Command::Simulate(args) => commands::simulate::run(&args, &mut out),
        Command::View(args) => commands::view::run(&args, &mut out),
    }?;
    Ok(out.flush()?)
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

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }
}
