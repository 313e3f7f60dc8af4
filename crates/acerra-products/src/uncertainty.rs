//! How far a target may stand from its true place, from what the positions say of themselves.

use acerra_imaging::metrics::Target;

use crate::outcome::Outcome;

/// Standard deviations of a target's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaceSigma {
    /// Along the track (m).
    pub along_m: f64,
    /// Across it (m).
    pub across_m: f64,
}

/// The deviation of a target's place, by the geometry at the point of the track that is nearest to it;
/// none where the positions do not tell their own.
///
/// Positions shift the image as a whole. A height that is off by σ displaces a target at horizontal
/// distance y from a track of height h from y to √(y² + 2hσ) (Eq. (14) of Catapano et al. 2020): by
/// hσ/y beside the track, by √(2hσ) under it. What the delay may be off is not in it.
pub(crate) fn place_sigma(outcome: &Outcome, target: &Target) -> Option<PlaceSigma> {
    let aligned = &outcome.prepared.aligned;
    let away_m = |p: &[f64; 3]| (p[0] - target.x_m).hypot(p[1] - target.y_m);
    let nearest = (0..aligned.position_m.len()).min_by(|a, b| {
        let distance = |k: usize| away_m(&aligned.position_m[k]);
        distance(*a).total_cmp(&distance(*b))
    })?;
    let sigma_m = aligned.sigma_m.get(nearest)?;
    let place = &aligned.position_m[nearest];
    let ground_m = outcome.prepared.ground.map_or(0.0, |found| found.sigma_m);
    let horizontal_m = sigma_m[0].hypot(sigma_m[1]) * std::f64::consts::FRAC_1_SQRT_2;
    let y_m = away_m(place);
    let by_height_m = displacement_m(y_m, place[2] - target.z_m, sigma_m[2].hypot(ground_m));
    Some(PlaceSigma {
        along_m: horizontal_m,
        across_m: horizontal_m.hypot(by_height_m),
    })
}

fn displacement_m(y_m: f64, height_m: f64, sigma_m: f64) -> f64 {
    (y_m * y_m + 2.0 * height_m.abs() * sigma_m).sqrt() - y_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_displace_targets_as_equation_14_has_it() {
        // Under the track √(2hσ), beside it hσ/y.
        assert!((displacement_m(0.0, 4.0, 0.01) - 0.08_f64.sqrt()).abs() < 1e-12);
        assert!((displacement_m(5.0, 10.0, 0.001) - 0.002).abs() < 1e-6);
    }
}
