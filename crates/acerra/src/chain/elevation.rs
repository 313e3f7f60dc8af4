//! What a flight tells of height: the resolution in elevation of all its positions together.

use super::ground::Ground;
use super::warnings::Warnings;

/// Warns where a volume is asked for of a flight that cannot tell its slices apart.
pub(super) fn check(
    ground: &Ground,
    position_m: &[[f64; 3]],
    wavelength_m: f64,
    warnings: &mut Warnings,
) {
    let Some(volume) = &ground.volume else {
        return;
    };
    let [x, y] = [
        (volume.base.nx, volume.base.x0_m),
        (volume.base.ny, volume.base.y0_m),
    ]
    .map(|(n, from)| from + 0.5 * (n.saturating_sub(1)) as f64 * volume.base.pixel_m);
    let tall_m = volume.nz.saturating_sub(1) as f64 * volume.step_m;
    let centre = [x, y, volume.base.z_m + 0.5 * tall_m];
    let resolution_m = resolution_m(position_m, centre, wavelength_m);
    if resolution_m > tall_m {
        warnings.add(format!(
            "the positions of the flight resolve {resolution_m:.1} m in elevation, the volume is \
             {tall_m:.1} m tall: height and distance across the track cannot be told apart; \
             several parallel tracks can"
        ));
    }
}

/// λR/2D, D being the lesser extent of the aperture as seen from the volume's centre at range R (that
/// of an even spread with the variance found). Infinite for a straight track.
fn resolution_m(position_m: &[[f64; 3]], centre_m: [f64; 3], wavelength_m: f64) -> f64 {
    let n = position_m.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|a| position_m.iter().map(|p| p[a]).sum::<f64>() / n);
    let towards: [f64; 3] = std::array::from_fn(|a| centre_m[a] - mean[a]);
    let range_m = dot(towards, towards).sqrt();
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
        let length = dot(d, d).sqrt();
        d.map(|v| v / length)
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

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
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
        assert!(resolution_m(&tracks(&[0.0]), centre, 0.076) > 1e3);
        // Five tracks 1 m apart spread evenly over √24 m, seen 24° off the vertical 4.9 m away.
        let found = resolution_m(&tracks(&[-2.0, -1.0, 0.0, 1.0, 2.0]), centre, 0.076);
        let expected = 0.076 * 4.92 / (2.0 * 24f64.sqrt() * (4.5 / 4.92));
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }
}
