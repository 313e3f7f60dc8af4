//! Path covered by each trace.

use crate::matrix::{Vector3, distance};

/// Path length (m) that each of a series of positions represents: half the way from the previous and half the
/// way to the next.
///
/// This is the trapezoidal weight that turns a sum over unevenly spaced traces into an integral
/// along the track. The weights add up to the whole path.
///
/// ```
/// use acerra_geo::interpolate::path_length_per_trace_m;
/// let track = [0.0, 1.0, 1.0, 3.0].map(|x| [x, 0.0, 5.0]);
/// assert_eq!(path_length_per_trace_m(&track), [0.5, 0.5, 1.0, 1.0]);
/// ```
#[must_use]
pub fn path_length_per_trace_m(positions_m: &[Vector3]) -> Vec<f64> {
    let mut covered = vec![0.0; positions_m.len()];
    for (i, pair) in positions_m.windows(2).enumerate() {
        let half = 0.5 * distance(pair[0], pair[1]);
        covered[i] += half;
        covered[i + 1] += half;
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_add_up_to_the_path() {
        let track: Vec<Vector3> = (0..50)
            .map(|i| [f64::from(i * i) * 0.01, f64::from(i).sin(), 3.0])
            .collect();
        let path: f64 = track.windows(2).map(|w| distance(w[0], w[1])).sum();
        let weights = path_length_per_trace_m(&track);
        assert!((weights.iter().sum::<f64>() - path).abs() < 1e-12);
        assert_eq!(path_length_per_trace_m(&[]), [0.0; 0]);
        assert_eq!(path_length_per_trace_m(&[[1.0; 3]]), [0.0]);
    }
}
