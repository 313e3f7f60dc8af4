//! A flight of known truth.

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::Attitude;

/// The origin of the flight.
pub fn origin() -> Geodetic {
    Geodetic::from_degrees(41.1, 14.25, 80.0)
}

/// Second zero of the flight.
pub fn start() -> GpsTime {
    GpsTime::from_week_tow(2390, 302_400.0)
}

/// Clock of the autopilot (s) at `time_s` of the flight: it started 200 s before and is 15 ppm slow.
pub fn boot_s(time_s: f64) -> f64 {
    200.0 + time_s * (1.0 - 15e-6)
}

/// The geoid lies so far above the ellipsoid (m).
pub const GEOID_M: f64 = 47.25;

/// East, north, up (m) at `time_s`.
pub fn position_m(time_s: f64) -> [f64; 3] {
    [
        3.0 * time_s,
        20.0 * (0.3 * time_s).sin(),
        25.0 + 0.5 * (0.2 * time_s).sin(),
    ]
}

/// Velocity east, north, up (m/s) at `time_s`.
pub fn velocity_m_s(time_s: f64) -> [f64; 3] {
    [3.0, 6.0 * (0.3 * time_s).cos(), 0.1 * (0.2 * time_s).cos()]
}

/// Latitude and longitude (degrees) and height above the ellipsoid (m) at `time_s`.
pub fn geodetic(time_s: f64) -> [f64; 3] {
    let place = EnuFrame::new(origin()).geodetic_from_enu(position_m(time_s));
    [place.latitude_deg(), place.longitude_deg(), place.height_m]
}

/// Roll, pitch and yaw (rad) at `time_s`.
pub fn euler_rad(time_s: f64) -> [f64; 3] {
    [
        0.15 * (0.7 * time_s).sin(),
        0.08 * (0.5 * time_s).cos(),
        0.9 + 0.3 * (0.25 * time_s).sin(),
    ]
}

/// The attitude flown.
pub fn attitude_at(time_s: f64) -> Attitude {
    attitude_of(euler_rad(time_s))
}

/// Roll and pitch from the horizon and yaw from north (rad) of the gimbal at `time_s`.
pub fn gimbal_rad(time_s: f64) -> [f64; 3] {
    [
        0.05 * (0.9 * time_s).cos(),
        -0.4 + 0.1 * (0.4 * time_s).sin(),
        2.0 + 0.2 * (0.3 * time_s).cos(),
    ]
}

/// The same with the yaw from the vehicle's nose, whose heading is the yaw of [`euler_rad`].
pub fn gimbal_from_nose_rad(time_s: f64) -> [f64; 3] {
    let [roll, pitch, yaw] = gimbal_rad(time_s);
    [roll, pitch, yaw - euler_rad(time_s)[2]]
}

/// The quaternion (w, x, y, z) from forward, right, down to north, east, down: turns about down by yaw, right by
/// pitch, forward by roll, multiplied one by one.
pub fn quaternion_frd_ned([roll, pitch, yaw]: [f64; 3]) -> [f64; 4] {
    let about = |axis: usize, angle: f64| {
        let mut q = [(0.5 * angle).cos(), 0.0, 0.0, 0.0];
        q[axis] = (0.5 * angle).sin();
        q
    };
    let times = |a: [f64; 4], b: [f64; 4]| {
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    };
    times(times(about(3, yaw), about(2, pitch)), about(1, roll))
}

/// The attitude of those angles, from the rotation's definition: columns are forward, left and up.
pub fn attitude_of([roll, pitch, yaw]: [f64; 3]) -> Attitude {
    let (sr, cr) = roll.sin_cos();
    let (sp, cp) = pitch.sin_cos();
    let (sy, cy) = yaw.sin_cos();
    let forward_ned = [cp * cy, cp * sy, -sp];
    let right_ned = [sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp];
    let down_ned = [cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp];
    let enu = |[n, e, d]: [f64; 3]| [e, n, -d];
    let columns = [
        enu(forward_ned),
        enu(right_ned.map(|v| -v)),
        enu(down_ned.map(|v| -v)),
    ];
    let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column: usize| columns[column][row]));
    Attitude::from_rotation(&matrix)
}
