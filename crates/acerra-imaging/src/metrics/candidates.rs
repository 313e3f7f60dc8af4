//! Local maxima of an image.

use num_complex::Complex32;
use rayon::prelude::*;

use super::image::ImageView;

/// Places (x, y), m, of the local maxima of an image down to `floor_db` below its greatest, strongest first,
/// with a limit on their number.
#[must_use]
pub fn strongest_maxima(image: &ImageView<'_>, floor_db: f64, most: usize) -> Vec<[f64; 2]> {
    let of_row = |row: &[Complex32]| row.iter().map(|v| v.norm_sqr()).fold(0.0, f32::max);
    let rows = image.values().par_chunks(image.grid().nx);
    let top = rows.map(of_row).reduce(|| 0.0, f32::max).sqrt();
    local_maxima(image, f64::from(top) * 10f64.powf(floor_db / 20.0))
        .into_iter()
        .take(most)
        .map(|c| image.centre_m(c.ix, c.iy))
        .collect()
}

/// A pixel that is higher than its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub ix: usize,
    pub iy: usize,
    pub amplitude: f64,
}

/// All pixels of at least `floor` that none of their eight neighbours exceeds, strongest first; equal ones in
/// the order of rows and columns. A plateau counts once, by its first pixel.
pub(super) fn local_maxima(image: &ImageView<'_>, floor: f64) -> Vec<Candidate> {
    let floor2 = (floor * floor) as f32;
    let mut found: Vec<Candidate> = (0..image.grid().ny)
        .into_par_iter()
        .flat_map_iter(|iy| {
            (0..image.grid().nx).filter_map(move |ix| {
                let here = image.at(ix, iy).norm_sqr();
                (here >= floor2 && here > 0.0 && is_highest(image, ix, iy, here)).then(|| {
                    Candidate {
                        ix,
                        iy,
                        amplitude: f64::from(here).sqrt(),
                    }
                })
            })
        })
        .collect();
    found.sort_by(|a, b| {
        b.amplitude
            .total_cmp(&a.amplitude)
            .then((a.iy, a.ix).cmp(&(b.iy, b.ix)))
    });
    found
}

fn is_highest(image: &ImageView<'_>, ix: usize, iy: usize, here: f32) -> bool {
    for jy in iy.saturating_sub(1)..=(iy + 1).min(image.grid().ny - 1) {
        for jx in ix.saturating_sub(1)..=(ix + 1).min(image.grid().nx - 1) {
            let there = image.at(jx, jy).norm_sqr();
            let earlier = (jy, jx) < (iy, ix);
            if there > here || (earlier && there == here) {
                return false;
            }
        }
    }
    true
}
