//! The finding on echoes that focus outside the image.

use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::{Complex32, ImagingError, PlaneGrid, TrialImage};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::control::{Cancelled, Control};
use crate::echoes::history::{Measured, distance_m};
use crate::echoes::{Searched, quick_look};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::Prepared;

/// Contributions of the image of the surroundings, and the bounds of its pixels: 5 cm apart on 1000 m².
const CONTRIBUTIONS: f64 = 4e9;
const PIXELS: [f64; 2] = [20_000.0, 400_000.0];
/// Surroundings reach to the farthest range held, and to the side of the track at most this many heights.
const MOST_HEIGHTS: f64 = 3.0;
/// Maxima compared on either side of the edge: least level (dB), and largest number.
const MAXIMA: usize = 400;
const FLOOR_DB: f64 = -30.0;
const POINTS: usize = 4;
/// Half of the side of the fine image about a maximum (m), and its pixels (m).
const HALF_SIDE_M: f64 = 0.25;
const FINE_PIXEL_M: f64 = 0.025;
/// Least distance from the edge up to which an echo outside may belong to a target on the edge (m).
const EDGE_M: f64 = 2.0 * FINE_PIXEL_M;
/// Range cells behind the ground straight below within which an echo may be a residue of the surface's, and
/// the coherence over the traces that see the echo from which it is a point all the same. The coherence of a
/// point is near 1, that of a residue is the share of these traces within a Fresnel zone, a tenth.
const SURFACE_CELLS: f64 = 4.0;
const LEAST_COHERENCE: f64 = 0.25;
/// Traces that see a place: largest range over that of closest approach, 48° to either side.
const SEEN_FROM: f64 = 1.5;
/// Places outside that are looked at finely.
const LOOKED_AT: usize = 16;
/// Level above the strongest echo inside from which an echo outside is reported (dB): a weaker one may be the
/// mirror image of an echo inside.
const STRONGER_DB: f64 = 3.0;

/// Judges the strongest echo outside the image by the strongest one inside it.
///
/// # Errors
/// The caller asked to stop.
pub(super) fn weigh(
    prepared: &Prepared,
    focused: &Focused,
    control: &Control<'_>,
) -> Result<Option<Finding>, Cancelled> {
    let pixels = &focused.pixels;
    let is_plain = focused.underground.is_none()
        && pixels.surface.is_none()
        && pixels.volume.is_none()
        && prepared.aligned.antennas_from_place_m.is_empty()
        && prepared.scene.open.sides == [false; 2];
    if !is_plain {
        return Ok(None);
    }
    control.check()?;
    let seen = Surroundings::of(prepared, pixels.grid).and_then(|around| around.strongest());
    control.check()?;
    // Surroundings that cannot be imaged give no finding.
    Ok(seen.ok().flatten().map(|seen| image_extent(&seen)))
}

/// The strongest echo outside the image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Outside {
    /// Place (m).
    place_m: [f64; 2],
    /// Level above that of the strongest echo inside (dB).
    above_db: f64,
}

fn image_extent(seen: &Outside) -> Finding {
    let verdict = if seen.above_db >= STRONGER_DB {
        Verdict::Doubtful
    } else {
        Verdict::Agrees
    };
    let [x_m, y_m] = seen.place_m;
    let consequence = match verdict {
        Verdict::Agrees => "",
        Verdict::Doubtful | Verdict::Contradicts => {
            ": targets of the image may be its sidelobes or its mirror image ([image] x_m, y_m; axes exchanged or \
             of the wrong sign in the file of the positions)"
        }
    };
    Finding::judged("image_extent", seen.above_db, "dB", verdict).because(format!(
        "the strongest echo outside the image focuses at ({x_m:.2}, {y_m:.2}) m, {:+.1} dB from the strongest \
         inside{consequence}",
        seen.above_db
    ))
}

/// The flight with its surroundings.
struct Surroundings<'a> {
    prepared: &'a Prepared,
    image: PlaneGrid,
    wide: PlaneGrid,
    cell_m: f64,
}

