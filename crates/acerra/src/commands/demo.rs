//! `acerra demo`: the paper's campaign, simulated and processed.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::demo::{Flown, TRACKS, demonstration_page};
use crate::terminal::{Verbosity, verbosity};
use acerra_chain::Journal;
use acerra_products::staging::Staging;

/// Simulate the paper's campaign, raw logs and all, and process it: no input needed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra demo
  acerra demo -o demo && xdg-open demo/index.html")]
pub struct Args {
    /// Directory for logs and products.
    #[arg(short, long, value_name = "DIR", default_value = "acerra-demo")]
    output: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// A directory that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut nowhere = std::io::sink();
    let out = if verbosity() > Verbosity::Quiet {
        out
    } else {
        &mut nowhere
    };
    let mut flights = Vec::new();
    for track in TRACKS {
        writeln!(out, "{}", track.title)?;
        out.flush()?;
        let folder = args.output.join(track.name);
        let mut journal = Journal::default();
        let flown = track.fly(&folder, &mut journal)?;
        say(&flown, &journal, &folder, out)?;
        flights.push((track, flown));
    }
    let flown: Vec<_> = flights
        .iter()
        .map(|(track, flown)| (*track, flown))
        .collect();
    let page = demonstration_page(&flown, &args.output)?;
    let staging = Staging::new(&args.output)?;
    staging.write("index.html", page)?;
    staging.publish()?;
    writeln!(out, "open {}", args.output.join("index.html").display())?;
    Ok(())
}

fn say(flown: &Flown, journal: &Journal, folder: &Path, out: &mut dyn Write) -> anyhow::Result<()> {
    writeln!(
        out,
        "  logged     {} scans, {} GNSS epochs in {}",
        flown.simulated.scans,
        flown.simulated.gnss_epochs,
        folder.display()
    )?;
    if let Some([off_s, sigma_s]) = flown.offset_error_s() {
        writeln!(
            out,
            "  clocks     offset found {:+.1} ms off the truth, ± {:.1} ms stated",
            off_s * 1e3,
            sigma_s * 1e3
        )?;
    }
    writeln!(
        out,
        "  imaged     {} traces; {} of them at fixed positions",
        flown.outcome.prepared.aligned.traces.len(),
        flown.fixed()
    )?;
    writeln!(
        out,
        "  reflector  off x (mm)  off y (mm)  height allows  level (dB)  along (m)  across (m)  \
         ghost"
    )?;
    let metres = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{v:.3}"));
    for f in flown.found() {
        let [x, y] = f.off_m();
        writeln!(
            out,
            "  {:>9}  {:>10.0}  {:>10.0}  {:>13}  {:>10.1}  {:>9}  {:>10}  {:>5}",
            f.number,
            x * 1e3,
            y * 1e3,
            format!("±{:.0}", f.across_bound_m * 1e3),
            f.target.level_db,
            metres(f.target.along.rayleigh_m),
            metres(f.target.across.rayleigh_m),
            f.target
                .ghost
                .map_or("–".to_owned(), |g| format!("{:.2}", g.level))
        )?;
    }
    for warning in &flown.outcome.warnings {
        writeln!(out, "  warning    {warning}")?;
    }
    let seconds: f64 = journal
        .stages
        .done()
        .iter()
        .map(|stage| stage.seconds)
        .sum();
    let products = folder.join("products");
    writeln!(out, "  products   {} in {seconds:.1} s", products.display())?;
    out.flush()?;
    Ok(())
}
