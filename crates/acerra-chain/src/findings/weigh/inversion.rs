//! Findings on how the scene was solved for.

use crate::findings::evidence::{
    Finding, InversionSeen, inversion_ambiguity, inversion_converged, inversion_residual,
};
use crate::focus::Focused;

/// Convergence, the residual beside the noise, and what the flight cannot tell apart; nothing of an adjoint.
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
