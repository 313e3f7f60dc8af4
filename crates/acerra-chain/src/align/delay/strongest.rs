//! The strongest echo of the same traces at many delays.
//!
//! Some delays image all pixels; the delays between them image the patches into which the strongest echoes of both
//! neighbours can have moved.

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
/// Pixels about the echo's farthest place that belong to a patch: twice the width of a point seen under 60°.
const MARGIN_PIXELS: f64 = 3.0;

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
            let patches = [after - 1, after].map(|node| {
                let farther_m = self.reach_m((later_s[k] - later_s[nodes[node]]).abs());
                let places_m = whole[node].1.iter();
                places_m.map(move |place_m| self.patch(*place_m, farther_m))
            });
            self.strongest_in(&looks, later_s[k], patches.into_iter().flatten())
        };
        (0..=last).into_par_iter().map(echo_at).collect()
    }

    /// The strongest echo in some patches.
    fn strongest_in(
        &self,
        looks: &TrialImages<'_>,
        later_s: f64,
        patches: impl Iterator<Item = Patch>,
    ) -> Result<StrongestEcho, DelayError> {
        let mut strongest = StrongestEcho::NONE;
        let mut imaged: Vec<Patch> = Vec::new();
        for patch in patches {
            if imaged.iter().any(|other| other.holds(patch)) {
                continue;
            }
            imaged.push(patch);
            let pixels = patch.pixels(self.grid);
            let image = self.tabulated_image(looks, later_s, pixels)?;
            let echo = StrongestEcho::of(&image, pixels)?;
            if echo.log_power > strongest.log_power {
                strongest = echo;
            }
        }
        Ok(strongest)
    }

    /// Where an echo at a place (x, y), m, may be when its range is longer or shorter by `farther_m`: it moves away from
    /// the path, most where it lies below.
    fn patch(&self, place_m: [f64; 2], farther_m: f64) -> Patch {
        let from = |p: &[f64; 3]| {
            let level_m = (p[0] - place_m[0]).hypot(p[1] - place_m[1]);
            (level_m.hypot(p[2] - self.grid.z_m), level_m)
        };
        let nearest = self.position_m.iter().map(from);
        let (range_m, level_m) = nearest
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or_default();
        let moved_m = [farther_m, -farther_m].map(|by_m| {
            let square_m2 = level_m * level_m + 2.0 * range_m * by_m + by_m * by_m;
            (square_m2.max(0.0).sqrt() - level_m).abs()
        });
        Patch {
            centre_m: place_m,
            half_m: moved_m[0].max(moved_m[1]) + MARGIN_PIXELS * self.grid.pixel_m,
        }
    }
}

/// A square of pixels that are imaged.
#[derive(Clone, Copy, Debug)]
struct Patch {
    centre_m: [f64; 2],
    half_m: f64,
}

impl Patch {
    /// Whether this patch holds another one.
    fn holds(self, other: Self) -> bool {
        let away = |k: usize| (self.centre_m[k] - other.centre_m[k]).abs();
        away(0).max(away(1)) <= self.half_m - other.half_m
    }

    /// The pixels of a grid in this patch.
    fn pixels(self, grid: PlaneGrid) -> PlaneGrid {
        let part = |k: usize, first_m: f64, count: usize| {
            let last = count.saturating_sub(1) as f64;
            let ends = [-self.half_m, self.half_m].map(|half_m| {
                let at = (self.centre_m[k] + half_m - first_m) / grid.pixel_m;
                at.round().clamp(0.0, last) as usize
            });
            (ends[0], ends[1] - ends[0] + 1)
        };
        let (ix, nx) = part(0, grid.x0_m, grid.nx);
        let (iy, ny) = part(1, grid.y0_m, grid.ny);
        PlaneGrid {
            x0_m: grid.x_m(ix),
            y0_m: grid.y_m(iy),
            nx,
            ny,
            ..grid
        }
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

    /// Compares the strongest echoes with those of whole images, for points (x, y) and their amplitudes seen from a
    /// straight path; the strongest echoes.
    fn compared(height_m: f64, points: &[([f64; 2], f64)], y_m: [f64; 2]) -> Vec<StrongestEcho> {
        let position_m: Vec<[f64; 3]> = (0..120)
            .map(|m| [0.05 * f64::from(m) - 3.0, 0.0, height_m])
            .collect();
        let frequency_hz: Vec<f64> = (0..150).map(|n| 3.2e9 + 1e7 * f64::from(n)).collect();
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
        let grid = PlaneGrid::from_ranges([-2.0, 2.0], y_m, 0.0, 0.025).unwrap();
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
            assert!(
                off.abs() < 0.03,
                "{height_m} m, {later_s}: {found:?} {whole:?}"
            );
        }
        found
    }

    #[test]
    fn patches_between_whole_images_hold_the_strongest_echo() {
        let points = [([-0.4, 1.0], 0.8), ([0.8, 4.2], 1.0), ([0.2, 3.6], 0.5)];
        let found = compared(4.0, &points, [0.2, 5.5]);
        // At the right delay the strongest echo is that of the strongest point.
        let [x_m, y_m] = found[11].place_m.unwrap();
        assert!((x_m - 0.8).hypot(y_m - 4.2) < 0.05, "{:?}", found[11]);
        assert!(found[11].log_power > found[0].log_power + 0.3);
    }

    #[test]
    fn echoes_below_the_path_are_followed_where_delays_move_them_most() {
        for y_m in [0.1, 0.9] {
            compared(10.0, &[([0.3, y_m], 1.0)], [-2.5, 2.5]);
        }
    }
}
