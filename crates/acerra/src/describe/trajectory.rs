//! Trajectories.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use acerra_geo::interpolate::default_max_gap_s;
use acerra_geo::read::{ReadError, ReadOptions, TrajectoryFormat, read_trajectory};
use acerra_geo::trajectory::{SolutionStatus, Trajectory};
use serde_json::json;

use super::description::Description;

pub fn describe(path: &Path, reader: impl BufRead) -> anyhow::Result<Description> {
    let (trajectory, report) = match read_trajectory(reader, &ReadOptions::default()) {
        Ok(read) => read,
        Err(ReadError::SeveralBodies { names }) => return describe_bodies(path, &names),
        Err(error) => return Err(error.into()),
    };
    let mut d = Description::new(report.format.to_string());
    add_trajectory(&mut d, &trajectory);
    for (name, value) in &report.about {
        d.notes.push(format!("{name}: {value}"));
    }
    if report.skipped_total() > 0 {
        d.notes.push(report.to_string());
    }
    d.notes
        .extend(report.warnings.iter().map(ToString::to_string));
    if !report.unused_columns.is_empty() {
        d.notes.push(format!(
            "columns not used: {}",
            report.unused_columns.join(", ")
        ));
    }
    Ok(d)
}

/// The rigid bodies of a motion capture that holds several, each by itself.
fn describe_bodies(path: &Path, names: &[String]) -> anyhow::Result<Description> {
    let mut d = Description::new(TrajectoryFormat::Motive.to_string());
    d.fact("rigid_bodies", json!(names));
    for name in names {
        let reader = BufReader::new(File::open(path)?);
        let options = ReadOptions::default().with_rigid_body(name);
        let (trajectory, _) = read_trajectory(reader, &options)?;
        let (low, high) = trajectory.bounds_m();
        d.notes.push(format!(
            "{name}: {} positions from {:.3} to {:.3} s, {:.2} m of path, x {:.2} to {:.2} m, y {:.2} to {:.2} m, z \
             {:.2} to {:.2} m",
            trajectory.fixes().len(),
            trajectory.start_s(),
            trajectory.end_s(),
            trajectory.path_length_m(),
            low[0],
            high[0],
            low[1],
            high[1],
            low[2],
            high[2]
        ));
    }
    d.notes.push(
        "acerra init takes the body whose motion agrees with the echoes, or that of --rigid-body; a \
         campaign names it ([trajectory] rigid_body)"
            .to_owned(),
    );
    Ok(d)
}

/// Adds the remarks on positions of any source.
pub fn add_trajectory(d: &mut Description, trajectory: &Trajectory) {
    d.fact("positions", trajectory.fixes().len());
    d.fact("start_s", trajectory.start_s());
    d.fact("end_s", trajectory.end_s());
    for (name, at) in [("start", trajectory.start_s()), ("end", trajectory.end_s())] {
        if let Some(time) = trajectory.gps_time_at(at) {
            d.fact(&format!("{name}_gpst"), time.to_string());
        }
    }
    d.fact("interval_s", trajectory.sample_interval_s());
    let max_gap_s = default_max_gap_s(trajectory);
    let gaps: Vec<(f64, f64)> = trajectory.gaps(max_gap_s).collect();
    d.fact("gaps", gaps.len());
    for (from, to) in gaps.iter().take(10) {
        d.notes
            .push(format!("gap of {:.3} s from {from:.3} s", to - from));
    }
    d.fact("path_m", trajectory.path_length_m());
    let (low, high) = trajectory.bounds_m();
    d.fact("east_m", json!([low[0], high[0]]));
    d.fact("north_m", json!([low[1], high[1]]));
    d.fact("up_m", json!([low[2], high[2]]));
    let counts = trajectory.status_counts();
    for status in SolutionStatus::ALL {
        let count = counts.of(status);
        if count > 0 {
            d.fact(&format!("{}_positions", status.name()), count);
        }
    }
    if let Some(frame) = trajectory.frame().enu() {
        let origin = frame.origin();
        d.fact(
            "origin_deg_m",
            json!([
                origin.latitude_deg(),
                origin.longitude_deg(),
                origin.height_m
            ]),
        );
    }
}
