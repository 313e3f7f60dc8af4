//! ArduPilot logs, byte by byte as `AP_Logger/LogStructure.h` and `AP_GPS/LogStructure.h` lay them out.

/// A record that defines a type.
pub fn fmt(number: u8, name: &str, codes: &str, labels: &str) -> Vec<u8> {
    let size = |code: char| match code {
        'B' | 'b' | 'M' => 1,
        'c' | 'C' | 'h' | 'H' => 2,
        'Q' | 'q' | 'd' => 8,
        'N' => 16,
        'Z' => 64,
        _ => 4,
    };
    let length: usize = 3 + codes.chars().map(size).sum::<usize>();
    let mut out = vec![0xa3, 0x95, 128, number, u8::try_from(length).unwrap()];
    for (text, room) in [(name, 4), (codes, 16), (labels, 64)] {
        let mut field = text.as_bytes().to_vec();
        field.resize(room, 0);
        out.extend(field);
    }
    out
}

/// Types of the records written here.
pub const GPS: u8 = 130;
pub const GPA: u8 = 131;
pub const ATT: u8 = 132;
pub const POS: u8 = 133;
pub const MSG: u8 = 134;
pub const MNT: u8 = 135;
pub const PARM: u8 = 136;

/// The definitions at a log's head.
pub fn head() -> Vec<u8> {
    let mut out = fmt(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
    out.extend(fmt(
        GPS,
        "GPS",
        "QBBIHBcLLeffffB",
        "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U",
    ));
    out.extend(fmt(
        GPA,
        "GPA",
        "QBCCCCfBIHfHH",
        "TimeUS,I,VDop,HAcc,VAcc,SAcc,YAcc,VV,SMS,Delta,Und,RTCMFU,RTCMFD",
    ));
    out.extend(fmt(
        ATT,
        "ATT",
        "QffffffB",
        "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,AEKF",
    ));
    out.extend(fmt(
        POS,
        "POS",
        "QLLfff",
        "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt",
    ));
    out.extend(fmt(MSG, "MSG", "QZ", "TimeUS,Message"));
    out.extend(fmt(
        MNT,
        "MNT",
        "QBfffffffff",
        "TimeUS,I,DRoll,Roll,DPitch,Pitch,DYawB,YawB,DYawE,YawE,Dist",
    ));
    out.extend(fmt(PARM, "PARM", "QNff", "TimeUS,Name,Value,Default"));
    out
}

fn begin(kind: u8, boot_s: f64) -> Vec<u8> {
    let mut out = vec![0xa3, 0x95, kind];
    out.extend(((boot_s * 1e6).round() as u64).to_le_bytes());
    out
}

fn degrees(value: f64) -> [u8; 4] {
    ((value * 1e7).round() as i32).to_le_bytes()
}

/// What a receiver says at one instant.
#[derive(Clone, Copy)]
pub struct Gps {
    pub instance: u8,
    pub status: u8,
    pub week: u16,
    pub week_ms: u32,
    /// Latitude and longitude (degrees), height above the sea (m).
    pub place: [f64; 3],
    /// East, north, up (m/s).
    pub velocity_m_s: [f64; 3],
}

/// A record `GPS`.
pub fn gps(boot_s: f64, fix: &Gps) -> Vec<u8> {
    let mut out = begin(GPS, boot_s);
    out.extend([fix.instance, fix.status]);
    out.extend(fix.week_ms.to_le_bytes());
    out.extend(fix.week.to_le_bytes());
    out.push(21);
    out.extend(70_i16.to_le_bytes());
    out.extend(degrees(fix.place[0]));
    out.extend(degrees(fix.place[1]));
    out.extend(((fix.place[2] * 100.0).round() as i32).to_le_bytes());
    let [e, n, u] = fix.velocity_m_s;
    let course_deg = e.atan2(n).to_degrees().rem_euclid(360.0);
    for value in [e.hypot(n), course_deg, -u, 0.0] {
        out.extend((value as f32).to_le_bytes());
    }
    out.push(1);
    out
}

/// A record `GPA`; the height above the sea less that above the ellipsoid is `undulation_m`.
pub fn gpa(boot_s: f64, instance: u8, [h_m, v_m]: [f64; 2], undulation_m: f64) -> Vec<u8> {
    let mut out = begin(GPA, boot_s);
    out.push(instance);
    for value in [1.1, h_m, v_m, 0.1] {
        out.extend(((value * 100.0_f64).round() as u16).to_le_bytes());
    }
    out.extend(0_f32.to_le_bytes());
    out.push(1);
    out.extend(((boot_s * 1e3) as u32).to_le_bytes());
    out.extend(200_u16.to_le_bytes());
    out.extend((undulation_m as f32).to_le_bytes());
    out.extend([0; 4]);
    out
}

/// A record `ATT` of roll, pitch and yaw (rad).
pub fn att(boot_s: f64, [roll, pitch, yaw]: [f64; 3]) -> Vec<u8> {
    let mut out = begin(ATT, boot_s);
    for angle in [roll, pitch, yaw.rem_euclid(std::f64::consts::TAU)] {
        out.extend(0_f32.to_le_bytes());
        out.extend((angle.to_degrees() as f32).to_le_bytes());
    }
    out.push(3);
    out
}

/// A record `POS` of latitude and longitude (degrees) and height above the sea (m).
pub fn pos(boot_s: f64, place: [f64; 3]) -> Vec<u8> {
    let mut out = begin(POS, boot_s);
    out.extend(degrees(place[0]));
    out.extend(degrees(place[1]));
    for height in [place[2], 0.0, 0.0] {
        out.extend((height as f32).to_le_bytes());
    }
    out
}

/// A record `MSG`, which nobody reads here.
pub fn msg(boot_s: f64, text: &str) -> Vec<u8> {
    let mut out = begin(MSG, boot_s);
    let mut field = text.as_bytes().to_vec();
    field.resize(64, 0);
    out.extend(field);
    out
}

/// A record `MNT` of actual roll and pitch, and yaw from the nose and from north (rad); what was asked for is
/// something else.
pub fn mnt(boot_s: f64, instance: u8, angles_rad: [f64; 4]) -> Vec<u8> {
    let mut out = begin(MNT, boot_s);
    out.push(instance);
    for angle in angles_rad {
        out.extend(77_f32.to_le_bytes());
        out.extend((angle.to_degrees() as f32).to_le_bytes());
    }
    out.extend(f32::NAN.to_le_bytes());
    out
}

/// A record `PARM`.
pub fn parm(boot_s: f64, name: &str, value: f64) -> Vec<u8> {
    let mut out = begin(PARM, boot_s);
    let mut field = name.as_bytes().to_vec();
    field.resize(16, 0);
    out.extend(field);
    for value in [value, 0.0] {
        out.extend((value as f32).to_le_bytes());
    }
    out
}
