//! The comment lines of a solution file.

use std::io::{self, Write};

use acerra_geo::geodesy::geodetic_from_ecef;

use super::format::{PosFormat, PosFrame, PosTime, PosTimeScale};
use crate::observations::satellite::System;
use crate::options::{
    AmbiguityMode, FilterDirection, GlonassAmbiguity, PositioningMode, PpkOptions,
};
use crate::solution::PpkSolution;

/// Sources and settings of the file.
pub(super) fn write_header(
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

/// The line that names the columns.
pub(super) fn write_columns(out: &mut impl Write, format: &PosFormat) -> io::Result<()> {
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