impl<'a> Surroundings<'a> {
    fn of(prepared: &'a Prepared, image: PlaneGrid) -> Result<Self, ImagingError> {
        let position_m = &prepared.aligned.position_m;
        let mut heights_m: Vec<f64> = position_m.iter().map(|p| p[2] - image.z_m).collect();
        heights_m.sort_by(f64::total_cmp);
        let height_m = heights_m.get(heights_m.len() / 2).copied().unwrap_or(1.0);
        let height_m = height_m.max(0.1);
        let held_m = prepared.ranges_held_m();
        let farthest_m = held_m.iter().map(|held| held[1]).fold(0.0, f64::max);
        let swath_m = (farthest_m.powi(2) - height_m.powi(2)).max(0.0).sqrt();
        let swath_m = swath_m.min(MOST_HEIGHTS * height_m);
        let side = |axis: usize, stated: [f64; 2]| {
            let along = position_m.iter().map(|p| p[axis]);
            let low = along.clone().fold(stated[0] + swath_m, f64::min) - swath_m;
            let high = along.fold(stated[1] - swath_m, f64::max) + swath_m;
            [low, high]
        };
        let x_m = side(0, [image.x0_m, image.x_m(image.nx - 1)]);
        let y_m = side(1, [image.y0_m, image.y_m(image.ny - 1)]);
        let pixels = CONTRIBUTIONS / position_m.len().max(1) as f64;
        let area_m2 = (x_m[1] - x_m[0]) * (y_m[1] - y_m[0]);
        let coarse_m = (area_m2 / pixels.clamp(PIXELS[0], PIXELS[1])).sqrt();
        let frequency_hz = &prepared.spectrum.frequency_hz;
        let span_hz = match frequency_hz.as_slice() {
            [low, .., high] => high - low,
            _ => 0.0,
        };
        Ok(Self {
            prepared,
            image,
            wide: PlaneGrid::from_ranges(x_m, y_m, image.z_m, image.pixel_m.max(coarse_m))?,
            cell_m: 0.5 * prepared.scene.light_speed_m_s / span_hz.max(1.0),
        })
    }

    /// The strongest echo outside; none where nothing focuses there.
    fn strongest(&self) -> Result<Option<Outside>, ImagingError> {
        let Prepared {
            aligned,
            spectrum,
            scene,
            ..
        } = self.prepared;
        let (position_m, light_speed_m_s) = (&aligned.position_m, scene.light_speed_m_s);
        let image = quick_look(position_m, spectrum, self.wide, light_speed_m_s)?;
        // The fine images share range tables; they reach beyond the wide one's edge.
        let searched = Searched::new(position_m, spectrum, light_speed_m_s);
        let looks = searched.looks(self.wide, 2.0 * HALF_SIDE_M)?;
        let look = |grid: PlaneGrid| {
            looks.image(&TrialImage {
                position_m,
                beyond_m: 0.0,
                grid,
            })
        };
        let view = ImageView::new(&image, self.wide)?;
        let edge_m = EDGE_M.max(self.wide.pixel_m);
        let is_inside = |place_m| self.is_inside(place_m, 0.0);
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for place_m in strongest_maxima(&view, FLOOR_DB, MAXIMA) {
            if self.is_inside(place_m, edge_m) {
                inside.push(place_m);
            } else {
                outside.push(place_m);
            }
        }
        // Of an image without a maximum above the floor its brightest pixel.
        let inside = &inside[..inside.len().min(POINTS)];
        let inside = match stronger(self.finely(inside, look, is_inside)?) {
            Some((_, level)) => level,
            None => self.brightest_inside(&image),
        };
        let outside = &outside[..outside.len().min(LOOKED_AT)];
        let is_outside = |place_m| !self.is_inside(place_m, edge_m);
        let mut points = self.finely(outside, look, is_outside)?;
        points.retain(|(place_m, _)| self.is_point(*place_m));
        Ok(stronger(points).map(|(place_m, level)| Outside {
            place_m,
            above_db: 20.0 * (level / inside.max(f64::MIN_POSITIVE)).log10(),
        }))
    }

    /// Greatest amplitude of the wide image within the rectangle.
    fn brightest_inside(&self, image: &[Complex32]) -> f64 {
        let wide = &self.wide;
        let place_m = |k: usize| [wide.x_m(k % wide.nx), wide.y_m(k / wide.nx)];
        let amplitudes = image.iter().map(|v| f64::from(v.norm())).enumerate();
        amplitudes
            .filter(|(k, _)| self.is_inside(place_m(*k), 0.0))
            .fold(0.0, |most, (_, amplitude)| f64::max(most, amplitude))
    }

    fn is_inside(&self, [x_m, y_m]: [f64; 2], margin_m: f64) -> bool {
        let grid = &self.image;
        let within = |v: f64, from: f64, to: f64| (from - margin_m..=to + margin_m).contains(&v);
        within(x_m, grid.x0_m, grid.x_m(grid.nx - 1))
            && within(y_m, grid.y0_m, grid.y_m(grid.ny - 1))
    }

