//! The height cue: the surface echo's fast time against 2h/c of the trajectory, over all echoes followed.

use rayon::prelude::*;

use super::echo::Ridge;
use super::height_cue::{Grid, HeightCue};
use super::height_fit::{Fit, Mixture, Rough};
use super::surface::surfaces;
use super::{AlignError, FlightProfile};
use acerra_control::Control;

/// Initial model of the residuals: an error of 3 cm, every fifth a stray.
const TYPICAL: Mixture = Mixture {
    sigma_s: 0.2e-9,
    stray_share: 0.2,
};
/// Logarithm of the prior odds against an echo being the surface.
const DOUBT: f64 = 4.0;
/// Spacing of the coarse grid of offsets, in steps of the fine one.
const COARSE: f64 = 4.0;
/// Number of ridges tried on the whole grid.
const KEPT: usize = 6;

/// The cues of the echoes that follow the height best, the best first.
///
/// All ridges are tried on a coarse grid, the best few on the whole one. `likely_s` is the width of the
/// offsets that agree with the other cues.
pub(super) fn height_cues(
    ridges: &[Ridge],
    profile: &FlightProfile,
    grid: Grid,
    likely_s: f64,
    control: Control<'_>,
) -> Result<Vec<HeightCue>, AlignError> {
    let coarse = Grid {
        step_s: COARSE * grid.step_s,
        count: (grid.count as f64 / COARSE).ceil() as usize,
        ..grid
    };
    // Offsets half a second apart count as independent trials, each of which may fit by chance.
    let trials = (likely_s / 0.5).max(1.0);
    let fit = |ridge: &Ridge, grid, rough: Option<&HeightCue>| {
        let start = rough.map_or(TYPICAL, |cue| Mixture {
            sigma_s: cue.residual_s,
            stray_share: cue.stray_share,
        });
        let fit = Fit {
            ridge,
            profile,
            grid,
        };
        let rough = rough.map(|cue| Rough {
            curve: cue.curve.clone(),
            length: cue.correlation_length,
        });
        let cue = fit.cue(start, rough, control)?;
        let evidence = cue.evidence - trials.ln() - DOUBT;
        Ok::<_, AlignError>(HeightCue { evidence, ..cue })
    };
    let mut rough: Vec<(HeightCue, &Ridge)> = ridges
        .par_iter()
        .map(|ridge| Ok((fit(ridge, coarse, None)?, ridge)))
        .collect::<Result<_, AlignError>>()?;
    rough.sort_by(|a, b| b.0.preference.total_cmp(&a.0.preference));
    rough.truncate(KEPT);
    let mut cues: Vec<HeightCue> = rough
        .par_iter()
        .map(|(cue, ridge)| fit(ridge, grid, Some(cue)))
        .collect::<Result<_, AlignError>>()?;
    cues.retain(|cue| cue.evidence > 0.0);
    let mut cues = surfaces(cues);
    cues.sort_by(|a, b| b.preference.total_cmp(&a.preference));
    Ok(cues)
}
