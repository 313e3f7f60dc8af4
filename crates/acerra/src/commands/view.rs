//! `acerra view`: runs in the browser.

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;

use acerra_view::{Server, ServerOptions};
use anyhow::bail;

use crate::interrupt::cancel_flag;
use crate::terminal::note;

/// Show runs in the browser: image, radargram and flight, linked; new images as settings change.
///
/// Serves pages on this machine alone, under an address with a random token, until interrupted. The
/// radargram and new images need the logs that the run read, at the places where it read them.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra view flight-products
  acerra view may-products june-products
  acerra view flight-products --port 8080 --no-open
  acerra view flight-products --basemap 'https://tiles.example/{z}/{x}/{y}.png'
  acerra view flight-products --basemap map-tiles")]
pub struct Args {
    /// The directories of runs; two of them can be compared.
    #[arg(value_name = "DIRECTORY", required = true)]
    runs: Vec<PathBuf>,
    /// The port; any free one by default.
    #[arg(short, long, default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the address and open no browser.
    #[arg(long)]
    no_open: bool,
    /// Map tiles under the image: an address with {z}, {x} and {y}, loaded by the browser from that server,
    /// or a directory with files z/x/y.png. Without this option no tiles are loaded.
    #[arg(long, visible_alias = "tiles", value_name = "URL or DIRECTORY")]
    basemap: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// A directory without a run, a port that cannot be had.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    if let Some(file) = args.runs.iter().find(|run| run.is_file()) {
        bail!(
            "{}: expected the directory of a run, as acerra focus makes it, found a file",
            file.display()
        );
    }
    let server = Server::open(&ServerOptions {
        directories: args.runs.clone(),
        port: args.port,
        basemap: args.basemap.clone(),
    })?;
    writeln!(out, "{}", server.address())?;
    out.flush()?;
    if !args.no_open && !open(server.address()) {
        note("no browser could be started: open the address above");
    }
    Ok(server.run(|| cancel_flag().load(Ordering::Relaxed))?)
}

/// Opens an address in the user's browser; false where there is no program to do so.
pub(super) fn open(address: &str) -> bool {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    Command::new(program)
        .args(arguments)
        .arg(address)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .is_ok()
}
