//! Evidence on the permittivity from the image below the surface.

use std::ops::Range;

use acerra_imaging::ImagingError;
use rayon::prelude::*;

use super::echo::{Bench, PointEcho, Stretch};
use super::points::buried_points;
use super::posterior::{CommonSigma, Likelihood};
use super::spacing::{Spacing, spacing};
use super::zero::excess_path_m;
use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::focus::underground::Underground;
use crate::position::aligned::Aligned;
use crate::prepare::{Prepared, Track};

/// Deviation of the delay between the surface's echo and another, in resolution cells; and where no echo of the surface
/// is seen, so that the zero of fast time counts as stated.
pub(crate) const TIMING_CELLS: f64 = 0.1;
const UNSEEN_CELLS: f64 = 0.5;
/// Cells of depth from which a point is no residue of the surface's echo.
const DEEP_CELLS: f64 = 2.0;

/// Likelihood of the permittivities by the buried points of an image; none for an image that is no volume
/// below the surface, or where no point's echo exceeds the clutter.
///
/// # Errors
/// The caller asked to stop.
pub(crate) fn likelihood(
    prepared: &Prepared,
    focused: &Focused,
    control: &Control<'_>,
) -> Result<Option<Likelihood>, Cancelled> {
    let Some((bench, cell_m, excess_path_m)) = bench(prepared, focused) else {
        return Ok(None);
    };
    let seen = Seen {
        prepared,
        focused,
        cell_m,
    };
    let points = seen.fitted(&bench, DEEP_CELLS, control, |place_m| bench.fit(place_m))?;
    let underground = bench.underground;
    let index = top_index(underground);
    let points = without_double_echoes(points, index, cell_m);
    tracing::debug!(?points, ?excess_path_m, "buried points");
    let common = common_sigma(prepared, cell_m, excess_path_m);
    let frequency_hz = &prepared.spectrum.frequency_hz;
    Ok(Likelihood::of(underground, frequency_hz, &points, common).unwrap_or(None))
}

/// An image below the surface, and the resolution cell of the range in air (m).
struct Seen<'a> {
    prepared: &'a Prepared,
    focused: &'a Focused,
    cell_m: f64,
}

impl Seen<'_> {
    /// The fits to the buried points of the image that lie at least so many cells of depth below the surface.
    fn fitted<T: Send>(
        &self,
        bench: &Bench<'_>,
        least_cells: f64,
        control: &Control<'_>,
        fit: impl Fn([f64; 3]) -> Result<Option<T>, ImagingError> + Sync,
    ) -> Result<Vec<T>, Cancelled> {
        let underground = bench.underground;
        let places = buried_points(
            self.focused,
            underground,
            &self.prepared.scene.ground,
            self.cell_m,
            least_cells * self.cell_m / top_index(underground),
        );
        let fitted = places.into_par_iter().map(|place_m| {
            control.check()?;
            // A ground or place that cannot be imaged gives no comparison.
            Ok(fit(place_m).unwrap_or(None))
        });
        let fitted: Vec<Option<T>> = fitted.collect::<Result<_, Cancelled>>()?;
        Ok(fitted.into_iter().flatten().collect())
    }
}

/// Refractive index of the topmost layer.
fn top_index(underground: &Underground) -> f64 {
    let top = underground.layers.first();
    top.map_or(1.0, |layer| layer.soil.relative_permittivity.sqrt())
}

/// Errors that all points of a run have in common. `excess_path_m` is none where no echo of the surface is seen.
fn common_sigma(prepared: &Prepared, cell_m: f64, excess_path_m: Option<f64>) -> CommonSigma {
    let heights_m = prepared.aligned.sigma_m.iter().map(|s| s[2]);
    let count = prepared.aligned.sigma_m.len().max(1) as f64;
    CommonSigma {
        // A surface by the radar's own echo has the error of the zero of fast time.
        height_m: match prepared.scene.open.surface {
            true => UNSEEN_CELLS * cell_m,
            false => heights_m.sum::<f64>() / count,
        },
        delay_m: match excess_path_m {
            Some(_) => TIMING_CELLS * cell_m,
            None => UNSEEN_CELLS * cell_m,
        },
    }
}

