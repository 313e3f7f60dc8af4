//! The kinds of log.

/// The kinds of log that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LogFormat {
    /// ArduPilot's DataFlash log, `.bin`.
    ArduPilot,
    /// PX4's ULog, `.ulg`.
    Px4,
    /// MAVLink telemetry as ground stations record it, `.tlog`.
    Mavlink,
    /// MCAP with messages of ROS 2.
    Mcap,
}

impl LogFormat {
    /// A name for messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ArduPilot => "ArduPilot log",
            Self::Px4 => "PX4 log",
            Self::Mavlink => "MAVLink telemetry log",
            Self::Mcap => "MCAP file of ROS 2",
        }
    }
}

impl std::fmt::Display for LogFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}
