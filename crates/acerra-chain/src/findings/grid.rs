//! Findings on flight and grid: pixels, scans and frequencies against one another.

use std::f64::consts::TAU;
use std::ops::Range;

use super::background::window_of_background;
use super::coverage::{aperture_coverage, covered_by, range_coverage};
use crate::align::geometry::{ImageGeometry, distance_m, wavenumber_span};
use crate::focus::ImageRequest;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::{Prepared, Track};

/// Pixel size, scan spacing, and ranges imaged against ranges held.
pub(super) fn weigh_geometry(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
    request: &ImageRequest,
) -> Vec<Finding> {
    let range_m = prepared.ranges_held_by_m(track);
    [
        pixel_size(geometry, request.pixels.grid.pixel_m),
        scan_spacing(geometry, &prepared.aligned.lines(track.range.clone())),
        range_coverage(geometry, &range_m),
        aperture_coverage(geometry),
        request.options.incidence.and_then(|weight| {
            let boresights = prepared.aligned.boresights(request.options.antenna_axis);
            let looks = boresights.and_then(|b| b.looks.get(track.range.clone()));
            covered_by(&weight, geometry, looks)
        }),
        step_of_frequencies(prepared, &range_m),
        window_of_background(prepared, track, geometry),
        // Files of spectra bring their own frequencies: the processing between frequencies and ranges was not
        // Acerra's.
        track
            .cleaned
            .as_ref()
            .map(|_| light_speed(prepared.scene.light_speed_m_s)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The spacing of the frequencies, and the ranges that the data hold.
fn step_of_frequencies(prepared: &Prepared, range_m: &[[f64; 2]]) -> Option<Finding> {
    let [first, second, ..] = prepared.spectrum.frequency_hz.as_slice() else {
        return None;
    };
    let spans_m = range_m.iter().map(|[near, far]| far - near);
    let range_span_m = spans_m.fold(0.0, f64::max);
    range_span_m.is_finite().then(|| {
        frequency_step(&FrequencyGrid {
            step_hz: second - first,
            light_speed_m_s: prepared.scene.light_speed_m_s,
            range_span_m,
        })
    })
}

/// Pixel size against the resolution cell 2π/ΔK, the finer of the two axes, at the image's best
/// resolved pixel of those given. The edges of the aperture add little, so that the lobe is about
/// twice as wide as the cell; larger pixels leave gaps in which a target can disappear.
fn pixel_size(geometry: &ImageGeometry<'_>, pixel_size_m: f64) -> Option<Finding> {
    let span = geometry
        .pixel_m
        .iter()
        .flat_map(|pixel| wavenumber_span(geometry, *pixel))
        .fold(0.0, f64::max);
    if !(span > 0.0 && pixel_size_m.is_finite()) {
        return None;
    }
    let cell_m = TAU / span;
    let verdict = match pixel_size_m / cell_m {
        r if r <= 2.0 => Verdict::Agrees,
        r if r <= 6.0 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    Some(
        Finding::judged("pixel_size", pixel_size_m, "m", verdict)
            .expecting(cell_m)
            .because(format!(
                "pixels of {pixel_size_m} m, a resolution cell of {cell_m:.3} m: above twice the \
                 cell, targets fall between pixels ([image] pixel_m)"
            )),
    )
}

/// Level of the grating lobes that the spacing of the scans leaves, dB below the main lobe.
///
/// Where the two-way path changes by more than half a wavelength from trace to trace (spacing above
/// λ/4 at the steepest angle), aliased lobes appear; a band of width B about f smears each over all
/// but f/B traces, so that its amplitude is f/(B·N) of N traces.
fn scan_spacing(geometry: &ImageGeometry<'_>, lines: &[Range<usize>]) -> Option<Finding> {
    let [low_hz, high_hz] = geometry.band_hz;
    let wavelength_m = geometry.light_speed_m_s / high_hz;
    let pairs = pairs_on_lines(geometry.position_m, lines);
    let mut steps_m: Vec<f64> = pairs
        .iter()
        .map(|pair| distance_m(pair[0], pair[1]))
        .filter(|step| *step > 0.0)
        .collect();
    if steps_m.len() < 2 {
        return None;
    }
    steps_m.sort_by(f64::total_cmp);
    let spacing_m = steps_m[(steps_m.len() - 1) * 95 / 100];
    let steepest = steepest_sine(geometry, &pairs);
    let allowed_m = 0.25 * wavelength_m / steepest.max(1e-6);
    let traces = geometry.position_m.len() as f64;
    let smeared = 0.5 * (low_hz + high_hz) / (high_hz - low_hz).max(1e-3 * high_hz);
    let lobe_db = 20.0 * (smeared / traces).min(1.0).log10();
    let verdict = if spacing_m <= allowed_m || lobe_db < -20.0 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Some(
        Finding::judged("scan_spacing", spacing_m, "m", verdict)
            .expecting(allowed_m)
            .because(format!(
                "scans are {spacing_m:.3} m apart, λ/4 at the steepest angle imaged is \
                 {allowed_m:.3} m; the band smears aliased lobes to {lobe_db:.0} dB (fly slower, or \
                 scan faster)"
            )),
    )
}

/// Places of traces that follow one another on a line.
fn pairs_on_lines<'a>(position_m: &'a [[f64; 3]], lines: &[Range<usize>]) -> Vec<&'a [[f64; 3]]> {
    let of_line = |line: &Range<usize>| position_m.get(line.clone()).unwrap_or_default();
    lines
        .iter()
        .flat_map(|line| of_line(line).windows(2))
        .collect()
}

/// Greatest sine of the angle between the line of sight and the plane across the track.
fn steepest_sine(geometry: &ImageGeometry<'_>, pairs: &[&[[f64; 3]]]) -> f64 {
    let stride = (geometry.position_m.len() / 64).max(1);
    let mut steepest: f64 = 0.0;
    for pair in pairs.iter().step_by(stride) {
        let step_m = distance_m(pair[0], pair[1]);
        if step_m <= 0.0 {
            continue;
        }
        let direction: [f64; 3] = std::array::from_fn(|i| (pair[1][i] - pair[0][i]) / step_m);
        for pixel in geometry.pixel_m {
            let range_m = distance_m(pair[0], *pixel).max(1e-9);
            let along: f64 = (0..3).map(|i| direction[i] * (pixel[i] - pair[0][i])).sum();
            steepest = steepest.max((along / range_m).abs());
        }
    }
    steepest
}

/// Speed of light in vacuum (m/s).
pub(super) const LIGHT_SPEED_M_S: f64 = 299_792_458.0;

/// Spacing of the frequencies, and the ranges that the data hold.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FrequencyGrid {
    /// Distance of neighbouring frequencies (Hz).
    pub step_hz: f64,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
    /// Longest span of ranges that the data of one trace hold (m).
    pub range_span_m: f64,
}

/// Judges the spacing of the frequencies: an echo repeats in range every c/(2Δf), so that a span of
/// ranges longer than that folds onto itself.
fn frequency_step(grid: &FrequencyGrid) -> Finding {
    let unambiguous_m = 0.5 * grid.light_speed_m_s / grid.step_hz;
    let verdict = if grid.range_span_m <= unambiguous_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("frequency_step", unambiguous_m, "m", verdict)
        .expecting(grid.range_span_m)
        .because(format!(
            "at frequencies {:.3} MHz apart echoes repeat every {unambiguous_m:.2} m of range, the \
             data hold {:.2} m ([image] frequencies, band_ghz; [preprocess] gate_ns)",
            1e-6 * grid.step_hz,
            grid.range_span_m
        ))
}

/// Largest excess of the speed in vacuum over the speed in air (refractivity below 450·10⁻⁶, ITU-R P.453),
/// and rounding of settings.
const AIR_SHARE: f64 = 1e-3;

/// Judges the propagation speed: radar of drones works in air.
fn light_speed(light_speed_m_s: f64) -> Finding {
    let off = (light_speed_m_s / LIGHT_SPEED_M_S - 1.0).abs();
    let verdict = if off <= AIR_SHARE {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("light_speed", light_speed_m_s, "m/s", verdict)
        .expecting(LIGHT_SPEED_M_S)
        .because(format!(
            "ranges are scaled by {:.1} % against propagation in air ([image] light_speed_m_s)",
            100.0 * (light_speed_m_s / LIGHT_SPEED_M_S - 1.0)
        ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::align::geometry::samples::{geometry, track};

    #[test]
    fn pixels_of_ten_metres_contradict_and_of_a_centimetre_agree() {
        let track = track(0.1, 10.0);
        let pixels = [[4.0, 0.0, 0.0], [14.0, 0.0, 0.0]];
        let judge = |size| {
            pixel_size(&geometry(&track, &pixels), size)
                .unwrap()
                .verdict
        };
        assert_eq!(judge(0.01), Verdict::Agrees);
        assert_eq!(judge(0.1), Verdict::Doubtful);
        assert_eq!(judge(10.0), Verdict::Contradicts);
    }

    #[test]
    fn sparse_scans_of_a_wide_band_are_no_fault_until_they_are_few() {
        let pixels = [[0.0, 0.0, 0.0], [18.0, 0.0, 0.0]];
        let judge = |track: &[[f64; 3]], lines: &[Range<usize>]| {
            scan_spacing(&geometry(track, &pixels), lines).unwrap()
        };
        let dense = track(0.1, 10.0);
        assert_eq!(
            judge(&dense, std::slice::from_ref(&(0..dense.len()))).verdict,
            Verdict::Agrees
        );
        let sparse = track(1.5, 10.0);
        assert_eq!(
            judge(&sparse, std::slice::from_ref(&(0..sparse.len()))).verdict,
            Verdict::Doubtful
        );
        // The ways between short lines are no spacing of scans.
        let lines: Vec<Range<usize>> = (0..10).map(|k| 5 * k..5 * k + 5).collect();
        let grid: Vec<[f64; 3]> = (0..50)
            .map(|k| [0.1 * f64::from(k % 5), 2.0 * f64::from(k / 5), 10.0])
            .collect();
        assert!((judge(&grid, &lines).value.unwrap() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn a_range_span_that_folds_is_doubtful() {
        let judge = |count: f64| {
            frequency_step(&FrequencyGrid {
                step_hz: 1.7e9 / (count - 1.0),
                light_speed_m_s: 299_792_458.0,
                range_span_m: 4.5,
            })
        };
        assert_eq!(judge(341.0).verdict, Verdict::Agrees);
        assert!((judge(341.0).value.unwrap() - 29.98).abs() < 0.01);
        assert_eq!(judge(8.0).verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_speed_of_light_of_another_medium_is_doubtful() {
        assert_eq!(light_speed(299_702_547.0).verdict, Verdict::Agrees);
        assert_eq!(light_speed(3e8).verdict, Verdict::Agrees);
        assert_eq!(light_speed(2.9e8).verdict, Verdict::Doubtful);
    }
}
