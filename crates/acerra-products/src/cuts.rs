//! Cuts through the targets of an image, and the cuts by Eq. (5) for the same flight.

use acerra_imaging::metrics::{Field, ImageView, InterpolatedImage, LocalTrack, Target};
use acerra_imaging::psf::{Cell, PointSpread};
use rayon::prelude::*;

use crate::outcome::Outcome;
use crate::report::{Cut, CutLevels};
use acerra_chain::campaign::Weight;
use acerra_chain::measure::view_of;

/// Targets beyond this many, weakest last, have no cuts.
const MOST: usize = 12;
/// Cuts reach this many expected resolution distances to either side.
const REACH_CELLS: f64 = 6.0;
/// Points on either side.
const POINTS: i32 = 120;
/// Lower levels are drawn as this level (dB).
const FLOOR_DB: f64 = -60.0;

/// The point spread function of the flight that was imaged.
pub fn spread_of(outcome: &Outcome) -> Option<PointSpread> {
    let aligned = &outcome.prepared.aligned;
    let weight = match outcome.campaign.image.weight {
        Weight::Auto | Weight::Trace => None,
        Weight::Path => Some(aligned.path_m.clone()),
    };
    PointSpread::new(
        aligned.position_m.clone(),
        weight,
        outcome.prepared.spectrum.frequency_hz.clone(),
        outcome.campaign.image.light_speed_m_s,
    )
    .ok()
}

/// Cuts along and across the local track, one entry a target.
pub fn cuts(outcome: &Outcome, spread: &PointSpread) -> Vec<Option<CutLevels>> {
    let targets = outcome.measured.targets.par_iter().enumerate();
    let view = view_of(&outcome.focused).ok();
    targets
        .map(|(k, target)| {
            let view = view.filter(|_| k < MOST)?;
            through(view, spread, target)
        })
        .collect()
}

fn through(view: ImageView<'_>, spread: &PointSpread, target: &Target) -> Option<CutLevels> {
    let peak_m = [target.x_m, target.y_m];
    let point = [target.x_m, target.y_m, target.z_m];
    let track = LocalTrack::at(spread.position_m(), point)?;
    let cell = Cell::expected(spread, &track, point);
    let image = InterpolatedImage::about(view, peak_m);
    let peak = image.amplitude(peak_m[0], peak_m[1])?;
    let ideal_peak = spread.response(point, point).norm();
    let db = |ratio: f64| (20.0 * ratio.log10()).max(FLOOR_DB);
    let cut = |direction: [f64; 2], reach_m: f64| {
        let mut cut = Cut::default();
        for k in -POINTS..=POINTS {
            let s = reach_m * f64::from(k) / f64::from(POINTS);
            let at = [0, 1].map(|i| peak_m[i] + s * direction[i]);
            // The image may end before the cut does.
            let Some(amplitude) = image.amplitude(at[0], at[1]) else {
                continue;
            };
            let ideal = spread.response(point, [at[0], at[1], view.z_m(at[0], at[1])]);
            cut.distance_m.push(s);
            cut.image_db.push(db(amplitude / peak));
            cut.theory_db.push(db(ideal.norm() / ideal_peak));
        }
        cut
    };
    Some(CutLevels {
        along: cut(track.tangent, REACH_CELLS * cell.along_m),
        across: cut(track.left(), REACH_CELLS * cell.across_m),
    })
}
