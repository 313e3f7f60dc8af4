//! `acerra info`: describes any supported file.

use std::io::Write;
use std::path::PathBuf;

use serde_json::Value;

use crate::describe::{Description, describe};
use crate::terminal;

/// Describe any supported file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra info flight.mrm rover.ubx base.obs
  acerra info --json flight.mrm | jq .facts")]
pub struct Args {
    /// Radar logs, trajectories, GNSS logs and configurations, terrain, geoid grids, images.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Answer as JSON: one object for each file.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// Unreadable files or files of unsupported kinds: the last of them, after the others have been reported and
/// all readable files described.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut failure = None;
    for (k, file) in args.files.iter().enumerate() {
        let description = match describe(file) {
            Ok(description) => description,
            Err(error) => {
                if let Some(earlier) = failure.replace(error) {
                    terminal::fail(&earlier);
                }
                continue;
            }
        };
        if args.json {
            let mut object = serde_json::to_value(&description)?;
            object["file"] = Value::from(file.display().to_string());
            writeln!(out, "{object}")?;
        } else {
            if k > 0 {
                writeln!(out)?;
            }
            writeln!(out, "{}: {}", file.display(), description.kind)?;
            write_text(&description, out)?;
        }
    }
    failure.map_or(Ok(()), Err)
}

fn write_text(description: &Description, out: &mut dyn Write) -> anyhow::Result<()> {
    for (name, value) in &description.facts {
        let (label, mut unit) = label_and_unit(name);
        let text = match value {
            // Sampling intervals of radars are picoseconds.
            Value::Number(n)
                if unit == "s" && n.as_f64().is_some_and(|s| s != 0.0 && s.abs() < 1e-6) =>
            {
                unit = "ns";
                round(1e9 * n.as_f64().unwrap_or(f64::NAN))
            }
            Value::Number(n) if n.is_f64() => round(n.as_f64().unwrap_or(f64::NAN)),
            Value::Array(ends) => {
                let ends: Vec<String> = ends
                    .iter()
                    .map(|v| v.as_f64().map_or(v.to_string(), round))
                    .collect();
                ends.join(" … ")
            }
            Value::String(text) => text.clone(),
            Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
            Value::Object(named) => named
                .iter()
                .map(|(name, v)| {
                    let text = v.as_str().map_or_else(|| v.to_string(), str::to_owned);
                    format!("{name} {text}")
                })
                .collect::<Vec<_>>()
                .join(", "),
            Value::Null => "–".to_owned(),
            other => other.to_string(),
        };
        writeln!(
            out,
            "  {label:<24} {text}{}{unit}",
            if unit.is_empty() { "" } else { " " }
        )?;
    }
    for note in &description.notes {
        writeln!(out, "  - {note}")?;
    }
    Ok(())
}

/// Splits the unit off a name: `scan_interval_ms` is `scan interval` in `ms`.
fn label_and_unit(name: &str) -> (String, &str) {
    let units = [
        ("_deg_m", "° ° m"),
        ("_ghz", "GHz"),
        ("_hz", "Hz"),
        ("_ns", "ns"),
        ("_ps", "ps"),
        ("_ms", "ms"),
        ("_deg", "°"),
        ("_s", "s"),
        ("_m", "m"),
        ("_gpst", "GPST"),
    ];
    let found = units
        .iter()
        .find_map(|(end, unit)| name.strip_suffix(end).map(|n| (n, *unit)));
    let (stem, unit) = found.unwrap_or((name, ""));
    (stem.replace('_', " "), unit)
}

/// Nine significant digits, without trailing zeros.
fn round(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    #[expect(clippy::cast_possible_truncation, reason = "at most 309 digits")]
    let digits = (8 - value.abs().log10().floor() as i32).clamp(0, 12);
    let scale = 10.0_f64.powi(digits);
    ((value * scale).round() / scale).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_labels_with_units() {
        assert_eq!(
            label_and_unit("scan_interval_ms"),
            ("scan interval".to_owned(), "ms")
        );
        assert_eq!(
            label_and_unit("whole_scans"),
            ("whole scans".to_owned(), "")
        );
        assert_eq!(round(21.572_812_345_678), "21.5728123");
        assert_eq!(round(-0.5), "-0.5");
        assert_eq!(round(0.0), "0");
    }
}
