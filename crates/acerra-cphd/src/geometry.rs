//! Motion of the platform and geometry of the collection (CPHD 1.1.0, section 6.5).

use acerra_geo::geodesy::{EnuFrame, geodetic_from_ecef};

/// Half width, in seconds, of the window of positions from which a pulse's velocity is computed.
const VELOCITY_WINDOW_S: f64 = 0.25;
/// Least number of positions on either side of a pulse used for the pulse's velocity, where available.
const LEAST_NEIGHBOURS: usize = 1;
/// Grazing and slope angles are below 90° by the schema.
const MAX_ANGLE_DEG: f64 = 90.0 - 1e-9;

/// Velocity at every pulse by a straight line through the places about it (m/s).
pub(crate) fn velocities(time_s: &[f64], position_m: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let last = time_s.len().saturating_sub(1);
    (0..time_s.len())
        .map(|k| {
            let near = |t: &f64| (t - time_s[k]).abs() <= VELOCITY_WINDOW_S;
            let from = time_s.partition_point(|t| *t < time_s[k] && !near(t));
            let to = time_s.partition_point(|t| *t <= time_s[k] || near(t));
            let from = from.min(k.saturating_sub(LEAST_NEIGHBOURS));
            let to = to.max((k + LEAST_NEIGHBOURS).min(last) + 1);
            slope(&time_s[from..to], &position_m[from..to])
        })
        .collect()
}

/// Slope of the least-squares line through places over time (m/s).
fn slope(time_s: &[f64], position_m: &[[f64; 3]]) -> [f64; 3] {
    let n = time_s.len() as f64;
    let middle_s = time_s.iter().sum::<f64>() / n;
    let spread: f64 = time_s.iter().map(|t| (t - middle_s).powi(2)).sum();
    if spread <= 0.0 {
        return [0.0; 3];
    }
    std::array::from_fn(|i| {
        let origin_m = position_m[0][i];
        let pairs = time_s.iter().zip(position_m);
        pairs
            .map(|(t, p)| (t - middle_s) * (p[i] - origin_m))
            .sum::<f64>()
            / spread
    })
}

/// The geometry of a collection at one pulse: `ReferenceGeometry/Monostatic`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReferenceGeometry {
    pub looks_left: bool,
    pub slant_range_m: f64,
    pub ground_range_m: f64,
    pub doppler_cone_deg: f64,
    pub graze_deg: f64,
    pub azimuth_deg: f64,
    pub twist_deg: f64,
    pub slope_deg: f64,
    pub layover_deg: f64,
}

