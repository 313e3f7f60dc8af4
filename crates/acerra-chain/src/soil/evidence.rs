//! What the image below the surface shows of the permittivity.

use rayon::prelude::*;

use super::echo::{Bench, PointEcho};
use super::points::buried_points;
use super::posterior::{CommonSigma, Likelihood};
use super::zero::excess_path_m;
use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::prepare::Prepared;

/// Deviation of the delay between the surface's echo and another, in resolution cells; and where no echo of the surface
/// is seen, so that the zero of fast time counts as stated.
const TIMING_CELLS: f64 = 0.1;
const UNSEEN_CELLS: f64 = 0.5;

/// Likelihood of the permittivities by the buried points of an image; none of an image that is no volume below the
/// surface, and where no point's echo exceeds the clutter.
///
/// # Errors
/// The caller asked to stop.
pub(crate) fn likelihood(
    prepared: &Prepared,
    focused: &Focused,
    control: &Control<'_>,
) -> Result<Option<Likelihood>, Cancelled> {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let (Some(underground), Some(low), Some(high)) = (
        &focused.underground,
        frequency_hz.first(),
        frequency_hz.last(),
    ) else {
        return Ok(None);
    };
    // One-way optical length of a resolution cell of the delay.
    let cell_m = 0.5 * prepared.scene.light_speed_m_s / (high - low);
    if !cell_m.is_finite() {
        return Ok(None);
    }
    let places = buried_points(focused, underground, &prepared.scene.ground, cell_m);
    let grid = &focused.pixels.grid;
    let excess_path_m = excess_path_m(prepared);
    let bench = Bench {
        echoes: prepared.echoes(),
        underground,
        excess_path_m: excess_path_m.unwrap_or(0.0),
        extent_m: [
            [grid.x0_m, grid.x_m(grid.nx.saturating_sub(1))],
            [grid.y0_m, grid.y_m(grid.ny.saturating_sub(1))],
        ],
        places: (focused.projections.as_ref()).map_or(1, |p| p.volume.base.len() * p.volume.nz),
    };
    let fitted = places.into_par_iter().map(|place_m| {
        control.check()?;
        // A ground or place that cannot be imaged leaves nothing to compare.
        Ok(bench.fit(place_m).unwrap_or(None))
    });
    let points: Vec<Option<PointEcho>> = fitted.collect::<Result<_, Cancelled>>()?;
    let points: Vec<PointEcho> = points.into_iter().flatten().collect();
    if std::env::var("SOIL").is_ok() { let e=underground.layers[0].soil.relative_permittivity; eprintln!("in force {e:.2} places {} excess {excess_path_m:?}", bench.places); for p in &points { eprintln!("   at {:.3} {:.3} tau {:.4} q {:.4} ± {:.4}  eps as point {:.2}", p.place_m[0],p.place_m[2],p.delay_m,p.curvature_m,p.sigma_m,p.delay_m/p.curvature_m);} }
    tracing::debug!(?points, ?excess_path_m, "buried points");
    let heights_m = prepared.aligned.sigma_m.iter().map(|s| s[2]);
    let count = prepared.aligned.sigma_m.len().max(1) as f64;
    let common = CommonSigma {
        // A surface by the radar's own echo is off by what the zero of fast time is.
        height_m: match prepared.scene.open.surface {
            true => UNSEEN_CELLS * cell_m,
            false => heights_m.sum::<f64>() / count,
        },
        delay_m: match excess_path_m {
            Some(_) => TIMING_CELLS * cell_m,
            None => UNSEEN_CELLS * cell_m,
        },
    };
    Ok(Likelihood::of(underground, frequency_hz, &points, common).unwrap_or(None))
}
