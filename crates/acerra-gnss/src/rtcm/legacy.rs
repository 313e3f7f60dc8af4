//! Observation messages of the first generation: 1002 and 1004 (GPS), 1010 and 1012 (GLONASS)
//! (RTCM 10403.3, tables 3.5-2 ff. and 3.5-11 ff.).

use super::lock::least_of_7_bits_ms;
use super::measurement::{Measured, MeasuredSignal, PhaseRange, TimeTag};
use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::{SPEED_OF_LIGHT_M_S, SignalCode};
use crate::orbits::bits::BitCursor;

/// Step of a pseudorange (m).
const RANGE_STEP_M: f64 = 0.02;
/// Step of a phase range (m).
const PHASE_STEP_M: f64 = 0.0005;
/// Step of a carrier-to-noise density (dB-Hz).
const CN0_STEP_DB_HZ: f64 = 0.25;
/// Modulus of GPS pseudoranges: one millisecond.
const GPS_MODULUS_M: f64 = SPEED_OF_LIGHT_M_S * 1e-3;
/// Modulus of GLONASS pseudoranges: two milliseconds.
const GLONASS_MODULUS_M: f64 = SPEED_OF_LIGHT_M_S * 2e-3;

/// Message 1002 (L1) or 1004 (L1 and L2); `None` where the message is shorter than it announces.
pub(super) fn gps(payload: &[u8], with_l2: bool) -> Option<Measured> {
    let mut bits = BitCursor::new(payload);
    bits.skip(12)?;
    let station = bits.unsigned(12)? as u16;
    let tag = TimeTag::GpsWeek(bits.unsigned32(30)?);
    let mut out = head(&mut bits, station, tag)?;
    for _ in 0..out.1 {
        let number = bits.byte(6)?;
        let code = if bits.flag()? { 'P' } else { 'C' };
        let first = First::read(&mut bits, FirstFormat::GPS)?;
        let second = if with_l2 {
            Some(Second::read(&mut bits)?)
        } else {
            None
        };
        let satellite = match number {
            // 40 to 58 are SBAS satellites, PRN 120 to 138.
            40..=58 => SatelliteId::new(System::Sbas, number - 20),
            _ => SatelliteId::new(System::Gps, number),
        };
        let l2_code = ['X', 'P', 'D', 'W'];
        take(&mut out.0, satellite, code, &first, second, |c| {
            l2_code[c & 3]
        });
    }
    Some(out.0)
}

/// Message 1010 (L1) or 1012 (L1 and L2).
pub(super) fn glonass(payload: &[u8], with_l2: bool) -> Option<Measured> {
    let mut bits = BitCursor::new(payload);
    bits.skip(12)?;
    let station = bits.unsigned(12)? as u16;
    let tag = TimeTag::GlonassDay(bits.unsigned32(27)?);
    let mut out = head(&mut bits, station, tag)?;
    for _ in 0..out.1 {
        let number = bits.byte(6)?;
        let code = if bits.flag()? { 'P' } else { 'C' };
        let channel = bits.unsigned(5)? as i8 - 7;
        let first = First::read(&mut bits, FirstFormat::GLONASS)?;
        let second = if with_l2 {
            Some(Second::read(&mut bits)?)
        } else {
            None
        };
        let satellite = SatelliteId::new(System::Glonass, number);
        if satellite.is_some() && (-7..=6).contains(&channel) {
            out.0.channels.push((number, channel));
        }
        take(&mut out.0, satellite, code, &first, second, |c| {
            if c & 1 == 0 { 'C' } else { 'P' }
        });
    }
    Some(out.0)
}

/// The rest of a header, after the time: the message without signals, and the number of satellites that
/// follow.
fn head(bits: &mut BitCursor<'_>, station: u16, tag: TimeTag) -> Option<(Measured, u64)> {
    let more_follow = bits.flag()?;
    let satellites = bits.unsigned(5)?;
    // Divergence-free smoothing and its interval.
    bits.skip(4)?;
    let measured = Measured {
        station,
        tag,
        more_follow,
        signals: Vec::new(),
        channels: Vec::new(),
        unknown: 0,
    };
    Some((measured, satellites))
}

