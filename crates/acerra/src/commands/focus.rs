//! `acerra focus`: the whole chain, from raw logs to products.

use std::io::Write;
use std::path::{Path, PathBuf};

use acerra_chain::findings::Verdict;
use acerra_chain::{Control, Journal, Track};
use acerra_products::run_record::{RunRecord, depth_of};
use acerra_products::{
    Outcome, RunRequest, Share, TilesMade, Wanted, make_tiles, run_campaign_with,
};

use crate::interrupt::cancel_flag;
use crate::progress::Bar;
use crate::terminal::{Verbosity, verbosity, warn};

/// Focus a campaign: from raw logs to an image, its measurements and a report.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra focus flight.toml
  acerra focus flight.toml -o products --explain
  acerra focus flight.toml --json | jq .warnings
  acerra focus flight.toml --only image   (for thousands of them)
  acerra focus flight.toml --tiles 3/64   (then: acerra merge flight.toml)
  acerra init flight.mrm rover.ubx base.ubx -o flight.toml    (writes a campaign)")]
pub struct Args {
    /// The campaign file (TOML).
    #[arg(value_name = "CAMPAIGN.toml")]
    pub(crate) campaign: PathBuf,
    /// Directory for the products [default: CAMPAIGN-products next to the campaign file].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Correct the positions by autofocus where that is significant, as [autofocus] enabled does.
    #[arg(long)]
    autofocus: bool,
    /// Make this share of the image's tiles alone, such as 3/64, for job arrays of a cluster: every
    /// Nth tile from the Kth, into tiles.zarr of the directory. `acerra merge` puts them together.
    #[arg(long, value_name = "K/N", conflicts_with_all = ["json", "explain"])]
    tiles: Option<Share>,
    /// Write image.npz and run.json alone (looks.npz and volume.npz where the campaign asks for
    /// them): no pictures, maps or report.
    #[arg(long, value_name = "PRODUCTS", conflicts_with = "tiles")]
    only: Option<Only>,
    /// Print run.json on standard output instead of a summary.
    #[arg(long)]
    json: bool,
    /// Print the planned algorithm with its error bound and the reasons.
    #[arg(long)]
    explain: bool,
}

/// Restriction of the products.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Only {
    /// The image.
    Image,
}

/// Runs the command.
///
/// # Errors
/// Any failure of the chain, with the file, the place and the expectation.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let order = Order {
        campaign: &args.campaign,
        output: args.output.as_deref(),
        autofocus: args.autofocus,
        wanted: match args.only {
            Some(Only::Image) => Wanted::Image,
            None => Wanted::All,
        },
        json: args.json,
        explain: args.explain,
    };
    match args.tiles {
        Some(share) => order.make_tiles(share, out),
        None => order.run(run_campaign_with, out),
    }
}

/// A run that the command line asks for.
pub struct Order<'a> {
    /// The campaign file.
    pub campaign: &'a Path,
    /// Directory for the products, where it is not next to the campaign file.
    pub output: Option<&'a Path>,
    /// Positions are corrected whatever the campaign says.
    pub autofocus: bool,
    /// Which products are written.
    pub wanted: Wanted,
    /// The result is printed as JSON.
    pub json: bool,
    /// The plan is printed.
    pub explain: bool,
}

/// How the products of a run are made.
type Work = fn(RunRequest<'_>, &mut Journal, &Control<'_>) -> anyhow::Result<Outcome>;

