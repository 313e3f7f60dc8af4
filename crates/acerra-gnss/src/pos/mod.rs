//! RTKLIB's solution files (`.pos`).

mod format;
mod header;

use std::io::{self, Write};

use acerra_geo::geodesy::EnuFrame;

use crate::options::{PositioningMode, PpkOptions};
use crate::solution::{Baseline, PpkSolution, Solution};
use format::time_text;
use header::{write_columns, write_header};

pub use format::{PosFormat, PosFrame, PosTime, PosTimeScale};

/// Writes a solution in RTKLIB's format, with the same columns, widths and comment lines, so that RTKLIB's
/// tools and compatible programs can read the file.
///
/// `inputs` are the names of the files used, for the header. As in RTKLIB, epochs without a position are not
/// written. Standard deviations of negative variance are 0, covariances are written as sign(c)·√|c|.
///
/// # Errors
/// Errors of the writer; [`io::ErrorKind::InvalidInput`] for a baseline without a base, and for a position
/// outside the grid of the geoid.
pub fn write_pos(
    mut out: impl Write,
    solution: &PpkSolution,
    options: &PpkOptions,
    inputs: &[String],
    format: &PosFormat,
) -> io::Result<()> {
    let moves = options.mode == PositioningMode::MovingBase;
    let base = match (format.frame, solution.base_position_ecef_m) {
        (PosFrame::EnuBaseline, None) if !moves => {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "a baseline needs a base position",
            ));
        }
        (_, base) => base,
    };
    if format.header {
        write_header(&mut out, solution, options, inputs, format)?;
    }
    write_columns(&mut out, format)?;
    let frame = base.map(EnuFrame::from_ecef);
    for epoch in &solution.epochs {
        let own = epoch.baseline.as_ref().map(Baseline::frame);
        write_epoch(&mut out, epoch, own.as_ref().or(frame.as_ref()), format)?;
    }
    Ok(())
}

