//! Findings on the image: its grid against flight and data, and its values.

use acerra_imaging::IncidenceWeight;

use crate::choices::Background;
use crate::findings::evidence::{
    BackgroundWindow, Coverage, Finding, FrequencyGrid, ImageContrast, ImageGeometry, SeenWithin,
    Verdict, aperture_coverage, background_window, contrast, coverage, frequency_step,
    incidence_coverage, light_speed, pixel_size, scan_spacing, wavenumber_span,
};
use crate::findings::weigh::median::median;
use crate::focus::{Focused, ImageRequest};
use crate::prepare::{Prepared, Track};

/// Pixel size, scan spacing, and ranges imaged against ranges held.
pub(super) fn weigh_geometry(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
    request: &ImageRequest,
) -> Vec<Finding> {
    let range_m = prepared.ranges_held_by_m(track);
    let held = Coverage { range_m: &range_m };
    [
        pixel_size(geometry, request.pixels.grid.pixel_m),
        scan_spacing(geometry),
        coverage(geometry, held),
        aperture_coverage(geometry),
        request.options.incidence.and_then(|weight| {
            let boresights = prepared.aligned.boresights(request.options.antenna_axis);
            let looks = boresights.and_then(|b| b.looks.get(track.range.clone()));
            covered_by(&weight, geometry, looks)
        }),
        step_of_frequencies(prepared, &range_m),
        window_of_background(prepared, track, geometry),
        // Spectra bring their own: what stands between them and the ranges is not Acerra's.
        track
            .cleaned
            .as_ref()
            .map(|_| light_speed(prepared.scene.light_speed_m_s)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The share of the image that a weight lets through; one that a pattern merely weakens is doubted at most.
fn covered_by(
    weight: &IncidenceWeight,
    geometry: &ImageGeometry<'_>,
    boresight: Option<&[[f64; 3]]>,
) -> Option<Finding> {
    let within = SeenWithin {
        incidence_rad: weight.max_rad,
        off_boresight_rad: pattern_rad(weight),
        boresight,
    };
    let most = if within.off_boresight_rad < weight.max_rad {
        Verdict::Doubtful
    } else {
        Verdict::Contradicts
    };
    incidence_coverage(geometry, within).map(|finding| finding.at_most(most))
}

/// Angle from where the antenna looks at which its pattern has fallen by 10 dB; all round without a pattern.
fn pattern_rad(weight: &IncidenceWeight) -> f64 {
    const FALLEN: f64 = 0.316;
    if weight.cosine_power > 0.0 {
        FALLEN.powf(weight.cosine_power.recip()).acos()
    } else {
        std::f64::consts::PI
    }
}

/// The spacing of the frequencies beside the ranges that the data hold.
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

/// The background's window, where it has one, beside the Fresnel zone below the flight.
fn window_of_background(
    prepared: &Prepared,
    track: &Track,
    geometry: &ImageGeometry<'_>,
) -> Option<Finding> {
    let Background::Window { window } = track.background else {
        return None;
    };
    let path_m: f64 = prepared
        .aligned
        .path_m
        .get(track.range.clone())?
        .iter()
        .sum();
    let middle_hz = 0.5 * (geometry.band_hz[0] + geometry.band_hz[1]);
    Some(background_window(&BackgroundWindow {
        path_m: path_m * window as f64 / track.range.len().max(1) as f64,
        wavelength_m: geometry.light_speed_m_s / middle_hz,
        range_m: median(
            prepared.aligned.height_m[track.range.clone()]
                .iter()
                .copied(),
        )?
        .abs(),
    }))
}

/// Contrast of the image.
pub(super) fn weigh_values(prepared: &Prepared, focused: &Focused) -> Vec<Finding> {
    let grid = &focused.pixels.grid;
    let power = |v: &acerra_imaging::Complex32| f64::from(v.norm_sqr());
    let stride = (focused.image.len() / 1_000_000).max(1);
    let most = focused.image.iter().map(power).fold(0.0, f64::max);
    let Some(middle) = median(focused.image.iter().step_by(stride).map(power)) else {
        return Vec::new();
    };
    let peak_over_median_db = 10.0 * (most / middle).log10();
    let frequency_hz = &prepared.spectrum.frequency_hz;
    let (Some(low), Some(high)) = (frequency_hz.first(), frequency_hz.last()) else {
        return Vec::new();
    };
    let at = [
        grid.x_m(grid.nx / 2),
        grid.y_m(grid.ny / 2),
        focused.pixels.middle_m(),
    ];
    let geometry = ImageGeometry {
        position_m: &prepared.aligned.position_m,
        pixel_m: &[at],
        band_hz: [*low, *high],
        light_speed_m_s: prepared.scene.light_speed_m_s,
    };
    let side_m = [grid.nx, grid.ny].map(|n| n as f64 * grid.pixel_m);
    let cells = wavenumber_span(&geometry, at)
        .iter()
        .zip(side_m)
        .map(|(span, side_m)| (span * side_m / std::f64::consts::TAU).max(1.0))
        .product::<f64>()
        .min(focused.image.len() as f64);
    vec![contrast(&ImageContrast {
        peak_over_median_db,
        cells,
    })]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steep_pattern_lets_less_through_than_its_limit() {
        let within_deg = |cosine_power| {
            let weight = IncidenceWeight {
                cosine_power,
                ..IncidenceWeight::default()
            };
            pattern_rad(&weight).to_degrees()
        };
        assert!((within_deg(0.0) - 180.0).abs() < 1e-9);
        // cos² falls to 10 dB at 56°, cos²⁰ at 19°.
        assert!((within_deg(2.0) - 55.8).abs() < 0.2);
        assert!((within_deg(20.0) - 19.2).abs() < 0.2);
    }
}
