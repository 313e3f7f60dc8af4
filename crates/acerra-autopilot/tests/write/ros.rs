//! MCAP files with messages of ROS 2, byte by byte as mcap.dev and the Common Data Representation lay them
//! out.

use std::io::Write;

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];

fn text(value: &str) -> Vec<u8> {
    let mut out = (value.len() as u32).to_le_bytes().to_vec();
    out.extend(value.as_bytes());
    out
}

/// A record.
pub fn record(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut out = vec![kind];
    out.extend((content.len() as u64).to_le_bytes());
    out.extend(content);
    out
}

/// The mark and the header.
pub fn head() -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    let mut header = text("ros2");
    header.extend(text("libmcap 1.3.0"));
    out.extend(record(1, &header));
    out
}

/// The end of a file that was closed, without a summary.
pub fn end() -> Vec<u8> {
    let mut out = record(0x0f, &[0; 4]);
    out.extend(record(2, &[0; 20]));
    out.extend(MAGIC);
    out
}

/// A schema and a channel of it, both of number `id`.
pub fn topic(id: u16, name: &str, schema: &str, encoding: &str) -> Vec<u8> {
    let mut content = id.to_le_bytes().to_vec();
    content.extend(text(schema));
    content.extend(text("ros2msg"));
    content.extend(text("# the definition's text"));
    let mut out = record(3, &content);
    let mut content = id.to_le_bytes().to_vec();
    content.extend(id.to_le_bytes());
    content.extend(text(name));
    content.extend(text(encoding));
    content.extend(0_u32.to_le_bytes());
    out.extend(record(4, &content));
    out
}

/// A message, logged at another time than it is stamped.
pub fn message(id: u16, content: &[u8]) -> Vec<u8> {
    let mut out = id.to_le_bytes().to_vec();
    out.extend(1_u32.to_le_bytes());
    out.extend(1_800_000_000_000_000_000_u64.to_le_bytes());
    out.extend(1_800_000_000_000_000_000_u64.to_le_bytes());
    out.extend(content);
    record(5, &out)
}

/// A chunk of records, packed as its name says.
pub fn chunk(records: &[u8], compression: &str) -> Vec<u8> {
    let packed = match compression {
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(records).unwrap();
            encoder.finish().unwrap()
        }
        "zstd" => {
            let level = ruzstd::encoding::CompressionLevel::Fastest;
            ruzstd::encoding::compress_to_vec(records, level)
        }
        _ => records.to_vec(),
    };
    let mut out = [0; 16].to_vec();
    out.extend((records.len() as u64).to_le_bytes());
    out.extend(crc32fast::hash(records).to_le_bytes());
    out.extend(text(compression));
    out.extend((packed.len() as u64).to_le_bytes());
    out.extend(packed);
    record(6, &out)
}

/// Writes numbers at multiples of their length.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new(seconds: i32, nanos: u32, frame: &str) -> Self {
        let mut cdr = Self(vec![0, 1, 0, 0]);
        cdr.put(&seconds.to_le_bytes());
        cdr.put(&nanos.to_le_bytes());
        cdr.text(frame);
        cdr
    }

    fn put(&mut self, value: &[u8]) {
        while !(self.0.len() - 4).is_multiple_of(value.len()) {
            self.0.push(0);
        }
        self.0.extend(value);
    }

    fn text(&mut self, value: &str) {
        self.put(&(value.len() as u32 + 1).to_le_bytes());
        self.0.extend(value.as_bytes());
        self.0.push(0);
    }

    fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.put(&v.to_le_bytes()));
    }
}

/// When a message is stamped: seconds and nanoseconds.
pub type Stamp = (i32, u32);

/// NavSatFix: latitude, longitude (degrees), height above the ellipsoid (m), deviations (m).
pub fn fix((seconds, nanos): Stamp, status: i8, place: [f64; 3], sigma_m: [f64; 3]) -> Vec<u8> {
    let mut cdr = Cdr::new(seconds, nanos, "gps");
    cdr.put(&[status as u8]);
    cdr.put(&15_u16.to_le_bytes());
    cdr.f64s(&place);
    let [e, n, u] = sigma_m.map(|s| s * s);
    cdr.f64s(&[e, 0.0, 0.0, 0.0, n, 0.0, 0.0, 0.0, u]);
    cdr.put(&[2]);
    cdr.0
}

/// Imu with an orientation (x, y, z, w).
pub fn imu((seconds, nanos): Stamp, quaternion: [f64; 4], first_covariance: f64) -> Vec<u8> {
    let mut cdr = Cdr::new(seconds, nanos, "imu_link");
    cdr.f64s(&quaternion);
    cdr.f64s(&[first_covariance, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1]);
    cdr.f64s(&[0.0; 24]);
    cdr.0
}

/// Odometry: position (m), orientation (x, y, z, w).
pub fn odometry((seconds, nanos): Stamp, position_m: [f64; 3], quaternion: [f64; 4]) -> Vec<u8> {
    let mut cdr = Cdr::new(seconds, nanos, "odom");
    cdr.text("base_link");
    cdr.f64s(&position_m);
    cdr.f64s(&quaternion);
    let mut covariance = [0.0; 36];
    for k in [0, 7, 14] {
        covariance[k] = 0.01;
    }
    cdr.f64s(&covariance);
    cdr.f64s(&[0.0; 42]);
    cdr.0
}

/// QuaternionStamped (x, y, z, w).
pub fn quaternion((seconds, nanos): Stamp, quaternion: [f64; 4]) -> Vec<u8> {
    let mut cdr = Cdr::new(seconds, nanos, "gimbal_link");
    cdr.f64s(&quaternion);
    cdr.0
}
