//! Logs of autopilots and robots.

use std::io::Read;

use acerra_autopilot::{HeightDatum, LogFormat, LogOptions, LogReport, read_log};

use super::description::Description;
use super::trajectory::add_trajectory;

pub fn describe(reader: impl Read) -> anyhow::Result<Description> {
    let (trajectory, report) = read_log(reader, &LogOptions::default().taking_first())?;
    let mut d = Description::new(report.format.to_string());
    d.fact("source", report.source.name.clone());
    d.fact("sources", sources(&report).join("; "));
    d.fact("attitude_source", report.attitude_source.clone());
    d.fact("attitudes", report.attitudes);
    if let Some(datum) = report.height_datum {
        d.fact(
            "heights",
            match datum {
                HeightDatum::Ellipsoid => "above the ellipsoid",
                HeightDatum::SeaLevel => "above the sea",
            },
        );
    }
    if let Some(clock) = report.clock {
        d.fact("clock_rate_ppm", clock.rate_ppm);
        d.fact("clock_spread_s", clock.spread_s);
    }
    add_trajectory(&mut d, &trajectory);
    d.notes
        .extend(report.warnings.iter().map(ToString::to_string));
    Ok(d)
}

/// Every source with its contents.
fn sources(report: &LogReport) -> Vec<String> {
    let positions = report
        .sources
        .iter()
        .map(|s| format!("{} ({}, {} positions)", s.name, s.kind, s.positions));
    let attitudes = report
        .attitude_sources
        .iter()
        .map(|s| format!("{} ({} attitudes)", s.name, s.attitudes));
    let what = match report.format {
        LogFormat::Mcap => "for gimbal_source alone",
        _ => "gimbal",
    };
    let gimbals = report
        .gimbal_sources
        .iter()
        .map(|s| format!("{} ({}, {} attitudes)", s.name, what, s.attitudes));
    positions.chain(attitudes).chain(gimbals).collect()
}
