//! NMEA 0183 sentences: GGA, RMC and GST.

use std::io::{self, Write};

use acerra_geo::geodesy::EnuFrame;

use crate::solution::{PpkSolution, Quality, Solution};
use acerra_geo::geoid::GeoidGrid;

/// Metres per second in a knot.
const KNOT_M_S: f64 = 1852.0 / 3600.0;

/// Writes GGA, RMC and GST for every position, in UTC, as talker `GN`.
///
/// GGA gives the height above the geoid of `geoid` and the geoid's height above the ellipsoid; without a
/// geoid, or outside its grid, the ellipsoidal height and a separation of 0, so that the sum is right in
/// either case. Dilutions of precision are not known and left empty, as are speed and course where no
/// velocity was estimated. Quality: 4 fixed, 5 float, 2 differential code, 1 single, 9 SBAS, 3 PPP.
///
/// # Errors
/// Errors of the writer.
pub fn write_nmea(
    mut out: impl Write,
    solution: &PpkSolution,
    geoid: Option<&GeoidGrid>,
) -> io::Result<()> {
    for epoch in &solution.epochs {
        for body in [gga(epoch, geoid), rmc(epoch), gst(epoch)] {
            let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
            write!(out, "${body}*{checksum:02X}\r\n")?;
        }
    }
    Ok(())
}

/// Time of day and date (UTC).
fn time_and_date(epoch: &Solution) -> [String; 2] {
    let utc = epoch.time.rounded(3).to_utc();
    [
        format!(
            "{:02}{:02}{:02}.{:03.0}",
            utc.hour,
            utc.minute,
            utc.second,
            (utc.fraction * 1e3).round()
        ),
        format!(
            "{:02}{:02}{:02}",
            utc.day,
            utc.month,
            utc.year.rem_euclid(100)
        ),
    ]
}

/// An angle as degrees and minutes with seven decimals, and the letter of the hemisphere.
fn degrees_minutes(degrees: f64, width: usize, sides: [char; 2]) -> String {
    // The angle is rounded before it is split, so that minutes never reach 60.
    let units = (degrees.abs() * 60e7).round() as i64;
    let (whole, minutes) = (units / 600_000_000, units % 600_000_000);
    let side = sides[usize::from(degrees < 0.0)];
    format!(
        "{whole:0width$}{:02}.{:07},{side}",
        minutes / 10_000_000,
        minutes % 10_000_000
    )
}

fn place(epoch: &Solution) -> (String, EnuFrame) {
    let frame = EnuFrame::from_ecef(epoch.position_ecef_m);
    let place = frame.origin();
    let latitude = degrees_minutes(place.latitude_deg(), 2, ['N', 'S']);
    let longitude = degrees_minutes(place.longitude_deg(), 3, ['E', 'W']);
    (format!("{latitude},{longitude}"), frame)
}

fn gga(epoch: &Solution, geoid: Option<&GeoidGrid>) -> String {
    let [time, _] = time_and_date(epoch);
    let (place_text, frame) = place(epoch);
    let place = frame.origin();
    let quality = match epoch.quality {
        Quality::Fixed => 4,
        Quality::Float => 5,
        Quality::Sbas => 9,
        Quality::Dgps => 2,
        Quality::Single => 1,
        Quality::Ppp => 3,
    };
    let separation_m = geoid
        .and_then(|grid| grid.height_m(place.latitude_deg(), place.longitude_deg()))
        .unwrap_or(0.0);
    let base = match epoch.quality {
        Quality::Single => ",".to_owned(),
        _ => format!("{:.1},0000", epoch.age_s.abs()),
    };
    format!(
        "GNGGA,{time},{place_text},{quality},{:02},,{:.4},M,{separation_m:.4},M,{base}",
        epoch.satellites,
        place.height_m - separation_m,
    )
}

fn rmc(epoch: &Solution) -> String {
    let [time, date] = time_and_date(epoch);
    let (place, frame) = place(epoch);
    let motion = epoch.velocity_ecef_m_s.map_or_else(
        || ",".to_owned(),
        |velocity| {
            let [east, north, _] = frame.enu_vector_from_ecef(velocity);
            let course = east.atan2(north).to_degrees().rem_euclid(360.0);
            format!("{:.3},{course:.2}", east.hypot(north) / KNOT_M_S)
        },
    );
    let mode = match epoch.quality {
        Quality::Fixed => 'R',
        Quality::Float => 'F',
        Quality::Sbas | Quality::Dgps => 'D',
        Quality::Single => 'A',
        Quality::Ppp => 'P',
    };
    format!("GNRMC,{time},A,{place},{motion},{date},,,{mode}")
}

/// Standard deviations: error ellipse (semi-axes and direction of the longer from north), latitude,
/// longitude, height.
fn gst(epoch: &Solution) -> String {
    let [time, _] = time_and_date(epoch);
    let frame = EnuFrame::from_ecef(epoch.position_ecef_m);
    let c = frame.enu_covariance_from_ecef(&epoch.covariance_ecef_m2);
    let (east, north, mixed) = (c[0][0], c[1][1], c[0][1]);
    let mean = 0.5 * (east + north);
    let radius = (0.5 * (north - east)).hypot(mixed);
    let orientation = (0.5 * (2.0 * mixed).atan2(north - east)).to_degrees();
    let sigma = |variance: f64| variance.max(0.0).sqrt();
    format!(
        "GNGST,{time},,{:.4},{:.4},{:.1},{:.4},{:.4},{:.4}",
        sigma(mean + radius),
        sigma(mean - radius),
        orientation.rem_euclid(180.0),
        sigma(north),
        sigma(east),
        sigma(c[2][2])
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minutes_never_reach_sixty() {
        let text = |degrees| degrees_minutes(degrees, 2, ['N', 'S']);
        assert_eq!(text(47.999_999_999_999), "4800.0000000,N");
        assert_eq!(text(-5.5), "0530.0000000,S");
        assert_eq!(
            degrees_minutes(8.504_211_7, 3, ['E', 'W']),
            "00830.2527020,E"
        );
    }
}
