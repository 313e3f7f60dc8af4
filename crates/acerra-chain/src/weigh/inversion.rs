//! Findings on how the scene was solved for.

use crate::evidence::{Finding, InversionSeen, inversion_converged, inversion_residual};
use crate::focus::Focused;

/// Convergence, and the residual beside the noise; nothing of an adjoint.
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
    std::iter::once(inversion_converged(&seen))
        .chain(inversion_residual(&seen))
        .collect()
}
