//! Stage `position`: where the positioned point was, as a trajectory in the image's frame.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use acerra_geo::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::read::{ReadOptions, read_trajectory};
use acerra_geo::trajectory::Trajectory;
use acerra_gnss::conf::read_conf;
use acerra_gnss::{BasePosition, PpkOptions, RuleSet};
use anyhow::Context;

use super::read::{RadarData, name_of};
use super::warnings::Warnings;
use crate::campaign::{Campaign, GnssSection, TrajectorySection};
use crate::positioning::{self, PositioningInput};

/// Positions, as the campaign gives them.
#[derive(Clone, Debug)]
pub enum Positions {
    /// A trajectory of the radar's phase centre, on a clock of its own.
    Trajectory(Box<Trajectory>),
    /// One position of the phase centre for each trace, from the radar file (m).
    PerTrace(Vec<[f64; 3]>),
}

/// Finds the positions.
///
/// # Errors
/// No source of positions, or one that cannot be read; the message names the file and the place.
pub fn position(
    campaign: &Campaign,
    radar: &RadarData,
    warnings: &mut Warnings,
) -> anyhow::Result<Positions> {
    if let Some(gnss) = &campaign.gnss {
        let trajectory = from_gnss(gnss, &campaign.trajectory, warnings)?;
        return Ok(Positions::Trajectory(Box::new(trajectory)));
    }
    match (&campaign.trajectory.file, &radar.position_m) {
        (Some(file), inside) => {
            if inside.is_some() {
                warnings.add(format!(
                    "{} brings positions of its own; those of {} are used",
                    name_of(&campaign.radar.file),
                    name_of(file)
                ));
            }
            let trajectory = read(file, &campaign.trajectory, warnings)?;
            Ok(Positions::Trajectory(Box::new(trajectory)))
        }
        (None, Some(position_m)) => {
            if campaign.trajectory.lever_arm_m != [0.0; 3] {
                anyhow::bail!(
                    "[trajectory] lever_arm_m: expected none, as position_m in {} gives the \
                     phase centre itself",
                    campaign.radar.file.display()
                );
            }
            Ok(Positions::PerTrace(position_m.clone()))
        }
        (None, None) => anyhow::bail!(
            "no positions: expected [trajectory] file, [gnss], or position_m in {}",
            campaign.radar.file.display()
        ),
    }
}

fn read(
    path: &Path,
    section: &TrajectorySection,
    warnings: &mut Warnings,
) -> anyhow::Result<Trajectory> {
    let file = File::open(path).with_context(|| format!("{}", path.display()))?;
    let mut options = ReadOptions::default();
    if let Some([latitude, longitude, height_m]) = section.origin_deg_m {
        options = options.with_origin(Geodetic::from_degrees(latitude, longitude, height_m));
    }
    if let Some(name) = &section.rigid_body {
        options = options.with_rigid_body(name);
    }
    let (trajectory, report) = read_trajectory(BufReader::new(file), &options)
        .with_context(|| format!("{}", path.display()))?;
    if report.skipped_total() > 0 {
        warnings.add(format!("{}: {report}", name_of(path)));
    }
    for warning in &report.warnings {
        warnings.add(format!("{}: {warning}", name_of(path)));
    }
    phase_centre(trajectory, section)
}

/// Computes the trajectory from raw GNSS logs.
fn from_gnss(
    gnss: &GnssSection,
    section: &TrajectorySection,
    warnings: &mut Warnings,
) -> anyhow::Result<Trajectory> {
    let mut options = match &gnss.config {
        None => PpkOptions::default(),
        Some(path) => {
            let at = || format!("{}", path.display());
            let file = File::open(path).with_context(at)?;
            let conf = read_conf(BufReader::new(file), RuleSet::Rtklib).with_context(at)?;
            for setting in &conf.not_followed {
                warnings.add(format!("{}: {setting}", name_of(path)));
            }
            conf.options
        }
    };
    if let Some(ecef_m) = gnss.base_ecef_m {
        options.base_position = BasePosition::Ecef(ecef_m);
    }
    if let Some([latitude, longitude, height_m]) = gnss.base_deg_m {
        let place = Geodetic::from_degrees(latitude, longitude, height_m);
        options.base_position = BasePosition::Ecef(ecef_from_geodetic(&place));
    }
    let input = PositioningInput {
        rover: gnss.rover.clone(),
        base: Some(gnss.base.clone()),
        navigation: gnss.navigation.0.clone(),
        ..PositioningInput::default()
    };
    let positioned = positioning::run(&input, &options).context("[gnss]")?;
    for warning in &positioned.warnings {
        warnings.add(format!("[gnss] {warning}"));
    }
    let mut trajectory = positioned.solution.trajectory().context("[gnss]")?;
    if let Some([latitude, longitude, height_m]) = section.origin_deg_m {
        let origin = EnuFrame::new(Geodetic::from_degrees(latitude, longitude, height_m));
        trajectory = trajectory
            .in_frame(origin)
            .context("[trajectory] origin_deg_m")?;
    }
    phase_centre(trajectory, section)
}

/// Moves a trajectory of the positioned point to the radar's phase centre.
fn phase_centre(trajectory: Trajectory, section: &TrajectorySection) -> anyhow::Result<Trajectory> {
    if section.lever_arm_m == [0.0; 3] {
        return Ok(trajectory);
    }
    let (moved, _) = apply_lever_arm(&trajectory, section.lever_arm_m, &HeadingOptions::default())
        .context("[trajectory] lever_arm_m")?;
    Ok(moved)
}
