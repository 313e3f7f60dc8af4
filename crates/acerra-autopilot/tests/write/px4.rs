//! ULog files, byte by byte as the PX4 User Guide lays them out ("ULog File Format").

/// A message: length, type, content.
pub fn message(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut out = u16::try_from(content.len()).unwrap().to_le_bytes().to_vec();
    out.push(kind);
    out.extend(content);
    out
}

/// The file's header, and the flags with the place of appended data.
pub fn head(appended_at: u64) -> Vec<u8> {
    let mut out = b"ULog\x01\x12\x35\x01".to_vec();
    out.extend(112_574_307_u64.to_le_bytes());
    let mut flags = vec![0; 40];
    flags[8] = u8::from(appended_at > 0);
    flags[16..24].copy_from_slice(&appended_at.to_le_bytes());
    out.extend(message(b'B', &flags));
    out
}

/// A definition.
pub fn format(text: &str) -> Vec<u8> {
    message(b'F', text.as_bytes())
}

/// A subscription.
pub fn subscribe(id: u16, instance: u8, topic: &str) -> Vec<u8> {
    let mut content = vec![instance];
    content.extend(id.to_le_bytes());
    content.extend(topic.as_bytes());
    message(b'A', &content)
}

/// Definition of a receiver's message before version 1.14, in the order of PX4's `uORB`: long fields first.
pub const OLD_GPS: &str = "vehicle_gps_position:uint64_t timestamp;uint64_t time_utc_usec;int32_t lat;int32_t lon;\
    int32_t alt;int32_t alt_ellipsoid;float s_variance_m_s;float eph;float epv;float vel_n_m_s;float vel_e_m_s;\
    float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;uint8_t satellites_used;uint8_t[5] _padding0;";
/// The same since.
pub const NEW_GPS: &str = "sensor_gps:uint64_t timestamp;uint64_t timestamp_sample;double latitude_deg;\
    double longitude_deg;double altitude_msl_m;double altitude_ellipsoid_m;uint64_t time_utc_usec;float eph;float epv;\
    float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;uint8_t satellites_used;\
    uint8_t[5] _padding0;";
/// Definition of the attitude.
pub const ATTITUDE: &str = "vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;\
    float[4] delta_q_reset;uint8_t quat_reset_counter;uint8_t[7] _padding0;";
/// Definition of the filter's position.
pub const GLOBAL: &str = "vehicle_global_position:uint64_t timestamp;uint64_t timestamp_sample;double lat;double lon;\
    float alt;float alt_ellipsoid;float eph;float epv;bool dead_reckoning;uint8_t[7] _padding0;";

/// What a receiver says at one instant.
#[derive(Clone, Copy)]
pub struct Gps {
    pub boot_us: u64,
    pub utc_us: u64,
    pub fix_type: u8,
    /// Latitude and longitude (degrees), height above the ellipsoid (m).
    pub place: [f64; 3],
    /// Height of the sea above the ellipsoid (m).
    pub geoid_m: f64,
    /// East, north, up (m/s).
    pub velocity_m_s: [f64; 3],
}

fn tail(out: &mut Vec<u8>, gps: &Gps) {
    let [e, n, u] = gps.velocity_m_s;
    for value in [0.012, 0.02, n, e, -u] {
        out.extend((value as f32).to_le_bytes());
    }
    out.extend([gps.fix_type, 1, 19]);
}

/// A receiver's message before version 1.14.
pub fn old_gps(id: u16, gps: &Gps) -> Vec<u8> {
    let [latitude, longitude, height_m] = gps.place;
    let mut out = id.to_le_bytes().to_vec();
    out.extend(gps.boot_us.to_le_bytes());
    out.extend(gps.utc_us.to_le_bytes());
    for value in [
        latitude * 1e7,
        longitude * 1e7,
        (height_m - gps.geoid_m) * 1e3,
        height_m * 1e3,
    ] {
        out.extend((value.round() as i32).to_le_bytes());
    }
    out.extend(0.1_f32.to_le_bytes());
    tail(&mut out, gps);
    message(b'D', &out)
}

/// A receiver's message since version 1.14.
pub fn new_gps(id: u16, gps: &Gps) -> Vec<u8> {
    let [latitude, longitude, height_m] = gps.place;
    let mut out = id.to_le_bytes().to_vec();
    out.extend(gps.boot_us.to_le_bytes());
    out.extend(0_u64.to_le_bytes());
    for value in [latitude, longitude, height_m - gps.geoid_m, height_m] {
        out.extend(value.to_le_bytes());
    }
    out.extend(gps.utc_us.to_le_bytes());
    tail(&mut out, gps);
    message(b'D', &out)
}

/// An attitude of roll, pitch and yaw (rad), sampled 2 ms before it was published.
pub fn attitude(id: u16, sample_us: u64, [roll, pitch, yaw]: [f64; 3]) -> Vec<u8> {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(|a| (0.5 * a).sin_cos());
    let mut out = id.to_le_bytes().to_vec();
    out.extend((sample_us + 2000).to_le_bytes());
    out.extend(sample_us.to_le_bytes());
    for value in [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        1.0,
        0.0,
        0.0,
        0.0,
    ] {
        out.extend((value as f32).to_le_bytes());
    }
    out.push(0);
    message(b'D', &out)
}

/// A position of the filter, its height above the sea and above the ellipsoid.
pub fn global(id: u16, sample_us: u64, place: [f64; 3], geoid_m: f64) -> Vec<u8> {
    let mut out = id.to_le_bytes().to_vec();
    out.extend((sample_us + 2000).to_le_bytes());
    out.extend(sample_us.to_le_bytes());
    out.extend(place[0].to_le_bytes());
    out.extend(place[1].to_le_bytes());
    for value in [place[2] - geoid_m, place[2], 0.3, 0.4] {
        out.extend((value as f32).to_le_bytes());
    }
    out.push(0);
    message(b'D', &out)
}

/// Definition of a gimbal's attitude since version 1.14.
pub const GIMBAL: &str = "gimbal_device_attitude_status:uint64_t timestamp;float[4] q;float angular_velocity_x;\
    float angular_velocity_y;float angular_velocity_z;uint32_t failure_flags;float delta_yaw;\
    float delta_yaw_velocity;uint16_t device_flags;uint8_t target_system;uint8_t target_component;\
    uint8_t gimbal_device_id;bool received_from_mavlink;uint8_t[6] _padding0;";

/// An attitude of a gimbal (w, x, y, z) with its flags, and the vehicle's heading (rad).
pub fn gimbal(id: u16, us: u64, quaternion: [f64; 4], flags: u16, heading_rad: f64) -> Vec<u8> {
    let mut out = id.to_le_bytes().to_vec();
    out.extend(us.to_le_bytes());
    for value in quaternion.into_iter().chain([0.0; 3]) {
        out.extend((value as f32).to_le_bytes());
    }
    out.extend(0_u32.to_le_bytes());
    out.extend((heading_rad as f32).to_le_bytes());
    out.extend(0_f32.to_le_bytes());
    out.extend(flags.to_le_bytes());
    out.extend([0, 0, 0, 1]);
    message(b'D', &out)
}
