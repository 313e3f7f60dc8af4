//! The GPS navigation message (IS-GPS-200, LNAV): rounding of its parameters, and its subframes.

use acerra_geo::time::GpsTime;
use acerra_gnss::{KeplerEphemeris, Klobuchar};
use std::f64::consts::PI;

/// π as the message's users must take it (IS-GPS-200, 20.3.3.4.3.3), to 14 digits.
#[expect(clippy::approx_constant, reason = "the interface fixes this value")]
const SEMICIRCLE_RAD: f64 = 3.141_592_653_589_8;

/// The ten 24-bit words of a subframe, parity removed.
pub(super) type Words = [u32; 10];

/// A scaled integer of the message: its place, width, sign and unit.
struct Field {
    subframe: usize,
    at: usize,
    bits: u32,
    signed: bool,
    unit: f64,
}

impl Field {
    /// The nearest integer that fits.
    fn raw(&self, value: f64) -> i64 {
        let (low, high) = if self.signed {
            (-(1_i64 << (self.bits - 1)), (1_i64 << (self.bits - 1)) - 1)
        } else {
            (0, (1_i64 << self.bits) - 1)
        };
        ((value / self.unit).round() as i64).clamp(low, high)
    }
}

const fn power(exponent: i32) -> f64 {
    // 2^exponent for the exponents of the message, exactly.
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

const fn field(subframe: usize, at: usize, bits: u32, signed: bool, exponent: i32) -> Field {
    Field {
        subframe,
        at,
        bits,
        signed,
        unit: power(exponent),
    }
}

const fn angle(subframe: usize, at: usize, bits: u32, exponent: i32) -> Field {
    Field {
        subframe,
        at,
        bits,
        signed: true,
        unit: power(exponent) * SEMICIRCLE_RAD,
    }
}

/// Every scaled parameter with its place in subframes 1 to 3.
const FIELDS: [Field; 20] = [
    field(1, 160, 8, true, -31),   // T_GD
    field(1, 192, 8, true, -55),   // a_f2
    field(1, 200, 16, true, -43),  // a_f1
    field(1, 216, 22, true, -31),  // a_f0
    field(2, 56, 16, true, -5),    // C_rs
    angle(2, 72, 16, -43),         // Δn
    angle(2, 88, 32, -31),         // M_0
    field(2, 120, 16, true, -29),  // C_uc
    field(2, 136, 32, false, -33), // e
    field(2, 168, 16, true, -29),  // C_us
    field(2, 184, 32, false, -19), // √A
    field(3, 48, 16, true, -29),   // C_ic
    angle(3, 64, 32, -31),         // Ω_0
    field(3, 96, 16, true, -29),   // C_is
    angle(3, 112, 32, -31),        // i_0
    field(3, 144, 16, true, -5),   // C_rc
    angle(3, 160, 32, -31),        // ω
    angle(3, 192, 24, -43),        // Ω̇
    angle(3, 224, 14, -43),        // i̇
    field(2, 216, 16, false, 4),   // t_oe
];

/// The parameters in the order of [`FIELDS`].
fn parameters(e: &mut KeplerEphemeris) -> [&mut f64; 20] {
    let [cuc, cus] = &mut e.latitude_correction_rad;
    let [crc, crs] = &mut e.radius_correction_m;
    let [cic, cis] = &mut e.inclination_correction_rad;
    let [af0, af1, af2] = &mut e.clock;
    [
        &mut e.group_delay_s[0],
        af2,
        af1,
        af0,
        crs,
        &mut e.mean_motion_correction_rad_s,
        &mut e.mean_anomaly_rad,
        cuc,
        &mut e.eccentricity,
        cus,
        &mut e.sqrt_semi_major_axis,
        cic,
        &mut e.ascending_node_rad,
        cis,
        &mut e.inclination_rad,
        crc,
        &mut e.perigee_rad,
        &mut e.ascending_node_rate_rad_s,
        &mut e.inclination_rate_rad_s,
        &mut e.toe_seconds_of_week,
    ]
}

/// Angles into −π…π, as the message holds them.
fn wrapped(mut e: KeplerEphemeris) -> KeplerEphemeris {
    for angle in [
        &mut e.mean_anomaly_rad,
        &mut e.ascending_node_rad,
        &mut e.perigee_rad,
    ] {
        *angle = (*angle + PI).rem_euclid(2.0 * PI) - PI;
    }
    e
}

/// The ephemeris with every number rounded as in the message.
pub(super) fn quantised(ephemeris: &KeplerEphemeris) -> KeplerEphemeris {
    let mut e = wrapped(*ephemeris);
    for (field, value) in FIELDS.iter().zip(parameters(&mut e)) {
        *value = field.raw(*value) as f64 * field.unit;
    }
    e
}

/// Writes `bits` bits of `value` from bit `at` of the 240 data bits on.
fn put(words: &mut Words, at: usize, bits: u32, value: i64) {
    for i in 0..bits as usize {
        let bit = (value >> (bits as usize - 1 - i)) as u32 & 1;
        let place = at + i;
        words[place / 24] |= bit << (23 - place % 24);
    }
}

/// Telemetry and hand-over words of a subframe `id` that ends at `end`.
fn header(id: u8, end: GpsTime) -> Words {
    let mut words = [0; 10];
    put(&mut words, 0, 8, 0x8B);
    put(&mut words, 24, 17, (end.seconds() / 6).rem_euclid(100_800));
    put(&mut words, 43, 3, i64::from(id));
    words
}

/// Subframe 1, 2 or 3 of an ephemeris, ending at `end`.
pub(super) fn ephemeris_subframe(e: &KeplerEphemeris, id: u8, end: GpsTime) -> Words {
    let mut words = header(id, end);
    let mut e = wrapped(*e);
    let (iode, iodc) = (i64::from(e.iode & 255), i64::from(e.iodc & 1023));
    match id {
        1 => {
            put(&mut words, 48, 10, e.toe.week().rem_euclid(1024));
            put(&mut words, 58, 2, 1); // P code on L2
            put(&mut words, 60, 4, accuracy_index(e.accuracy_m));
            put(&mut words, 64, 6, i64::from(e.health & 63));
            put(&mut words, 70, 2, iodc >> 8);
            put(&mut words, 168, 8, iodc & 255);
            put(&mut words, 176, 16, (e.toc.tow_s() / 16.0).round() as i64);
        }
        2 => put(&mut words, 48, 8, iode),
        _ => put(&mut words, 216, 8, iode),
    }
    for (field, value) in FIELDS.iter().zip(parameters(&mut e)) {
        if field.subframe == usize::from(id) {
            put(&mut words, field.at, field.bits, field.raw(*value));
        }
    }
    words
}

/// Subframe 4 or 5 as sent in the frame that ends at `end`: page 18 of subframe 4 carries the
/// ionosphere and UTC, every other page a dummy satellite (number 0, alternating bits).
pub(super) fn page_subframe(id: u8, end: GpsTime, klobuchar: Option<Klobuchar>) -> Words {
    let mut words = header(id, end);
    put(&mut words, 48, 2, 1); // data identification
    let page = (end.seconds() - 1).div_euclid(30).rem_euclid(25) + 1;
    match klobuchar {
        Some(ionosphere) if id == 4 && page == 18 => {
            put(&mut words, 50, 6, 56);
            let scales = [-30, -27, -24, -24, 11, 14, 16, 16];
            let values = ionosphere.alpha.into_iter().chain(ionosphere.beta);
            for (i, (value, exponent)) in values.zip(scales).enumerate() {
                let place = field(4, 56 + 8 * i, 8, true, exponent);
                put(&mut words, place.at, place.bits, place.raw(value));
            }
            let leap = end.gpst_minus_utc_s();
            put(&mut words, 176, 8, (end.tow_s() / 4096.0) as i64);
            put(&mut words, 184, 8, end.week() & 255);
            put(&mut words, 192, 8, leap);
            put(&mut words, 200, 8, end.week() & 255);
            put(&mut words, 208, 8, 7);
            put(&mut words, 216, 8, leap);
        }
        _ => {
            for place in 56..238 {
                put(&mut words, place, 1, (place % 2) as i64);
            }
        }
    }
    words
}

/// Upper limits of the accuracy indices 0 to 14 (m).
const ACCURACY_M: [f64; 15] = [
    2.4, 3.4, 4.85, 6.85, 9.65, 13.65, 24.0, 48.0, 96.0, 192.0, 384.0, 768.0, 1536.0, 3072.0,
    6144.0,
];

fn accuracy_index(accuracy_m: f64) -> i64 {
    ACCURACY_M
        .iter()
        .position(|limit| accuracy_m <= *limit)
        .unwrap_or(15) as i64
}