impl Order<'_> {
    /// Runs `work` and prints its result.
    ///
    /// # Errors
    /// Errors of the run; an output that is closed.
    pub fn run(&self, work: Work, out: &mut dyn Write) -> anyhow::Result<()> {
        let mut journal = Journal::default();
        let run = self.followed(&mut journal, work);
        self.print(run, &journal, out)
    }

    /// Makes a share of the tiles and prints their number.
    fn make_tiles(&self, share: Share, out: &mut dyn Write) -> anyhow::Result<()> {
        let mut journal = Journal::default();
        let made = self.followed(&mut journal, |request, journal, control| {
            make_tiles(request, share, journal, control)
        });
        journal.warnings.said().iter().for_each(|text| warn(text));
        tell_tiles(&made?, &self.directory(), out)
    }

    /// Runs `work` with a progress bar, which signals end.
    fn followed<T>(
        &self,
        journal: &mut Journal,
        work: impl FnOnce(RunRequest<'_>, &mut Journal, &Control<'_>) -> T,
    ) -> T {
        let bar = Bar::following(&mut journal.stages);
        let control = Control::default()
            .reporting_to(&*bar)
            .cancelled_by(cancel_flag());
        let directory = self.directory();
        let request = RunRequest {
            file: self.campaign,
            directory: &directory,
            autofocus: self.autofocus,
            wanted: self.wanted,
        };
        let done = work(request, journal, &control);
        bar.clear();
        done
    }

    /// The directory for the products.
    pub fn directory(&self) -> PathBuf {
        let by_default = || default_output(self.campaign);
        self.output.map_or_else(by_default, Path::to_owned)
    }

    /// Prints a run's results on standard output, and its warnings on stderr.
    ///
    /// # Errors
    /// Errors of the run; an output that is closed.
    pub fn print(
        &self,
        run: anyhow::Result<Outcome>,
        journal: &Journal,
        out: &mut dyn Write,
    ) -> anyhow::Result<()> {
        if run.is_err() || verbosity() == Verbosity::Quiet {
            // Remarks help to understand a failure as well.
            journal.warnings.said().iter().for_each(|text| warn(text));
        }
        let outcome = run?;
        if verbosity() != Verbosity::Quiet {
            // A closed stderr is no failure of the run.
            let _ = writeln!(
                std::io::stderr(),
                "evidence: {}{}",
                outcome.evidence.summary(),
                unchecked(&outcome)
            );
        }
        let stages = journal.stages.done();
        if self.json {
            let record = RunRecord::of(&outcome, stages);
            writeln!(out, "{}", serde_json::to_string(&record)?)?;
            return Ok(());
        }
        if verbosity() == Verbosity::Quiet {
            return Ok(());
        }
        summarise(&outcome, self.explain, out)?;
        let seconds: f64 = stages.iter().map(|stage| stage.seconds).sum();
        writeln!(
            out,
            "products   {} in {seconds:.2} s",
            self.directory().display()
        )?;
        Ok(())
    }
}

/// Result of a share of the tiles.
fn tell_tiles(made: &TilesMade, directory: &Path, out: &mut dyn Write) -> anyhow::Result<()> {
    if verbosity() == Verbosity::Quiet {
        return Ok(());
    }
    let TilesMade {
        made,
        held,
        missing,
        all,
    } = made;
    writeln!(
        out,
        "tiles      {made} made, {held} there before, {missing} of {all} missing in {}",
        directory.display()
    )?;
    if *missing == 0 {
        writeln!(out, "           all are there: run `acerra merge`")?;
    }
    Ok(())
}

/// The directory for the products of a campaign that names none.
fn default_output(campaign: &Path) -> PathBuf {
    let mut name = campaign
        .file_stem()
        .unwrap_or(campaign.as_os_str())
        .to_owned();
    name.push("-products");
    campaign.with_file_name(name)
}

/// Settings that no data check, as the end of a line.
fn unchecked(outcome: &Outcome) -> String {
    let settings: Vec<&str> = outcome.unchecked.iter().map(|one| one.setting).collect();
    if settings.is_empty() {
        String::new()
    } else {
        format!("; nothing checks: {}", settings.join(", "))
    }
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
    for note in &outcome.notes {
        writeln!(out, "note       {note}")?;
    }
    for finding in outcome.evidence.findings() {
        let word = match finding.verdict {
            // A line for each surveyed point, with the target nearest to it.
            Verdict::Agrees if finding.name == "survey" => "agrees",
            Verdict::Agrees => continue,
            Verdict::Doubtful => "doubtful",
            Verdict::Contradicts => "contradicts",
        };
        writeln!(out, "{word:<10} {}: {}", finding.name, finding.explanation)?;
    }
    for one in &outcome.unchecked {
        writeln!(out, "unchecked  {}: {}", one.setting, one.explanation)?;
    }
    Ok(())
}

