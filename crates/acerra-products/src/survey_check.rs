//! The finding `survey`: distances of targets from surveyed points, and the settings that their agreement
//! checks.

use acerra_chain::Prepared;
use acerra_chain::findings::{Finding, Setting, Verdict};
use acerra_imaging::PlaneGrid;
use acerra_imaging::metrics::Target;

use crate::surveyed::SurveyRecord;
use crate::uncertainty::place_sigma;

/// A surveyed point within the image, and the distance of its target.
#[derive(Clone, Copy, Debug)]
struct Seen<'a> {
    point: &'a SurveyRecord,
    distance_m: f64,
    /// Standard deviation of that distance if all settings are right (m).
    sigma_m: f64,
}

impl Seen<'_> {
    fn deviations(&self) -> f64 {
        self.distance_m / self.sigma_m
    }
}

/// The worst of the surveyed points inside the image, in standard deviations of its distance, by the target's
/// place and by a range cell, within which the echo of a reflector may lie. None where no point lies in the
/// image or the image has no target.
pub(crate) fn survey_finding(
    prepared: &Prepared,
    grid: &PlaneGrid,
    points: &[SurveyRecord],
    targets: &[Target],
) -> Option<Finding> {
    let worst = seen(prepared, grid, points, targets)
        .into_iter()
        .max_by(|a, b| a.deviations().total_cmp(&b.deviations()))?;
    let finding = Finding::compared("survey", worst.deviations(), 0.0, 1.0, "σ");
    let name = &worst.point.name;
    let (distance_m, sigma_m) = (worst.distance_m, worst.sigma_m);
    let place = format!(
        "the surveyed point {name} is {distance_m:.2} m from the nearest target, {:.1} of its deviations of \
         {sigma_m:.2} m",
        worst.deviations()
    );
    let explanation = match finding.verdict {
        Verdict::Agrees => format!("{place}: it is where the image shows it"),
        _ => format!(
            "{place}: the point was surveyed elsewhere, is not seen, or the image is displaced ([measure] \
             survey; [radar] delay_ns, [trajectory] time_offset_s, lever_arm_m, [image] z_m)"
        ),
    };
    Some(finding.because(explanation))
}

/// The settings that agreeing points check: errors of these would have moved a point by more than the
/// tolerance of its distance.
pub(crate) fn checked_by_survey(
    prepared: &Prepared,
    grid: &PlaneGrid,
    points: &[SurveyRecord],
    targets: &[Target],
) -> Vec<Setting> {
    let agreeing = seen(prepared, grid, points, targets);
    let agreeing: Vec<_> = agreeing.iter().filter(|s| s.deviations() <= 3.0).collect();
    if agreeing.is_empty() {
        return Vec::new();
    }
    let mut settings = vec![
        Setting::Delay,
        Setting::Heights,
        Setting::ClockOffset,
        Setting::LeverArmForward,
        Setting::LeverArmLeft,
        Setting::Base,
    ];
    // Where exchanged axes or axes of the wrong sign would have put the point.
    let is_moved_by_axes = |s: &&Seen<'_>| {
        let (x_m, y_m) = (s.point.x_m, s.point.y_m);
        let nearest_m = (2.0 * x_m.abs())
            .min(2.0 * y_m.abs())
            .min(std::f64::consts::SQRT_2 * (x_m - y_m).abs().min((x_m + y_m).abs()));
        nearest_m > 6.0 * s.sigma_m
    };
    let several = agreeing.len() >= 2;
    if several || agreeing.iter().copied().any(|s| is_moved_by_axes(&s)) {
        settings.push(Setting::Axes);
    }
    settings
}

fn seen<'a>(
    prepared: &Prepared,
    grid: &PlaneGrid,
    points: &'a [SurveyRecord],
    targets: &[Target],
) -> Vec<Seen<'a>> {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let band_hz = match frequency_hz.as_slice() {
        [low, .., high] => high - low,
        _ => return Vec::new(),
    };
    let cell_m = 0.5 * prepared.scene.light_speed_m_s / band_hz;
    let is_inside = |p: &&SurveyRecord| {
        let [right_m, top_m] = [
            grid.x_m(grid.nx.saturating_sub(1)),
            grid.y_m(grid.ny.saturating_sub(1)),
        ];
        (grid.x0_m..=right_m).contains(&p.x_m) && (grid.y0_m..=top_m).contains(&p.y_m)
    };
    let of = |point: &'a SurveyRecord| {
        let nearest = point.nearest?;
        let target = targets.get(nearest.target.checked_sub(1)?)?;
        let place_m = place_sigma(prepared, target).map_or(0.0, |s| s.along_m.hypot(s.across_m));
        Some(Seen {
            point,
            distance_m: nearest.distance_m,
            sigma_m: cell_m.hypot(place_m),
        })
    };
    points.iter().filter(is_inside).filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surveyed::NearestTarget;

    #[test]
    fn deviations_are_distance_over_sigma() {
        let point = SurveyRecord {
            name: "a".to_owned(),
            x_m: 1.0,
            y_m: 2.0,
            z_m: 0.0,
            nearest: Some(NearestTarget {
                target: 1,
                distance_m: 0.9,
                off_m: [0.9, 0.0],
            }),
        };
        let seen = Seen {
            point: &point,
            distance_m: 0.9,
            sigma_m: 0.09,
        };
        assert!((seen.deviations() - 10.0).abs() < 1e-12);
    }
}
