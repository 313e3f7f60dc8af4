//! `acerra calibrate`: delay, clock offset, lever arm and range scale from reflectors at known places.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use acerra_chain::calibrate::read_points;
use acerra_chain::{Control, Journal};
use acerra_products::calibration::{
    CalibrationOutcome, CalibrationRecord, CampaignFile, keys_at_rest,
};
use acerra_settings::Assignment;

use super::values::{not_negative, point_m, positive};
use crate::interrupt::cancel_flag;
use crate::terminal::warn;

/// Calibrate delay, clock offset, lever arm and range scale on reflectors at known places.
///
/// Deviations include noise, errors of the positions and errors of the survey. Echoes that overlap with the surface echo or another
/// reflector are not used.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    acerra calibrate campaign.toml --reflector 4,0,0.1 --reflector 14,-3,0.1\n  \
    acerra calibrate campaign.toml --survey points.csv -o calibration --write\n  \
    acerra calibrate bench.toml --range-m 6.20")]
#[command(group(clap::ArgGroup::new("targets").required(true)))]
pub struct Args {
    /// The campaign file (TOML).
    #[arg(value_name = "CAMPAIGN.toml")]
    pub(crate) campaign: PathBuf,
    /// Place of a reflector's phase centre: east, north, up (m) in the campaign's frame. May be
    /// given several times.
    #[arg(long, value_name = "X,Y,Z", value_parser = point_m, allow_hyphen_values = true,
          group = "targets")]
    reflector: Vec<[f64; 3]>,
    /// Places of the reflectors: a CSV file with lines x_m,y_m,z_m or name,x_m,y_m,z_m.
    #[arg(long, value_name = "POINTS.csv", group = "targets")]
    survey: Option<PathBuf>,
    /// Standard deviation of each coordinate of a reflector's surveyed place (m).
    #[arg(long, value_name = "S", value_parser = not_negative, default_value = "0.02",
          conflicts_with = "range_m")]
    survey_sigma_m: f64,
    /// The radar is at rest, and a reflector is at this range from its antennas (m): finds the delay alone.
    #[arg(long, value_name = "R", value_parser = positive, group = "targets")]
    range_m: Option<f64>,
    /// Standard deviation of that range (m).
    #[arg(long, value_name = "S", value_parser = not_negative, default_value = "0.005",
          requires = "range_m")]
    range_sigma_m: f64,
    /// Write calibration.json and report.html there.
    #[arg(short, long, value_name = "DIR", conflicts_with = "range_m")]
    output: Option<PathBuf>,
    /// Write the keys into the campaign file; its comments stay.
    #[arg(long)]
    write: bool,
    /// Answer as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// Logs that cannot be read or do not show the reflectors, with the file and the expectation.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let file = CampaignFile::read(&args.campaign)?;
    let mut journal = Journal::default();
    let keys = match args.range_m {
        Some(range_m) => at_rest(args, &file, range_m, &mut journal, out),
        None => on_reflectors(args, &file, &mut journal, out),
    };
    if keys.is_err() {
        // Remarks help to understand a failure as well.
        journal.warnings.said().iter().for_each(|text| warn(text));
    }
    let keys = keys?;
    if args.write {
        file.write_keys(&keys)?;
    }
    Ok(())
}

fn on_reflectors(
    args: &Args,
    file: &CampaignFile,
    journal: &mut Journal,
    out: &mut dyn Write,
) -> anyhow::Result<Vec<Assignment>> {
    let reflector_m = match &args.survey {
        Some(survey) => places(survey)?,
        None => args.reflector.clone(),
    };
    let control = Control::default().cancelled_by(cancel_flag());
    let outcome = file.calibrate(reflector_m, args.survey_sigma_m, journal, &control)?;
    if let Some(directory) = &args.output {
        outcome.deliver(&file.path.display().to_string(), directory)?;
    }
    let keys = outcome.keys();
    if args.json {
        let record = CalibrationRecord::of(&outcome);
        writeln!(out, "{}", serde_json::to_string(&record)?)?;
    } else {
        summarise(&outcome, out)?;
        show(file, &keys, args.write, out)?;
    }
    Ok(keys)
}

fn at_rest(
    args: &Args,
    file: &CampaignFile,
    range_m: f64,
    journal: &mut Journal,
    out: &mut dyn Write,
) -> anyhow::Result<Vec<Assignment>> {
    let found = file.delay_at_rest(range_m, args.range_sigma_m, journal)?;
    let keys = keys_at_rest(&file.campaign, &found);
    let warnings = journal.warnings.said();
    if args.json {
        let record = serde_json::json!({
            "delay_ns": found.delay_s * 1e9,
            "sigma_ns": found.sigma_s * 1e9,
            "contrast_db": found.contrast_db,
            "coupling_seen": found.coupling_seen,
            "traces": found.traces,
            "warnings": warnings,
        });
        writeln!(out, "{record}")?;
        return Ok(keys);
    }
    writeln!(
        out,
        "delay      {:.4} ± {:.4} ns, from {} traces at rest, the echo {:.0} dB over their median",
        found.delay_s * 1e9,
        found.sigma_s * 1e9,
        found.traces,
        found.contrast_db
    )?;
    for warning in warnings {
        writeln!(out, "warning    {warning}")?;
    }
    show(file, &keys, args.write, out)?;
    Ok(keys)
}

fn places(survey: &Path) -> anyhow::Result<Vec<[f64; 3]>> {
    let at = || survey.display().to_string();
    let text = std::fs::read_to_string(survey).with_context(at)?;
    let points = read_points(&text).with_context(at)?;
    Ok(points.into_iter().map(|point| point.position_m).collect())
}

fn summarise(outcome: &CalibrationOutcome, out: &mut dyn Write) -> anyhow::Result<()> {
    let record = CalibrationRecord::of(outcome);
    for e in &record.estimates {
        match e.sigma {
            Some(sigma) => writeln!(
                out,
                "{:<18} {:.4} ± {:.4} {} (campaign: {:.4})",
                e.name, e.value, sigma, e.unit, e.campaign
            )?,
            None => writeln!(
                out,
                "{:<18} not observable, kept at {:.4} {}",
                e.name, e.value, e.unit
            )?,
        }
    }
    for s in &record.sensitivity {
        writeln!(
            out,
            "{:<18} moves by {:+.4} {} {}",
            s.of, s.slope, s.unit, s.to
        )?;
    }
    for (k, r) in record.reflectors.iter().enumerate() {
        writeln!(
            out,
            "reflector {:<8} {} of {} echoes, {:.1} mm rms",
            k + 1,
            r.kept,
            r.echoes,
            1e3 * r.rms_m
        )?;
    }
    for warning in &record.warnings {
        writeln!(out, "warning            {warning}")?;
    }
    Ok(())
}

/// The keys as a campaign file states them.
fn show(
    file: &CampaignFile,
    keys: &[Assignment],
    written: bool,
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    // Refused here where they could not be written either.
    file.with_keys(keys)?;
    let verb = if written { "written into" } else { "for" };
    writeln!(out, "keys       {verb} {}", file.path.display())?;
    for key in keys {
        writeln!(out, "           {key}")?;
    }
    Ok(())
}