fn write_epoch(
    out: &mut impl Write,
    epoch: &Solution,
    base: Option<&EnuFrame>,
    format: &PosFormat,
) -> io::Result<()> {
    write!(out, "{}", time_text(epoch.time, format))?;
    // Covariances in the order of the columns: xx, yy, zz, xy, yz, zx.
    let in_order = |c: &[[f64; 3]; 3], [i, j, k]: [usize; 3]| {
        [c[i][i], c[j][j], c[k][k], c[i][j], c[j][k], c[k][i]]
    };
    let covariance = match format.frame {
        PosFrame::Geodetic => {
            let here = EnuFrame::from_ecef(epoch.position_ecef_m);
            let place = here.origin();
            write!(
                out,
                " {:14.9} {:14.9} {:10.4}",
                place.latitude_deg(),
                place.longitude_deg(),
                format.height_m(place)?
            )?;
            // North, east, up.
            in_order(
                &here.enu_covariance_from_ecef(&epoch.covariance_ecef_m2),
                [1, 0, 2],
            )
        }
        PosFrame::Ecef => {
            let [x, y, z] = epoch.position_ecef_m;
            write!(out, " {x:14.4} {y:14.4} {z:14.4}")?;
            in_order(&epoch.covariance_ecef_m2, [0, 1, 2])
        }
        PosFrame::EnuBaseline => {
            let Some(base) = base else { return Ok(()) };
            let [e, n, u] = base.enu_from_ecef(epoch.position_ecef_m);
            write!(out, " {e:14.4} {n:14.4} {u:14.4}")?;
            in_order(
                &base.enu_covariance_from_ecef(&epoch.relative_covariance_ecef_m2()),
                [0, 1, 2],
            )
        }
    };
    write!(out, " {:3} {:3}", epoch.quality.number(), epoch.satellites)?;
    for (i, value) in covariance.into_iter().enumerate() {
        let deviation = match i {
            0..3 => value.max(0.0).sqrt(),
            _ => value.signum() * value.abs().sqrt(),
        };
        // No negative zero.
        let rounded = (deviation * 1e4).round() / 1e4 + 0.0;
        write!(out, " {rounded:8.4}")?;
    }
    write!(out, " {:6.2} {:6.1}", epoch.age_s, epoch.ratio)?;
    if let Some(velocity) = epoch.velocity_ecef_m_s.filter(|_| format.velocity) {
        let here = || EnuFrame::from_ecef(epoch.position_ecef_m);
        let [a, b, c] = match (format.frame, base) {
            (PosFrame::Ecef, _) => velocity,
            (PosFrame::EnuBaseline, Some(base)) => base.enu_vector_from_ecef(velocity),
            _ => {
                let [east, north, up] = here().enu_vector_from_ecef(velocity);
                [north, east, up]
            }
        };
        write!(out, " {a:10.5} {b:10.5} {c:9.5}")?;
    }
    writeln!(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solution::{PpkSummary, Quality};
    use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
    use acerra_geo::time::GpsTime;

    fn solution() -> (PpkSolution, EnuFrame) {
        let base = EnuFrame::new(Geodetic::from_degrees(41.0, 14.4, 60.0));
        let enu = [
            [4e-4, -1e-5, 2e-5],
            [-1e-5, 9e-4, -3e-5],
            [2e-5, -3e-5, 25e-4],
        ];
        let epoch = |n: f64| Solution {
            time: GpsTime::from_week_tow(2445, 475_200.0 + n) + 0.9996,
            position_ecef_m: base.ecef_from_enu([10.0 + n, -5.0, 2.5]),
            covariance_ecef_m2: base.ecef_covariance_from_enu(&enu),
            baseline: None,
            velocity_ecef_m_s: None,
            quality: if n < 1.0 {
                Quality::Fixed
            } else {
                Quality::Float
            },
            satellites: 9,
            age_s: -0.25,
            ratio: 12.34,
            not_fixed: None,
            residuals: Vec::new(),
        };
        let solution = PpkSolution {
            base_position_ecef_m: Some(ecef_from_geodetic(base.origin())),
            epochs: vec![epoch(0.0), epoch(1.0)],
            lost: Vec::new(),
            events: Vec::new(),
            summary: PpkSummary::default(),
        };
        (solution, base)
    }

    fn text(format: &PosFormat) -> String {
        let mut out = Vec::new();
        let (solution, _) = solution();
        let inputs = ["rover.obs".to_owned(), "bad\nname".to_owned()];
        write_pos(&mut out, &solution, &PpkOptions::default(), &inputs, format).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn baselines_as_rtklib_prints_them() {
        let format = PosFormat {
            frame: PosFrame::EnuBaseline,
            ..PosFormat::default()
        };
        let text = text(&format);
        let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with('%')).collect();
        assert_eq!(
            lines[0],
            "2026/11/20 12:00:01.000        10.0000        -5.0000         2.5000   1   9   \
             0.0200   0.0300   0.0500  -0.0032  -0.0055   0.0045  -0.25   12.3"
        );
        assert_eq!(lines.len(), 2);
        let columns = text.lines().rfind(|l| l.starts_with('%')).unwrap();
        assert_eq!(
            columns,
            "%  GPST                  e-baseline(m)  n-baseline(m)  u-baseline(m)   Q  ns   \
             sde(m)   sdn(m)   sdu(m)  sden(m)  sdnu(m)  sdue(m) age(s)  ratio"
        );
        assert_eq!(columns.len(), lines[0].len());
        assert!(text.contains("% inp file  : bad name\n"));
    }

    #[test]
    fn times_in_all_scales_and_forms() {
        let first = |time, scale| {
            let text = text(&PosFormat {
                time,
                scale,
                header: false,
                ..PosFormat::default()
            });
            text.lines().find(|l| !l.starts_with('%')).unwrap()[..23].to_owned()
        };
        let calendar = |scale| first(PosTime::Calendar, scale);
        assert_eq!(calendar(PosTimeScale::Gps), "2026/11/20 12:00:01.000");
        assert_eq!(calendar(PosTimeScale::Utc), "2026/11/20 11:59:43.000");
        assert_eq!(calendar(PosTimeScale::Jst), "2026/11/20 20:59:43.000");
        assert!(first(PosTime::WeekTow, PosTimeScale::Gps).starts_with("2445 475201.000 "));
        assert!(first(PosTime::WeekTow, PosTimeScale::Utc).starts_with("2445 475183.000 "));
    }

    #[test]
    fn a_baseline_needs_a_base() {
        let (mut solution, _) = solution();
        solution.base_position_ecef_m = None;
        let format = PosFormat {
            frame: PosFrame::EnuBaseline,
            ..PosFormat::default()
        };
        let mut out = Vec::new();
        let result = write_pos(&mut out, &solution, &PpkOptions::default(), &[], &format);
        assert!(result.is_err());
        assert!(out.is_empty());
    }
}
