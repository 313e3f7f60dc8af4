//! Resolution in elevation of an aperture of any shape.

use crate::vector::{dot, norm};

/// Resolution in elevation of a target at `target_m` seen from all of `position_m`, m: λR/2D, D being the
/// lesser extent of the aperture across the line of sight from its mean, at range R (the extent of a uniform
/// distribution with the variance of the positions). Infinite for a straight track, which cannot determine
/// height from distance across.
///
/// ```
/// use acerra_imaging::resolution::elevation_m;
/// let line = |x_m: f64| (0..101).map(move |m| [x_m, 0.1 * f64::from(m) - 5.0, 5.0]);
/// let five: Vec<_> = (-2..=2).flat_map(|x| line(f64::from(x))).collect();
/// assert!(elevation_m(&five, [2.0, 0.0, 0.5], 0.076) < 0.06);
/// let one: Vec<_> = line(0.0).collect();
/// assert!(elevation_m(&one, [2.0, 0.0, 0.5], 0.076) > 1e3);
/// ```
#[must_use]
pub fn elevation_m(position_m: &[[f64; 3]], target_m: [f64; 3], wavelength_m: f64) -> f64 {
    let n = position_m.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|a| position_m.iter().map(|p| p[a]).sum::<f64>() / n);
    let towards: [f64; 3] = std::array::from_fn(|a| target_m[a] - mean[a]);
    let range_m = norm(towards);
    let unit = towards.map(|v| v / range_m.max(1e-9));
    // Two directions across the line of sight.
    let helper = if unit[0].abs() < 0.7 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let first = {
        let along = dot(helper, unit);
        let d: [f64; 3] = std::array::from_fn(|a| helper[a] - along * unit[a]);
        d.map(|v| v / norm(d))
    };
    let second = [
        unit[1] * first[2] - unit[2] * first[1],
        unit[2] * first[0] - unit[0] * first[2],
        unit[0] * first[1] - unit[1] * first[0],
    ];
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    for p in position_m {
        let d: [f64; 3] = std::array::from_fn(|a| p[a] - mean[a]);
        let (a, b) = (dot(d, first), dot(d, second));
        aa += a * a / n;
        ab += a * b / n;
        bb += b * b / n;
    }
    let half = 0.5 * (aa + bb);
    let lesser = (half - ((0.5 * (aa - bb)).powi(2) + ab * ab).sqrt()).max(0.0);
    let extent_m = (12.0 * lesser).sqrt();
    wavelength_m * range_m / (2.0 * extent_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_tracks_resolve_height_and_one_does_not() {
        let tracks = |x_m: &[f64]| -> Vec<[f64; 3]> {
            x_m.iter()
                .flat_map(|x| (0..101).map(move |m| [*x, 0.1 * f64::from(m) - 5.0, 5.0]))
                .collect()
        };
        let centre = [2.0, 0.0, 0.5];
        assert!(elevation_m(&tracks(&[0.0]), centre, 0.076) > 1e3);
        // Five tracks 1 m apart spread evenly over √24 m, seen 24° off the vertical 4.9 m away.
        let found = elevation_m(&tracks(&[-2.0, -1.0, 0.0, 1.0, 2.0]), centre, 0.076);
        let expected = 0.076 * 4.92 / (2.0 * 24f64.sqrt() * (4.5 / 4.92));
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }
}