/// Field widths and modulus of a system.
struct FirstFormat {
    range_bits: usize,
    range_invalid: u64,
    ambiguity_bits: usize,
    modulus_m: f64,
}

impl FirstFormat {
    const GPS: Self = Self {
        range_bits: 24,
        range_invalid: 0x80_0000,
        ambiguity_bits: 8,
        modulus_m: GPS_MODULUS_M,
    };
    const GLONASS: Self = Self {
        range_bits: 25,
        range_invalid: 0x100_0000,
        ambiguity_bits: 7,
        modulus_m: GLONASS_MODULUS_M,
    };
}

/// The first frequency of a satellite.
struct First {
    range_m: Option<f64>,
    excess_m: Option<f64>,
    least_lock_ms: u32,
    cn0_db_hz: Option<f64>,
}

impl First {
    fn read(bits: &mut BitCursor<'_>, format: FirstFormat) -> Option<Self> {
        let range = bits.unsigned(format.range_bits)?;
        let excess_m = excess_m(bits.signed(20)?);
        let least_lock_ms = least_of_7_bits_ms(bits.unsigned32(7)?);
        let modulus_m = bits.unsigned(format.ambiguity_bits)? as f64 * format.modulus_m;
        let cn0_db_hz = cn0_db_hz(bits.unsigned(8)?);
        Some(Self {
            range_m: (range != format.range_invalid)
                .then_some(range as f64 * RANGE_STEP_M + modulus_m),
            excess_m,
            least_lock_ms,
            cn0_db_hz,
        })
    }
}

/// The second frequency of a satellite, relative to the first.
struct Second {
    code: usize,
    difference_m: Option<f64>,
    excess_m: Option<f64>,
    least_lock_ms: u32,
    cn0_db_hz: Option<f64>,
}

impl Second {
    fn read(bits: &mut BitCursor<'_>) -> Option<Self> {
        let code = bits.unsigned(2)? as usize;
        let difference = bits.signed(14)?;
        Some(Self {
            code,
            difference_m: (difference != -0x2000).then_some(difference as f64 * RANGE_STEP_M),
            excess_m: excess_m(bits.signed(20)?),
            least_lock_ms: least_of_7_bits_ms(bits.unsigned32(7)?),
            cn0_db_hz: cn0_db_hz(bits.unsigned(8)?),
        })
    }
}

/// Phase range minus pseudorange (m); `None` for the value that means "not valid".
fn excess_m(steps: i64) -> Option<f64> {
    (steps != -0x8_0000).then_some(steps as f64 * PHASE_STEP_M)
}

fn cn0_db_hz(steps: u64) -> Option<f64> {
    (steps != 0).then_some(steps as f64 * CN0_STEP_DB_HZ)
}

/// Adds a satellite's signals to the message.
fn take(
    out: &mut Measured,
    satellite: Option<SatelliteId>,
    l1: char,
    first: &First,
    second: Option<Second>,
    l2: impl Fn(usize) -> char,
) {
    let Some(satellite) = satellite else {
        out.unknown += 1 + u64::from(second.is_some());
        return;
    };
    let signal = |code, range_m, excess_m: Option<f64>, least_lock_ms, cn0_db_hz| MeasuredSignal {
        satellite,
        code,
        range_m,
        phase: first
            .range_m
            .zip(excess_m)
            .map(|(range_m, excess_m)| PhaseRange::Modulo1500 { range_m, excess_m }),
        rate_m_s: None,
        cn0_db_hz,
        least_lock_ms,
        half_cycle_unknown: false,
    };
    out.signals.push(signal(
        SignalCode::new(1, l1),
        first.range_m,
        first.excess_m,
        first.least_lock_ms,
        first.cn0_db_hz,
    ));
    if let Some(s) = second {
        let range_m = first.range_m.zip(s.difference_m).map(|(a, b)| a + b);
        out.signals.push(signal(
            SignalCode::new(2, l2(s.code)),
            range_m,
            s.excess_m,
            s.least_lock_ms,
            s.cn0_db_hz,
        ));
    }
}
