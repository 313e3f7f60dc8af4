//! What the image says of itself.

use super::finding::{Finding, Verdict};

/// Level statistics of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageContrast {
    /// Maximum over median of the power (dB).
    pub peak_over_median_db: f64,
    /// Resolution cells in the image: independent values.
    pub cells: f64,
}

/// Judges the image's maximum by that of an image of noise alone.
///
/// Of N independent values of circular Gaussian noise the greatest power stands ln N / ln 2 over the
/// median; 3 dB above that, something is focused.
#[must_use]
pub fn contrast(image: &ImageContrast) -> Finding {
    let noise_db = 10.0 * (image.cells.max(4.0).ln() / std::f64::consts::LN_2).log10();
    let verdict = if image.peak_over_median_db > noise_db + 3.0 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("image_contrast", image.peak_over_median_db, "dB", verdict)
        .expecting(noise_db)
        .because(format!(
            "the image's maximum stands {:.1} dB over its median, that of noise alone would stand \
             {noise_db:.1} dB: too few traces ([radar] select), places or a gate of something else \
             ([trajectory] time_offset_s, [preprocess] gate_ns), or nothing there ([image] x_m, y_m)",
            image.peak_over_median_db
        ))
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
