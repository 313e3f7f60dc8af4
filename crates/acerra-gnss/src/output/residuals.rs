//! The residual file.

use std::io::{self, Write};

use crate::solution::PpkSolution;

/// Writes the residuals of every satellite and frequency of every epoch as CSV.
///
/// Columns: `time_gpst` (`yyyy/mm/dd hh:mm:ss.sss`), `quality` (RTKLIB's number), `satellite`,
/// `frequency` (1 L1, 2 L2 or E5b, 3 L5), `azimuth_deg`, `elevation_deg`, `phase_m` and `code_m`
/// (double differences after the update, empty where the measurement was not used), `slipped`,
/// `fixed` (0 or 1).
///
/// # Errors
/// Errors of the writer.
pub fn write_residuals(mut out: impl Write, solution: &PpkSolution) -> io::Result<()> {
    writeln!(
        out,
        "time_gpst,quality,satellite,frequency,azimuth_deg,elevation_deg,phase_m,code_m,slipped,\
         fixed"
    )?;
    let value = |residual: Option<f64>| residual.map_or_else(String::new, |r| format!("{r:.4}"));
    for epoch in &solution.epochs {
        let (time, quality) = (epoch.time.format_calendar(3), epoch.quality.number());
        for r in &epoch.residuals {
            writeln!(
                out,
                "{time},{quality},{},{},{:.2},{:.2},{},{},{},{}",
                r.satellite,
                r.slot + 1,
                r.azimuth_rad.to_degrees().rem_euclid(360.0),
                r.elevation_rad.to_degrees(),
                value(r.phase_m),
                value(r.code_m),
                u8::from(r.slipped),
                u8::from(r.fixed)
            )?;
        }
    }
    Ok(())
}
