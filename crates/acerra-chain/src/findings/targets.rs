//! Findings on the measured targets.

use acerra_imaging::metrics::Target;

use super::{reach, side, target_focus};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::position::aligned::Aligned;
use crate::prepare::Prepared;
use crate::soil::evidence::is_distinct;

/// Judges the targets of an image; no finding where no log holds traces, whose surface echo is known.
#[must_use]
pub fn weigh_targets(prepared: &Prepared, focused: &Focused, targets: &[Target]) -> Vec<Finding> {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let (Some(low), Some(high)) = (frequency_hz.first(), frequency_hz.last()) else {
        return Vec::new();
    };
    if high <= low || prepared.tracks.iter().all(|track| track.cleaned.is_none()) {
        return Vec::new();
    }
    let cell_m = 0.5 * prepared.scene.light_speed_m_s / (high - low);
    let is_residue = |target: &&Target| {
        target.along.rayleigh_m.is_none() && is_below(&prepared.aligned, target, cell_m)
    };
    let residues = targets.iter().filter(is_residue).count();
    let mut findings = vec![surface_residue(residues, targets.len())];
    findings.extend(side::weigh(prepared, targets));
    findings.extend(shallow(prepared, focused, targets, cell_m));
    findings.extend(reach::weigh(prepared, focused, targets));
    findings.extend(target_focus::weigh(prepared, focused, targets));
    findings
}

/// Whether a target lies within a range cell of the ground straight below the trace nearest to it.
fn is_below(aligned: &Aligned, target: &Target, cell_m: f64) -> bool {
    let range_m = |p: &[f64; 3]| {
        let away = [target.x_m - p[0], target.y_m - p[1], target.z_m - p[2]];
        away.iter().map(|v| v * v).sum::<f64>().sqrt()
    };
    let traces = aligned.position_m.iter().zip(&aligned.height_m);
    let nearest = traces
        .map(|(p, height_m)| (range_m(p), *height_m))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.is_some_and(|(range_m, height_m)| (range_m - height_m).abs() <= cell_m)
}

/// Residues of the surface echo from which their share is judged: fewer are chance.
const LEAST_RESIDUES: usize = 3;

/// Judges how many of the `targets` are residues of the surface echo after background removal: straight below
/// the flight, and without a width along the track, as speckle.
///
/// An image of a scene to the side holds only such residues where the campaign leaves the image's sides to
/// the flight.
fn surface_residue(residues: usize, targets: usize) -> Finding {
    let share = residues as f64 / targets.max(1) as f64;
    let verdict = if residues >= LEAST_RESIDUES && 2 * residues > targets {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    Finding::judged("surface_residue", share, "share of the targets", verdict)
        .expecting(0.0)
        .because(match verdict {
            Verdict::Agrees => format!(
                "{residues} of {targets} targets lie straight below the flight without a width along the \
                 track, as residues of the surface echo do"
            ),
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "{residues} of {targets} targets lie straight below the flight and have no width along the \
                 track: residues of the surface echo after background removal, not points. A scene to the \
                 side is imaged where [image] x_m, y_m state it, without a gate ([preprocess] gate_ns, \
                 background)"
            ),
        })
}

/// Cells of depth below the surface of the ground within which residues of its echo lie: its main lobe and the first
/// sidelobe.
const SHALLOW_CELLS: f64 = 2.0;

/// Counts the targets just below the surface of the ground that do not exceed other echoes at their depth;
/// none for an image above the surface.
fn shallow(
    prepared: &Prepared,
    focused: &Focused,
    targets: &[Target],
    cell_m: f64,
) -> Option<Finding> {
    let underground = focused.underground.as_ref()?;
    let top = underground.layers.first()?.soil.relative_permittivity;
    let least_m = SHALLOW_CELLS * cell_m / top.max(1.0).sqrt();
    let surface_m = |target: &Target| match underground.is_uneven {
        true => prepared.scene.ground.below_m(target.x_m, target.y_m),
        false => underground.surface_z_m,
    };
    let is_shallow = |target: &&Target| (0.0..least_m).contains(&(surface_m(target) - target.z_m));
    let is_residue =
        |target: &&Target| !is_distinct(prepared, focused, [target.x_m, target.y_m, target.z_m]);
    let count = targets.iter().filter(is_shallow).filter(is_residue).count();
    Some(shallow_targets(count, targets.len(), least_m))
}

fn shallow_targets(count: usize, targets: usize, least_m: f64) -> Finding {
    let verdict = if count > 0 {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let place = format!(
        "{count} of {targets} targets are shallower than {least_m:.3} m, two cells of depth, and no stronger than chance \
         among the residues of the surface echo at their depth"
    );
    Finding::judged("shallow_targets", count as f64, "targets", verdict)
        .expecting(0.0)
        .because(match verdict {
            Verdict::Agrees => place,
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "{place}. Compare backgrounds ([preprocess] background), or begin [image] z_m below that depth"
            ),
        })
}

#[cfg(test)]
mod tests {
    use acerra_imaging::metrics::AlongTrack;

    use super::*;

    #[test]
    fn below_is_within_a_range_cell_of_the_height() {
        let aligned = Aligned {
            position_m: (0..50).map(|k| [0.2 * f64::from(k), -20.0, 6.5]).collect(),
            height_m: vec![8.0; 50],
            ..Aligned::default()
        };
        let at = |y_m: f64| Target {
            x_m: 4.1,
            y_m,
            z_m: -1.5,
            level_db: 0.0,
            along: AlongTrack::default(),
            across: Default::default(),
            pslr_db: None,
            islr_db: None,
            ghost: None,
        };
        // √(2 · 8 · 0.088) = 1.19 m.
        assert!(is_below(&aligned, &at(-20.0), 0.088));
        assert!(is_below(&aligned, &at(-18.9), 0.088));
        assert!(!is_below(&aligned, &at(-18.7), 0.088));
        assert!(!is_below(&aligned, &at(0.0), 0.088));
    }

    #[test]
    fn targets_just_below_the_surface_are_doubtful() {
        assert_eq!(shallow_targets(0, 3, 0.06).verdict, Verdict::Agrees);
        let found = shallow_targets(2, 7, 0.057);
        assert_eq!(found.verdict, Verdict::Doubtful);
        assert!(
            found
                .explanation
                .starts_with("2 of 7 targets are shallower than 0.057 m")
        );
    }

    #[test]
    fn mostly_residues_are_doubtful() {
        assert_eq!(surface_residue(0, 0).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(2, 2).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(3, 6).verdict, Verdict::Agrees);
        assert_eq!(surface_residue(37, 47).verdict, Verdict::Doubtful);
    }
}
