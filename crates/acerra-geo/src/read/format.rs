//! The kinds of trajectory file.

/// The kinds of trajectory file that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TrajectoryFormat {
    /// RTKLIB's solution text.
    RtklibPos,
    /// A table with a header line: commas, semicolons, tabs or blanks between columns.
    ///
    /// Units may follow a name as `x_mm`, `x (mm)` or `x [mm]`; case does not matter.
    ///
    /// | meaning | names |
    /// | --- | --- |
    /// | time | `time_s`, `time`, `t`, `timestamp`, `elapsed`; ISO 8601 text, also as `utc`, `datetime` or `date` with `time` (UTC unless it ends in an offset); `gps_week` with `tow_s`; `gpst_unix_s`; `unix_s` (UTC) |
    /// | position | `x y z`, `east north up`, `e n u`; `lat lon` (also `latitude`, `longitude`, `lng`) with a height; `ecef_x ecef_y ecef_z` |
    /// | height | above the ellipsoid: `height`, `h`, `ellipsoidal_height`, `hae`; above the sea: `altitude_msl`, `altitude_above_sealevel`; above take-off: `height_above_takeoff`; `altitude` and `alt` name no datum, [`ReadOptions::heights`](super::ReadOptions) does |
    /// | attitude | `roll pitch heading` (also `yaw`) in degrees: right side down, nose up, clockwise from north; or `qw qx qy qz` |
    /// | standard deviation | `sd_x`, `sdx`, `sigma_x`, `std_x`, … for the same axes; east, north, up for geodetic positions |
    /// | quality | `q` (RTKLIB), `nmea_quality`, `status` (word or RTKLIB's number) |
    /// | others | `vx vy vz`, `qw qx qy qz` (body forward-left-up to east-north-up), `ns`, `age_s`, `ratio` |
    Csv,
    /// NMEA 0183 sentences.
    Nmea,
    /// OptiTrack Motive's CSV export.
    Motive,
}

impl TrajectoryFormat {
    /// A name for messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RtklibPos => "RTKLIB .pos",
            Self::Csv => "CSV table",
            Self::Nmea => "NMEA 0183",
            Self::Motive => "OptiTrack Motive export",
        }
    }
}

impl std::fmt::Display for TrajectoryFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}
