//! The path of the surface's echo: from transmitter to receiver by way of the ground.

use crate::position::aligned::Aligned;
use crate::scene::Ground;

/// Points from the middle to either side of the coarse search over uneven ground.
const HALF: i32 = 12;

/// Steps of the coarse search over its reach, and the size at which the fine search ends (m): the path
/// changes by the square of the remaining error.
const FINEST_M: f64 = 1e-4;

/// Shortest path from transmitter to receiver by way of the ground, for each trace (m).
pub(crate) fn surface_path_m(aligned: &Aligned, ground: &Ground) -> Vec<f64> {
    let antennas = (0..aligned.position_m.len()).map(|k| aligned.antennas_at_m(k));
    antennas.map(|pair| path_m(pair, ground)).collect()
}

fn path_m([transmitter_m, receiver_m]: [[f64; 3]; 2], ground: &Ground) -> f64 {
    let middle: [f64; 2] =
        std::array::from_fn(|axis| 0.5 * (transmitter_m[axis] + receiver_m[axis]));
    let level_m = ground.below_m(middle[0], middle[1]);
    if !ground.is_uneven() {
        let apart = [0, 1].map(|axis| transmitter_m[axis] - receiver_m[axis]);
        // The mirror image of the receiver.
        let rise_m = transmitter_m[2] + receiver_m[2] - 2.0 * level_m;
        return (apart[0] * apart[0] + apart[1] * apart[1] + rise_m * rise_m).sqrt();
    }
    let by_way_of = |[x_m, y_m]: [f64; 2]| {
        let z_m = ground.below_m(x_m, y_m);
        let leg = |a: [f64; 3]| {
            ((x_m - a[0]).powi(2) + (y_m - a[1]).powi(2) + (z_m - a[2]).powi(2)).sqrt()
        };
        leg(transmitter_m) + leg(receiver_m)
    };
    // A nearest point lies within a cone about the vertical unless slopes exceed 45°.
    let reach_m = 0.5 * (transmitter_m[2] + receiver_m[2]) - level_m;
    let mut step_m = reach_m.abs().max(1e-3) / f64::from(HALF);
    let mut best = (middle, by_way_of(middle));
    for i in -HALF..=HALF {
        for j in -HALF..=HALF {
            let place = [
                middle[0] + step_m * f64::from(i),
                middle[1] + step_m * f64::from(j),
            ];
            let found = by_way_of(place);
            if found < best.1 {
                best = (place, found);
            }
        }
    }
    while step_m > FINEST_M {
        step_m *= 0.5;
        loop {
            let [x, y] = best.0;
            let around = [
                [x - step_m, y],
                [x + step_m, y],
                [x, y - step_m],
                [x, y + step_m],
            ];
            let nearest = around
                .map(|place| (place, by_way_of(place)))
                .into_iter()
                .fold(best, |least, one| if one.1 < least.1 { one } else { least });
            if nearest.1 >= best.1 {
                break;
            }
            best = nearest;
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_imaging::{PlaneGrid, SurfaceGrid};
    use std::sync::Arc;

    #[test]
    fn level_ground_mirrors_and_a_tilted_plane_is_met_at_its_perpendicular() {
        let pair = [[0.2, 0.0, 1.0], [0.5, 0.4, 1.2]];
        let level = path_m(pair, &Ground::level(0.1));
        assert!((level - 0.5_f64.hypot(2.0)).abs() < 1e-12);
        // z = 0.2 x: the distance of (0.3, 0, 1) is (1 − 0.06)/√1.04.
        let grid = PlaneGrid::from_ranges([-2.0, 2.0], [-2.0, 2.0], 0.0, 0.05).unwrap();
        let surface = SurfaceGrid::in_parallel(grid, |x_m, _| {
            Ok::<_, acerra_imaging::ImagingError>(0.2 * x_m)
        });
        let ground = Ground::surface(Arc::new(surface.unwrap()));
        let found = path_m([[0.3, 0.0, 1.0]; 2], &ground);
        assert!(
            (found - 2.0 * 0.94 / 1.04_f64.sqrt()).abs() < 1e-5,
            "{found}"
        );
    }
}
