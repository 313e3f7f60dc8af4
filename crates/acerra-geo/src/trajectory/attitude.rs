//! Attitude as a unit quaternion.

use crate::matrix::{Matrix3, Vector3, cross};

/// The rotation that takes a vector of body axes (forward, left, up) to east, north, up.
///
/// A unit quaternion; `q` and `−q` are the same rotation.
///
/// ```
/// use acerra_geo::trajectory::Attitude;
/// // Heading north: forward is north, left is west.
/// let north = Attitude::from_heading(0.0);
/// let [e, n, u] = north.rotate([1.0, 0.0, 0.0]);
/// assert!(e.abs() < 1e-15 && (n - 1.0).abs() < 1e-15 && u == 0.0);
/// assert!((north.rotate([0.0, 1.0, 0.0])[0] + 1.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    w: f64,
    x: f64,
    y: f64,
    z: f64,
}

impl Attitude {
    /// Forward is east, left is north, up is up.
    pub const IDENTITY: Self = Self {
        w: 1.0,
        x: 0.0,
        y: 0.0,
        z: 0.0,
    };

    /// From the four parts, scalar first, brought to unit length; none when the length is not a
    /// positive finite number.
    #[must_use]
    pub fn from_quaternion(w: f64, x: f64, y: f64, z: f64) -> Option<Self> {
        let length = w.hypot(x).hypot(y).hypot(z);
        (length.is_finite() && length > 1e-9).then(|| Self {
            w: w / length,
            x: x / length,
            y: y / length,
            z: z / length,
        })
    }

    /// Level, with the nose towards `heading_rad`, clockwise from north.
    #[must_use]
    pub fn from_heading(heading_rad: f64) -> Self {
        let yaw = std::f64::consts::FRAC_PI_2 - heading_rad;
        let (s, c) = (0.5 * yaw).sin_cos();
        Self {
            w: c,
            x: 0.0,
            y: 0.0,
            z: s,
        }
    }

    /// From roll, pitch and heading (rad) as aircraft have them: turns about down by the heading, then right by pitch, then
    /// forward by roll.
    ///
    /// Roll is positive with the right side down, pitch with the nose up, the heading clockwise from north. None for
    /// angles that are not finite.
    #[must_use]
    pub fn from_euler([roll_rad, pitch_rad, heading_rad]: [f64; 3]) -> Option<Self> {
        let [(sr, cr), (sp, cp), (sy, cy)] =
            [roll_rad, pitch_rad, heading_rad].map(|a| (0.5 * a).sin_cos());
        Self::from_frd_to_ned([
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ])
    }

    /// From the unit quaternion (w, x, y, z) that takes forward, right, down to north, east, down. None for one without a
    /// length.
    ///
    /// The same turn from forward, left, up to east, north, up is p·q·r, where r = (0, 1, 0, 0) takes forward, left, up to
    /// forward, right, down and p = (0, 1, 1, 0)/√2 takes north, east, down to east, north, up.
    #[must_use]
    pub fn from_frd_to_ned([w, x, y, z]: [f64; 4]) -> Option<Self> {
        Self::from_quaternion(-w - z, -x - y, y - x, z - w)
    }

    /// The parts, scalar first: w, x, y, z.
    #[must_use]
    pub const fn quaternion(&self) -> [f64; 4] {
        [self.w, self.x, self.y, self.z]
    }

    /// A vector of body axes in east, north, up.
    #[must_use]
    pub fn rotate(&self, vector_in_body: Vector3) -> Vector3 {
        let axis = [self.x, self.y, self.z];
        let t = cross(axis, vector_in_body).map(|v| 2.0 * v);
        let u = cross(axis, t);
        [0, 1, 2].map(|i| vector_in_body[i] + self.w * t[i] + u[i])
    }

    /// The attitude in axes that `target_from_enu` (a rotation matrix) turns into.
    #[must_use]
    pub fn turned_by(&self, target_from_enu: &Matrix3) -> Self {
        let r = Self::from_rotation(target_from_enu);
        let (a, b) = (r, *self);
        Self {
            w: a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
            x: a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            y: a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            z: a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        }
        .unit()
    }

