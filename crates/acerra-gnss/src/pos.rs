//! RTKLIB's solution files (`.pos`).

use std::io::{self, Write};
use std::sync::Arc;

use acerra_geo::geodesy::{EnuFrame, Geodetic, geodetic_from_ecef};
use acerra_geo::geoid::GeoidGrid;
use acerra_geo::time::GpsTime;

use crate::{
    AmbiguityMode, Baseline, FilterDirection, GlonassAmbiguity, PositioningMode, PpkOptions,
    PpkSolution, Solution, System,
};

/// Coordinates of a solution file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosFrame {
    /// Latitude and longitude in degrees, ellipsoidal height; covariance in axes at the solution.
    #[default]
    Geodetic,
    /// Earth-centred, Earth-fixed.
    Ecef,
    /// Baseline from the base, in its local axes.
    EnuBaseline,
}

/// How times are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosTime {
    /// `yyyy/mm/dd hh:mm:ss.sss`.
    #[default]
    Calendar,
    /// Week and seconds of week.
    WeekTow,
}

/// The scale of the times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosTimeScale {
    /// GPS time.
    #[default]
    Gps,
    /// Coordinated universal time.
    Utc,
    /// Japan standard time, UTC + 9 h.
    Jst,
}

/// The layout of a solution file.
#[derive(Debug, Clone, PartialEq)]
pub struct PosFormat {
    /// Coordinates.
    pub frame: PosFrame,
    /// Form of the times.
    pub time: PosTime,
    /// Scale of the times.
    pub scale: PosTimeScale,
    /// Decimals of the seconds.
    pub decimals: usize,
    /// Whether the lines about inputs and options are written.
    pub header: bool,
    /// Whether velocities are written (m/s): north, east, up with geodetic positions, else along
    /// the axes of the positions. Where none was estimated the line ends before them.
    pub velocity: bool,
    /// The geoid that the heights of geodetic positions count from (RTKLIB's
    /// `out-height = geodetic`); `None` for heights above the ellipsoid.
    pub geoid: Option<Arc<GeoidGrid>>,
}

impl PosFormat {
    /// Height above the ellipsoid (m) where there is no geoid.
    fn height_m(&self, place: &Geodetic) -> io::Result<f64> {
        let Some(geoid) = &self.geoid else {
            return Ok(place.height_m);
        };
        let (latitude, longitude) = (place.latitude_deg(), place.longitude_deg());
        let separation_m = geoid.height_m(latitude, longitude).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("the geoid grid does not cover {latitude:.6}° {longitude:.6}°"),
            )
        })?;
        Ok(place.height_m - separation_m)
    }
}

impl Default for PosFormat {
    fn default() -> Self {
        Self {
            frame: PosFrame::default(),
            time: PosTime::default(),
            scale: PosTimeScale::default(),
            decimals: 3,
            header: true,
            velocity: false,
            geoid: None,
        }
    }
}

/// Writes a solution as RTKLIB does: same columns, widths and comment lines, so that its tools
/// and everything made for them read it.
///
/// `inputs` are the names of the files used, for the header. Epochs without a position are not
/// written, as there. Standard deviations of negative variance are 0, covariances are written as
/// sign(c)·√|c|.
///
/// # Errors
/// Those of the writer; [`io::ErrorKind::InvalidInput`] for a baseline without a base, and for a
/// position outside the grid of the geoid.
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

