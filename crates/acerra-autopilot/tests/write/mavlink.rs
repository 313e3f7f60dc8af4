//! MAVLink telemetry logs, byte by byte as the MAVLink Developer Guide and `common.xml` lay them out.

fn checksum(bytes: &[u8]) -> u16 {
    // CRC-16/MCRF4XX bit by bit.
    let mut crc = 0xffff_u16;
    for byte in bytes {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 {
                (crc >> 1) ^ 0x8408
            } else {
                crc >> 1
            };
        }
    }
    crc
}

/// Who sends a packet.
#[derive(Clone, Copy)]
pub struct Sender {
    pub version: u8,
    pub system: u8,
    pub component: u8,
}

/// The autopilot of the first vehicle.
pub const AUTOPILOT: Sender = Sender {
    version: 2,
    system: 1,
    component: 1,
};

/// A packet behind the ground station's stamp (µs since 1970).
pub fn packet(
    stamp_us: u64,
    sender: Sender,
    (message, extra): (u32, u8),
    payload: &[u8],
) -> Vec<u8> {
    let mut packet = Vec::new();
    if sender.version == 1 {
        packet.extend([
            0xfe,
            payload.len() as u8,
            0,
            sender.system,
            sender.component,
            message as u8,
        ]);
        packet.extend(payload);
    } else {
        // Zeros at the end are left out, but for the first byte.
        let end = payload
            .iter()
            .rposition(|b| *b != 0)
            .map_or(1, |last| last + 1);
        let [a, b, c, _] = message.to_le_bytes();
        packet.extend([
            0xfd,
            end as u8,
            0,
            0,
            7,
            sender.system,
            sender.component,
            a,
            b,
            c,
        ]);
        packet.extend(&payload[..end]);
    }
    let mut checked = packet[1..].to_vec();
    checked.push(extra);
    packet.extend(checksum(&checked).to_le_bytes());
    let mut out = stamp_us.to_be_bytes().to_vec();
    out.extend(packet);
    out
}

/// HEARTBEAT.
pub fn heartbeat() -> ((u32, u8), Vec<u8>) {
    ((0, 50), vec![0, 0, 0, 0, 2, 3, 81, 4, 3])
}

/// SYSTEM_TIME.
pub fn system_time(unix_us: u64, boot_ms: u32) -> ((u32, u8), Vec<u8>) {
    let mut out = unix_us.to_le_bytes().to_vec();
    out.extend(boot_ms.to_le_bytes());
    ((2, 137), out)
}

/// ATTITUDE of roll, pitch and yaw (rad).
pub fn attitude(boot_ms: u32, euler_rad: [f64; 3]) -> ((u32, u8), Vec<u8>) {
    let mut out = boot_ms.to_le_bytes().to_vec();
    for value in euler_rad.into_iter().chain([0.01; 3]) {
        out.extend((value as f32).to_le_bytes());
    }
    ((30, 39), out)
}

fn degrees(value: f64) -> [u8; 4] {
    ((value * 1e7).round() as i32).to_le_bytes()
}

fn millimetres(value: f64) -> [u8; 4] {
    ((value * 1e3).round() as i32).to_le_bytes()
}

/// GLOBAL_POSITION_INT: latitude and longitude (degrees), height above the sea (m), velocity east, north,
/// up (m/s).
pub fn global(boot_ms: u32, place: [f64; 3], [e, n, u]: [f64; 3]) -> ((u32, u8), Vec<u8>) {
    let mut out = boot_ms.to_le_bytes().to_vec();
    out.extend(degrees(place[0]));
    out.extend(degrees(place[1]));
    out.extend(millimetres(place[2]));
    out.extend(millimetres(10.0));
    for value in [n, e, -u] {
        out.extend(((value * 100.0).round() as i16).to_le_bytes());
    }
    out.extend(9000_u16.to_le_bytes());
    ((33, 104), out)
}

/// What a receiver says.
#[derive(Clone, Copy)]
pub struct Gps {
    pub time_us: u64,
    pub fix_type: u8,
    /// Latitude and longitude (degrees), height above the sea (m).
    pub place: [f64; 3],
    /// Height above the ellipsoid (m), 0 where it is not known.
    pub above_ellipsoid_m: f64,
}

/// GPS_RAW_INT.
pub fn gps_raw(gps: &Gps) -> ((u32, u8), Vec<u8>) {
    let mut out = gps.time_us.to_le_bytes().to_vec();
    out.extend(degrees(gps.place[0]));
    out.extend(degrees(gps.place[1]));
    out.extend(millimetres(gps.place[2]));
    for value in [80_u16, 120, 300, 4500] {
        out.extend(value.to_le_bytes());
    }
    out.extend([gps.fix_type, 17]);
    out.extend(millimetres(gps.above_ellipsoid_m));
    for value in [14_u32, 25, 100, 0] {
        out.extend(value.to_le_bytes());
    }
    out.extend(0_u16.to_le_bytes());
    ((24, 24), out)
}

/// GPS2_RAW.
pub fn gps2_raw(gps: &Gps) -> ((u32, u8), Vec<u8>) {
    let mut out = gps.time_us.to_le_bytes().to_vec();
    out.extend(degrees(gps.place[0]));
    out.extend(degrees(gps.place[1]));
    out.extend(millimetres(gps.place[2]));
    out.extend(0_u32.to_le_bytes());
    for value in [80_u16, 120, 300, 4500] {
        out.extend(value.to_le_bytes());
    }
    out.extend([gps.fix_type, 12, 0]);
    out.extend(0_u16.to_le_bytes());
    out.extend(millimetres(gps.above_ellipsoid_m));
    for value in [30_u32, 50, 100, 0] {
        out.extend(value.to_le_bytes());
    }
    ((124, 87), out)
}

/// What a gimbal device says of itself.
#[derive(Clone, Copy)]
pub struct GimbalStatus {
    pub boot_ms: u32,
    pub flags: u16,
    pub failures: u32,
    /// w, x, y, z.
    pub quaternion: [f64; 4],
    /// Heading of the vehicle (rad), and number of the device; none as senders of older definitions leave them out.
    pub extension: Option<(f64, u8)>,
}

/// GIMBAL_DEVICE_ATTITUDE_STATUS.
pub fn gimbal_status(status: &GimbalStatus) -> ((u32, u8), Vec<u8>) {
    let mut out = status.boot_ms.to_le_bytes().to_vec();
    let rates = [f64::NAN; 3];
    for value in status.quaternion.into_iter().chain(rates) {
        out.extend((value as f32).to_le_bytes());
    }
    out.extend(status.failures.to_le_bytes());
    out.extend(status.flags.to_le_bytes());
    out.extend([255, 190]);
    if let Some((delta_yaw_rad, device)) = status.extension {
        out.extend((delta_yaw_rad as f32).to_le_bytes());
        out.extend(f32::NAN.to_le_bytes());
        out.push(device);
    }
    ((285, 137), out)
}

/// MOUNT_ORIENTATION of roll, pitch, yaw from the nose and, where it is told, from north (rad).
pub fn mount_orientation(boot_ms: u32, angles_rad: &[f64]) -> ((u32, u8), Vec<u8>) {
    let mut out = boot_ms.to_le_bytes().to_vec();
    for angle in angles_rad {
        out.extend((angle.to_degrees() as f32).to_le_bytes());
    }
    ((265, 26), out)
}
