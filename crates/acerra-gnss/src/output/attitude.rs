//! Headings and pitches of baselines.

use std::io::{self, Write};

use crate::solution::PpkSolution;

/// Writes direction and length of the baseline of every epoch as CSV, of a solution with a moving
/// base; epochs without a heading (an upright baseline) keep their length alone.
///
/// Columns: `time_gpst` (`yyyy/mm/dd hh:mm:ss.sss`), `quality` (RTKLIB's number), `heading_deg` (from
/// north over east, base to rover), `heading_sigma_deg`, `pitch_deg` (above the horizon),
/// `pitch_sigma_deg`, `length_m`, `length_sigma_m`.
///
/// # Errors
/// Errors of the writer; [`io::ErrorKind::InvalidInput`] for a solution with a fixed base.
pub fn write_attitudes(mut out: impl Write, solution: &PpkSolution) -> io::Result<()> {
    if solution.epochs.iter().any(|e| e.baseline.is_none()) {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "headings need a moving base",
        ));
    }
    writeln!(
        out,
        "time_gpst,quality,heading_deg,heading_sigma_deg,pitch_deg,pitch_sigma_deg,length_m,\
         length_sigma_m"
    )?;
    for epoch in &solution.epochs {
        let Some(baseline) = epoch.baseline else {
            continue;
        };
        let (time, quality) = (epoch.time.format_calendar(3), epoch.quality.number());
        write!(out, "{time},{quality}")?;
        match baseline.attitude() {
            Some(a) => writeln!(
                out,
                ",{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}",
                a.heading_rad.to_degrees(),
                a.heading_sigma_rad.to_degrees(),
                a.pitch_rad.to_degrees(),
                a.pitch_sigma_rad.to_degrees(),
                a.length_m,
                a.length_sigma_m
            )?,
            None => writeln!(out, ",,,,,{:.4},", baseline.length_m())?,
        }
    }
    Ok(())
}
