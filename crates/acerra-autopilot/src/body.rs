//! Attitudes as autopilots write them: from forward, right, down to north, east, down.

use acerra_geo::trajectory::Attitude;

/// From roll, pitch and yaw (rad): turns about down by yaw, then right by pitch, then forward by roll.
///
/// Roll is positive with the right side down, pitch with the nose up, yaw clockwise from north. None
/// for angles that are not finite.
pub fn attitude_from_euler([roll_rad, pitch_rad, yaw_rad]: [f64; 3]) -> Option<Attitude> {
    let [(sr, cr), (sp, cp), (sy, cy)] =
        [roll_rad, pitch_rad, yaw_rad].map(|a| (0.5 * a).sin_cos());
    attitude_from_frd_to_ned([
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ])
}

/// From the unit quaternion (w, x, y, z) that takes forward, right, down to north, east, down. None
/// for one without a length.
///
/// The same turn from forward, left, up to east, north, up is p·q·r, where r = (0, 1, 0, 0) takes
/// forward, left, up to forward, right, down and p = (0, 1, 1, 0)/√2 takes north, east, down to east,
/// north, up.
pub fn attitude_from_frd_to_ned([w, x, y, z]: [f64; 4]) -> Option<Attitude> {
    Attitude::from_quaternion(-w - z, -x - y, y - x, z - w)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn axes_point_where_the_angles_say() {
        let forward = [1.0, 0.0, 0.0];
        let left = [0.0, 1.0, 0.0];
        let up = [0.0, 0.0, 1.0];
        let level_north = attitude_from_euler([0.0; 3]).unwrap();
        assert!(near(level_north.rotate(forward), [0.0, 1.0, 0.0]));
        assert!(near(level_north.rotate(left), [-1.0, 0.0, 0.0]));
        assert!(near(level_north.rotate(up), [0.0, 0.0, 1.0]));
        let east = attitude_from_euler([0.0, 0.0, FRAC_PI_2]).unwrap();
        assert!(near(east.rotate(forward), [1.0, 0.0, 0.0]));
        // Nose up by 30°.
        let climbing = attitude_from_euler([0.0, FRAC_PI_2 / 3.0, 0.0]).unwrap();
        assert!(near(climbing.rotate(forward), [0.0, 0.75_f64.sqrt(), 0.5]));
        // Right side down: left goes up.
        let banked = attitude_from_euler([FRAC_PI_2 / 3.0, 0.0, 0.0]).unwrap();
        assert!(near(banked.rotate(left), [-(0.75_f64.sqrt()), 0.0, 0.5]));
        for heading in [0.3, 2.0, -1.0] {
            let level = attitude_from_euler([0.0, 0.0, heading]).unwrap();
            assert!(level.angle_to(&Attitude::from_heading(heading)) < 1e-7);
        }
        assert!(attitude_from_euler([f64::NAN, 0.0, 0.0]).is_none());
    }

    #[test]
    fn all_three_angles_at_once_are_the_product_of_their_rotations() {
        let (roll, pitch, yaw) = (0.31_f64, -0.22_f64, 2.4_f64);
        let ([sr, cr], [sp, cp], [sy, cy]) = (
            [roll.sin(), roll.cos()],
            [pitch.sin(), pitch.cos()],
            [yaw.sin(), yaw.cos()],
        );
        // Rows of the rotation from forward, right, down to north, east, down (Diebel 2006, eq. 67).
        let ned = [
            [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
            [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
            [-sp, sr * cp, cr * cp],
        ];
        let attitude = attitude_from_euler([roll, pitch, yaw]).unwrap();
        for body in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, -0.7, 1.3]] {
            let [f, l, u] = body;
            let frd = [f, -l, -u];
            let [n, e, d] = ned.map(|row| row.iter().zip(frd).map(|(a, b)| a * b).sum::<f64>());
            assert!(near(attitude.rotate(body), [e, n, -d]));
        }
    }
}
