//! Multiple signal messages 4 to 7 of every system (RTCM 10403.3, section 3.5.16).

use super::lock::{least_of_4_bits_ms, least_of_10_bits_ms};
use super::measurement::{Measured, MeasuredSignal, PhaseRange, TimeTag, satellite};
use super::signals::signal;
use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::{SPEED_OF_LIGHT_M_S, SignalCode};
use crate::orbits::bits::BitCursor;

/// Metres that light travels in a millisecond.
const LIGHT_MILLISECOND_M: f64 = SPEED_OF_LIGHT_M_S * 1e-3;
/// Largest number of cells (satellites times signals) of a message.
const MAX_CELLS: usize = 64;

/// System and kind (4 to 7) of an MSM message number, if the kind is supported.
pub(super) fn kind(number: u16) -> Option<(System, u8)> {
    let system = match number / 10 {
        107 => System::Gps,
        108 => System::Glonass,
        109 => System::Galileo,
        110 => System::Sbas,
        111 => System::Qzss,
        112 => System::Beidou,
        113 => System::Navic,
        _ => return None,
    };
    match number % 10 {
        kind @ 4..=7 => Some((system, kind as u8)),
        _ => None,
    }
}

/// The observations of an MSM message; `None` where the message is shorter than it announces or announces
/// more than the limit.
pub(super) fn read(payload: &[u8], system: System, kind: u8) -> Option<Measured> {
    let mut bits = BitCursor::new(payload);
    let header = Header::read(&mut bits, system)?;
    let satellites = Satellites::read(&mut bits, header.satellites.len(), kind)?;
    let cells = Cells::read(&mut bits, header.cells.len(), kind)?;
    let mut out = Measured {
        station: header.station,
        tag: header.tag,
        more_follow: header.more_follow,
        signals: Vec::with_capacity(header.cells.len()),
        channels: Vec::new(),
        unknown: 0,
    };
    if system == System::Glonass {
        for (id, info) in header.satellites.iter().zip(&satellites.info) {
            if let (Some(id), Some(info @ 0..=13)) = (id, info) {
                out.channels.push((id.number(), *info as i8 - 7));
            }
        }
    }
    for (k, &(row, code)) in header.cells.iter().enumerate() {
        let (Some(satellite), Some(code)) = (header.satellites[row], code) else {
            out.unknown += 1;
            continue;
        };
        out.signals
            .push(cells.signal(k, (satellite, code), satellites.row(row)));
    }
    Some(out)
}

struct Header {
    station: u16,
    tag: TimeTag,
    more_follow: bool,
    /// Satellite of each row; `None` for reserved numbers.
    satellites: Vec<Option<SatelliteId>>,
    /// Row and signal of each cell; `None` for reserved signals.
    cells: Vec<(usize, Option<SignalCode>)>,
}

impl Header {
    fn read(bits: &mut BitCursor<'_>, system: System) -> Option<Self> {
        bits.skip(12)?;
        let station = bits.unsigned(12)? as u16;
        let time = bits.unsigned32(30)?;
        let tag = match system {
            // Three bits of the day of the week, then the time of day.
            System::Glonass => TimeTag::GlonassDay(time & 0x7FF_FFFF),
            System::Beidou => TimeTag::BeidouWeek(time),
            _ => TimeTag::GpsWeek(time),
        };
        let more_follow = bits.flag()?;
        // Issue of data, reserved, clock steering, external clock, smoothing and its interval.
        bits.skip(3 + 7 + 2 + 2 + 1 + 3)?;
        let satellites: Vec<Option<SatelliteId>> = set_bits(bits.unsigned(64)?, 64)
            .map(|number| satellite(system, number))
            .collect();
        let signals: Vec<Option<SignalCode>> = set_bits(bits.unsigned(32)?, 32)
            .map(|bit| signal(system, bit))
            .collect();
        if satellites.len() * signals.len() > MAX_CELLS {
            return None;
        }
        let mut cells = Vec::with_capacity(MAX_CELLS);
        for row in 0..satellites.len() {
            for &code in &signals {
                if bits.flag()? {
                    cells.push((row, code));
                }
            }
        }
        Some(Self {
            station,
            tag,
            more_follow,
            satellites,
            cells,
        })
    }
}

/// Positions, from 1 at the left, of the bits set in a mask of `width` bits.
fn set_bits(mask: u64, width: u8) -> impl Iterator<Item = u8> {
    (1..=width).filter(move |&place| mask >> (width - place) & 1 == 1)
}