/// Spacing of the traces of a track along its lines, by the shapes of buried points' echoes; none for an image above ground,
/// or where no echo exceeds the clutter.
///
/// # Errors
/// The caller asked to stop.
pub(crate) fn spacing_below(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    control: &Control<'_>,
) -> Result<Option<Spacing>, Cancelled> {
    let Some((bench, cell_m, excess_path_m)) = bench(prepared, focused) else {
        return Ok(None);
    };
    let underground = bench.underground;
    let along = directions(&prepared.aligned);
    let stretch = Stretch {
        traces: [track.range.start, track.range.end],
        along: &along,
        factors: [1.0; 2],
    };
    let seen = Seen {
        prepared,
        focused,
        cell_m,
    };
    // Within a cell an echo is one with the surface's.
    let echoes = seen.fitted(&bench, 1.0, control, |place_m| {
        bench.stretched(place_m, stretch)
    })?;
    tracing::debug!(?echoes, "spacing");
    let common = common_sigma(prepared, cell_m, excess_path_m);
    let frequency_hz = &prepared.spectrum.frequency_hz;
    Ok(spacing(underground, frequency_hz, &echoes, common).unwrap_or(None))
}

/// Horizontal direction of each trace's line, of length one; zero on lines that have none.
fn directions(aligned: &Aligned) -> Vec<[f64; 2]> {
    let lines = aligned.lines(0..aligned.position_m.len());
    let of_line = |line: Range<usize>| {
        let places = &aligned.position_m[line];
        let (first, last) = (places[0], places[places.len() - 1]);
        let way_m = [last[0] - first[0], last[1] - first[1]];
        let length_m = way_m[0].hypot(way_m[1]).max(f64::MIN_POSITIVE);
        std::iter::repeat_n(way_m.map(|w| w / length_m), places.len())
    };
    let with_traces = lines.into_iter().filter(|line| !line.is_empty());
    with_traces.flat_map(of_line).collect()
}

/// The echoes of a run, to be compared with hyperbolas, the one-way optical length of a resolution cell of
/// the delay, and the two-way path by which the echo of the surface is later than its geometry, where one is
/// seen (m); none for an image above ground.
pub(crate) fn bench<'a>(
    prepared: &'a Prepared,
    focused: &'a Focused,
) -> Option<(Bench<'a>, f64, Option<f64>)> {
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let underground = focused.underground.as_ref()?;
    let cell_m =
        0.5 * prepared.scene.light_speed_m_s / (frequency_hz.last()? - frequency_hz.first()?);
    if !cell_m.is_finite() {
        return None;
    }
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
        stretch: None,
    };
    Some((bench, cell_m, excess_path_m))
}

/// Whether the echo of each place below ground exceeds the clutter at its depth by more than chance; empty for images
/// above ground.
pub(crate) fn distinct(
    prepared: &Prepared,
    focused: &Focused,
    places_m: &[[f64; 3]],
    control: &Control<'_>,
) -> Result<Vec<bool>, Cancelled> {
    let Some((bench, ..)) = bench(prepared, focused) else {
        return Ok(Vec::new());
    };
    let is_distinct = places_m.par_iter().map(|place_m| {
        control.check()?;
        // A ground or place that cannot be imaged has no targets.
        Ok((bench.distinct(*place_m)).is_ok_and(|found| found.is_some()))
    });
    is_distinct.collect()
}

/// Points without those that are the echo from one point by way of another. The points come strongest first;
/// such an echo lies midway between both points, and its delay exceeds their mean by half of their distance
/// in the soil, to a cell of the delay.
fn without_double_echoes(points: Vec<PointEcho>, index: f64, cell_m: f64) -> Vec<PointEcho> {
    let mut kept: Vec<PointEcho> = Vec::new();
    for point in points {
        let is_double = |a: &PointEcho, b: &PointEcho| {
            let middle = |axis: usize| 0.5 * (a.place_m[axis] + b.place_m[axis]);
            let away_m = (middle(0) - point.place_m[0]).hypot(middle(1) - point.place_m[1]);
            let apart: f64 = (0..3).map(|k| (a.place_m[k] - b.place_m[k]).powi(2)).sum();
            let later_m = point.delay_m - 0.5 * (a.delay_m + b.delay_m + index * apart.sqrt());
            away_m <= cell_m && later_m.abs() <= cell_m
        };
        let is_any =
            (kept.iter().enumerate()).any(|(k, a)| kept[k + 1..].iter().any(|b| is_double(a, b)));
        if !is_any {
            kept.push(point);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_echo_from_one_point_by_way_of_another_is_none() {
        let point = |x_m: f64, depth_m: f64| PointEcho {
            place_m: [x_m, 0.0, -depth_m],
            delay_m: 3.0 * depth_m,
            curvature_m: depth_m / 3.0,
            sigma_m: 1e-3,
        };
        let (a, b) = (point(1.0, 0.2), point(1.4, 0.1));
        let path_m = 3.0 * (0.2 + 0.1 + 0.4_f64.hypot(0.1));
        let double = point(1.2, path_m / 6.0);
        let deep = point(1.2, 0.5);
        let kept = without_double_echoes(vec![a, b, double, deep], 3.0, 0.075);
        assert_eq!(kept, [a, b, deep]);
    }
}
