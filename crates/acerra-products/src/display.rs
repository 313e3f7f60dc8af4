//! Display of the levels of an image: the window of levels and the compensation for range.

use acerra_figure::{DisplayGain, ImageDb, LevelWindow, Levels, PixelValues};
use acerra_imaging::PlaneGrid;

use crate::outcome::Outcome;

/// Share of an image's pixels below the lowest level of its picture: "peak over median" counts from the
/// median, and ground that the gate or the antenna leaves dark does not widen the window.
pub const DARK_SHARE: f64 = 0.5;

/// Levels of an image's picture: from a percentile of the image up to its maximum, as no fixed window suits
/// both two reflectors on a lawn and a street of houses.
pub const WINDOW: LevelWindow = LevelWindow::Percentile { share: DARK_SHARE };

/// Pictures are compensated for range where 1/R² varies by more than this over the image (dB), half
/// of a usual window of levels.
const COMPENSATED_FROM_DB: f64 = 20.0;

/// Positions of a track from which the nearest to a pixel is taken, at most.
const MOST_POSITIONS: usize = 512;

/// Parameters of the gain that removes 1/R².
#[derive(Clone, Copy, Debug)]
pub struct RangeGeometry<'a> {
    /// Columns and rows of the image.
    pub grid: &'a PlaneGrid,
    /// A height for all of its pixels (m).
    pub z_m: f64,
    /// Positions of the phase centre (m).
    pub position_m: &'a [[f64; 3]],
    /// Range cell c/(2B), below which range is not resolved; not finite for one frequency (m).
    pub range_cell_m: f64,
}

/// Display of the levels of a run's image in all of its pictures.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The gain that undoes the 1/R² of Eq. (3); none where it varies little over the image.
    pub gain: Option<DisplayGain>,
    /// Level at 0 dB and floor, the gain included.
    pub levels: Levels,
}

impl Shown {
    /// The window of levels and the gain for a run's image, from all of its pixels.
    #[must_use]
    pub fn of(outcome: &Outcome) -> Self {
        let grid = &outcome.focused.pixels.grid;
        let values = PixelValues::Complex(&outcome.focused.image);
        let mut figure = ImageDb::new("", values, grid.nx, grid.ny);
        figure.window = WINDOW;
        figure.gain = range_gain_of(outcome);
        Self {
            levels: figure.levels(),
            gain: figure.gain,
        }
    }
}

/// The gain that undoes the 1/R² of Eq. (3) for display of a run's image.
fn range_gain_of(outcome: &Outcome) -> Option<DisplayGain> {
    let frequency_hz = &outcome.prepared.spectrum.frequency_hz;
    let bandwidth_hz = frequency_hz.last()? - frequency_hz.first()?;
    range_gain(RangeGeometry {
        grid: &outcome.focused.pixels.grid,
        z_m: outcome.focused.pixels.middle_m(),
        position_m: &outcome.prepared.aligned.position_m,
        range_cell_m: 0.5 * outcome.campaign.image.light_speed_m_s / bandwidth_hz,
    })
}

/// The gain that removes the 1/R² of Eq. (3) for display, R being the distance to the nearest point of the
/// tracks: without the gain clutter near the antenna has the maximum, and far pixels are black. None where
/// 1/R² varies little over the image.
#[must_use]
pub fn range_gain(geometry: RangeGeometry<'_>) -> Option<DisplayGain> {
    let RangeGeometry { grid, z_m, .. } = geometry;
    let positions = geometry.position_m;
    let step = positions.len().div_ceil(MOST_POSITIONS).max(1);
    let sampled: Vec<[f64; 3]> = positions.iter().step_by(step).copied().collect();
    // Below a range cell (a pixel, for one frequency alone), range is not resolved.
    let least_m = if geometry.range_cell_m.is_finite() {
        geometry.range_cell_m.max(grid.pixel_m)
    } else {
        grid.pixel_m
    };
    let range_m = |x_m: f64, y_m: f64| {
        let to = |p: &[f64; 3]| {
            let away_m = [p[0] - x_m, p[1] - y_m, p[2] - z_m];
            away_m.iter().map(|d| d * d).sum::<f64>()
        };
        let nearest_m2 = sampled.iter().map(to).fold(f64::INFINITY, f64::min);
        nearest_m2.sqrt().max(least_m)
    };
    #[expect(clippy::cast_precision_loss, reason = "a count of pixels")]
    let edges = |first_m: f64, n: usize| {
        let edge_m = first_m - 0.5 * grid.pixel_m;
        [edge_m, edge_m + grid.pixel_m * n as f64]
    };
    let gain = DisplayGain::sample(
        "1/R² undone",
        edges(grid.x0_m, grid.nx),
        edges(grid.y0_m, grid.ny),
        |x_m, y_m| 40.0 * range_m(x_m, y_m).log10(),
    );
    (gain.span_db() > COMPENSATED_FROM_DB).then_some(gain)
}
