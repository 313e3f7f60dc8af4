//! The finding on the permittivity of the ground, by the echoes of buried points.

use super::{Finding, Setting, Verdict};
use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::journal::finding::DOUBTFUL_SIGMAS;
use crate::prepare::Prepared;
use crate::soil::evidence::likelihood;
use crate::soil::posterior::Likelihood;

/// Relative deviation of the permittivity up to which it counts as checked: depths are known to half of that.
const CHECKED: f64 = 0.1;

/// Judges the permittivity in force; nothing where no buried point exceeds the clutter.
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
    let (sigma, bounds) = match found {
        Some(found) => (found.sigma, format!("{value:.2} ± {:.2}", found.sigma)),
        // By the bounds at three standard deviations.
        None => (
            (to - from) / (2.0 * DOUBTFUL_SIGMAS),
            format!("{from:.1} to {to:.1} within three standard deviations"),
        ),
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
    let is_narrow = sigma <= CHECKED * value;
    let explanation = match (verdict, is_narrow || is_open) {
        (Verdict::Agrees, true) => seen,
        (Verdict::Agrees, false) => format!(
            "{seen}: within that it is not checked, as rays are too near to the vertical for the clutter and the heights"
        ),
        _ => format!(
            "{seen}, {sigmas:.1} standard deviations away ({keys}). Objects with a smooth top wider than some centimetres, \
             and pipes that cross the track obliquely, do so too"
        ),
    };
    let finding = Finding {
        sigma: Some(sigma),
        ..Finding::judged("ground_permittivity", value, "", verdict).expecting(in_force)
    };
    let finding = finding.because(explanation);
    match is_narrow || is_open {
        true => finding.checking(Setting::Permittivity),
        false => finding,
    }
}
