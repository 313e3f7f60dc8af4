//! `acerra init`: a commented campaign from logs.

use std::io::Write;
use std::path::{Path, PathBuf};

use acerra_chain::campaign::Campaign;
use acerra_products::staging::StagedFile;
use anyhow::{Context, ensure};

use crate::init::{Logs, compose, expanded};
use crate::terminal::{Verbosity, verbosity};

/// Write a campaign for a flight's logs: the keys that matter, set where the files say, then all others.
///
/// Recognises radar logs, trajectories, the logs of GNSS receivers and navigation files by their content,
/// distinguishes rover and base by their motion, and writes its findings next to each key.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra init flight.mrm rover.ubx base.ubx -o flight.toml && acerra focus flight.toml
  acerra init flight.mrm rover.obs base.obs brdc.nav
  acerra init flight.npz flight.pos > flight.toml
  acerra init 'line-*.rd3' -o area.toml")]
pub struct Args {
    /// The logs of one flight, or the files of several lines over one area; `*` and `?` in a name match any
    /// characters.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write the campaign there instead of to standard output; an existing file is kept.
    #[arg(short, long, value_name = "CAMPAIGN.toml")]
    output: Option<PathBuf>,
    /// Replace the campaign that is there already.
    #[arg(short, long, requires = "output")]
    force: bool,
    /// Rigid body of a motion capture with several; by default the one whose motion agrees with the echoes.
    #[arg(long, value_name = "NAME")]
    rigid_body: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read or has no place in a campaign, logs that do not make a campaign, a
/// campaign file that is there already.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let folder = match args.output.as_deref().and_then(Path::parent) {
        Some(folder) => folder.to_owned(),
        None => std::env::current_dir().context("the current directory")?,
    };
    if let Some(file) = &args.output {
        ensure!(
            args.force || !file.exists(),
            "{}: is there already; replace it with --force, or name another file with -o",
            file.display()
        );
        let mut inputs = args.files.iter();
        ensure!(
            !inputs.any(|input| is_same_file(input, file)),
            "{}: is one of the logs and would be overwritten",
            file.display()
        );
    }
    let logs = Logs::look(&expanded(&args.files)?, args.rigid_body.as_deref())?;
    let text = compose(&logs, &folder)?;
    Campaign::parse(&text).context("the campaign from these logs cannot be used")?;
    let Some(file) = &args.output else {
        out.write_all(text.as_bytes())?;
        return Ok(());
    };
    StagedFile::write(file, |to| Ok(to.write_all(text.as_bytes())?))?.publish()?;
    if verbosity() > Verbosity::Quiet {
        writeln!(out, "process with: acerra focus {}", file.display())?;
    }
    Ok(())
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