fn write_header(
    out: &mut impl Write,
    solution: &PpkSolution,
    options: &PpkOptions,
    inputs: &[String],
    format: &PosFormat,
) -> io::Result<()> {
    writeln!(out, "% program   : Acerra {}", env!("CARGO_PKG_VERSION"))?;
    for input in inputs {
        // A line break in a name must not become a line of data.
        let name: String = input
            .chars()
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        writeln!(out, "% inp file  : {name}")?;
    }
    let ends = [
        ("start", solution.epochs.first()),
        ("end", solution.epochs.last()),
    ];
    for (name, epoch) in ends {
        let Some(epoch) = epoch else { continue };
        let t = epoch.time.rounded(1);
        let name = format!("obs {name}");
        writeln!(
            out,
            "% {name:<10}: {} GPST (week{:04} {:8.1}s)",
            t.format_calendar(1),
            t.week(),
            t.tow_s()
        )?;
    }
    let switch = |on: bool| if on { "on" } else { "off" };
    let mode = match options.mode {
        PositioningMode::Single => "Single",
        PositioningMode::Dgps => "DGPS",
        PositioningMode::Kinematic => "Kinematic",
        PositioningMode::Static => "Static",
        PositioningMode::MovingBase => "Moving-Base",
    };
    writeln!(out, "% pos mode  : {mode}")?;
    if options.mode != PositioningMode::Single {
        let frequencies = ["L1", "L1+L2", "L1+L2+L5"][options.frequencies.clamp(1, 3) - 1];
        writeln!(out, "% freqs     : {frequencies}")?;
        let direction = match options.direction {
            FilterDirection::Forward => "Forward",
            FilterDirection::Backward => "Backward",
            FilterDirection::Combined => "Combined",
            FilterDirection::CombinedWithoutReset => "Combined-no phase reset",
        };
        writeln!(out, "% solution  : {direction}")?;
    }
    writeln!(
        out,
        "% elev mask : {:.1} deg",
        options.elevation_mask_rad.to_degrees()
    )?;
    if options.mode != PositioningMode::Single {
        writeln!(out, "% dynamics  : {}", switch(options.dynamics.is_some()))?;
        writeln!(out, "% tidecorr  : off")?;
    }
    writeln!(out, "% ionos opt : Broadcast")?;
    writeln!(out, "% tropo opt : Saastamoinen")?;
    writeln!(out, "% ephemeris : Broadcast")?;
    let systems: Vec<&str> = options
        .systems
        .iter()
        .map(|s| if s == System::Beidou { "BDS" } else { s.name() })
        .collect();
    writeln!(out, "% navi sys  : {}", systems.join(" "))?;
    if options.mode.uses_phases() {
        let ambiguity = match options.ambiguity {
            AmbiguityMode::Off => "OFF",
            AmbiguityMode::Continuous => "Continuous",
            AmbiguityMode::Instantaneous => "Instantaneous",
            AmbiguityMode::FixAndHold => "Fix and Hold",
        };
        writeln!(out, "% amb res   : {ambiguity}")?;
        if options.systems.contains(System::Glonass) {
            let glonass = match options.glonass_ambiguity {
                GlonassAmbiguity::Off => "OFF",
                GlonassAmbiguity::On => "ON",
                GlonassAmbiguity::Auto => "Auto Calibration",
                GlonassAmbiguity::FixAndHold => "Fix and Hold",
            };
            writeln!(out, "% amb glo   : {glonass}")?;
        }
        if options.ambiguity != AmbiguityMode::Off {
            writeln!(out, "% val thres : {:.1}", options.ratio_threshold)?;
        }
    }
    if let Some(base) = solution.base_position_ecef_m {
        for (n, [e, north, u]) in [(1, options.rover_antenna_m), (2, options.base_antenna_m)] {
            writeln!(
                out,
                "% antenna{n}  : {:<21} ({e:7.4} {north:7.4} {u:7.4})",
                ""
            )?;
        }
        if format.frame == PosFrame::Ecef {
            let [x, y, z] = base;
            writeln!(out, "% ref pos   :{x:14.4} {y:14.4} {z:14.4}")?;
        } else {
            let place = geodetic_from_ecef(base);
            let height_m = match format.frame {
                PosFrame::Geodetic => format.height_m(&place)?,
                _ => place.height_m,
            };
            writeln!(
                out,
                "% ref pos   :{:13.9} {:14.9} {height_m:10.4}",
                place.latitude_deg(),
                place.longitude_deg(),
            )?;
        }
    }
    writeln!(out, "%")
}

