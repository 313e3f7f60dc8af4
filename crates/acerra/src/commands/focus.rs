//! `acerra focus`: the whole chain, from raw logs to products.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;

use acerra_chain::Outcome;
use acerra_chain::campaign::Campaign;
use acerra_chain::stages::Stages;
use acerra_chain::staging::Staging;
use acerra_products::deliver::deliver;
use acerra_products::names::{PRODUCTS, of_older_run};
use acerra_products::run_json;

use crate::progress::Bar;
use crate::terminal::{self, Verbosity, verbosity};

/// Focus a campaign: from raw logs to an image, its measurements and a report.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra focus flight.toml
  acerra focus flight.toml -o products --explain
  acerra focus flight.toml --json | jq .warnings
  acerra init flight.mrm rover.ubx base.ubx -o flight.toml    (writes a campaign)")]
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
    let mut stages = Stages::default();
    let outcome = focus_file(&args.campaign, &directory, &mut stages)?;
    if args.json {
        writeln!(out, "{}", run_json::run(&outcome, stages.done()))?;
    } else if verbosity() > Verbosity::Quiet {
        summarise(&outcome, &stages, &directory, args.explain, out)?;
    } else {
        outcome
            .warnings
            .iter()
            .for_each(|text| terminal::warn(text));
    }
    Ok(())
}

/// Focuses one campaign file into `directory`.
///
/// # Errors
/// As [`run`].
pub fn focus_file(file: &Path, directory: &Path, stages: &mut Stages) -> anyhow::Result<Outcome> {
    let text = std::fs::read_to_string(file).with_context(|| format!("{}", file.display()))?;
    let campaign = Campaign::parse(&text).with_context(|| format!("{}", file.display()))?;
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let name = name_of_campaign(file);
    let campaign = campaign.resolved_in(folder);
    let bar = Arc::new(Bar::default());
    stages.listen({
        let bar = Arc::clone(&bar);
        move |event| bar.stage(event)
    });
    inputs_are_kept(&campaign, file, directory)?;
    let mut staging = Staging::new(directory)?;
    staging.supersede(of_older_run(directory));
    let outcome = acerra_chain::run(&name, &campaign, Some(file), &staging, stages, &*bar)?;
    deliver(&outcome, staging, stages)?;
    Ok(outcome)
}

/// Refuses a directory in which a product would take the place of an input.
fn inputs_are_kept(campaign: &Campaign, file: &Path, directory: &Path) -> anyhow::Result<()> {
    let each = campaign.each_track();
    let logs = each.iter().flat_map(|one| {
        let radar = one.radar.file.as_path();
        std::iter::once(radar).chain(one.position_files())
    });
    let inputs: Vec<PathBuf> = logs
        .chain(campaign.image.terrain.as_deref())
        .chain([file])
        .filter_map(|path| path.canonicalize().ok())
        .collect();
    for name in PRODUCTS {
        let place = directory.join(name);
        let clash = place.canonicalize().is_ok_and(|p| inputs.contains(&p));
        anyhow::ensure!(
            !clash,
            "{}: is an input and would be overwritten; name another directory with -o",
            place.display()
        );
    }
    Ok(())
}

/// What a campaign is called: as its file, or as the folder of one that is called `campaign`.
fn name_of_campaign(file: &Path) -> String {
    let of = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = of(file.file_stem()).unwrap_or_default();
    let folder = std::path::absolute(file)
        .ok()
        .and_then(|file| of(file.parent()?.file_name()));
    match folder {
        Some(folder) if stem == "campaign" => folder,
        _ => stem,
    }
}

fn default_output(campaign: &Path) -> PathBuf {
    let stem = campaign
        .file_stem()
        .unwrap_or(campaign.as_os_str())
        .to_string_lossy();
    campaign.with_file_name(format!("{stem}-products"))
}

fn summarise(
    outcome: &Outcome,
    stages: &Stages,
    directory: &Path,
    explain: bool,
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    let aligned = &outcome.aligned;
    let ground = &outcome.focused.ground;
    let grid = &ground.grid;
    writeln!(out, "radar      {}", outcome.radar.summary)?;
    write!(
        out,
        "traces     {} of {} imaged, over {:.2} m of path",
        aligned.traces.len(),
        outcome.traces_in_log,
        aligned.path_m.iter().sum::<f64>()
    )?;
    writeln!(out, ", time offset {:.4} s", aligned.time_offset_s)?;
    if let Some(search) = &aligned.search {
        writeln!(
            out,
            "           found: motion correlates with {:.2} (elsewhere {:.2}), image {:.2} times \
             sharper than the median",
            search.motion.correlation, search.motion.runner_up, search.sharpness_ratio
        )?;
    }
    for track in &outcome.tracks {
        let k = &track.calibration;
        write!(
            out,
            "track      {}: {} traces, {:+.3} ns and {:+.1}° taken off as given",
            track.name,
            track.aligned.traces.len(),
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
    }
    if let Some(traces) = &outcome.cleaned.traces {
        writeln!(out, "fast time  shifted by {:+.3} ns", traces.shift_s * 1e9)?;
    }
    write!(
        out,
        "image      {} × {} pixels of {} m {}",
        grid.nx,
        grid.ny,
        grid.pixel_m,
        ground.describe()
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
    write_targets(outcome, out)?;
    for warning in &outcome.warnings {
        writeln!(out, "warning    {warning}")?;
    }
    let seconds: f64 = stages.done().iter().map(|stage| stage.seconds).sum();
    writeln!(out, "products   {} in {seconds:.2} s", directory.display())?;
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
