//! Findings on the measured targets.

use acerra_imaging::metrics::{Measurement, Target};
use acerra_imaging::psf::PointSpread;

use super::target_focus::{Seen, point_spread};
use super::{reach, side, target_focus};
use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::position::aligned::Aligned;
use crate::prepare::Prepared;
use crate::soil::evidence::distinct;

/// Whether each target below ground exceeds the clutter at its depth: the probability that clutter alone has a maximum
/// as strong anywhere in the image is below 1 %. Empty for images above ground.
///
/// # Errors
/// The caller asked to stop.
pub fn exceed_clutter(
    prepared: &Prepared,
    focused: &Focused,
    targets: &[Target],
    control: &Control<'_>,
) -> Result<Vec<bool>, Cancelled> {
    let places_m: Vec<[f64; 3]> = targets.iter().map(|t| [t.x_m, t.y_m, t.z_m]).collect();
    distinct(prepared, focused, &places_m, control)
}

/// Range cell of the band (m), where a log holds traces, whose surface echo is known.
fn range_cell_m(prepared: &Prepared) -> Option<f64> {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let band_hz = frequency_hz.last()? - frequency_hz.first()?;
    let has_traces = prepared.tracks.iter().any(|track| track.cleaned.is_some());
    (band_hz > 0.0 && has_traces).then(|| 0.5 * prepared.scene.light_speed_m_s / band_hz)
}

/// Judges how many of an image's targets are residues of the surface echo; where these are the majority, they become
/// clutter. No finding below ground, where targets are compared with the clutter at their depth.
#[must_use]
pub fn separate_residues(
    prepared: &Prepared,
    focused: &Focused,
    measured: &mut Measurement,
) -> Option<Finding> {
    let cell_m = range_cell_m(prepared).filter(|_| focused.underground.is_none())?;
    let spread = point_spread(prepared, focused);
    let is_residue = |target: &Target| {
        is_below(&prepared.aligned, target, cell_m) && is_speckle(spread.as_ref(), target)
    };
    let targets = measured.targets.len();
    let is_residue: Vec<bool> = measured.targets.iter().map(is_residue).collect();
    let residues = is_residue.iter().filter(|residue| **residue).count();
    let finding = surface_residue(residues, targets);
    if finding.verdict != Verdict::Agrees {
        let mut judged = is_residue.iter();
        measured.targets.retain(|_| judged.next() != Some(&true));
        measured.clutter += residues;
        let strongest_db = measured.targets.first().map_or(0.0, |t| t.level_db);
        for target in &mut measured.targets {
            target.level_db -= strongest_db;
        }
    }
    Some(finding)
}

/// Judges the targets of an image, of which those below ground [exceed the clutter](exceed_clutter) or do not; no
/// finding where no log holds traces, whose surface echo is known.
#[must_use]
pub fn weigh_targets(
    prepared: &Prepared,
    focused: &Focused,
    targets: &[Target],
    exceeds_clutter: &[bool],
) -> Vec<Finding> {
    let Some(cell_m) = range_cell_m(prepared) else {
        return Vec::new();
    };
    let mut findings = Vec::new();
    findings.extend(side::weigh(prepared, targets));
    findings.extend(clutter(
        prepared,
        focused,
        (targets, exceeds_clutter),
        cell_m,
    ));
    findings.extend(reach::weigh(prepared, focused, targets));
    findings.extend(target_focus::weigh(prepared, focused, targets));
    findings
}

/// Whether a maximum has no width along the track, or more energy in its sidelobes than a point in focus has.
fn is_speckle(spread: Option<&PointSpread>, target: &Target) -> bool {
    let seen = || spread.and_then(|spread| Seen::of(spread, target));
    target.along.rayleigh_m.is_none() || seen().is_some_and(|seen| seen.is_out_of_focus())
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

/// Judges how many of the maxima are residues of the surface echo after background removal: straight below
/// the flight, and without a main lobe of their own, as speckle.
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
    Finding::judged("surface_residue", share, "share of the maxima", verdict)
        .expecting(0.0)
        .because(match verdict {
            Verdict::Agrees => format!(
                "{residues} of {targets} maxima lie straight below the flight without a main lobe that holds \
                 most of their energy, as residues of the surface echo do"
            ),
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "{residues} of {targets} maxima lie straight below the flight and have no main lobe that holds \
                 most of their energy: residues of the surface echo after background removal, not points, and \
                 not listed as targets. A scene to the side is imaged where [image] x_m, y_m state it, without \
                 a gate ([preprocess] gate_ns, background)"
            ),
        })
}

/// Cells of depth below the surface of the ground within which residues of its echo lie: its main lobe and the first
/// sidelobe.
const SHALLOW_CELLS: f64 = 2.0;

/// Judges the targets below ground that do not exceed the clutter at their depth; none for an image above the surface.
fn clutter(
    prepared: &Prepared,
    focused: &Focused,
    (targets, exceeds_clutter): (&[Target], &[bool]),
    cell_m: f64,
) -> Option<Finding> {
    let underground = focused.underground.as_ref()?;
    let top = underground.layers.first()?.soil.relative_permittivity;
    let least_m = SHALLOW_CELLS * cell_m / top.max(1.0).sqrt();
    let surface_m = |target: &Target| match underground.is_uneven {
        true => prepared.scene.ground.below_m(target.x_m, target.y_m),
        false => underground.surface_z_m,
    };
    let is_shallow = |target: &Target| (0.0..least_m).contains(&(surface_m(target) - target.z_m));
    let weak =
        || (targets.iter().zip(exceeds_clutter).enumerate()).filter(|(_, (_, exceeds))| !**exceeds);
    let numbers: Vec<usize> = weak().map(|(k, _)| k + 1).collect();
    let shallow = weak().filter(|(_, (target, _))| is_shallow(target)).count();
    Some(clutter_targets(&numbers, targets.len(), (shallow, least_m)))
}

/// The finding on the targets of these numbers; `shallow` of them are less than `least_m` below the surface.
fn clutter_targets(numbers: &[usize], targets: usize, (shallow, least_m): (usize, f64)) -> Finding {
    let verdict = if shallow > 0 {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let count = numbers.len();
    let named = match numbers {
        [] => String::new(),
        _ => {
            let numbers: Vec<String> = numbers.iter().map(usize::to_string).collect();
            format!(" (no. {})", numbers.join(", "))
        }
    };
    let place = format!(
        "{count} of {targets} targets{named} are no stronger than chance among the other echoes at their depth; {shallow} \
         of these are shallower than {least_m:.3} m, two cells of depth, where residues of the surface echo lie"
    );
    Finding::judged("clutter_targets", count as f64, "targets", verdict)
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
    fn weak_targets_just_below_the_surface_are_doubtful() {
        let of = |numbers: &[usize], shallow| clutter_targets(numbers, 7, (shallow, 0.057));
        assert_eq!(of(&[], 0).verdict, Verdict::Agrees);
        assert_eq!(of(&[7], 0).verdict, Verdict::Agrees);
        let found = of(&[3, 7], 1);
        assert_eq!(found.verdict, Verdict::Doubtful);
        assert!(
            (found.explanation)
                .starts_with("2 of 7 targets (no. 3, 7) are no stronger than chance"),
            "{}",
            found.explanation
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
