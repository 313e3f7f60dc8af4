//! The command line: accepted arguments, wording of failures, and exit codes.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use acerra_products::PlainWriter;
use anyhow::{Context, anyhow};
use clap::{CommandFactory, Parser, Subcommand};

use crate::describe::describe;
use crate::settings_files::SettingsFile;
use crate::terminal::{Verbosity, set_verbosity};
use crate::{commands, interrupt, terminal};

/// From raw drone radar and GNSS logs to a focused, measured, georeferenced image of the ground.
#[derive(Debug, Parser)]
#[command(
    name = "acerra",
    version,
    propagate_version = true,
    arg_required_else_help = true,
    help_template = grouped_help(),
    after_help = "Examples:
  acerra demo
  acerra init flight.mrm rover.ubx base.ubx -o flight.toml
  acerra focus flight.toml
  acerra help focus"
)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print only failures and doubts about the result: no progress, no notes, no summary.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print the cost of each stage.
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

/// Commands by purpose, each group in the order of use.
const GROUPS: [(&str, &[&str]); 5] = [
    ("First flight", &["demo", "init", "focus", "view", "info"]),
    ("Positions", &["ppk", "calibrate"]),
    ("Planning", &["plan", "psf", "resolution", "simulate"]),
    ("Field", &["record", "live", "emulate"]),
    (
        "Data",
        &["convert", "merge", "schema", "completions", "man", "help"],
    ),
];

/// Columns of the help text.
const HELP_COLUMNS: usize = 100;

/// The overview's help with the commands in their groups.
fn grouped_help() -> String {
    let commands = Command::augment_subcommands(clap::Command::new("acerra"));
    let about = |name: &str| match commands.find_subcommand(name).and_then(|c| c.get_about()) {
        Some(about) => about.to_string(),
        None => "Print this help, or that of a command".to_owned(),
    };
    let names = GROUPS.iter().flat_map(|(_, names)| *names);
    let column = 4 + names.map(|name| name.len()).max().unwrap_or_default();
    let mut text = "{about-with-newline}\n{usage-heading} {usage}\n".to_owned();
    for (heading, names) in GROUPS {
        text.push_str(&format!("\n{heading}:\n"));
        for name in names {
            text.push_str(&format!("  {name:<width$}", width = column - 2));
            text.push_str(&indented(&about(name), column));
            text.push('\n');
        }
    }
    text + "\nOptions:\n{options}{after-help}"
}

/// Words in lines that begin at `column`; the first line is not indented.
fn indented(words: &str, column: usize) -> String {
    let mut text = String::new();
    let mut at = column;
    for word in words.split_whitespace() {
        let length = word.chars().count();
        if at > column && at + 1 + length > HELP_COLUMNS {
            text.push_str(&format!("\n{:column$}", ""));
            at = column;
        } else if at > column {
            text.push(' ');
            at += 1;
        }
        text.push_str(word);
        at += length;
    }
    text
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
    let reads = cli.command.settings_file();
    let outcome = prepare_process().and_then(|()| run(cli.command));
    let outcome = outcome.map_err(|failure| match &reads {
        Some(reads) => reads.blamed(failure),
        None => failure,
    });
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

/// Handlers for signals, and threads: they fail under a limit on memory or processes.
fn prepare_process() -> anyhow::Result<()> {
    interrupt::end_on_signals().context("cannot handle signals")?;
    rayon::ThreadPoolBuilder::new()
        .build_global()
        .context("cannot start threads")
}

/// A settings file that a command reads.
struct Reads {
    file: PathBuf,
    kind: SettingsFile,
}

impl Command {
    /// The settings file that the command reads.
    fn settings_file(&self) -> Option<Reads> {
        let (file, kind) = match self {
            Self::Calibrate(args) => (Some(&args.campaign), SettingsFile::Campaign),
            Self::Focus(args) => (Some(&args.campaign), SettingsFile::Campaign),
            Self::Merge(args) => (Some(&args.campaign), SettingsFile::Campaign),
            Self::Plan(args) => (args.plan.as_ref(), SettingsFile::Plan),
            Self::Simulate(args) => (args.scene.as_ref(), SettingsFile::Scene),
            _ => return None,
        };
        file.map(|file| Reads {
            file: file.clone(),
            kind,
        })
    }
}

impl Reads {
    /// The failure of a command, or the kind of the file where it holds data instead of settings.
    fn blamed(&self, failure: anyhow::Error) -> anyhow::Error {
        // A pipe cannot be read twice.
        if !self.file.is_file() || holds_toml(&self.file) {
            return failure;
        }
        let Ok(found) = describe(&self.file) else {
            return failure;
        };
        let (name, first) = match self.kind {
            SettingsFile::Campaign => ("campaign", "acerra init LOGS… -o flight.toml"),
            SettingsFile::Scene => ("scene", "acerra simulate --example > scene.toml"),
            SettingsFile::Plan => ("plan", "acerra plan --example > area.toml"),
        };
        anyhow!(
            "{}: expected a {name} (TOML), found a log or another file of data ({}); write a {name} first: {first}",
            self.file.display(),
            found.kind
        )
    }
}

fn holds_toml(file: &Path) -> bool {
    let text = std::fs::read_to_string(file);
    text.is_ok_and(|text| text.parse::<toml::Table>().is_ok())
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

    #[test]
    fn the_help_names_every_command_once() {
        let mut grouped: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, names)| *names)
            .copied()
            .collect();
        grouped.sort_unstable();
        let all = Command::augment_subcommands(clap::Command::new("acerra"));
        let mut all: Vec<&str> = all.get_subcommands().map(clap::Command::get_name).collect();
        all.push("help");
        all.sort_unstable();
        assert_eq!(grouped, all);
    }
}
