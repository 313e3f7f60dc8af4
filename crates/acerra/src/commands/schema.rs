//! `acerra schema`: the JSON Schema of a settings file.

use std::io::Write;

use crate::settings_files::SettingsFile;

/// Print the JSON Schema of a settings file, for editors that complete and check TOML.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra schema campaign > campaign.schema.json
  Then, as the first line of a campaign (Even Better TOML, taplo):
  #:schema ./campaign.schema.json")]
pub struct Args {
    /// Which file.
    #[arg(value_enum)]
    file: SettingsFile,
}

/// Runs the command.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    writeln!(out, "{:#}", args.file.schema())?;
    Ok(())
}
