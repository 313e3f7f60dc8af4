//! Findings on a track's positions.

use crate::evidence::{
    Finding, ImageGeometry, flight_height, focusing_loss, lever_arm_heading, lever_arm_length,
    radar_height, trajectory_coverage,
};
use crate::position::Positions;
use crate::prepare::{Prepared, Track};
use crate::weigh::median::median;

/// Share of the log that has positions, and the positions' own σ along the line of sight.
pub(super) fn weigh(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let before: usize = prepared
        .tracks
        .iter()
        .take_while(|other| other.range.start < track.range.start)
        .map(|other| other.traces_in_log)
        .sum();
    let all = prepared.aligned.all.iter().skip(before);
    let positioned = all
        .take(track.traces_in_log)
        .filter(|place| place.flag.is_covered())
        .count();
    findings.push(trajectory_coverage(positioned, track.traces_in_log));
    let middle_hz = 0.5 * (geometry.band_hz[0] + geometry.band_hz[1]);
    let wavelength_m = geometry.light_speed_m_s / middle_hz;
    let heights_m = prepared.aligned.height_m.get(track.range.clone());
    if track.cleaned.is_some() {
        findings.extend(heights_m.and_then(height_reached_m).map(flight_height));
    }
    if track.horizontal_lever_arm_m > 0.0 {
        findings.push(lever_arm_length(track.horizontal_lever_arm_m));
    }
    if track.horizontal_lever_arm_m > 0.0 && !has_attitude(track) {
        let arm_m = track.horizontal_lever_arm_m;
        findings.push(lever_arm_heading(arm_m, wavelength_m));
    }
    if let Some(seen) = prepared.aligned.radar_height {
        findings.push(radar_height(
            seen.positions_off_m,
            seen.stated_m,
            seen.sigma_m,
        ));
    }
    if let Some(sigma_m) = line_of_sight_sigma_m(prepared, track, geometry) {
        findings.push(focusing_loss(sigma_m, wavelength_m));
    }
    findings
}

/// The height that a tenth of the traces exceed: on the ground a drone may stand for long (m).
fn height_reached_m(height_m: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = height_m.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() * 9 / 10).copied()
}

/// Whether a track's positions come with attitudes.
fn has_attitude(track: &Track) -> bool {
    match &track.positions {
        Positions::Trajectory(trajectory) => {
            trajectory.fixes().iter().any(|fix| fix.attitude.is_some())
        }
        Positions::PerTrace(_) => true,
    }
}

/// Median over the traces of the positions' σ towards the middle of the image (m).
fn line_of_sight_sigma_m(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<f64> {
    let sigma_m = prepared.aligned.sigma_m.get(track.range.clone())?;
    let middle = geometry.pixel_m.get(geometry.pixel_m.len() / 2)?;
    let along = |(position, sigma): (&[f64; 3], &[f64; 3])| {
        let away: [f64; 3] = std::array::from_fn(|i| middle[i] - position[i]);
        let range_m = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        let weighed = (0..3).map(|i| (away[i] / range_m * sigma[i]).powi(2));
        weighed.sum::<f64>().sqrt()
    };
    median(geometry.position_m.iter().zip(sigma_m).map(along))
}
