//! The strongest echo of the same traces at many delays.
//!
//! Some delays image all pixels. Echoes move little from one of these delays to the next: the delays between them image
//! patches about the strongest echoes of both.

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{PlaneGrid, TrialImages};
use rayon::prelude::*;

use super::echo_power::StrongestEcho;
use super::error::DelayError;
use super::scan::DelayScan;

/// Number of delays from one image of all pixels to the next.
const WHOLE_EVERY: usize = 4;
/// Level of the echoes that are followed, relative to the strongest (dB), and their largest number: half the spacing of
/// whole images costs an echo seen over 60° two decibels.
const FLOOR_DB: f64 = -6.0;
const FOLLOWED: usize = 16;
/// Half of a patch's side, and the distance below which one patch serves two echoes (m).
const HALF_SIDE_M: f64 = 0.4;
const APART_M: f64 = 0.15;

/// The strongest echo of an image of all pixels, and the places (x, y) of the echoes that are followed (m).
type Whole = (StrongestEcho, Vec<[f64; 2]>);

impl DelayScan<'_> {
    /// The strongest echo at each of some rising delays, relative to the delay of the spectra (s); `imaged` is called
    /// for each.
    pub(super) fn strongest_at(
        &self,
        later_s: &[f64],
        imaged: impl Fn() -> Result<(), DelayError> + Sync,
    ) -> Result<Vec<StrongestEcho>, DelayError> {
        let Some(last) = later_s.len().checked_sub(1) else {
            return Ok(Vec::new());
        };
        let searched = self.searched();
        let largest_s = later_s.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        let reach_m = self.reach_m(largest_s);
        let looks = searched.delays(self.grid, reach_m)?;
        let whole_at = |k: usize| {
            imaged()?;
            let image = self.tabulated_image(&looks, later_s[k], self.grid)?;
            let view = ImageView::new(&image, self.grid)?;
            let places_m = strongest_maxima(&view, FLOOR_DB, FOLLOWED);
            Ok((StrongestEcho::of(&image, self.grid)?, places_m))
        };
        let nodes: Vec<usize> = (0..last).step_by(WHOLE_EVERY).chain([last]).collect();
        let whole: Vec<Whole> = (nodes.par_iter())
            .map(|k| whole_at(*k))
            .collect::<Result<_, DelayError>>()?;
        let looks = searched.looks(self.grid, reach_m)?;
        let echo_at = |k: usize| {
            let after = nodes.partition_point(|node| *node < k);
            if nodes[after] == k {
                return Ok(whole[after].0);
            }
            imaged()?;
            let places_m = [after - 1, after].map(|node| &whole[node].1);
            self.strongest_about(&looks, later_s[k], places_m.into_iter().flatten())
        };
        (0..=last).into_par_iter().map(echo_at).collect()
    }

    /// The strongest echo about some places (x, y), m.
    fn strongest_about<'p>(
        &self,
        looks: &TrialImages<'_>,
        later_s: f64,
        places_m: impl Iterator<Item = &'p [f64; 2]>,
    ) -> Result<StrongestEcho, DelayError> {
        let mut strongest = StrongestEcho::NONE;
        let mut centres_m: Vec<[f64; 2]> = Vec::new();
        for &[x_m, y_m] in places_m {
            if centres_m
                .iter()
                .any(|[x, y]| (x - x_m).hypot(y - y_m) < APART_M)
            {
                continue;
            }
            centres_m.push([x_m, y_m]);
            let patch = patch_about(self.grid, [x_m, y_m]);
            let image = self.tabulated_image(looks, later_s, patch)?;
            let echo = StrongestEcho::of(&image, patch)?;
            if echo.log_power > strongest.log_power {
                strongest = echo;
            }
        }
        Ok(strongest)
    }
}

/// The pixels of a grid within [`HALF_SIDE_M`] of a place.
fn patch_about(grid: PlaneGrid, [x_m, y_m]: [f64; 2]) -> PlaneGrid {
    let half = (HALF_SIDE_M / grid.pixel_m).ceil();
    let part = |place_m: f64, first_m: f64, count: usize| {
        let middle = (place_m - first_m) / grid.pixel_m;
        let last = count.saturating_sub(1) as f64;
        let ends = [middle - half, middle + half].map(|k| k.round().clamp(0.0, last) as usize);
        (ends[0], ends[1] - ends[0] + 1)
    };
    let (ix, nx) = part(x_m, grid.x0_m, grid.nx);
    let (iy, ny) = part(y_m, grid.y0_m, grid.ny);
    PlaneGrid {
        x0_m: grid.x_m(ix),
        y0_m: grid.y_m(iy),
        nx,
        ny,
        ..grid
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use std::f64::consts::TAU;

    use acerra_radar::Spectrum;
    use num_complex::Complex64;

    use super::*;

    const LIGHT_SPEED_M_S: f64 = 299_792_458.0;

    #[test]
    fn patches_between_whole_images_hold_the_strongest_echo() {
        let position_m: Vec<[f64; 3]> = (0..120)
            .map(|m| [0.05 * f64::from(m) - 3.0, 0.0, 4.0])
            .collect();
        let frequency_hz: Vec<f64> = (0..150).map(|n| 3.2e9 + 1e7 * f64::from(n)).collect();
        // The stronger of two echoes changes with the delay, as they are seen under different angles.
        let points = [([-0.4, 1.0], 0.8), ([0.8, 4.2], 1.0), ([0.2, 3.6], 0.5)];
        let echo = |p: &[f64; 3], f: f64| -> Complex64 {
            let of_point = |([x_m, y_m], level): &([f64; 2], f64)| {
                let range_m = (p[0] - x_m).hypot(p[1] - y_m).hypot(p[2]);
                level * Complex64::cis(-2.0 * TAU * f * range_m / LIGHT_SPEED_M_S)
            };
            points.iter().map(of_point).sum()
        };
        let values = (position_m.iter())
            .flat_map(|p| frequency_hz.iter().map(move |f| echo(p, *f)))
            .collect();
        let spectrum = Spectrum {
            time_s: (0..120).map(f64::from).collect(),
            frequency_hz,
            values,
        };
        let grid = PlaneGrid::from_ranges([-2.0, 2.0], [0.2, 5.5], 0.0, 0.025).unwrap();
        let scan = DelayScan {
            position_m: &position_m,
            spectrum: &spectrum,
            grid,
            light_speed_m_s: LIGHT_SPEED_M_S,
        };
        let later_s: Vec<f64> = (-11..=11).map(|k| 0.15e-9 * f64::from(k)).collect();
        let found = scan.strongest_at(&later_s, || Ok(())).unwrap();
        for (later_s, found) in later_s.iter().zip(&found) {
            let image = scan.image(*later_s, grid).unwrap();
            let whole = StrongestEcho::of(&image, grid).unwrap();
            let off = found.log_power - whole.log_power;
            assert!(off.abs() < 0.03, "{later_s}: {found:?} {whole:?}");
        }
        // At the right delay the strongest echo is that of the strongest point.
        let [x_m, y_m] = found[11].place_m.unwrap();
        assert!((x_m - 0.8).hypot(y_m - 4.2) < 0.05, "{:?}", found[11]);
        assert!(found[11].log_power > found[0].log_power + 0.3);
    }
}