fn write_traces(outcome: &Outcome, out: &mut dyn Write) -> anyhow::Result<()> {
    let aligned = &outcome.prepared.aligned;
    let first = outcome.prepared.first();
    writeln!(out, "radar      {}", outcome.radar_summary())?;
    if aligned.is_often_at_rest {
        writeln!(
            out,
            "           the platform is at rest for a tenth of the time or more: the traces in motion are imaged, weighted by \
             path length"
        )?;
    }
    write!(
        out,
        "traces     {} of {} imaged, over {:.2} m of path",
        aligned.traces.len(),
        outcome.prepared.traces_in_log(),
        aligned.path_m.iter().sum::<f64>()
    )?;
    write!(out, ", time offset {:.4} s", first.time_offset_s)?;
    match &first.recorded_clock {
        Some(clock) => writeln!(out, " (recorded clock, ± {:.2} ms)", 1e3 * clock.sigma_s)?,
        None => writeln!(out)?,
    }
    if let Some(found) = outcome.prepared.ground {
        writeln!(
            out,
            "           ground found at z = {:.3} ± {:.3} m",
            found.z_m, found.sigma_m
        )?;
    }
    if let Some(found) = outcome.prepared.permittivity {
        writeln!(
            out,
            "           relative permittivity found: {:.2} ± {:.2}, from {} buried points",
            found.value, found.sigma, found.points
        )?;
    }
    if let Some(search) = &first.search {
        write!(
            out,
            "           found: ± {:.1} ms",
            1e3 * search.estimate.sigma_s
        )?;
        let along = outcome.evidence.findings().iter();
        let mut along = along.filter(|f| f.name.starts_with("clock_offset_sigma"));
        if let Some(along_m) = along.next().and_then(|finding| finding.value) {
            write!(out, " (± {along_m:.3} m along the track)")?;
        }
        if let Some(height) = &search.likelihood.height {
            write!(out, ", by height {:.3} s", height.offset_s)?;
        }
        if let Some(motion) = &search.likelihood.motion {
            write!(out, ", by motion {:.3} s", motion.offset_s)?;
        }
        if let Some(sharpness) = &search.estimate.sharpness {
            write!(out, ", by sharpness {:.4} s", sharpness.offset_s)?;
        }
        writeln!(out)?;
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
    let below = targets.iter().any(|t| depth_of(outcome, t).is_some());
    writeln!(
        out,
        "targets      x (m)    y (m)  level (dB)  along (m)  across (m)  ghost{}",
        match below {
            true => "  depth (m)  above clutter",
            false => "",
        }
    )?;
    let metres = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{v:.3}"));
    for (k, t) in targets.iter().enumerate() {
        let ghost = t
            .ghost
            .map_or("–".to_owned(), |g| format!("{:.2}", g.level));
        writeln!(
            out,
            "{:>4}      {:>8.3} {:>8.3}  {:>10.1} {:>10} {:>11}  {:>5}{}",
            k + 1,
            t.x_m,
            t.y_m,
            t.level_db,
            metres(t.along.rayleigh_m),
            metres(t.across.rayleigh_m),
            ghost,
            depth_of(outcome, t).map_or(String::new(), |[depth_m, _]| {
                let is_above = outcome.exceeds_clutter.get(k).copied();
                let is_above = if is_above == Some(true) { "yes" } else { "no" };
                format!("  {depth_m:>9.3}  {is_above:>13}")
            })
        )?;
    }
    Ok(())
}
