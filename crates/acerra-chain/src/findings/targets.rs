//! Findings on the measured targets.

use acerra_imaging::metrics::Target;

use super::{reach, side, target_focus};
use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
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
pub(super) fn range_cell_m(prepared: &Prepared) -> Option<f64> {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let band_hz = frequency_hz.last()? - frequency_hz.first()?;
    let has_traces = prepared.tracks.iter().any(|track| track.cleaned.is_some());
    (band_hz > 0.0 && has_traces).then(|| 0.5 * prepared.scene.light_speed_m_s / band_hz)
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
    use super::*;

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
}
