//! Expected resolution about a point.

use super::spread::PointSpread;
use crate::metrics::track::LocalTrack;

/// Expected Rayleigh distances about one point of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Along the track, m.
    pub along_m: f64,
    /// Across it, m.
    pub across_m: f64,
}

impl Cell {
    /// The cell at `at_m`: Eq. (6) with the angles that the flight spans, and Eq. (9) with the local track's
    /// height and offset.
    ///
    /// Along the track Eq. (6) gives c/(4 f_c sin θ) for views from −θ to θ; views from θ₁ to θ₂ give c/(2
    /// f_c (sin θ₂ − sin θ₁)). Across the track the range resolution gives the distance, or the views from several
    /// tracks at that point of the flight, where these are so dense that their lobes are no nearer than the range
    /// resolution. No distance exceeds the range itself, so that it is finite for a single pulse or a single frequency.
    pub fn expected(spread: &PointSpread, track: &LocalTrack, at_m: [f64; 3]) -> Self {
        let (low, high) = spread.band_hz();
        let left = track.left();
        let sines = |p: &[f64; 3]| {
            let d = [p[0] - at_m[0], p[1] - at_m[1], p[2] - at_m[2]];
            let range = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let along = |axis: [f64; 2]| (d[0] * axis[0] + d[1] * axis[1]) / range;
            (range > 0.0).then(|| [along(track.tangent), along(left)])
        };
        let views: Vec<[f64; 2]> = spread.position_m().iter().filter_map(sines).collect();
        let ends = views
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [sine, _]| {
                [a.min(*sine), b.max(*sine)]
            });
        let offset_m = track.offset_m.abs();
        let range_m = offset_m.hypot(track.height_m);
        let c = spread.light_speed_m_s();
        let along_m = c / (low + high) / (ends[1] - ends[0]).max(1e-12);
        let step_m = 0.5 * c / (high - low).max(1e-3);
        let by_range_m =
            (offset_m.powi(2) + step_m.powi(2) + 2.0 * step_m * range_m).sqrt() - offset_m;
        let across_m = match gap_and_extent(&views, ends) {
            [gap, extent] if c / (low + high) >= gap * by_range_m => {
                by_range_m.min(c / (low + high) / extent.max(1e-12))
            }
            _ => by_range_m,
        };
        // The smallest bound only guards a target on the antenna itself.
        let bound_m = range_m.max(1e-3);
        Self {
            along_m: along_m.min(bound_m),
            across_m: across_m.min(bound_m),
        }
    }
}

/// Largest gap between neighbours among the sines across the track, and their extent, of the views in the middle eighth
/// of the sines along the track, whose `ends` are given: there a straight track has a single one.
fn gap_and_extent(views: &[[f64; 2]], [least, most]: [f64; 2]) -> [f64; 2] {
    let is_middle = |along: f64| (along - 0.5 * (least + most)).abs() <= (most - least) / 16.0;
    let middle = views.iter().filter(|[along, _]| is_middle(*along));
    let mut across: Vec<f64> = middle.map(|[_, across]| *across).collect();
    across.sort_by(f64::total_cmp);
    let gaps = across.windows(2).map(|pair| pair[1] - pair[0]);
    [gaps.clone().fold(0.0, f64::max), gaps.sum()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(lines: usize) -> Cell {
        let line = |y_m: f64| (0..81).map(move |m| [0.05 * f64::from(m) - 2.0, y_m, 1.5]);
        let middle: Vec<[f64; 3]> = line(0.0).collect();
        let local = LocalTrack::at(&middle, [0.0; 3]).unwrap();
        let y_m = |k: usize| 2.0 * k as f64 / (lines.max(2) - 1) as f64 - 1.0;
        let track = (0..lines).flat_map(|k| line(y_m(k))).collect();
        let frequency_hz = (0..40).map(|n| 1e9 + 25e6 * f64::from(n)).collect();
        let spread = PointSpread::new(track, None, frequency_hz, 3e8).unwrap();
        Cell::expected(&spread, &local, [0.0; 3])
    }

    /// Of one line and of two the range resolves across; of many as dense as needed the angles do, as along the lines.
    #[test]
    fn dense_lines_resolve_across() {
        let [one, two, many] = [1, 2, 41].map(cell);
        assert!(
            one.across_m > 0.6 && (two.across_m - one.across_m).abs() < 0.1,
            "{one:?} {two:?}"
        );
        // Sines from −0.555 to 0.555, mean frequency 1.4875 GHz.
        assert!(
            (many.across_m - 3e8 / 2.975e9 / 1.109).abs() < 0.005,
            "{many:?}"
        );
        assert!((many.along_m / one.along_m - 1.0).abs() < 0.1);
    }
}
