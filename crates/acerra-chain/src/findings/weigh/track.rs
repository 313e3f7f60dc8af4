//! Findings on a track's positions.

use crate::findings::evidence::{
    Finding, ImageGeometry, flight_height, focusing_loss, lever_arm_heading, lever_arm_length,
    radar_height, trajectory_coverage,
};
use crate::findings::weigh::median::median;
use crate::position::Positions;
use crate::prepare::{Prepared, Track};

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
    findings.extend(position_sigma(prepared, track, geometry));
    findings
}

/// The loss of focus by the positions' own σ and, where the clock offset is a recorded clock's, by its.
fn position_sigma(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<Finding> {
    let middle_hz = 0.5 * (geometry.band_hz[0] + geometry.band_hz[1]);
    let wavelength_m = geometry.light_speed_m_s / middle_hz;
    let positions_m = line_of_sight_sigma_m(prepared, track, geometry)?;
    let clock_m = track
        .recorded_clock
        .as_ref()
        .and_then(|clock| line_of_sight_wander_m_s(prepared, track, geometry).zip(Some(clock)))
        .map(|(wander_m_s, clock)| wander_m_s * clock.sigma_s);
    let mut finding = focusing_loss(positions_m.hypot(clock_m.unwrap_or(0.0)), wavelength_m);
    if let Some(clock_m) = clock_m {
        finding.explanation.push_str(&format!(
            "; {:.1} mm of them are the recorded clock's, where the velocity differs from its mean",
            1e3 * clock_m
        ));
    }
    Some(finding)
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

/// Root mean square of what the velocity differs from its mean, along the line of sight to the middle of
/// the image (m/s): an error of the clock moves traces by that against one another, and the image as a
/// whole by the mean.
fn line_of_sight_wander_m_s(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<f64> {
    let middle = geometry.pixel_m.get(geometry.pixel_m.len() / 2)?;
    let times_s = prepared.aligned.time_s.get(track.range.clone())?;
    let pairs = geometry.position_m.windows(2).zip(times_s.windows(2));
    let velocities: Vec<([f64; 3], [f64; 3])> = pairs
        .filter(|(_, t)| t[1] > t[0])
        .map(|(p, t)| {
            let velocity = std::array::from_fn(|i| (p[1][i] - p[0][i]) / (t[1] - t[0]));
            (p[0], velocity)
        })
        .collect();
    let count = velocities.len() as f64;
    let mean: [f64; 3] =
        std::array::from_fn(|i| velocities.iter().map(|(_, v)| v[i]).sum::<f64>() / count);
    let square = |(position, velocity): &([f64; 3], [f64; 3])| {
        let away: [f64; 3] = std::array::from_fn(|i| middle[i] - position[i]);
        let range_m = away.iter().map(|v| v * v).sum::<f64>().sqrt();
        let along: f64 = (0..3)
            .map(|i| (velocity[i] - mean[i]) * away[i] / range_m)
            .sum();
        along * along
    };
    let wander_m_s = (velocities.iter().map(square).sum::<f64>() / count).sqrt();
    wander_m_s.is_finite().then_some(wander_m_s)
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
