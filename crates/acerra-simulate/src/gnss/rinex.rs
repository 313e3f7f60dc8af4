//! Logs as RINEX 2.11.

use super::receiver::ReceiverLog;
use acerra_geo::time::GpsTime;
use acerra_gnss::{Ephemeris, KeplerEphemeris, Navigation, System};
use std::fmt::Write as _;

impl ReceiverLog {
    /// The log as a RINEX 2.11 observation file with C1, L1, D1 and S1.
    #[must_use]
    pub fn to_rinex(&self, marker: &str) -> String {
        let mut out = String::new();
        header(
            &mut out,
            &format!("{:>9.2}{:11}OBSERVATION DATA    G (GPS)", 2.11, ""),
            "RINEX VERSION / TYPE",
        );
        let first = self
            .epochs
            .first()
            .map_or(GpsTime::EPOCH, |epoch| epoch.tag);
        run_by(&mut out, first);
        header(
            &mut out,
            &marker.chars().take(60).collect::<String>(),
            "MARKER NAME",
        );
        header(
            &mut out,
            "ACERRA              SIMULATED",
            "OBSERVER / AGENCY",
        );
        header(
            &mut out,
            "SIMULATED           U-BLOX LEA-6T       1.0",
            "REC # / TYPE / VERS",
        );
        header(&mut out, "SIMULATED           PATCH", "ANT # / TYPE");
        let [x, y, z] = self.position_ecef_m;
        header(
            &mut out,
            &format!("{x:14.4}{y:14.4}{z:14.4}"),
            "APPROX POSITION XYZ",
        );
        header(
            &mut out,
            &format!("{:14.4}{:14.4}{:14.4}", 0.0, 0.0, 0.0),
            "ANTENNA: DELTA H/E/N",
        );
        header(&mut out, "     1     0", "WAVELENGTH FACT L1/2");
        header(
            &mut out,
            "     4    C1    L1    D1    S1",
            "# / TYPES OF OBSERV",
        );
        header(&mut out, &format!("{:10.3}", self.interval_s), "INTERVAL");
        let c = first.to_calendar();
        header(
            &mut out,
            &format!(
                "{:6}{:6}{:6}{:6}{:6}{:13.7}     GPS",
                c.year,
                c.month,
                c.day,
                c.hour,
                c.minute,
                c.second_f64()
            ),
            "TIME OF FIRST OBS",
        );
        header(
            &mut out,
            &format!("{:6}", first.gpst_minus_utc_s()),
            "LEAP SECONDS",
        );
        header(&mut out, "", "END OF HEADER");

        for epoch in &self.epochs {
            let c = epoch.tag.to_calendar();
            let _ = write!(
                out,
                " {:02} {:2} {:2} {:2} {:2}{:11.7}  0{:3}",
                c.year % 100,
                c.month,
                c.day,
                c.hour,
                c.minute,
                c.second_f64(),
                epoch.observed.len()
            );
            for (i, seen) in epoch.observed.iter().enumerate() {
                if i > 0 && i % 12 == 0 {
                    let _ = write!(out, "\n{:32}", "");
                }
                let _ = write!(out, "{}", seen.satellite);
            }
            out.push('\n');
            for seen in &epoch.observed {
                let strength = (seen.cn0_db_hz / 6).clamp(1, 9);
                let lock = match seen.loss_of_lock.0 {
                    0 => " ".to_owned(),
                    bits => bits.to_string(),
                };
                let _ = writeln!(
                    out,
                    "{:14.3}  {:14.3}{lock}{strength}{:14.3}  {:14.3}",
                    seen.pseudorange_m,
                    seen.phase_cycles,
                    seen.doppler_hz,
                    f64::from(seen.cn0_db_hz)
                );
            }
        }
        out
    }
}