/// Data of a message on each satellite.
struct Satellites {
    /// Rough range (ms); `None` where it is not valid.
    range_ms: Vec<Option<f64>>,
    /// Extended information (MSM5 and 7).
    info: Vec<Option<u64>>,
    /// Rough range rate (m/s).
    rate_m_s: Vec<Option<f64>>,
}

impl Satellites {
    fn read(bits: &mut BitCursor<'_>, count: usize, kind: u8) -> Option<Self> {
        let with_rates = matches!(kind, 5 | 7);
        let whole_ms = column(count, || bits.unsigned(8))?;
        let info = match with_rates {
            true => column(count, || bits.unsigned(4).map(Some))?,
            false => vec![None; count],
        };
        let fraction = column(count, || bits.unsigned(10))?;
        let rate_m_s = match with_rates {
            true => column(count, || valid(bits, 14))?,
            false => vec![None; count],
        };
        let range_ms = whole_ms
            .iter()
            .zip(fraction)
            .map(|(&ms, part)| (ms != 255).then_some(ms as f64 + part as f64 / 1024.0))
            .collect();
        Some(Self {
            range_ms,
            info,
            rate_m_s,
        })
    }

    fn row(&self, row: usize) -> Rough {
        Rough {
            range_ms: self.range_ms[row],
            rate_m_s: self.rate_m_s[row],
        }
    }
}

/// Data common to a satellite's signals.
#[derive(Clone, Copy)]
struct Rough {
    range_ms: Option<f64>,
    rate_m_s: Option<f64>,
}

/// Data of a message on each cell, in the units of its kind.
struct Cells {
    range_ms: Vec<Option<f64>>,
    phase_ms: Vec<Option<f64>>,
    least_lock_ms: Vec<u32>,
    half_cycle: Vec<bool>,
    cn0_db_hz: Vec<f64>,
    rate_m_s: Vec<Option<f64>>,
}

impl Cells {
    fn read(bits: &mut BitCursor<'_>, count: usize, kind: u8) -> Option<Self> {
        let fine = kind >= 6;
        let (range, phase) = if fine {
            ((20, -29), (24, -31))
        } else {
            ((15, -24), (22, -29))
        };
        let scaled = |bits: &mut BitCursor<'_>, (width, exponent): (usize, i32)| {
            Some(valid(bits, width)?.map(|steps| steps * 2f64.powi(exponent)))
        };
        Some(Self {
            range_ms: column(count, || scaled(bits, range))?,
            phase_ms: column(count, || scaled(bits, phase))?,
            least_lock_ms: column(count, || {
                Some(if fine {
                    least_of_10_bits_ms(bits.unsigned32(10)?)
                } else {
                    least_of_4_bits_ms(bits.unsigned32(4)?)
                })
            })?,
            half_cycle: column(count, || bits.flag())?,
            cn0_db_hz: column(count, || {
                Some(if fine {
                    bits.unsigned(10)? as f64 / 16.0
                } else {
                    bits.unsigned(6)? as f64
                })
            })?,
            rate_m_s: match kind {
                5 | 7 => column(count, || Some(valid(bits, 15)?.map(|steps| steps * 1e-4)))?,
                _ => vec![None; count],
            },
        })
    }

    fn signal(&self, k: usize, of: (SatelliteId, SignalCode), rough: Rough) -> MeasuredSignal {
        let metres = |fine_ms: Option<f64>| {
            rough
                .range_ms
                .zip(fine_ms)
                .map(|(rough_ms, fine_ms)| (rough_ms + fine_ms) * LIGHT_MILLISECOND_M)
        };
        MeasuredSignal {
            satellite: of.0,
            code: of.1,
            range_m: metres(self.range_ms[k]),
            phase: metres(self.phase_ms[k]).map(PhaseRange::Whole),
            rate_m_s: rough.rate_m_s.zip(self.rate_m_s[k]).map(|(a, b)| a + b),
            cn0_db_hz: Some(self.cn0_db_hz[k]).filter(|&cn0| cn0 > 0.0),
            least_lock_ms: self.least_lock_ms[k],
            half_cycle_unknown: self.half_cycle[k],
        }
    }
}

/// One field for every row of a block.
fn column<T>(count: usize, mut field: impl FnMut() -> Option<T>) -> Option<Vec<T>> {
    (0..count).map(|_| field()).collect()
}

/// A two's-complement field whose most negative value means "not valid".
fn valid(bits: &mut BitCursor<'_>, width: usize) -> Option<Option<f64>> {
    let steps = bits.signed(width)?;
    Some((steps != -1 << (width - 1)).then_some(steps as f64))
}
