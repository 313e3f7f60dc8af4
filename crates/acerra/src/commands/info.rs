//! `acerra info`: says what any supported file holds.

use std::io::Write;
use std::path::PathBuf;

/// Say what any supported file holds.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Radar logs, trajectories, GNSS observations or navigation, images.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Answer as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// A file that cannot be read or is of no supported kind.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let _ = args.json;
    for file in &args.files {
        anyhow::bail!(
            "{}: not a kind of file that this version reads",
            file.display()
        );
    }
    out.flush()?;
    Ok(())
}
