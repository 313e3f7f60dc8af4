//! What an autofocus says of the positions.

use super::finding::{Finding, Verdict};

/// Rms correction, in deviations that the positions state, from which those are doubtful.
const DOUBTFUL_CORRECTION: f64 = 2.0;

/// What became of an autofocus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AutofocusSeen {
    /// Its correction is applied.
    Applied,
    /// Points that took no part in the correction did not gain significantly.
    NotSignificant,
    /// No point stands out.
    NoPoints,
    /// The correction is larger than the positions' deviations allow.
    AgainstPrior,
}

/// Judges the gain of the points' peaks by an autofocus, beside the loss that the positions'
/// deviations predict.
#[must_use]
pub fn autofocus_gain(seen: AutofocusSeen, gain_db: f64, sigma_db: f64, points: usize) -> Finding {
    let (verdict, what) = match seen {
        AutofocusSeen::Applied if points < 2 => (
            Verdict::Doubtful,
            "the places are corrected by a single point, whose own motion would look the same",
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
            "no point stands out of the image: the places are as stated",
        ),
        AutofocusSeen::AgainstPrior => (
            Verdict::Doubtful,
            "the echoes ask for corrections beyond what the positions' deviations allow (do the points move? \
             [autofocus] sigma_m): the places are as stated",
        ),
    };
    let mut finding = Finding::judged("autofocus_gain", gain_db, "dB", verdict)
        .because(format!("{points} points; {what}"));
    finding.sigma = Some(sigma_db);
    finding
}

/// Judges the corrections by the deviations that the positions state: rms in units of them, 1 if they
/// are right and the echoes see everything.
#[must_use]
pub fn autofocus_correction(in_sigmas: f64) -> Finding {
    let verdict = if in_sigmas <= DOUBTFUL_CORRECTION {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("autofocus_correction", in_sigmas, "σ", verdict)
        .expecting(1.0)
        .because(
            "rms of the corrections over the deviations of the positions: beyond 2 those are too small, or \
             errors of another kind (delay, clock, height of the ground) are taken for theirs",
        )
}

/// States the deviation of the places after an autofocus, and the axes that the echoes do not see.
#[must_use]
pub fn autofocus_sigma(sigma_m: f64, unobserved: [f64; 3]) -> Finding {
    let shares = unobserved.map(|share| format!("{:.0}", 100.0 * share));
    Finding::judged("autofocus_sigma", 1e3 * sigma_m, "mm", Verdict::Agrees).because(format!(
        "rms deviation of a place after the correction, common shifts included; of the variance east, north \
         and up before, {} % are left, the most where the echoes do not see an axis",
        shares.join(", ")
    ))
}
