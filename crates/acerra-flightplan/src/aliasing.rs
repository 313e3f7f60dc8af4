//! Level of the aliases when scans lie further apart than λ/(4 sin θ).
//!
//! A wide band spreads the grating lobes of an undersampled track: the lobes of each frequency are at another
//! place. Their remaining level is computed by the exact point spread function, relative to that of a finely
//! sampled track.

use acerra_imaging::psf::PointSpread;
use acerra_imaging::resolution::{along_track_m, longest_step_m};

use super::swath::View;
use super::{LIGHT_SPEED_M_S, PlanError, PlanFile, Radar, Swath};

/// Strongest aliases that are flown: as strong as the first sidelobe of an unweighted aperture, which
/// every image has anyway.
pub(super) const TOLERATED: f64 = 0.217;

/// The antenna's pattern is followed to this many half widths off its axis.
const HALF_WIDTHS: f64 = 1.5;
/// Largest angle off the axis at which the antennas see (degrees).
const STEEPEST_DEG: f64 = 75.0;

/// Largest distance between scans without aliasing over the antenna's whole beam (m).
pub(super) fn beam_step_m(radar: &Radar) -> Result<f64, PlanError> {
    let [_, high_hz] = radar.band_hz();
    longest_step_m(high_hz, radar.half_beam_rad(), LIGHT_SPEED_M_S)
        .map_err(|e| PlanError::Impossible(e.to_string()))
}

/// The strongest alias along the track, relative to its target, of targets at both ends of the swath
/// with scans `step_m` apart.
pub(super) fn level(
    file: &PlanFile,
    view: &View,
    swath: &Swath,
    step_m: f64,
) -> Result<f64, PlanError> {
    let ends = [swath.near_m.max(file.want.across_m), swath.far_m];
    ends.iter().try_fold(0.0_f64, |worst, offset_m| {
        level_at(&file.radar, view, swath.height_m, *offset_m, step_m).map(|l| worst.max(l))
    })
}

fn level_at(
    radar: &Radar,
    view: &View,
    height_m: f64,
    offset_m: f64,
    step_m: f64,
) -> Result<f64, PlanError> {
    let failed = |e: acerra_imaging::ImagingError| PlanError::Impossible(e.to_string());
    let range_m = height_m.hypot(offset_m);
    let seen_rad = (HALF_WIDTHS * radar.half_beam_rad()).min(STEEPEST_DEG.to_radians());
    let half_m = range_m * seen_rad.tan();
    let [_, high_hz] = radar.band_hz();
    let fine_m = longest_step_m(high_hz, seen_rad, LIGHT_SPEED_M_S).map_err(failed)?;
    let flown = spread(radar, [half_m, step_m], [height_m, range_m])?;
    let fine = spread(radar, [half_m, fine_m], [height_m, range_m])?;

    let target_m = [0.0, offset_m, 0.0];
    let at =
        |spread: &PointSpread, along_m: f64| spread.response(target_m, [along_m, offset_m, 0.0]);
    let (peak, fine_peak) = (at(&flown, 0.0), at(&fine, 0.0));
    let cell_m =
        along_track_m(radar.centre_hz(), radar.half_beam_rad(), LIGHT_SPEED_M_S).map_err(failed)?;
    let reach_m = range_m * view.half_rad.tan() + range_m;
    let points = (3.0 * reach_m / cell_m).ceil();
    let aliases = (0..=points as usize).map(|i| {
        let along_m = reach_m * i as f64 / points;
        (at(&flown, along_m) / peak - at(&fine, along_m) / fine_peak).norm()
    });
    Ok(aliases.fold(0.0, f64::max))
}

/// A straight track over ±`half_m` with scans `step_m` apart, weighted by the antennas' two-way pattern: half
/// the power at half the beam's width, each way.
fn spread(
    radar: &Radar,
    [half_m, step_m]: [f64; 2],
    [height_m, range_m]: [f64; 2],
) -> Result<PointSpread, PlanError> {
    let count = (half_m / step_m).floor() as i32;
    let along: Vec<f64> = (-count..=count).map(|i| step_m * f64::from(i)).collect();
    let weight = along
        .iter()
        .map(|x| {
            let off_axis = x.atan2(range_m) / radar.half_beam_rad();
            (-std::f64::consts::LN_2 * off_axis * off_axis).exp()
        })
        .collect();
    let track = along.iter().map(|x| [*x, 0.0, height_m]).collect();
    let [low_hz, high_hz] = radar.band_hz();
    let frequency_hz = (0..171)
        .map(|n| low_hz + (high_hz - low_hz) * f64::from(n) / 170.0)
        .collect();
    PointSpread::new(track, Some(weight), frequency_hz, LIGHT_SPEED_M_S)
        .map_err(|e| PlanError::Impossible(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level_of(band_ghz: [f64; 2], step_m: f64) -> f64 {
        let text = format!(
            "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2003], [40.9002, 14.2003]]\n\
             [want]\nalong_m = 0.06\nacross_m = 0.5\n[radar]\nband_ghz = {band_ghz:?}\n"
        );
        let file = PlanFile::parse(&text).expect("possible");
        let view = View::of(&file).expect("a view");
        level_at(&file.radar, &view, 4.0, 2.0, step_m).expect("computed")
    }

    #[test]
    fn a_wide_band_spreads_aliases_and_a_narrow_one_does_not() {
        assert!(level_of([3.1, 4.8], 0.014) < 0.01);
        let wide = level_of([3.1, 4.8], 0.1);
        let narrow = level_of([3.94, 3.96], 0.1);
        assert!(wide < 0.1 && narrow > 4.0 * wide, "{wide} {narrow}");
        assert!(level_of([3.1, 4.8], 0.4) > wide);
    }

    /// Track 1 of the paper: 31.4 m in 17.5 s at 14.28 scans a second, 4 m high, imaged without
    /// visible aliases.
    #[test]
    fn the_paper_s_flight_is_tolerated() {
        let level = level_of([3.1, 4.8], 31.4 / 17.5 / 14.28);
        assert!(level < TOLERATED, "{level}");
    }
}
