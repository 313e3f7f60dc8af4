//! Findings on the corrections of the positions.

use acerra_autofocus::Decision;

use crate::align::correction::PathCorrection;
use crate::findings::evidence::{
    AutofocusSeen, Finding, autofocus_correction, autofocus_gain, autofocus_global, autofocus_sigma,
};

/// Weighs what an autofocus found.
#[must_use]
pub fn weigh_autofocus(correction: &PathCorrection) -> Vec<Finding> {
    let found = &correction.found;
    let seen = match found.decision {
        Decision::Applied => AutofocusSeen::Applied,
        Decision::NoPoints => AutofocusSeen::NoPoints,
        Decision::AgainstPrior => AutofocusSeen::AgainstPrior,
        _ => AutofocusSeen::NotSignificant,
    };
    let points = found.points.len();
    let mut findings = vec![autofocus_gain(
        seen,
        [found.gain_db, found.gain_sigma_db],
        points,
        found.ghosts,
    )];
    if points > 0 {
        findings.push(autofocus_correction(found.correction_in_sigmas));
        findings.extend(correction.globals.iter().map(|global| {
            let name = match global.track {
                None => global.quantity.name().to_owned(),
                Some(track) => format!("{}_{}", global.quantity.name(), track + 1),
            };
            let values = [global.value, global.sigma, global.prior_sigma];
            let unit = global.quantity.unit();
            autofocus_global(&name, unit, values, correction.is_applied())
        }));
    }
    if correction.is_applied() {
        let square = |s: &[f64; 3]| s.iter().map(|v| v * v).sum::<f64>();
        let count = found.sigma_m.len().max(1) as f64;
        let mean = found.sigma_m.iter().map(square).sum::<f64>() / count;
        findings.push(autofocus_sigma(mean.sqrt(), found.unobserved));
    }
    findings
}
