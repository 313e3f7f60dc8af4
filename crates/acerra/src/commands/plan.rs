//! `acerra plan`: from an area and a required resolution to flight lines.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use acerra_figure::{Axis, Map};
use acerra_flightplan::{
    FlightPlan, PlanFile, expected_maps, to_geojson, to_kml, to_qgroundcontrol, to_ugcs,
    to_waypoints, to_wpml,
};
use acerra_products::staging::Staging;

use crate::settings_files::SettingsFile;

/// Plan a flight: lines, height, speed, batteries, and the expected image.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra plan --example > area.toml
  acerra plan area.toml
  acerra plan area.toml -o plan    (plan.plan opens in QGroundControl)

Missions, a file for each flight: plan.plan (QGroundControl), plan.waypoints (Mission Planner,
ArduPilot), plan-dji.kmz (DJI Pilot 2, FlightHub 2), plan-ugcs.csv (UgCS). With a terrain in the plan
file they keep their height above it.")]
pub struct Args {
    /// The plan file: area, required resolution, radar, drone.
    #[arg(value_name = "PLAN.toml", required_unless_present = "example")]
    pub(crate) plan: Option<PathBuf>,
    /// Print a commented plan file with every key, to begin with.
    #[arg(long, conflicts_with_all = ["plan", "output", "json"])]
    example: bool,
    /// Write there: the missions, plan.geojson, plan.kml, plan.json, across.png, ghost.png.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Answer as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// An unreadable plan file, an impossible request, or an output directory that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let Some(file) = args.plan.as_ref().filter(|_| !args.example) else {
        write!(out, "{}", SettingsFile::Plan.example())?;
        return Ok(());
    };
    let name = || file.display().to_string();
    let text = std::fs::read_to_string(file).with_context(name)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let plan = PlanFile::parse(&text)
        .and_then(|plan| FlightPlan::make(plan.resolved_in(folder)))
        .with_context(name)?;
    if let Some(directory) = &args.output {
        let mut staging = Staging::new(directory)?;
        staging.supersede(older_missions(directory));
        for (name, bytes) in products(&plan)? {
            staging.write(&name, bytes)?;
        }
        staging.publish()?;
    }
    if args.json {
        serde_json::to_writer_pretty(&mut *out, &plan.summary)?;
        writeln!(out)?;
    } else {
        out.write_all(describe(&plan).as_bytes())?;
    }
    Ok(())
}

/// How the names of missions end, after `plan` and the number of the flight.
const MISSION_ENDS: [&str; 4] = [".plan", ".waypoints", "-dji.kmz", "-ugcs.csv"];

/// The missions and maps of an older plan in a directory: the newer one may have fewer.
fn older_missions(directory: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(directory) else {
        return Vec::new();
    };
    if !directory.join("plan.json").is_file() {
        return Vec::new();
    }
    let is_ours = |name: &String| {
        let Some(rest) = name.strip_prefix("plan") else {
            return name == "ghost.png";
        };
        let number = |end: &&str| {
            let number = rest.strip_suffix(*end)?.strip_prefix('-')?;
            number.parse::<usize>().ok()
        };
        MISSION_ENDS
            .iter()
            .any(|end| rest == *end || number(end).is_some())
    };
    entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(is_ours)
        .collect()
}