impl ReferenceGeometry {
    /// The geometry of a phase centre at `arp_m` with velocity `velocity_m_s` about the reference
    /// point `srp_m`, all Earth-centred, Earth-fixed; none of a platform at rest, or straight above
    /// the reference point. Numbers in comments refer to section 6.5.2.
    pub fn of(arp_m: [f64; 3], velocity_m_s: [f64; 3], srp_m: [f64; 3]) -> Option<Self> {
        let frame = EnuFrame::new(geodetic_from_ecef(srp_m));
        let axis = |enu| frame.ecef_vector_from_enu(enu);
        let (east, north, up) = (
            axis([1.0, 0.0, 0.0]),
            axis([0.0, 1.0, 0.0]),
            axis([0.0, 0.0, 1.0]),
        );
        // (2)
        let away = minus(arp_m, srp_m);
        let slant_range_m = norm(away);
        let to_arp = unit(away)?;
        // (4): the angle at the centre of the Earth, by its sine, which is exact for small angles.
        let arc = norm(cross(arp_m, srp_m)).atan2(dot(arp_m, srp_m));
        let ground_range_m = norm(srp_m) * arc;
        // (5), (6)
        let along = unit(velocity_m_s)?;
        let left = cross(unit(arp_m)?, along);
        let looks_left = dot(left, to_arp) < 0.0;
        let look = if looks_left { 1.0 } else { -1.0 };
        // (7)
        let doppler_cone_deg = (-dot(to_arp, along)).clamp(-1.0, 1.0).acos().to_degrees();
        // (8)
        let ground_y = unit(cross(up, to_arp))?;
        let ground_x = cross(ground_y, up);
        // (9)
        let graze_deg = dot(to_arp, up).atan2(dot(to_arp, ground_x)).to_degrees();
        // (10)
        let azimuth_deg = compass_deg(dot(ground_x, east), dot(ground_x, north));
        // (11)
        let plane_normal = unit(cross(to_arp, along).map(|v| look * v))?;
        // (12) to (14)
        let twist_deg = -dot(plane_normal, ground_y)
            .clamp(-1.0, 1.0)
            .asin()
            .to_degrees();
        let slope_deg = dot(up, plane_normal).clamp(-1.0, 1.0).acos().to_degrees();
        let layover_deg = compass_deg(-dot(plane_normal, east), -dot(plane_normal, north));
        Some(Self {
            looks_left,
            slant_range_m,
            ground_range_m,
            doppler_cone_deg,
            graze_deg: graze_deg.clamp(0.0, MAX_ANGLE_DEG),
            azimuth_deg,
            twist_deg,
            slope_deg: slope_deg.clamp(0.0, MAX_ANGLE_DEG),
            layover_deg,
        })
        .filter(|_| ground_range_m > 0.0)
    }
}

/// Direction from north over east (degrees, 0 to below 360).
fn compass_deg(east: f64, north: f64) -> f64 {
    let turned = east.atan2(north).to_degrees().rem_euclid(360.0);
    if turned < 360.0 { turned } else { 0.0 }
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The direction of a vector that is no zero vector.
fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length > 0.0).then(|| a.map(|v| v / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::geodesy::Geodetic;

    #[test]
    fn a_straight_flight_has_its_velocity_everywhere() {
        let time_s: Vec<f64> = (0..50).map(|k| 0.02 * f64::from(k)).collect();
        let place = |t: &f64| [1.0 + 2.0 * t, -3.0 * t, 8.0];
        let position_m: Vec<_> = time_s.iter().map(place).collect();
        for v in velocities(&time_s, &position_m) {
            assert!(
                (v[0] - 2.0).abs() < 1e-9 && (v[1] + 3.0).abs() < 1e-9,
                "{v:?}"
            );
        }
        // Pulses farther apart than the window still have neighbours.
        let v = velocities(
            &[0.0, 2.0, 4.0],
            &[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        );
        assert_eq!(v[1], [0.5, 0.0, 0.0]);
        assert_eq!(v[2], [0.5, 0.0, 0.0]);
    }

    #[test]
    fn a_flight_to_the_north_looks_right_at_a_target_in_the_east() {
        let frame = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
        // The platform is 10 m west of the reference point and 10 m above it.
        let arp = frame.ecef_from_enu([-10.0, 0.0, 10.0]);
        let along = frame.ecef_vector_from_enu([0.0, 2.0, 0.0]);
        let seen = ReferenceGeometry::of(arp, along, frame.origin_in_ecef_m()).unwrap();
        assert!(!seen.looks_left);
        assert!((seen.slant_range_m - 200f64.sqrt()).abs() < 1e-8);
        assert!((seen.ground_range_m - 10.0).abs() < 1e-4, "{seen:?}");
        for (found, expected) in [
            (seen.doppler_cone_deg, 90.0),
            (seen.graze_deg, 45.0),
            (seen.azimuth_deg, 270.0),
            (seen.twist_deg, 0.0),
            (seen.slope_deg, 45.0),
            (seen.layover_deg, 270.0),
        ] {
            assert!((found - expected).abs() < 1e-3, "{seen:?}");
        }
        assert!(ReferenceGeometry::of(arp, [0.0; 3], frame.origin_in_ecef_m()).is_none());
    }
}
