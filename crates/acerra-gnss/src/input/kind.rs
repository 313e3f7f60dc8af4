//! Kinds of files.

use std::fmt;

/// Kind of a file by its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileKind {
    /// RINEX observation data.
    RinexObservation,
    /// RINEX navigation data (of any system).
    RinexNavigation,
    /// RINEX satellite and station clocks.
    RinexClock,
    /// RINEX of another type (meteorological …).
    RinexOther,
    /// Hatanaka-compressed RINEX observation data.
    Crinex,
    /// u-blox UBX frames, possibly among NMEA sentences or RTCM.
    Ubx,
    /// gzip; the kind of the content is not known yet.
    Gzip,
    /// UNIX `compress` (.Z).
    UnixCompress,
    /// zip archive.
    Zip,
    /// An RTKLIB configuration (`pos1-posmode =…`).
    RtklibConf,
    /// An RTKLIB solution (`.pos`).
    RtklibPos,
    /// NMEA sentences without UBX frames.
    Nmea,
    /// RTCM 3 frames.
    Rtcm3,
    /// SP3 precise orbits.
    Sp3,
    /// ANTEX antenna calibrations.
    Antex,
    /// Nothing at all.
    Empty,
    /// A file of any other kind.
    Unknown,
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::RinexObservation => "RINEX observation data",
            Self::RinexNavigation => "RINEX navigation data",
            Self::RinexClock => "RINEX clock data",
            Self::RinexOther => "RINEX of another type",
            Self::Crinex => "Hatanaka-compressed RINEX observation data",
            Self::Ubx => "u-blox UBX",
            Self::Gzip => "gzip",
            Self::UnixCompress => "UNIX compress (.Z)",
            Self::Zip => "a zip archive",
            Self::RtklibConf => "an RTKLIB configuration",
            Self::RtklibPos => "an RTKLIB solution (.pos)",
            Self::Nmea => "NMEA sentences",
            Self::Rtcm3 => "RTCM 3",
            Self::Sp3 => "SP3 orbits",
            Self::Antex => "ANTEX antenna calibrations",
            Self::Empty => "empty",
            Self::Unknown => "of no known kind",
        })
    }
}
