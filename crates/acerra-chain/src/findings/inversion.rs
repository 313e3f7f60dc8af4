//! Findings on how the scene was solved for.

use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};

/// Convergence, residual relative to the noise, and places that the flight cannot distinguish; no findings
/// for an adjoint.
pub(super) fn weigh(focused: &Focused) -> Vec<Finding> {
    let Some(record) = &focused.inversion else {
        return Vec::new();
    };
    let seen = InversionSeen {
        iterations: record.iterations.last().map_or(0, |last| last.number),
        is_converged: record.stop.is_converged(),
        residual: record.residual,
        noise: record.noise.map(|noise| noise.expected_residual),
    };
    let at_strongest = record.resolution.first().and_then(|point| point.adjoint);
    let beside_db = at_strongest.and_then(|response| response.artefact_db);
    std::iter::once(inversion_converged(&seen))
        .chain(inversion_residual(&seen))
        .chain(beside_db.map(inversion_ambiguity))
        .collect()
}

/// The end of an inversion's iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
struct InversionSeen {
    /// Iterations done.
    pub iterations: usize,
    /// Whether the iterations converged to the solution that the method defines.
    pub is_converged: bool,
    /// ‖d − Lσ‖/‖d‖.
    pub residual: f64,
    /// Relative residual that noise alone would leave.
    pub noise: Option<f64>,
}

/// A residual this far above the noise is not the noise's, dB: something in the data is not in the model.
const MODEL_ERROR_DB: f64 = 6.0;

/// A residual this far below it explains noise as a scene, dB.
const OVER_FIT_DB: f64 = -3.0;

/// Doubts an image whose solution has not converged.
fn inversion_converged(seen: &InversionSeen) -> Finding {
    let verdict = if seen.is_converged {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    let iterations = seen.iterations as f64;
    Finding::judged("inversion_converged", iterations, "iterations", verdict).because(format!(
        "after {} iterations the solution {}: more iterations ([image.inversion] max_iterations), or more \
         regularisation (threshold_db, damping, sparsity, clean_threshold_db), lead to convergence",
        seen.iterations,
        if seen.is_converged {
            "no longer changes"
        } else {
            "still changes, or no longer improves"
        },
    ))
}

/// Judges the residual by the noise measured; none where no noise is known.
fn inversion_residual(seen: &InversionSeen) -> Option<Finding> {
    let noise = seen.noise.filter(|noise| *noise > 0.0)?;
    let value_db = 20.0 * seen.residual.max(f64::MIN_POSITIVE).log10();
    let noise_db = 20.0 * noise.log10();
    let above_db = value_db - noise_db;
    let (verdict, meaning) = if above_db > MODEL_ERROR_DB {
        (
            Verdict::Doubtful,
            "no point of the image explains much of the data: wrong positions or delay, echoes from outside \
             the image or from other heights, or too strong regularisation",
        )
    } else if above_db < OVER_FIT_DB {
        (
            Verdict::Doubtful,
            "the image explains noise as well: regularisation is too weak",
        )
    } else {
        (
            Verdict::Agrees,
            "the image explains the data up to the noise",
        )
    };
    let finding = Finding::judged("inversion_residual", value_db, "dB", verdict);
    Some(finding.expecting(noise_db).because(format!(
        "the echoes of the image differ from the data by {value_db:.1} dB of them, noise alone would give \
         {noise_db:.1} dB: {meaning} ([image] method, [image.inversion])"
    )))
}

/// An adjoint's ghost or sidelobe this close to the point itself leaves the choice between them to noise, dB.
const AMBIGUOUS_DB: f64 = -1.0;

/// Doubts a solution where the adjoint images a single point about as strongly elsewhere: `adjoint_db` is the
/// greatest value away from the point, at the strongest target.
fn inversion_ambiguity(adjoint_db: f64) -> Finding {
    let (verdict, meaning) = if adjoint_db > AMBIGUOUS_DB {
        (
            Verdict::Doubtful,
            "the flight cannot distinguish these places, so that the method's choice of one place (of the \
             side of a straight track) is arbitrary: compare with the adjoint, or fly a second track \
             parallel to this one",
        )
    } else {
        (Verdict::Agrees, "the flight distinguishes these places")
    };
    Finding::judged("inversion_ambiguity", adjoint_db, "dB", verdict).because(format!(
        "a point at the strongest target is seen by the adjoint at another place as well, {adjoint_db:.1} dB \
         relative to it: {meaning} ([image] method)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_far_from_the_noise_and_unfinished_iterations_are_doubtful() {
        let seen = |residual, noise, is_converged| InversionSeen {
            iterations: 40,
            is_converged,
            residual,
            noise,
        };
        let verdict = |residual, noise| {
            inversion_residual(&seen(residual, noise, true)).map(|finding| finding.verdict)
        };
        assert_eq!(verdict(0.5, Some(0.1)), Some(Verdict::Doubtful));
        assert_eq!(verdict(0.12, Some(0.1)), Some(Verdict::Agrees));
        assert_eq!(verdict(0.05, Some(0.1)), Some(Verdict::Doubtful));
        assert_eq!(verdict(0.05, None), None);
        assert_eq!(inversion_ambiguity(-0.2).verdict, Verdict::Doubtful);
        assert_eq!(inversion_ambiguity(-6.0).verdict, Verdict::Agrees);
        let converged = |is_converged| inversion_converged(&seen(0.1, None, is_converged)).verdict;
        assert_eq!(converged(true), Verdict::Agrees);
        assert_eq!(converged(false), Verdict::Doubtful);
    }
}