    /// The attitude of a rotation matrix (body axes as its columns).
    ///
    /// The largest of the four parts is found first, so that no digits are lost at half turns.
    #[must_use]
    pub fn from_rotation(m: &Matrix3) -> Self {
        let trace = m[0][0] + m[1][1] + m[2][2];
        let largest = [trace, m[0][0], m[1][1], m[2][2]]
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))
            .map_or(0, |(i, _)| i);
        let (w, x, y, z) = match largest {
            0 => (
                1.0 + trace,
                m[2][1] - m[1][2],
                m[0][2] - m[2][0],
                m[1][0] - m[0][1],
            ),
            1 => (
                m[2][1] - m[1][2],
                1.0 + m[0][0] - m[1][1] - m[2][2],
                m[0][1] + m[1][0],
                m[0][2] + m[2][0],
            ),
            2 => (
                m[0][2] - m[2][0],
                m[0][1] + m[1][0],
                1.0 - m[0][0] + m[1][1] - m[2][2],
                m[1][2] + m[2][1],
            ),
            _ => (
                m[1][0] - m[0][1],
                m[0][2] + m[2][0],
                m[1][2] + m[2][1],
                1.0 - m[0][0] - m[1][1] + m[2][2],
            ),
        };
        Self::from_quaternion(w, x, y, z).unwrap_or(Self::IDENTITY)
    }

    /// The attitude between this one (`share` 0) and `other` (`share` 1), along the shorter turn.
    ///
    /// The straight line between the quaternions, brought back to unit length: for the turns of
    /// less than 30° between neighbouring samples it stays within 0.1° of constant rate.
    #[must_use]
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let (a, b) = (self.quaternion(), other.quaternion());
        let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
        let sign = if cosine < 0.0 { -share } else { share };
        let [w, x, y, z] = [0, 1, 2, 3].map(|i| (1.0 - share) * a[i] + sign * b[i]);
        Self { w, x, y, z }.unit()
    }

    /// The angle (rad, 0 to π) of the turn from this attitude to `other`.
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        let (a, b) = (self.quaternion(), other.quaternion());
        let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
        2.0 * cosine.abs().min(1.0).acos()
    }

    fn unit(self) -> Self {
        Self::from_quaternion(self.w, self.x, self.y, self.z).unwrap_or(Self::IDENTITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::{distance, multiply_vector, transpose};
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

    fn columns(a: &Attitude) -> Matrix3 {
        transpose(&[
            a.rotate([1.0, 0.0, 0.0]),
            a.rotate([0.0, 1.0, 0.0]),
            a.rotate([0.0, 0.0, 1.0]),
        ])
    }

    #[test]
    fn rotates_as_its_matrix_and_comes_back_from_it() {
        for parts in [
            [0.3, -0.5, 0.7, 0.2],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [1e-3, 0.0, 0.1, 1.0],
        ] {
            let [w, x, y, z] = parts;
            let a = Attitude::from_quaternion(w, x, y, z).expect("a quaternion");
            let back = Attitude::from_rotation(&columns(&a));
            let v = [0.3, -2.0, 1.1];
            assert!(distance(a.rotate(v), back.rotate(v)) < 1e-14);
            let turned = a.turned_by(&columns(&a));
            assert!(distance(turned.rotate(v), multiply_vector(&columns(&a), a.rotate(v))) < 1e-14);
        }
        assert_eq!(Attitude::from_quaternion(0.0, 0.0, 0.0, 0.0), None);
        assert_eq!(Attitude::from_quaternion(f64::NAN, 0.0, 0.0, 0.0), None);
    }

    #[test]
    fn half_way_between_headings() {
        let a = Attitude::from_heading(0.0);
        let b = Attitude::from_heading(PI / 2.0);
        let forward = a.towards(&b, 0.5).rotate([1.0, 0.0, 0.0]);
        assert!(distance(forward, [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0]) < 1e-12);
        assert!((a.angle_to(&b) - PI / 2.0).abs() < 1e-12 && a.angle_to(&a) < 1e-7);
        // The sign of a quaternion does not matter.
        let [w, x, y, z] = b.quaternion();
        let same = Attitude::from_quaternion(-w, -x, -y, -z).expect("a quaternion");
        assert!(distance(a.towards(&same, 0.5).rotate([1.0, 0.0, 0.0]), forward) < 1e-12);
    }

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn axes_point_where_the_angles_say() {
        let forward = [1.0, 0.0, 0.0];
        let left = [0.0, 1.0, 0.0];
        let up = [0.0, 0.0, 1.0];
        let level_north = Attitude::from_euler([0.0; 3]).unwrap();
        assert!(near(level_north.rotate(forward), [0.0, 1.0, 0.0]));
        assert!(near(level_north.rotate(left), [-1.0, 0.0, 0.0]));
        assert!(near(level_north.rotate(up), [0.0, 0.0, 1.0]));
        let east = Attitude::from_euler([0.0, 0.0, FRAC_PI_2]).unwrap();
        assert!(near(east.rotate(forward), [1.0, 0.0, 0.0]));
        // Nose up by 30°.
        let climbing = Attitude::from_euler([0.0, FRAC_PI_2 / 3.0, 0.0]).unwrap();
        assert!(near(climbing.rotate(forward), [0.0, 0.75_f64.sqrt(), 0.5]));
        // Right side down: left goes up.
        let banked = Attitude::from_euler([FRAC_PI_2 / 3.0, 0.0, 0.0]).unwrap();
        assert!(near(banked.rotate(left), [-(0.75_f64.sqrt()), 0.0, 0.5]));
        for heading in [0.3, 2.0, -1.0] {
            let level = Attitude::from_euler([0.0, 0.0, heading]).unwrap();
            assert!(level.angle_to(&Attitude::from_heading(heading)) < 1e-7);
        }
        assert!(Attitude::from_euler([f64::NAN, 0.0, 0.0]).is_none());
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
        let attitude = Attitude::from_euler([roll, pitch, yaw]).unwrap();
        for body in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, -0.7, 1.3]] {
            let [f, l, u] = body;
            let frd = [f, -l, -u];
            let [n, e, d] = ned.map(|row| row.iter().zip(frd).map(|(a, b)| a * b).sum::<f64>());
            assert!(near(attitude.rotate(body), [e, n, -d]));
        }
    }
}
