//! Trajectories and interpolated positions as tables.

use std::io::{self, Write};

use crate::interpolate::Interpolated;
use crate::matrix::{Matrix3, Vector3};
use crate::time::GpsTime;
use crate::trajectory::{Frame, TimeOrigin, Trajectory};

/// Writes a trajectory as CSV that [`read_trajectory`](crate::read::read_trajectory) reproduces bitwise,
/// except for covariances between axes.
///
/// Two comment lines (`#`) keep the frame's origin and the instant of second zero, when known;
/// columns without a single value are left out.
///
/// # Errors
/// Errors of the writer.
pub fn write_trajectory_csv(mut out: impl Write, trajectory: &Trajectory) -> io::Result<()> {
    if let Frame::Enu(frame) = trajectory.frame() {
        let o = frame.origin();
        let (lat, lon) = (o.latitude_deg(), o.longitude_deg());
        writeln!(out, "# origin_deg_m: {lat} {lon} {}", o.height_m)?;
    }
    if let TimeOrigin::Gps(zero) = trajectory.time_origin() {
        writeln!(
            out,
            "# second_zero_gps_week_tow_s: {} {}",
            zero.week(),
            zero.tow_s()
        )?;
    }
    let fixes = trajectory.fixes();
    let has_deviations = fixes.iter().any(|f| f.covariance_m2.is_some());
    let has_velocity = fixes.iter().any(|f| f.velocity_m_s.is_some());
    let has_attitude = fixes.iter().any(|f| f.attitude.is_some());
    let has_satellites = fixes.iter().any(|f| f.satellites.is_some());
    let has_age = fixes.iter().any(|f| f.age_s.is_some());
    let has_ratio = fixes.iter().any(|f| f.ratio.is_some());

    let mut header = "time_s,x_m,y_m,z_m,status".to_owned();
    for (has, names) in [
        (has_deviations, ",sd_x_m,sd_y_m,sd_z_m"),
        (has_velocity, ",vx_m_s,vy_m_s,vz_m_s"),
        (has_attitude, ",qw,qx,qy,qz"),
        (has_satellites, ",satellites"),
        (has_age, ",age_s"),
        (has_ratio, ",ratio"),
    ] {
        if has {
            header.push_str(names);
        }
    }
    writeln!(out, "{header}")?;
    for fix in fixes {
        let [x, y, z] = fix.position_m;
        write!(out, "{},{x},{y},{z},{}", fix.time_s, fix.status)?;
        if has_deviations {
            numbers(&mut out, fix.standard_deviation_m(), 3)?;
        }
        if has_velocity {
            numbers(&mut out, fix.velocity_m_s, 3)?;
        }
        if has_attitude {
            numbers(&mut out, fix.attitude.map(|a| a.quaternion()), 4)?;
        }
        if has_satellites {
            numbers(&mut out, fix.satellites.map(|n| [n]), 1)?;
        }
        if has_age {
            numbers(&mut out, fix.age_s.map(|a| [a]), 1)?;
        }
        if has_ratio {
            numbers(&mut out, fix.ratio.map(|r| [r]), 1)?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Writes cells, or as many empty ones.
fn numbers<T: std::fmt::Display, const N: usize>(
    out: &mut impl Write,
    values: Option<[T; N]>,
    count: usize,
) -> io::Result<()> {
    match values {
        Some(values) => values.iter().try_for_each(|v| write!(out, ",{v}")),
        None => write!(out, "{}", ",".repeat(count)),
    }
}

/// Writes the positions of a series of traces: the product `trajectory.csv`.
///
/// The header is the first line: `trace,time_s,x_m,y_m,z_m,sd_x_m,sd_y_m,sd_z_m,vx_m_s,vy_m_s,
/// vz_m_s,status,flag`, and `latitude_deg,longitude_deg,height_m` when the frame has a place on
/// the Earth, and `gpst` when second zero is an instant. Positions to 0.1 mm, times to 1 µs.
/// Cells that are not known are empty.
///
/// # Errors
/// Errors of the writer.
pub fn write_positions_csv(
    mut out: impl Write,
    positions: &[Interpolated],
    frame: &Frame,
    time_origin: TimeOrigin,
) -> io::Result<()> {
    let enu = frame.enu();
    let zero: Option<GpsTime> = time_origin.gps_time();
    write!(
        out,
        "trace,time_s,x_m,y_m,z_m,sd_x_m,sd_y_m,sd_z_m,vx_m_s,vy_m_s,vz_m_s,status,flag"
    )?;
    if enu.is_some() {
        write!(out, ",latitude_deg,longitude_deg,height_m")?;
    }
    if zero.is_some() {
        write!(out, ",gpst")?;
    }
    writeln!(out)?;
    let deviations = |c: Matrix3| -> Vector3 { [0, 1, 2].map(|i| c[i][i].max(0.0).sqrt()) };
    for (trace, p) in positions.iter().enumerate() {
        let [x, y, z] = p.position_m;
        write!(out, "{trace},{:.6},{x:.4},{y:.4},{z:.4}", p.time_s)?;
        match p.covariance_m2.map(deviations) {
            Some([x, y, z]) => write!(out, ",{x:.4},{y:.4},{z:.4}")?,
            None => write!(out, ",,,")?,
        }
        let [vx, vy, vz] = p.velocity_m_s;
        write!(out, ",{vx:.4},{vy:.4},{vz:.4},{},{}", p.status, p.flag)?;
        if let Some(enu) = enu {
            let g = enu.geodetic_from_enu(p.position_m);
            let (lat, lon) = (g.latitude_deg(), g.longitude_deg());
            write!(out, ",{lat:.9},{lon:.9},{:.4}", g.height_m)?;
        }
        if let Some(zero) = zero {
            write!(out, ",{}", (zero + p.time_s).format_calendar(6))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::{EnuFrame, Geodetic};
    use crate::interpolate::{InterpolationOptions, Interpolator};
    use crate::read::{ReadOptions, read_trajectory};
    use crate::trajectory::Fix;

    #[test]
    fn the_product_can_be_read_and_says_where_it_is() -> Result<(), Box<dyn std::error::Error>> {
        let frame = Frame::Enu(EnuFrame::new(Geodetic::from_degrees(40.9, 14.2, 60.0)));
        let zero = TimeOrigin::Gps(GpsTime::from_week_tow(2100, 0.0));
        let fixes = vec![
            Fix::new(10.0, [0.0, 0.0, 4.0]),
            Fix::new(11.0, [2.0, 0.0, 4.0]),
        ];
        let track = Trajectory::new(frame, zero, fixes)?;
        let at = Interpolator::new(&track, &InterpolationOptions::default());
        let (positions, _) = at.at_all(&[10.25, 12.0]);
        let mut text = Vec::new();
        write_positions_csv(&mut text, &positions, track.frame(), track.time_origin())?;
        let text = String::from_utf8(text)?;
        let rows: Vec<&str> = text.lines().collect();
        assert!(rows[0].starts_with("trace,time_s,x_m,y_m,z_m,sd_x_m"));
        assert_eq!(
            rows[1],
            "0,10.250000,0.5000,0.0000,4.0000,,,,2.0000,0.0000,0.0000,external,ok,\
             40.900000000,14.200005934,64.0000,2020/04/05 00:00:10.250000"
        );
        assert!(rows[2].contains("external,after-end"));
        let (back, _) = read_trajectory(text.as_bytes(), &ReadOptions::default())?;
        assert_eq!(back.fixes()[0].position_m, [0.5, 0.0, 4.0]);
        Ok(())
    }
}
