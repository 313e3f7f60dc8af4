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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mostly_residues_are_doubtful() {
        assert_eq!(surface_residue(0, 0).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(2, 2).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(3, 6).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(37, 47).verdict, Verdict::Doubtful);
    }
}
