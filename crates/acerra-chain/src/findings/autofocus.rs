//! Findings on the corrections of the positions by an autofocus.

use acerra_autofocus::Decision;

use crate::align::correction::PathCorrection;
use crate::journal::finding::{DOUBTFUL_SIGMAS, Finding, Verdict};

/// Judges the results of an autofocus.
#[must_use]
pub fn weigh_autofocus(correction: &PathCorrection) -> Vec<Finding> {
    let found = &correction.found;
    let seen = match found.decision {
        Decision::Applied => AutofocusSeen::Applied,
        Decision::NoPoints => AutofocusSeen::NoPoints,
        Decision::AgainstPrior => AutofocusSeen::AgainstPrior,
        Decision::LonePoint => AutofocusSeen::LonePoint,
        Decision::Worsens => AutofocusSeen::Worsens,
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

/// Rms correction, in deviations that the positions state, from which those are doubtful.
const DOUBTFUL_CORRECTION: f64 = 2.0;

/// Outcome of an autofocus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AutofocusSeen {
    /// The autofocus' correction is applied.
    Applied,
    /// Points that took no part in the correction did not gain significantly.
    NotSignificant,
    /// No point is clear enough.
    NoPoints,
    /// The correction is larger than the positions' deviations allow.
    AgainstPrior,
    /// The correction rests on one point.
    LonePoint,
    /// The correction makes a point weaker.
    Worsens,
}

/// Judges the gain of the points' peaks by an autofocus, relative to the loss that the positions' deviations
/// predict.
fn autofocus_gain(
    seen: AutofocusSeen,
    [gain_db, sigma_db]: [f64; 2],
    points: usize,
    ghosts: usize,
) -> Finding {
    let (verdict, what) = match seen {
        AutofocusSeen::Applied if ghosts > 0 => (
            Verdict::Doubtful,
            "points gain by corrections that they took no part in, and the places are corrected; but some have \
             the ranges of another and are its ghost, or it theirs: the image is sharper, and places and \
             heights may be drawn to the wrong side of the track by more than their deviations say",
        ),
        AutofocusSeen::Applied => (
            Verdict::Agrees,
            "points gain by corrections that they took no part in: the places are corrected",
        ),
        AutofocusSeen::NotSignificant => (
            Verdict::Agrees,
            "points do not gain significantly by corrections that they took no part in: the places are as \
             stated",
        ),
        AutofocusSeen::NoPoints => (
            Verdict::Agrees,
            "no point is clear enough in the image: the places are as stated",
        ),
        AutofocusSeen::LonePoint => (
            Verdict::Agrees,
            "a motion of the point would look the same as one of the track: the places are as stated",
        ),
        AutofocusSeen::Worsens => (
            Verdict::Agrees,
            "a point used for the correction is weaker with the correction than without: the places are as \
             stated",
        ),
        AutofocusSeen::AgainstPrior => (
            Verdict::Doubtful,
            "the echoes need corrections beyond what the positions' deviations allow (do the points move? \
             [autofocus] sigma_m): the places are as stated",
        ),
    };
    let number = match (points, ghosts) {
        (1, _) => "1 point".to_owned(),
        (_, 0) => format!("{points} points"),
        _ => format!("{points} points, {ghosts} of them with the ranges of another point"),
    };
    let finding = Finding::judged("autofocus_gain", gain_db, "dB", verdict);
    let mut finding = finding.because(format!("{number}; {what}"));
    finding.sigma = Some(sigma_db);
    finding
}

/// Judges the corrections by the deviations that the positions state: rms in units of the deviations, 1 if
/// the deviations are right and the echoes determine every error.
fn autofocus_correction(in_sigmas: f64) -> Finding {
    let verdict = if in_sigmas <= DOUBTFUL_CORRECTION {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("autofocus_correction", in_sigmas, "σ", verdict)
        .expecting(1.0)
        .because(
            "rms of the corrections over the deviations of the positions: beyond 2 the deviations are too \
             small, or errors of another kind (delay, clock, height of the ground) are mistaken for errors \
             of the positions",
        )
}

/// Posterior over prior deviation from which the echoes count as not determining a quantity.
const UNDETERMINED_SHARE: f64 = 0.95;

/// Judges the autofocus' estimate of a quantity of the whole flight by the prior deviation stated: `value`
/// and its posterior `sigma`, and the prior's sigma.
fn autofocus_global(
    name: &str,
    unit: &'static str,
    [value, sigma, prior_sigma]: [f64; 3],
    is_applied: bool,
) -> Finding {
    let verdict = if value.abs() <= DOUBTFUL_SIGMAS * prior_sigma {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    let outcome = if sigma > UNDETERMINED_SHARE * prior_sigma {
        "the echoes do not determine it: it keeps its prior value"
    } else if is_applied {
        "it is applied with the corrections of the places"
    } else {
        "it is not applied, as the corrections of the places are not"
    };
    let prior = two_digits(prior_sigma);
    let mut finding = Finding::judged(format!("autofocus_{name}"), value, unit, verdict).because(
        format!("true less stated, where ± {prior} {unit} was stated beforehand; {outcome}"),
    );
    finding.sigma = Some(sigma);
    finding
}

/// A deviation with two digits that count.
fn two_digits(sigma: f64) -> String {
    let places = (1.0 - sigma.max(1e-12).log10().floor()).max(0.0) as usize;
    format!("{sigma:.places$}")
}

/// States the deviation of the places after an autofocus, and the axes that the echoes do not see.
fn autofocus_sigma(sigma_m: f64, unobserved: [f64; 3]) -> Finding {
    let shares = unobserved.map(|share| format!("{:.0}", 100.0 * share));
    Finding::judged("autofocus_sigma", 1e3 * sigma_m, "mm", Verdict::Agrees).because(format!(
        "rms deviation of a place after the correction, common shifts included; of the variance east, north \
         and up before, {} % are left, the most where the echoes do not see an axis",
        shares.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corrections_by_ghosts_are_doubtful() {
        let of = |ghosts| autofocus_gain(AutofocusSeen::Applied, [2.0, 0.5], 4, ghosts);
        assert_eq!(of(0).verdict, Verdict::Agrees);
        let drawn = of(2);
        assert_eq!(drawn.verdict, Verdict::Doubtful);
        assert!(drawn.explanation.contains("2 of them"), "{drawn:?}");
    }

    #[test]
    fn a_quantity_says_whether_the_echoes_tell_it() {
        let of = |values| autofocus_global("clock_offset", "s", values, true);
        let finding = of([0.002, 0.0004, 0.0015]);
        assert_eq!(finding.verdict, Verdict::Agrees);
        assert_eq!(finding.sigma, Some(0.0004));
        assert!(finding.explanation.contains("± 0.0015 s"), "{finding:?}");
        assert!(finding.explanation.contains("is applied"), "{finding:?}");
        let undetermined = of([0.0, 0.00149, 0.0015]);
        assert!(
            undetermined.explanation.contains("do not determine"),
            "{undetermined:?}"
        );
        assert_eq!(of([0.005, 0.0004, 0.0015]).verdict, Verdict::Doubtful);
    }
}