    /// Whether the flight passes a place whose echo is no residue of the surface's straight below.
    fn is_point(&self, [x_m, y_m]: [f64; 2]) -> bool {
        let Prepared {
            aligned,
            spectrum,
            scene,
            ..
        } = self.prepared;
        let place_m = [x_m, y_m, self.image.z_m];
        let range_m: Vec<f64> = (aligned.position_m.iter())
            .map(|p| distance_m(*p, place_m))
            .collect();
        let ranges = range_m.iter().copied().enumerate();
        let Some((nearest, closest_m)) = ranges.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return false;
        };
        if nearest == 0 || nearest + 1 == range_m.len() {
            return false;
        }
        let height_m = aligned.height_m.get(nearest).copied().unwrap_or(0.0);
        if closest_m > height_m + SURFACE_CELLS * self.cell_m {
            return true;
        }
        let all = 0..range_m.len();
        let part = Measured::part(&aligned.position_m, spectrum, all, scene.light_speed_m_s);
        part.is_some_and(|measured| {
            let history = measured.history(place_m);
            let seen = history.iter().zip(&range_m);
            let seen = seen.filter(|(_, range_m)| **range_m <= SEEN_FROM * closest_m);
            coherence(seen.map(|(echo, _)| *echo)) >= LEAST_COHERENCE
        })
    }

    /// The strongest pixels about some places, imaged finely, with their amplitudes; of the pixels only those that
    /// `is_there` accepts.
    fn finely(
        &self,
        places_m: &[[f64; 2]],
        look: impl Fn(PlaneGrid) -> Result<Vec<Complex32>, ImagingError> + Sync,
        is_there: impl Fn([f64; 2]) -> bool + Sync,
    ) -> Result<Vec<([f64; 2], f64)>, ImagingError> {
        let finely = |[x_m, y_m]: &[f64; 2]| {
            let about = |v: f64| [v - HALF_SIDE_M, v + HALF_SIDE_M];
            let (x_m, y_m) = (about(*x_m), about(*y_m));
            let grid = PlaneGrid::from_ranges(x_m, y_m, self.image.z_m, FINE_PIXEL_M)?;
            let image = look(grid)?;
            let levels = image.iter().map(|v| f64::from(v.norm())).enumerate();
            let levels =
                levels.map(|(k, level)| ([grid.x_m(k % grid.nx), grid.y_m(k / grid.nx)], level));
            Ok(stronger(levels.filter(|(place_m, _)| is_there(*place_m))))
        };
        let places = places_m.par_iter();
        places
            .filter_map(|place_m| finely(place_m).transpose())
            .collect()
    }
}

/// The place of the greatest amplitude.
fn stronger(points: impl IntoIterator<Item = ([f64; 2], f64)>) -> Option<([f64; 2], f64)> {
    points.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Power of the coherent sum of some echoes over that of as many echoes in phase: 1 where all are equal.
fn coherence(echoes: impl Iterator<Item = Complex64>) -> f64 {
    let (mut sum, mut power, mut count) = (Complex64::default(), 0.0, 0.0);
    for echo in echoes {
        sum += echo;
        power += echo.norm_sqr();
        count += 1.0;
    }
    if power > 0.0 {
        sum.norm_sqr() / (count * power)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_echo_outside_is_doubtful_where_it_is_stronger_than_a_mirror_image() {
        let judged = |above_db| {
            image_extent(&Outside {
                place_m: [4.0, -1.5],
                above_db,
            })
        };
        assert_eq!(judged(-8.0).verdict, Verdict::Agrees);
        assert_eq!(judged(1.5).verdict, Verdict::Agrees);
        let doubted = judged(14.0);
        assert_eq!(doubted.verdict, Verdict::Doubtful);
        assert!(doubted.explanation.contains("(4.00, -1.50) m, +14.0 dB"));
    }

    #[test]
    fn coherence_tells_a_point_from_a_fresnel_zone() {
        let alike = vec![Complex64::new(0.3, -0.4); 50];
        assert!((coherence(alike.into_iter()) - 1.0).abs() < 1e-12);
        // A surface 4 m below, seen about a place on it: 4 GHz, 9 m of path.
        let flat = (-225..=225).map(|k| {
            let away_m = 0.02 * f64::from(k);
            let range_m = away_m.hypot(4.0);
            Complex64::from_polar(1.0, 4.0 * std::f64::consts::PI * (range_m - 4.0) / 0.075)
        });
        assert!(coherence(flat) < 0.5 * LEAST_COHERENCE);
    }
}
