//! `acerra focus`: the whole chain, from raw logs to products.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use acerra_chain::{Control, Journal, Progress, Track};
use acerra_products::run_record::RunRecord;
use acerra_products::{Outcome, run_campaign};

/// Focus a campaign: from raw logs to an image, its measurements and a report.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The campaign file (TOML).
    #[arg(value_name = "CAMPAIGN.toml")]
    campaign: PathBuf,
    /// Directory for the products [default: CAMPAIGN-products beside the campaign file].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print run.json on standard output instead of a summary.
    #[arg(long)]
    json: bool,
    /// Say which algorithm was planned, with which bound, and why.
    #[arg(long)]
    explain: bool,
}

/// Runs the command.
///
/// # Errors
/// Whatever the chain cannot do, with the file, the place and what was expected.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let directory = args
        .output
        .clone()
        .unwrap_or_else(|| default_output(&args.campaign));
    let mut journal = Journal::default();
    let bar = Bar::default();
    let control = Control::default().reporting_to(&bar);
    let outcome = run_campaign(&args.campaign, &directory, &mut journal, &control)?;
    let stages = journal.stages.done();
    if args.json {
        let record = RunRecord::of(&outcome, stages);
        writeln!(out, "{}", serde_json::to_string(&record)?)?;
        return Ok(());
    }
    summarise(&outcome, args.explain, out)?;
    let seconds: f64 = stages.iter().map(|stage| stage.seconds).sum();
    writeln!(out, "products   {} in {seconds:.2} s", directory.display())?;
    Ok(())
}

fn default_output(campaign: &Path) -> PathBuf {
    let stem = campaign
        .file_stem()
        .unwrap_or(campaign.as_os_str())
        .to_string_lossy();
    campaign.with_file_name(format!("{stem}-products"))
}

fn summarise(outcome: &Outcome, explain: bool, out: &mut dyn Write) -> anyhow::Result<()> {
    write_traces(outcome, out)?;
    for track in outcome.listed_tracks() {
        write_track(track, out)?;
    }
    if let Some(traces) = outcome.prepared.cleaned() {
        writeln!(out, "fast time  shifted by {:+.3} ns", traces.shift_s * 1e9)?;
    }
    write_image(outcome, explain, out)?;
    write_targets(outcome, out)?;
    for warning in &outcome.warnings {
        writeln!(out, "warning    {warning}")?;
    }
    Ok(())
}

fn write_traces(outcome: &Outcome, out: &mut dyn Write) -> anyhow::Result<()> {
    let aligned = &outcome.prepared.aligned;
    let first = outcome.prepared.first();
    writeln!(out, "radar      {}", outcome.radar_summary())?;
    write!(
        out,
        "traces     {} of {} imaged, over {:.2} m of path",
        aligned.traces.len(),
        outcome.prepared.traces_in_log(),
        aligned.path_m.iter().sum::<f64>()
    )?;
    writeln!(out, ", time offset {:.4} s", first.time_offset_s)?;
    if let Some(search) = &first.search {
        writeln!(
            out,
            "           found: motion correlates with {:.2} (elsewhere {:.2}), image {:.2} times \
             sharper than the median",
            search.motion.correlation, search.motion.runner_up, search.sharpness_ratio
        )?;
    }
    Ok(())
}

fn write_track(track: &Track, out: &mut dyn Write) -> anyhow::Result<()> {
    let k = &track.calibration;
    write!(
        out,
        "track      {}: {} traces, {:+.3} ns and {:+.1}° taken off as given",
        track.name,
        track.range.len(),
        k.given_delay_ns,
        k.given_phase_deg
    )?;
    match k.found {
        Some(f) => writeln!(
            out,
            ", {:+.4} ± {:.4} ns and {:+.1} ± {:.1}° as found",
            f.delay_ns, f.delay_sigma_ns, f.phase_deg, f.phase_sigma_deg
        )?,
        None => writeln!(out)?,
    }
    Ok(())
}

fn write_image(outcome: &Outcome, explain: bool, out: &mut dyn Write) -> anyhow::Result<()> {
    let pixels = &outcome.focused.pixels;
    let grid = &pixels.grid;
    write!(
        out,
        "image      {} × {} pixels of {} m {}",
        grid.nx,
        grid.ny,
        grid.pixel_m,
        pixels.describe()
    )?;
    match outcome.measured.statistics.median_db {
        Some(median_db) => writeln!(out, ", peak {:.1} dB over its median", -median_db)?,
        None => writeln!(out, ", empty")?,
    }
    if explain {
        for line in outcome.focused.plan.lines() {
            writeln!(out, "           {line}")?;
        }
    }
    Ok(())
}

fn write_targets(outcome: &Outcome, out: &mut dyn Write) -> anyhow::Result<()> {
    let targets = &outcome.measured.targets;
    if targets.is_empty() {
        writeln!(out, "targets    none")?;
        return Ok(());
    }
    writeln!(
        out,
        "targets      x (m)    y (m)  level (dB)  along (m)  across (m)  ghost"
    )?;
    let metres = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{v:.3}"));
    for (k, t) in targets.iter().enumerate() {
        let ghost = t
            .ghost
            .map_or("–".to_owned(), |g| format!("{:.2}", g.level));
        writeln!(
            out,
            "{:>4}      {:>8.3} {:>8.3}  {:>10.1} {:>10} {:>11}  {:>5}",
            k + 1,
            t.x_m,
            t.y_m,
            t.level_db,
            metres(t.along.rayleigh_m),
            metres(t.across.rayleigh_m),
            ghost
        )?;
    }
    Ok(())
}

/// Progress on stderr, when it is a terminal.
#[derive(Debug, Default)]
pub struct Bar {
    shown: Mutex<Option<ProgressBar>>,
}

impl Progress for Bar {
    fn start(&self, name: &str, total: u64) {
        if !std::io::stderr().is_terminal() {
            return;
        }
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template(
            "{msg:10} {wide_bar} {percent:>3} %  {per_sec}  {eta} left",
        );
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_message(name.to_owned());
        if let Ok(mut shown) = self.shown.lock() {
            *shown = Some(bar);
        }
    }

    fn at(&self, done: u64) {
        if let Ok(shown) = self.shown.lock()
            && let Some(bar) = shown.as_ref()
        {
            bar.set_position(done);
        }
    }

    fn finish(&self) {
        if let Ok(mut shown) = self.shown.lock()
            && let Some(bar) = shown.take()
        {
            bar.finish_and_clear();
        }
    }
}