/// All files by name. More than one flight makes `plan-1.plan`, `plan-2.plan`, … instead of `plan.plan`, and
/// likewise for the other missions.
fn products(plan: &FlightPlan) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut files = vec![
        (
            "plan.json".to_owned(),
            serde_json::to_vec_pretty(&plan.summary)?,
        ),
        (
            "plan.geojson".to_owned(),
            serde_json::to_vec_pretty(&to_geojson(plan))?,
        ),
        ("plan.kml".to_owned(), to_kml(plan).into_bytes()),
    ];
    for (i, flight) in plan.flights.iter().enumerate() {
        let name = match plan.flights.len() {
            1 => "plan".to_owned(),
            _ => format!("plan-{}", i + 1),
        };
        let missions = [
            serde_json::to_vec_pretty(&to_qgroundcontrol(plan, flight)?)?,
            to_waypoints(plan, flight)?.into_bytes(),
            to_wpml(plan, flight)?,
            to_ugcs(plan, flight)?.into_bytes(),
        ];
        let named = MISSION_ENDS.map(|end| format!("{name}{end}"));
        files.extend(named.into_iter().zip(missions));
    }
    let maps = expected_maps(plan);
    let draw = |title: &str, values: &[f64], what: &str| {
        Map {
            equal_aspect: true,
            ..Map::new(
                title,
                Axis::new("east of home", "m"),
                Axis::new("north of home", "m"),
                values,
                maps.columns,
                maps.rows,
            )
        }
        .grid(maps.east_m, maps.north_m)
        .values_are(what)
        .draw()
        .and_then(|drawing| drawing.to_png())
    };
    files.push((
        "across.png".to_owned(),
        draw(
            "Expected across-track Rayleigh resolution, Eq. (9)",
            &maps.across_m,
            "across-track Rayleigh resolution (m)",
        )?,
    ));
    // A map that is 1 everywhere adds nothing to the summary.
    if plan.curve.is_some() {
        let ghost = draw("Expected ghosts", &maps.ghost, "ghost over target")?;
        files.push(("ghost.png".to_owned(), ghost));
    }
    Ok(files)
}

fn describe(plan: &FlightPlan) -> String {
    let s = &plan.summary;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<22} {value}");
    };
    line("height", format!("{:.1} m above ground", s.height_m));
    line("speed", format!("{:.2} m/s", s.speed_m_s));
    line(
        "lines",
        match s.track_spacing_m {
            Some(m) => format!("{}, {m:.1} m apart, heading {:.0}°", s.lines, s.heading_deg),
            None => format!("{}, heading {:.0}°", s.lines, s.heading_deg),
        },
    );
    line(
        "length",
        format!(
            "{:.1} m the longest, {:.0} m in all",
            s.track_length_m, s.total_length_m
        ),
    );
    line(
        "each line shows",
        format!(
            "{:.1} to {:.1} m to its side, where {}",
            s.swath_m[0], s.swath_m[1], s.swath_ends
        ),
    );
    line(
        "resolution",
        format!(
            "{:.3} m along, {:.2} to {:.2} m across, {:.3} m in range",
            s.along_m, s.across_m[0], s.across_m[1], s.range_m
        ),
    );
    line(
        "signal to noise",
        format!(
            "{:.0} to {:.0} dB for {} dBsm",
            s.snr_db[0], s.snr_db[1], plan.file.want.rcs_dbsm
        ),
    );
    line(
        "sampling",
        format!(
            "{:.1} mm at {} scans/s; aliasing from {:.1} mm on at ±{:.1}°",
            1e3 * s.step_m,
            s.scans_hz,
            1e3 * s.longest_step_m,
            s.half_view_deg
        ),
    );
    if let Some(curve) = &s.curve {
        let ghosts: Vec<String> = curve
            .ghost
            .iter()
            .map(|[d, g]| format!("{g:.2} at {d:.1} m"))
            .collect();
        line(
            "curve",
            format!(
                "±{:.2} m over {:.1} m on {} straight legs a period, within {:.2} m of the wave; \
                 ghosts {}",
                curve.amplitude_m,
                curve.period_m,
                curve.waypoints_per_period,
                curve.waypoint_tolerance_m,
                ghosts.join(", ")
            ),
        );
    }
    line(
        "waypoints",
        format!("reached within {:.2} m", s.waypoint_acceptance_m),
    );
    line(
        "positions",
        format!(
            "random errors of {:.1} mm cost 1 dB of the peak",
            1e3 * s.position_error_for_1_db_m
        ),
    );
    for (i, flight) in s.flights.iter().enumerate() {
        line(
            &format!("flight {}", i + 1),
            format!(
                "lines {} to {}, {:.0} m, {:.1} minutes, {:.0} % of a battery",
                flight.first_line + 1,
                flight.last_line + 1,
                flight.distance_m,
                flight.time_s / 60.0,
                100.0 * flight.battery
            ),
        );
    }
    for warning in &s.warnings {
        line("note", warning.clone());
    }
    text
}
