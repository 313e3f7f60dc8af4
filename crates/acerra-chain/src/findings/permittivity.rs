//! The finding on the permittivity of the ground, by the echoes of buried points.

use super::{Finding, Setting, Verdict};
use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::journal::finding::DOUBTFUL_SIGMAS;
use crate::prepare::Prepared;
use crate::soil::evidence::likelihood;
use crate::soil::posterior::Likelihood;

/// Largest relative deviation of the permittivity that counts as checked: depths are known to half of this.
const CHECKED: f64 = 0.05;

/// Judges the permittivity in force; no finding where no buried point exceeds the clutter.
///
/// # Errors
/// The caller asked to stop.
pub(super) fn weigh(
    prepared: &Prepared,
    focused: &Focused,
    control: &Control<'_>,
) -> Result<Option<Finding>, Cancelled> {
    let Some(underground) = &focused.underground else {
        return Ok(None);
    };
    let in_force = (underground.layers.first()).map(|layer| layer.soil.relative_permittivity);
    let likelihood = likelihood(prepared, focused, control)?;
    Ok((likelihood.zip(in_force)).map(|(likelihood, in_force)| {
        let is_layered = underground.layers.len() > 1;
        ground_permittivity(&likelihood, in_force, underground.is_open, is_layered)
    }))
}

fn ground_permittivity(
    likelihood: &Likelihood,
    in_force: f64,
    is_open: bool,
    is_layered: bool,
) -> Finding {
    let sigmas = likelihood.sigmas_in_force();
    let found = likelihood.found();
    let value = found.map_or_else(|| likelihood.likeliest(), |found| found.value);
    let [from, to] = likelihood.bounds();
    let bounds = match found {
        Some(found) => format!("{value:.2} ± {:.2}", found.sigma),
        None => format!("{from:.1} to {to:.1} within three standard deviations"),
    };
    // Smooth objects of more than a few centimetres, and pipes that cross the track obliquely, have hyperbolas of
    // other shapes: that never contradicts.
    let verdict = match sigmas > DOUBTFUL_SIGMAS {
        true => Verdict::Doubtful,
        false => Verdict::Agrees,
    };
    let points = likelihood.points();
    let of = match is_layered {
        true => "of the topmost layer, all layers changed by one factor",
        false => "of the soil",
    };
    let seen = format!(
        "the hyperbolas of {points} buried {} give a relative permittivity {of} of {bounds}; in force is {in_force:.2}",
        if points == 1 { "point" } else { "points" }
    );
    let keys = "[ground] relative_permittivity, surface_z_m; heights of the positions";
    let is_narrow = found.is_some_and(|found| found.sigma <= CHECKED * value);
    let explanation = match (verdict, is_narrow || is_open) {
        (Verdict::Agrees, true) => seen,
        (Verdict::Agrees, false) => format!(
            "{seen}: within three standard deviations it is not checked, as rays near the vertical hardly depend on it"
        ),
        _ => format!(
            "{seen}, {sigmas:.1} standard deviations away ({keys}). Possible causes: water, snow or litter \
             on top that no layer states, objects with a smooth top wider than some centimetres, and pipes \
             that cross the track obliquely"
        ),
    };
    let finding = Finding {
        sigma: found.map(|found| found.sigma),
        ..Finding::judged("ground_permittivity", value, "", verdict).expecting(in_force)
    };
    let finding = finding.because(explanation);
    match is_narrow || is_open {
        true => finding.checking(Setting::Permittivity),
        false => finding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::focus::underground::Underground;
    use crate::soil::echo::PointEcho;
    use crate::soil::posterior::CommonSigma;

    /// The finding on a stated permittivity over points that a soil of 6 shows, at these depths.
    fn finding(stated: f64, depths_m: &[f64], sigma_m: f64, is_open: bool) -> Finding {
        below_water(0.0, stated, depths_m, sigma_m, is_open)
    }

    /// The same where water (81) of some thickness lies on the soil.
    fn below_water(
        water_m: f64,
        stated: f64,
        depths_m: &[f64],
        sigma_m: f64,
        is_open: bool,
    ) -> Finding {
        let underground = Underground {
            is_open,
            ..Underground::of_soil(stated)
        };
        let index = 6.0_f64.sqrt();
        let point = |depth_m: &f64| PointEcho {
            place_m: [0.0, 0.0, -depth_m],
            delay_m: 9.0 * water_m + index * (depth_m - 0.02),
            curvature_m: water_m / 9.0 + depth_m / index,
            sigma_m,
        };
        let points: Vec<PointEcho> = depths_m.iter().map(point).collect();
        let likelihood = Likelihood::of(&underground, &[1e9], &points, CommonSigma::default());
        ground_permittivity(&likelihood.unwrap().unwrap(), stated, is_open, false)
    }

    #[test]
    fn a_wrong_permittivity_is_doubtful_and_never_contradicts() {
        for wrong in [2.0, 2.5, 15.0, 60.0] {
            let found = finding(wrong, &[0.15, 0.25], 0.004, false);
            assert_eq!(found.verdict, Verdict::Doubtful, "{wrong}");
            assert!((found.value.unwrap() - 6.0).abs() < 0.5);
        }
    }

    #[test]
    fn water_on_top_that_is_not_stated_is_doubtful() {
        let verdict = |water_m: f64| below_water(water_m, 6.0, &[0.15, 0.25], 0.004, false).verdict;
        assert_eq!(verdict(0.0), Verdict::Agrees);
        for water_m in [0.02, 0.03, 0.05] {
            assert_eq!(verdict(water_m), Verdict::Doubtful, "{water_m}");
        }
    }

    #[test]
    fn a_right_one_agrees_and_is_checked_where_points_are_deep_enough() {
        let shallow = finding(6.0, &[0.12], 0.004, false);
        assert_eq!((shallow.verdict, shallow.checks), (Verdict::Agrees, None));
        assert!(shallow.sigma.unwrap() > 0.5);
        let deep = finding(6.0, &[0.8, 1.2, 1.6], 0.004, false);
        assert_eq!(deep.verdict, Verdict::Agrees);
        assert_eq!(deep.checks, Some(Setting::Permittivity));
        let found = finding(6.0, &[0.12], 0.004, true);
        assert_eq!(found.checks, Some(Setting::Permittivity));
    }

    #[test]
    fn points_that_fit_everything_have_bounds_and_no_deviation() {
        let vague = finding(6.0, &[0.12], 0.05, false);
        assert_eq!((vague.verdict, vague.sigma), (Verdict::Agrees, None));
        assert!(
            vague.explanation.contains("to 99.") || vague.explanation.contains("to 100."),
            "{}",
            vague.explanation
        );
    }
}
