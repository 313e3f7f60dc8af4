//! What the positions say of themselves.

use std::f64::consts::TAU;

use super::finding::{Finding, Verdict};

/// Judges the loss of focus that the positions' own σ predict, after Eq. (5): a phase error of
/// 4πσ/λ along the line of sight.
///
/// Errors that all traces share move the image without blurring it, so that the loss is a bound;
/// beyond half a wavelength (float and single-point positions) what is left of the focus is chance.
#[must_use]
pub fn focusing_loss(sigma_m: f64, wavelength_m: f64) -> Finding {
    let phase_rad = 2.0 * TAU * sigma_m / wavelength_m;
    let loss_db = 10.0 * std::f64::consts::LOG10_E * phase_rad * phase_rad;
    let verdict = if sigma_m <= 0.5 * wavelength_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("position_sigma", 1e3 * sigma_m, "mm", verdict)
        .expecting(0.0)
        .because(format!(
            "positions of σ = {:.0} mm along the line of sight cost up to {loss_db:.1} dB of focus, \
             as much of them as changes from trace to trace",
            1e3 * sigma_m
        ))
}

/// Judges the share of the log's traces that have a position.
#[must_use]
pub fn trajectory_coverage(positioned: usize, traces: usize) -> Finding {
    let share = positioned as f64 / traces.max(1) as f64;
    let verdict = match share {
        s if s >= 0.8 => Verdict::Agrees,
        0.0 => Verdict::Contradicts,
        _ => Verdict::Doubtful,
    };
    Finding::judged("trajectory_coverage", share, "share of the traces", verdict)
        .expecting(1.0)
        .because(format!(
            "{positioned} of {traces} traces have a position ([trajectory] time_offset_s; do the \
             logs belong together?)"
        ))
}

/// Judges heights by the radar beside those of the positions that they replace: `off_m` is the standard
/// deviation of the positions' about the radar's, `stated_m` what the positions state of themselves.
#[must_use]
pub fn radar_height(off_m: f64, stated_m: Option<f64>, sigma_m: f64) -> Finding {
    let verdict = match stated_m {
        // Good heights were given away for worse ones.
        Some(stated_m) if stated_m < sigma_m => Verdict::Doubtful,
        Some(stated_m) if off_m > 3.0 * stated_m.hypot(sigma_m) => Verdict::Doubtful,
        _ => Verdict::Agrees,
    };
    Finding {
        sigma: stated_m.map(|stated_m| stated_m.hypot(sigma_m)),
        ..Finding::judged("radar_height", off_m, "m", verdict)
    }
    .expecting(0.0)
    .because(format!(
        "heights are those by the surface echo over level ground, ± {sigma_m:.2} m each; the \
         positions' wander about them by {off_m:.2} m and state {}; keep those that are better \
         ([trajectory] height; [image] z_m: the level of the ground is taken for the image's)",
        stated_m.map_or("no deviation".to_owned(), |m| format!("± {m:.2} m"))
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn float_positions_are_doubtful_and_the_loss_is_that_of_the_phase_error() {
        // 6 mm at 7.6 cm: 0.99 rad, 4.3 dB.
        let fixed = focusing_loss(0.006, 0.0759);
        assert_eq!(fixed.verdict, Verdict::Agrees);
        assert!(fixed.explanation.contains("4.3 dB"), "{fixed:?}");
        assert_eq!(focusing_loss(0.4, 0.0759).verdict, Verdict::Doubtful);
    }

    #[test]
    fn radar_heights_in_place_of_better_ones_are_doubted() {
        let verdict = |off_m, stated_m| radar_height(off_m, stated_m, 0.05).verdict;
        assert_eq!(verdict(0.04, Some(0.01)), Verdict::Doubtful);
        assert_eq!(verdict(1.5, Some(2.0)), Verdict::Agrees);
        assert_eq!(verdict(9.0, Some(2.0)), Verdict::Doubtful);
        assert_eq!(verdict(1.5, None), Verdict::Agrees);
    }
}
