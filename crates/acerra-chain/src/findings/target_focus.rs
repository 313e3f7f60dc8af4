//! The finding on focus: the strongest targets compared with the flight's response to a point.
//!
//! Phases that err by σ leave a point exp(−σ²) of the power of its main lobe and put the rest into sidelobes.
//! Where nothing is focused every maximum is one of a comb of nearly equal lobes; the maxima of a rough
//! surface without points are similar, so that such an image is doubted and never contradicted.

use acerra_imaging::metrics::Target;
use acerra_imaging::psf::{Analysis, PointSpread};

use crate::focus::Focused;
use crate::focus::inversion::options::Method;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::Prepared;

/// Targets that are compared: least level relative to the strongest (dB), and largest number.
const FLOOR_DB: f64 = -6.0;
const MOST: usize = 6;
/// A target whose sidelobes hold more than its main lobe (dB) has lost half of its power to them.
const HALF_DB: f64 = 0.0;
/// The energy of sidelobes that the flight itself gives a point (dB) up to which a target may be judged.
const JUDGED_DB: f64 = -3.0;

/// Level of a target relative to its predicted response (dB).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    /// Highest sidelobe.
    peak_db: f64,
    /// Energy of the sidelobes over that of the main lobe.
    energy_db: f64,
    /// Predicted energy of the sidelobes over that of the main lobe.
    predicted_db: f64,
}

/// Judges the focus of an image by its strongest targets; no finding where no target has sidelobes inside the
/// image, for volumes, for images below ground, and for solutions of an inversion.
pub(super) fn weigh(prepared: &Prepared, focused: &Focused, targets: &[Target]) -> Option<Finding> {
    let is_adjoint = focused.options.inversion.method == Method::Adjoint;
    if focused.underground.is_some() || focused.projections.is_some() || !is_adjoint {
        return None;
    }
    let echoes = prepared.echoes();
    let weight = echoes.weights(focused.options.weight);
    let spread = PointSpread::of(&echoes.pulses(&weight).ok()?);
    let strong = targets.iter().filter(|t| t.level_db >= FLOOR_DB).take(MOST);
    let seen: Vec<Seen> = strong
        .filter_map(|target| {
            let (peak_db, energy_db) = (target.pslr_db?, target.islr_db?);
            let place_m = [target.x_m, target.y_m, target.z_m];
            let predicted = Analysis::of(&spread, place_m, target.z_m).ok()?;
            let predicted_db = predicted.islr_db?;
            let seen = Seen {
                peak_db,
                energy_db,
                predicted_db,
            };
            (predicted_db <= JUDGED_DB).then_some(seen)
        })
        .collect();
    target_focus(&seen)
}

fn target_focus(seen: &[Seen]) -> Option<Finding> {
    let best = seen
        .iter()
        .min_by(|a, b| a.energy_db.total_cmp(&b.energy_db))?;
    let verdict = if best.energy_db > HALF_DB {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let Seen {
        peak_db,
        energy_db,
        predicted_db,
    } = *best;
    let count = seen.len();
    let comparison = format!(
        "the best focused of the {count} strongest targets has {energy_db:+.1} dB of its energy in sidelobes, the \
         flight gives a point {predicted_db:+.1} dB, and its highest sidelobe is {peak_db:+.1} dB"
    );
    let keys = "[image] z_m, [radar] delay_ns, [trajectory] time_offset_s, lever_arm_m; positions that are not fixed";
    let explanation = if verdict == Verdict::Agrees {
        format!("{comparison}: it is in focus")
    } else {
        format!(
            "{comparison}: half of its power and more is out of focus ({keys}), or it is no point"
        )
    };
    let finding = Finding::judged("target_focus", energy_db, "dB", verdict);
    Some(finding.expecting(predicted_db).because(explanation))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(seen: &[[f64; 2]]) -> Option<Verdict> {
        let seen: Vec<Seen> = seen
            .iter()
            .map(|[peak_db, energy_db]| Seen {
                peak_db: *peak_db,
                energy_db: *energy_db,
                predicted_db: -8.0,
            })
            .collect();
        target_focus(&seen).map(|finding| finding.verdict)
    }

    #[test]
    fn one_target_in_focus_is_enough() {
        assert_eq!(verdict(&[]), None);
        assert_eq!(
            verdict(&[[-0.1, 7.0], [-11.0, -6.0], [-0.2, 6.0]]),
            Some(Verdict::Agrees)
        );
        assert_eq!(
            verdict(&[[-3.0, 1.5], [-0.5, 6.0]]),
            Some(Verdict::Doubtful)
        );
    }

    #[test]
    fn combs_of_equal_lobes_are_doubted() {
        let comb = [[-0.1, 7.0], [-0.3, 5.0], [-0.2, 6.0]];
        assert_eq!(verdict(&comb), Some(Verdict::Doubtful));
    }
}
