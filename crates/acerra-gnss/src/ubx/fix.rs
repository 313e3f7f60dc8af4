//! Status of a receiver's fix during a recording.

use super::frame::Frame;
use super::measurement::bytes;

/// Least number of satellites for a position.
const LEAST_SATELLITES: usize = 4;

/// Status of a receiver's fix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixState {
    /// Whether the receiver has a position in three dimensions, or enough satellites for one.
    pub has_fix: bool,
    /// Satellites used, or measured.
    pub satellites: usize,
    /// Height above the ellipsoid and the height's standard deviation (m), where the message has a position.
    pub height_m: Option<[f64; 2]>,
}

/// The fix status by a message: NAV-PVT, or the measurements of RXM-RAWX and RXM-RAW; `None` for other
/// messages.
///
/// NAV-PVT (01 07) states the fix; for measurements, satellites with a pseudorange are counted.
#[must_use]
pub fn fix_state(frame: &Frame<'_>) -> Option<FixState> {
    match (frame.class, frame.id) {
        (0x01, 0x07) => solution(frame.payload),
        (0x02, 0x15) => Some(measured(rawx_satellites(frame.payload)?)),
        (0x02, 0x10) => Some(measured(raw_satellites(frame.payload)?)),
        _ => None,
    }
}

/// Whether the message is a solution of the receiver, rather than measurements.
#[must_use]
pub fn is_solution(frame: &Frame<'_>) -> bool {
    (frame.class, frame.id) == (0x01, 0x07)
}

fn solution(payload: &[u8]) -> Option<FixState> {
    const MILLIMETRE_M: f64 = 1e-3;
    let (kind, flags, satellites) = (*payload.get(20)?, payload.get(21)?, *payload.get(23)?);
    let height_mm = i32::from_le_bytes(bytes(payload, 32)?);
    let sigma_mm = u32::from_le_bytes(bytes(payload, 44)?);
    // 3-D, or with dead reckoning.
    let has_fix = flags & 1 != 0 && matches!(kind, 3 | 4);
    Some(FixState {
        has_fix,
        satellites: satellites.into(),
        height_m: has_fix
            .then(|| [f64::from(height_mm), f64::from(sigma_mm)].map(|mm| MILLIMETRE_M * mm)),
    })
}

fn measured(mut satellites: Vec<[u8; 2]>) -> FixState {
    satellites.sort_unstable();
    satellites.dedup();
    FixState {
        has_fix: satellites.len() >= LEAST_SATELLITES,
        satellites: satellites.len(),
        height_m: None,
    }
}

/// System and number of each measured signal's satellite with a pseudorange.
fn rawx_satellites(payload: &[u8]) -> Option<Vec<[u8; 2]>> {
    const PSEUDORANGE_VALID: u8 = 1;
    let count = usize::from(*payload.get(11)?);
    let signals = payload.get(16..)?.chunks_exact(32).take(count);
    Some(
        signals
            .filter(|signal| signal[30] & PSEUDORANGE_VALID != 0)
            .map(|signal| [signal[20], signal[21]])
            .collect(),
    )
}

/// Use flags in messages of the sixth generation: quality from 4 on has a pseudorange.
fn raw_satellites(payload: &[u8]) -> Option<Vec<[u8; 2]>> {
    const LEAST_QUALITY: u8 = 4;
    let count = usize::from(*payload.get(6)?);
    let satellites = payload.get(8..)?.chunks_exact(24).take(count);
    Some(
        satellites
            .filter(|satellite| (LEAST_QUALITY..=7).contains(&satellite[21]))
            .map(|satellite| [0, satellite[20]])
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(class: u8, id: u8, payload: &[u8]) -> Option<FixState> {
        fix_state(&Frame {
            class,
            id,
            payload,
            offset: 0,
        })
    }

    #[test]
    fn a_solution_states_its_fix() {
        let mut payload = vec![0; 92];
        payload[20] = 3;
        payload[21] = 1;
        payload[23] = 11;
        payload[32..36].copy_from_slice(&123_456_i32.to_le_bytes());
        payload[44..48].copy_from_slice(&2_500_u32.to_le_bytes());
        let fixed = state(1, 7, &payload).unwrap();
        assert_eq!((fixed.has_fix, fixed.satellites), (true, 11));
        assert_eq!(fixed.height_m, Some([123.456, 2.5]));
        // Two dimensions; the flag that is missing.
        for (at, value) in [(20, 2), (21, 0)] {
            let mut payload = payload.clone();
            payload[at] = value;
            let found = state(1, 7, &payload).unwrap();
            assert_eq!((found.has_fix, found.height_m), (false, None));
        }
        assert_eq!(state(1, 7, &payload[..40]), None);
        assert_eq!(state(1, 2, &payload), None);
    }

    #[test]
    fn satellites_of_measurements_are_counted_once() {
        let mut payload = vec![0; 16 + 6 * 32];
        payload[11] = 6;
        for (k, [system, number]) in [[0, 3], [0, 3], [0, 7], [6, 7], [2, 1], [2, 9]]
            .into_iter()
            .enumerate()
        {
            let signal = &mut payload[16 + 32 * k..][..32];
            (signal[20], signal[21], signal[30]) = (system, number, 1);
        }
        // The last one has no pseudorange.
        payload[16 + 32 * 5 + 30] = 2;
        let found = state(2, 0x15, &payload).unwrap();
        assert_eq!((found.has_fix, found.satellites), (true, 4));
        payload[11] = 4;
        let found = state(2, 0x15, &payload).unwrap();
        assert_eq!((found.has_fix, found.satellites), (false, 3));
        assert_eq!(state(2, 0x15, &payload[..10]), None);
    }

    #[test]
    fn the_sixth_generation_tells_quality() {
        let mut payload = vec![0; 8 + 5 * 24];
        payload[6] = 5;
        for (k, quality) in [7, 6, 4, 3, 7].into_iter().enumerate() {
            let satellite = &mut payload[8 + 24 * k..][..24];
            (satellite[20], satellite[21]) = (k as u8 + 1, quality);
        }
        let found = state(2, 0x10, &payload).unwrap();
        assert_eq!((found.has_fix, found.satellites), (true, 4));
    }
}
