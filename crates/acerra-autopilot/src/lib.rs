//! Trajectory and attitude from the logs that autopilots and robots leave, recognised from content.
//!
//! ```text
//! bytes ──ardupilot──► Recording ──choose──► one source of positions, one of attitudes
//!                      (samples by source)        │
//!                      clock readings ──fit──► GPS time of both ──assemble──► Trajectory, LogReport
//! ```
//!
//! | format | positions | attitude | gimbal | time |
//! | --- | --- | --- | --- | --- |
//! | ArduPilot `.bin` | `GPS` with `GPA`; `POS` | `ATT` | `MNT` | GPS week and milliseconds in `GPS` |
//! | PX4 `.ulg` | `vehicle_gps_position`, `sensor_gps`; `vehicle_global_position` | `vehicle_attitude` | `gimbal_device_attitude_status` | UTC in the receiver's messages |
//! | MAVLink `.tlog` | `GPS_RAW_INT`, `GPS2_RAW`; `GLOBAL_POSITION_INT` | `ATTITUDE` | `GIMBAL_DEVICE_ATTITUDE_STATUS`, `MOUNT_ORIENTATION` | UTC in `SYSTEM_TIME` |
//! | MCAP of ROS 2 | `sensor_msgs/NavSatFix`; `nav_msgs/Odometry` | `sensor_msgs/Imu`, `nav_msgs/Odometry` | the named topic of these or `geometry_msgs/QuaternionStamped` | stamps of the headers, taken as UTC |
//!
//! Which positions: those of the GNSS receiver, as they carry GPS time and the kind and accuracy of their
//! solution; the filter's (`source = "ekf"`) where there is no receiver or where the source is named. Where
//! there are several of a kind, [`LogOptions::source`] names one.
//!
//! The attitude of a gimbal is read where [`LogOptions::gimbal`] asks for it; positions and lever arm stay the
//! vehicle's.
//!
//! Heights: a source's heights count from the ellipsoid or from the sea, never both; heights from the sea are
//! raised by a grid of the geoid, with a warning where there is none.
//!
//! All times are converted to GPS time. Positions with GPS time keep it; stamps by the autopilot's clock are
//! converted by a robust fit through the readings of both clocks in the log.
//!
//! Damaged data are skipped and counted, up to a twentieth of the file; a file that ends within a record is
//! refused with the byte at which it may be cut.

mod ardupilot;
mod assemble;
mod attitudes;
mod bytes;
mod choose;
mod clock;
mod collect;
mod error;
mod format;
mod gimbal;
mod height;
mod mavlink;
mod options;
mod px4;
mod remarks;
mod report;
mod ros;
mod sample;
mod timeline;

use std::io::Read;

use acerra_geo::trajectory::Trajectory;

pub use attitudes::LogAttitudes;
pub use error::LogError;
pub use format::LogFormat;
pub use options::{GimbalChoice, LogOptions};
pub use report::{AttitudeSummary, ClockSummary, LogReport, LogWarning, SourceSummary};
pub use sample::{Damage, HeightDatum, PairKind, SourceKind};

use assemble::Assembled;
use bytes::LogBytes;

/// Number of bytes of a file for [`sniff`].
pub const SNIFF_BYTES: usize = 512;

/// The kind of log that begins like this; none when no reader knows it.
///
/// ```
/// use acerra_autopilot::{LogFormat, sniff};
/// assert_eq!(sniff(b"\xa3\x95\x80\x80\x59FMT\0BBnNZ"), Some(LogFormat::ArduPilot));
/// assert_eq!(sniff(b"time_s,x_m,y_m,z_m\n"), None);
/// ```
#[must_use]
pub fn sniff(start: &[u8]) -> Option<LogFormat> {
    let kinds = [
        (ardupilot::begins(start), LogFormat::ArduPilot),
        (px4::begins(start), LogFormat::Px4),
        (mavlink::begins(start), LogFormat::Mavlink),
        (ros::begins(start), LogFormat::Mcap),
    ];
    let known = kinds.iter().find(|(is_known, _)| *is_known);
    known.map(|(_, format)| *format)
}

/// Reads a log of any known format.
///
/// The input is read once, front to back, in the memory of its positions, attitudes and clock readings.
///
/// # Errors
/// [`LogError`], with the byte if there is one; the caller adds the path.
pub fn read_log(
    reader: impl Read,
    options: &LogOptions,
) -> Result<(Trajectory, LogReport), LogError> {
    let log = read(reader, options)?;
    Ok((log.trajectory, log.report))
}

/// Reads a log for its attitudes, for use with positions of another source; the log's own positions are
/// returned for comparison.
///
/// # Errors
/// As [`read_log`]. A log without positions is refused: they carry its GPS time.
pub fn read_attitudes(
    reader: impl Read,
    options: &LogOptions,
) -> Result<(LogAttitudes, Trajectory, LogReport), LogError> {
    let options = options.clone().for_attitudes();
    let log = read(reader, &options)?;
    Ok((log.attitudes, log.trajectory, log.report))
}

fn read(reader: impl Read, options: &LogOptions) -> Result<Assembled, LogError> {
    let mut bytes = LogBytes::new(reader);
    let start = bytes.peek(SNIFF_BYTES)?;
    if start.is_empty() {
        return Err(LogError::Empty);
    }
    let recording = match sniff(start) {
        Some(LogFormat::ArduPilot) => ardupilot::read(&mut bytes, options.max_samples)?,
        Some(LogFormat::Px4) => px4::read(&mut bytes, options.max_samples)?,
        Some(LogFormat::Mavlink) => mavlink::read(&mut bytes, options.max_samples)?,
        Some(LogFormat::Mcap) => ros::read(&mut bytes, options.max_samples)?,
        None => return Err(LogError::unrecognised(start)),
    };
    assemble::assemble(&recording, options)
}