fn write_columns(out: &mut impl Write, format: &PosFormat) -> io::Result<()> {
    let coordinates = match format.frame {
        PosFrame::Geodetic if format.geoid.is_some() => "lat/lon/height=WGS84/geodetic",
        PosFrame::Geodetic => "lat/lon/height=WGS84/ellipsoidal",
        PosFrame::Ecef => "x/y/z-ecef=WGS84",
        PosFrame::EnuBaseline => "e/n/u-baseline=WGS84",
    };
    writeln!(
        out,
        "% ({coordinates},Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites)"
    )?;
    let scale = match format.scale {
        PosTimeScale::Gps => "GPST",
        PosTimeScale::Utc => "UTC",
        PosTimeScale::Jst => "JST",
    };
    // The time column is as wide as the times below it.
    let width = match format.time {
        PosTime::Calendar => 16,
        PosTime::WeekTow => 8,
    } + if format.decimals > 0 {
        format.decimals + 1
    } else {
        0
    };
    let [names, deviations] = match format.frame {
        PosFrame::Geodetic => [
            ["latitude(deg)", "longitude(deg)", "height(m)"],
            ["sdn", "sde", "sdu"],
        ],
        PosFrame::Ecef => [
            ["x-ecef(m)", "y-ecef(m)", "z-ecef(m)"],
            ["sdx", "sdy", "sdz"],
        ],
        PosFrame::EnuBaseline => [
            ["e-baseline(m)", "n-baseline(m)", "u-baseline(m)"],
            ["sde", "sdn", "sdu"],
        ],
    };
    let last = if format.frame == PosFrame::Geodetic {
        10
    } else {
        14
    };
    let mixed = match format.frame {
        PosFrame::Geodetic => ["sdne", "sdeu", "sdun"],
        PosFrame::Ecef => ["sdxy", "sdyz", "sdzx"],
        PosFrame::EnuBaseline => ["sden", "sdnu", "sdue"],
    };
    write!(out, "%  {scale:<width$}")?;
    write!(
        out,
        " {:>14} {:>14} {:>last$}",
        names[0], names[1], names[2]
    )?;
    write!(out, " {:>3} {:>3}", "Q", "ns")?;
    for name in deviations.iter().chain(&mixed) {
        write!(out, " {:>8}", format!("{name}(m)"))?;
    }
    write!(out, " {:>6} {:>6}", "age(s)", "ratio")?;
    if format.velocity {
        let [a, b, c] = match format.frame {
            PosFrame::Geodetic => ["vn(m/s)", "ve(m/s)", "vu(m/s)"],
            PosFrame::Ecef => ["vx(m/s)", "vy(m/s)", "vz(m/s)"],
            PosFrame::EnuBaseline => ["ve(m/s)", "vn(m/s)", "vu(m/s)"],
        };
        write!(out, " {a:>10} {b:>10} {c:>9}")?;
    }
    writeln!(out)
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

fn time_text(time: GpsTime, format: &PosFormat) -> String {
    let jst_s = 9.0 * 3600.0;
    match (format.time, format.scale) {
        (PosTime::WeekTow, PosTimeScale::Gps) => time.format_week_tow(format.decimals),
        (PosTime::Calendar, PosTimeScale::Gps) => time.format_calendar(format.decimals),
        (PosTime::Calendar, PosTimeScale::Utc) => time.format_utc(format.decimals),
        (PosTime::Calendar, PosTimeScale::Jst) => (time + jst_s).format_utc(format.decimals),
        // Weeks of a scale other than GPS time: the same clock reading, counted in weeks.
        (PosTime::WeekTow, scale) => {
            let ahead_s = if scale == PosTimeScale::Jst {
                jst_s
            } else {
                0.0
            };
            let reading = (time + ahead_s).rounded(format.decimals).to_utc();
            GpsTime::from_calendar(&reading).format_week_tow(format.decimals)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PpkSummary, Quality};
    use acerra_geo::geodesy::ecef_from_geodetic;

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
