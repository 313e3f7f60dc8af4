//! What the measured targets say of the image.

use super::finding::{Finding, Verdict};

/// Residues of the surface echo from which their share is judged: fewer are chance.
const LEAST_RESIDUES: usize = 3;

/// Judges how many of the `targets` are what the background leaves of the surface echo: straight below the
/// flight, and without a width along the track, as speckle is.
///
/// A scene to the side of the flight shows nothing else where the image's sides are left to the flight.
#[must_use]
pub fn surface_residue(residues: usize, targets: usize) -> Finding {
    let share = residues as f64 / targets.max(1) as f64;
    let verdict = if residues >= LEAST_RESIDUES && 2 * residues > targets {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    Finding::judged("surface_residue", share, "share of the targets", verdict)
        .expecting(0.0)
        .because(format!(
            "{residues} of {targets} targets stand straight below the flight and have no width along the \
             track: what the background leaves of the surface echo, not points. What lies to the side is \
             imaged where [image] x_m, y_m name it, without a gate ([preprocess] gate_ns, background)"
        ))
}

/// How surely a target stands on its side of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideSeen {
    /// Place of the target (x, y), m.
    pub place_m: [f64; 2],
    /// Probability that it stands where its ghost is.
    pub risk: f64,
}

impl SideSeen {
    /// Risk from which a target's side is doubtful.
    pub const DOUBTFUL_RISK: f64 = 0.01;
}

/// Judges the sides of the strongest targets; none where no target has a ghost.
#[must_use]
pub fn target_side(seen: &[SideSeen]) -> Option<Finding> {
    let worst = seen.iter().max_by(|a, b| a.risk.total_cmp(&b.risk))?;
    let is_doubtful = |target: &&SideSeen| target.risk > SideSeen::DOUBTFUL_RISK;
    let doubtful = seen.iter().filter(is_doubtful).count();
    let (verdict, what) = if doubtful == 0 {
        let what = "how the track bends and wanders tells it from its ghost".to_owned();
        (Verdict::Agrees, what)
    } else {
        let what = format!(
            "the track is too straight, for positions with the deviations stated, to tell the side of \
             {doubtful} of the {} strongest targets with a ghost: each may as well stand where its ghost is. A \
             bent track, a second one beside it or a surveyed point tells",
            seen.len()
        );
        (Verdict::Doubtful, what)
    };
    let [x_m, y_m] = worst.place_m;
    let risk = match worst.risk {
        risk if risk < SideSeen::DOUBTFUL_RISK => "less than 0.01".to_owned(),
        risk => format!("{risk:.2}"),
    };
    let finding = Finding::judged("target_side", worst.risk, "probability", verdict)
        .expecting(0.0)
        .because(format!(
            "the target at ({x_m:.2}, {y_m:.2}) m is on the other side of the track with a probability of \
             {risk}: {what}"
        ));
    Some(finding)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_doubtful_where_any_target_s_is() {
        let seen = |risk: f64| SideSeen {
            place_m: [4.0, -5.97],
            risk,
        };
        assert_eq!(target_side(&[]), None);
        let sure = target_side(&[seen(1e-6), seen(1e-3)]).map(|f| (f.verdict, f.value));
        assert_eq!(sure, Some((Verdict::Agrees, Some(1e-3))));
        let unsure = target_side(&[seen(1e-6), seen(0.07)]).map(|f| (f.verdict, f.value));
        assert_eq!(unsure, Some((Verdict::Doubtful, Some(0.07))));
    }

    #[test]
    fn mostly_residues_are_doubtful() {
        assert_eq!(surface_residue(0, 0).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(2, 2).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(3, 6).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(37, 47).verdict, Verdict::Doubtful);
    }
}