/// The GPS ephemerides and the ionosphere as a RINEX 2.11 navigation file.
#[must_use]
pub fn navigation_to_rinex(navigation: &Navigation) -> String {
    let mut out = String::new();
    header(
        &mut out,
        &format!("{:>9.2}{:11}N: GPS NAV DATA", 2.11, ""),
        "RINEX VERSION / TYPE",
    );
    let gps: Vec<&KeplerEphemeris> = navigation
        .ephemerides
        .iter()
        .filter_map(|ephemeris| match ephemeris {
            Ephemeris::Kepler(e) if e.satellite.system() == System::Gps => Some(e),
            _ => None,
        })
        .collect();
    let first = gps.first().map_or(GpsTime::EPOCH, |e| e.toc);
    run_by(&mut out, first);
    if let Some(ionosphere) = navigation.klobuchar {
        for (values, label) in [
            (ionosphere.alpha, "ION ALPHA"),
            (ionosphere.beta, "ION BETA"),
        ] {
            let text: String = values.iter().map(|v| exponent_d(*v, 12, 4)).collect();
            header(&mut out, &format!("  {text}"), label);
        }
    }
    header(
        &mut out,
        &format!("{:6}", first.gpst_minus_utc_s()),
        "LEAP SECONDS",
    );
    header(&mut out, "", "END OF HEADER");
    for e in gps {
        ephemeris(&mut out, e);
    }
    out
}

fn ephemeris(out: &mut String, e: &KeplerEphemeris) {
    let c = e.toc.to_calendar();
    let _ = write!(
        out,
        "{:2} {:02} {:2} {:2} {:2} {:2}{:5.1}",
        e.satellite.number(),
        c.year % 100,
        c.month,
        c.day,
        c.hour,
        c.minute,
        c.second_f64()
    );
    let [af0, af1, af2] = e.clock;
    let [cuc, cus] = e.latitude_correction_rad;
    let [crc, crs] = e.radius_correction_m;
    let [cic, cis] = e.inclination_correction_rad;
    // Seconds of the week of the ephemeris, which may begin after the transmission.
    let week_start = GpsTime::from_week_tow(e.toe.week(), 0.0);
    for text in [af0, af1, af2].map(|v| exponent_d(v, 19, 12)) {
        out.push_str(&text);
    }
    let rest = [
        [
            f64::from(e.iode),
            crs,
            e.mean_motion_correction_rad_s,
            e.mean_anomaly_rad,
        ],
        [cuc, e.eccentricity, cus, e.sqrt_semi_major_axis],
        [e.toe_seconds_of_week, cic, e.ascending_node_rad, cis],
        [
            e.inclination_rad,
            crc,
            e.perigee_rad,
            e.ascending_node_rate_rad_s,
        ],
        [e.inclination_rate_rad_s, 1.0, e.toe.week() as f64, 0.0],
        [
            e.accuracy_m,
            f64::from(e.health),
            e.group_delay_s[0],
            f64::from(e.iodc),
        ],
        [e.transmission_time.seconds_since(week_start), 4.0, 0.0, 0.0],
    ];
    for line in rest {
        out.push_str("\n   ");
        for value in line {
            out.push_str(&exponent_d(value, 19, 12));
        }
    }
    out.push('\n');
}

/// One header line: sixty columns and a label.
fn header(out: &mut String, text: &str, label: &str) {
    let _ = writeln!(out, "{text:<60}{label:<20}");
}

/// Program that made the file; the date is that of the data, so that equal data give equal files.
fn run_by(out: &mut String, first: GpsTime) {
    let c = first.to_calendar();
    let text = format!(
        "ACERRA              SIMULATION          {:04}{:02}{:02} {:02}{:02}{:02} UTC",
        c.year, c.month, c.day, c.hour, c.minute, c.second
    );
    header(out, &text, "PGM / RUN BY / DATE");
}

/// Fortran's D format with one digit before the point.
fn exponent_d(value: f64, width: usize, decimals: usize) -> String {
    let text = format!("{value:.decimals$E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    let number = format!("{mantissa}D{sign}{:02}", exponent.abs());
    format!("{number:>width$}")
}
