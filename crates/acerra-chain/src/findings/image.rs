//! The finding on the values of the image.

use rayon::prelude::*;

use super::median::median;
use crate::align::geometry::{ImageGeometry, wavenumber_span};
use crate::focus::Focused;
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::Prepared;

/// Contrast of the image.
pub(super) fn weigh_values(prepared: &Prepared, focused: &Focused) -> Vec<Finding> {
    let grid = &focused.pixels.grid;
    let power = |v: &acerra_imaging::Complex32| f64::from(v.norm_sqr());
    let stride = (focused.image.len() / 1_000_000).max(1);
    let rows = focused.image.par_chunks(grid.nx.max(1));
    let of_row = |row: &[acerra_imaging::Complex32]| row.iter().map(power).fold(0.0, f64::max);
    let most = rows.map(of_row).reduce(|| 0.0, f64::max);
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

/// Level statistics of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ImageContrast {
    /// Maximum over median of the power (dB).
    pub peak_over_median_db: f64,
    /// Resolution cells in the image: independent values.
    pub cells: f64,
}

/// Judges the image's maximum by the maximum of an image of noise alone.
///
/// Of N independent values of circular Gaussian noise the greatest power is ln N / ln 2 over the median; 3 dB
/// above that, something is focused.
fn contrast(image: &ImageContrast) -> Finding {
    let noise_db = 10.0 * (image.cells.max(4.0).ln() / std::f64::consts::LN_2).log10();
    let verdict = if image.peak_over_median_db > noise_db + 3.0 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("image_contrast", image.peak_over_median_db, "dB", verdict)
        .expecting(noise_db)
        .because(match verdict {
            Verdict::Agrees => format!(
                "the image's maximum is {:.1} dB over its median, the maximum of noise alone would be \
                 {noise_db:.1} dB over it: something is focused",
                image.peak_over_median_db
            ),
            Verdict::Doubtful | Verdict::Contradicts => format!(
                "the image's maximum is {:.1} dB over its median, the maximum of noise alone would be \
                 {noise_db:.1} dB over it: too few traces ([radar] select), wrong places or a wrong gate \
                 ([trajectory] time_offset_s, [preprocess] gate_ns), or no target there ([image] x_m, y_m)",
                image.peak_over_median_db
            ),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_of_noise_is_doubtful() {
        let judge = |peak_over_median_db| {
            contrast(&ImageContrast {
                peak_over_median_db,
                cells: 1e5,
            })
            .verdict
        };
        assert_eq!(judge(12.0), Verdict::Doubtful);
        assert_eq!(judge(36.0), Verdict::Agrees);
    }
}
