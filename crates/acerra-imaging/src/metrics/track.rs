//! Local straight-line approximation of the track at a target.

/// The straight line that approximates the track about its closest approach to a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalTrack {
    /// The point of the track nearest to the target, m.
    pub closest_m: [f64; 3],
    /// Horizontal unit vector of the flight direction at the closest point.
    pub tangent: [f64; 2],
    /// Horizontal distance of the target from the line, m; positive to the left of the flight.
    pub offset_m: f64,
    /// Height of the closest point above the target, m.
    pub height_m: f64,
}

/// The tangent is fitted over the part of the track that lies within this fraction of the range
/// from the closest point: short against the curvature of a flight, long against the centimetres
/// by which recorded positions scatter.
const FIT_FRACTION: f64 = 0.2;

impl LocalTrack {
    /// Finds the closest approach of the polyline through `position_m` to `target_m` and the
    /// direction of flight there.
    ///
    /// The direction is the principal axis of the positions about the closest approach. Where they
    /// do not spread horizontally (one pulse, a hover, a vertical flight), it is x.
    /// `None` when there is no position.
    pub fn at(position_m: &[[f64; 3]], target_m: [f64; 3]) -> Option<Self> {
        let closest_m = closest_point(position_m, target_m)?;
        let range = distance(closest_m, target_m);
        let tangent = tangent_about(position_m, closest_m, FIT_FRACTION * range);
        let across = [target_m[0] - closest_m[0], target_m[1] - closest_m[1]];
        let offset_m = tangent[0] * across[1] - tangent[1] * across[0];
        Some(Self {
            closest_m,
            tangent,
            offset_m,
            height_m: closest_m[2] - target_m[2],
        })
    }

    /// Unit vector to the left of the flight.
    pub fn left(&self) -> [f64; 2] {
        [-self.tangent[1], self.tangent[0]]
    }

    /// The mirror image of (x, y) on the other side of the track: where the left–right ambiguity
    /// puts the ghost.
    pub fn mirrored_m(&self, at_m: [f64; 2]) -> [f64; 2] {
        let left = self.left();
        let offset =
            left[0] * (at_m[0] - self.closest_m[0]) + left[1] * (at_m[1] - self.closest_m[1]);
        [
            at_m[0] - 2.0 * offset * left[0],
            at_m[1] - 2.0 * offset * left[1],
        ]
    }
}

fn closest_point(position_m: &[[f64; 3]], target_m: [f64; 3]) -> Option<[f64; 3]> {
    let mut best = *position_m.first()?;
    let mut best_range = distance(best, target_m);
    for pair in position_m.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let step = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let length2: f64 = step.iter().map(|v| v * v).sum();
        let reach: f64 = (0..3).map(|i| (target_m[i] - a[i]) * step[i]).sum();
        let t = if length2 > 0.0 {
            (reach / length2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let point = [a[0] + t * step[0], a[1] + t * step[1], a[2] + t * step[2]];
        let range = distance(point, target_m);
        if range < best_range {
            best = point;
            best_range = range;
        }
    }
    Some(best)
}

fn tangent_about(position_m: &[[f64; 3]], centre_m: [f64; 3], reach_m: f64) -> [f64; 2] {
    // Enough neighbours even where the pulses are sparse.
    let mut reach_m = reach_m;
    let widest = position_m
        .iter()
        .map(|p| distance(*p, centre_m))
        .fold(0.0, f64::max);
    let near: Vec<[f64; 3]> = loop {
        let near: Vec<_> = position_m
            .iter()
            .copied()
            .filter(|p| distance(*p, centre_m) <= reach_m)
            .collect();
        if near.len() >= 3 || reach_m >= widest || reach_m <= 0.0 {
            break if near.len() >= 3 {
                near
            } else {
                position_m.to_vec()
            };
        }
        reach_m *= 2.0;
    };
    let n = near.len() as f64;
    let mean = [0, 1].map(|i| near.iter().map(|p| p[i]).sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in &near {
        let (x, y) = (p[0] - mean[0], p[1] - mean[1]);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    if (xx + yy) / n <= 1e-12 {
        return [1.0, 0.0];
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let axis = [angle.cos(), angle.sin()];
    let (first, last) = (near[0], near[near.len() - 1]);
    let forward = axis[0] * (last[0] - first[0]) + axis[1] * (last[1] - first[1]);
    if forward < 0.0 {
        [-axis[0], -axis[1]]
    } else {
        axis
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(radius: f64) -> Vec<[f64; 3]> {
        (0..720)
            .map(|k| {
                let a = f64::from(k) * std::f64::consts::PI / 360.0;
                [radius * a.cos(), radius * a.sin(), 10.0]
            })
            .collect()
    }

    #[test]
    fn a_circle_is_met_along_its_tangent() {
        let a = 0.3_f64;
        let target = [30.0 * a.cos(), 30.0 * a.sin(), 0.0];
        let local = LocalTrack::at(&circle(25.0), target).unwrap();
        assert!(
            (local.tangent[0] + a.sin()).abs() < 5e-3 && (local.tangent[1] - a.cos()).abs() < 5e-3
        );
        // Counter-clockwise flight: outside is to the right.
        assert!((local.offset_m + 5.0).abs() < 1e-2, "{}", local.offset_m);
        assert!((local.height_m - 10.0).abs() < 1e-12);
        let ghost = local.mirrored_m([target[0], target[1]]);
        assert!((ghost[0].hypot(ghost[1]) - 20.0).abs() < 2e-2);
    }

    #[test]
    fn one_pulse_has_no_direction_of_its_own() {
        let local = LocalTrack::at(&[[1.0, 2.0, 5.0]], [1.0, 4.0, 0.0]).unwrap();
        assert_eq!(local.tangent, [1.0, 0.0]);
        assert_eq!(local.offset_m, 2.0);
        assert!(LocalTrack::at(&[], [0.0; 3]).is_none());
    }
}
