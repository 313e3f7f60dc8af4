//! Per-vector parameters (PVP) of a channel, as stored in the file.

use acerra_geo::geodesy::EnuFrame;

use crate::error::WriteError;
use crate::geometry::{ReferenceGeometry, dot, minus, norm, velocities};
use crate::model::{Channel, SPEED_OF_LIGHT_M_S};

/// Parameters of the PVP array in file order: name, 8-byte words, format.
pub(crate) const PARAMETERS: [(&str, usize, &str); 18] = [
    ("TxTime", 1, "F8"),
    ("TxPos", 3, XYZ),
    ("TxVel", 3, XYZ),
    ("RcvTime", 1, "F8"),
    ("RcvPos", 3, XYZ),
    ("RcvVel", 3, XYZ),
    ("SRPPos", 3, XYZ),
    ("aFDOP", 1, "F8"),
    ("aFRR1", 1, "F8"),
    ("aFRR2", 1, "F8"),
    ("FX1", 1, "F8"),
    ("FX2", 1, "F8"),
    ("TOA1", 1, "F8"),
    ("TOA2", 1, "F8"),
    ("TDTropoSRP", 1, "F8"),
    ("SC0", 1, "F8"),
    ("SCSS", 1, "F8"),
    ("SIGNAL", 1, "I8"),
];
const XYZ: &str = "X=F8;Y=F8;Z=F8;";

/// Number of words of a vector's parameters.
pub(crate) const WORDS: usize = 28;

/// Sampling beyond the Nyquist rate that the format asks of frequencies: the span of fast time that a
/// file states is below the unambiguous one by this factor.
const OVERSAMPLING: f64 = 1.2;

/// A pulse as stored in the file; positions and velocities are Earth-centred, Earth-fixed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector {
    /// Transmit and receive time (s).
    pub time_s: [f64; 2],
    /// Phase centre at these times (m).
    pub position_m: [[f64; 3]; 2],
    /// Velocity (m/s).
    pub velocity_m_s: [f64; 3],
    /// Two-way delay of the reference point's echo (s).
    pub srp_delay_s: f64,
    /// First and last delay relative to it at which echoes were kept (s).
    pub toa_s: [f64; 2],
    /// Fractional Doppler shift of the reference point's echo.
    pub doppler: f64,
}

/// The vectors of a channel, and their common properties.
#[derive(Clone, Debug)]
pub(crate) struct Vectors {
    pub all: Vec<Vector>,
    /// The reference point, Earth-centred, Earth-fixed (m).
    pub srp_m: [f64; 3],
    /// Index of the vector that defines the reference geometry of the collection.
    pub reference: usize,
    /// The geometry there.
    pub geometry: ReferenceGeometry,
}

impl Vectors {
    /// The vectors of a channel with positions in `frame`, for the reference point `srp_m`.
    ///
    /// # Errors
    /// A platform that never moves, or moves only straight above the reference point.
    pub fn of(
        channel: &Channel<'_>,
        frame: &EnuFrame,
        srp_m: [f64; 3],
    ) -> Result<Self, WriteError> {
        let velocity = velocities(&channel.time_s, &channel.position_m);
        let kept_s = kept_fast_time_s(channel);
        let srp_in_enu_m = frame.enu_from_ecef(srp_m);
        let pulses = channel.time_s.iter().zip(&channel.position_m).zip(velocity);
        let all: Vec<Vector> = pulses
            .map(|((time_s, position_m), velocity)| {
                // In the local frame, where coordinates are small.
                let away = minus(*position_m, srp_in_enu_m);
                let range_m = norm(away);
                let srp_delay_s = 2.0 * range_m / SPEED_OF_LIGHT_M_S;
                let velocity_m_s = frame.ecef_vector_from_enu(velocity);
                let half_s = 0.5 * srp_delay_s;
                let middle_m = frame.ecef_from_enu(*position_m);
                let moved = |s: f64| std::array::from_fn(|i| middle_m[i] + s * velocity_m_s[i]);
                Vector {
                    time_s: [time_s - half_s, time_s + half_s],
                    position_m: [moved(-half_s), moved(half_s)],
                    velocity_m_s,
                    srp_delay_s,
                    toa_s: kept_s.map(|t| t - srp_delay_s),
                    doppler: match range_m > 0.0 {
                        true => -2.0 * dot(away, velocity) / (range_m * SPEED_OF_LIGHT_M_S),
                        false => 0.0,
                    },
                }
            })
            .collect();
        let middle = all.len() / 2;
        let seen_from = |k: &usize| {
            let vector = &all[*k];
            let [a, b] = vector.position_m;
            let arp_m = std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
            let geometry = ReferenceGeometry::of(arp_m, vector.velocity_m_s, srp_m)?;
            Some((*k, geometry))
        };
        // The vector nearest to the middle that has a geometry.
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by_key(|k| k.abs_diff(middle));
        let Some((reference, geometry)) = order.iter().find_map(seen_from) else {
            return Err(WriteError::AtRest {
                name: channel.name.clone(),
            });
        };
        Ok(Self {
            all,
            srp_m,
            reference,
            geometry,
        })
    }

    /// Least and greatest of `values` over all vectors.
    pub fn extent(&self, values: impl Fn(&Vector) -> [f64; 2]) -> [f64; 2] {
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        self.all.iter().map(values).fold(start, |[low, high], v| {
            [low.min(v[0]).min(v[1]), high.max(v[0]).max(v[1])]
        })
    }

    /// Transmit times (s).
    pub fn transmit_s(&self) -> [f64; 2] {
        self.extent(|v| [v.time_s[0]; 2])
    }

    /// Delays relative to the reference point's (s).
    pub fn toa_s(&self) -> [f64; 2] {
        self.extent(|v| v.toa_s)
    }

    /// Whether the delays are equal for all vectors.
    pub fn is_toa_fixed(&self) -> bool {
        self.all.iter().all(|v| v.toa_s == self.all[0].toa_s)
    }

    /// First and last time at which the reference point is at the middle of the two-way path (s).
    pub fn reference_time_s(&self) -> [f64; 2] {
        self.extent(|v| [0.5 * (v.time_s[0] + v.time_s[1]); 2])
    }
}

/// The fast time that a channel's spectra hold, no longer than the format admits.
fn kept_fast_time_s(channel: &Channel<'_>) -> [f64; 2] {
    let longest_s = 1.0 / (OVERSAMPLING * channel.frequency.step_hz);
    match channel.fast_time_s {
        Some([from, to]) if to > from => [from, to.min(from + longest_s)],
        _ => [0.0, longest_s],
    }
}
