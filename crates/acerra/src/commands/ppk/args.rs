//! Arguments of `acerra ppk`.

use std::path::PathBuf;

use acerra_geo::time::GpsTime;
use acerra_gnss::pos::{PosFrame, PosTime, PosTimeScale};
use acerra_gnss::{
    AmbiguityMode, BasePosition, FilterDirection, GlonassAmbiguity, PositioningMode, RuleSet,
    SatelliteId, SystemSet,
};

use super::option_values::{
    base_position, directions, elevation_deg, frames, named, systems, time,
};
use crate::commands::values::positive;

/// Position a rover by carrier phase against a base, after the flight.
///
/// Reads RINEX 2–4 (plain or Hatanaka-compressed), u-blox UBX and RTCM 3 logs, SP3 orbits and RINEX clocks,
/// each also inside gzip or compress (.Z), recognised by content; UBX and RTCM 3 logs hold navigation data.
/// Without options: kinematic, fix and hold, forward and backward combined, every system's L1, the base's
/// position from its header.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra ppk rover.ubx base.ubx -o flight.pos --report flight.html
  acerra ppk rover.obs base.obs brdc.nav --base-position llh:40.9596,14.3696,75.0 -o flight.pos
  acerra ppk rover.obs base.obs brdc.nav --config rtkpost.conf --json")]
pub struct Args {
    /// The rover's log.
    pub(super) rover: PathBuf,
    /// The base's log.
    pub(super) base: Option<PathBuf>,
    /// Navigation files: broadcast ephemerides, SP3 orbits, RINEX clocks.
    #[arg(value_name = "NAV")]
    pub(super) navigation: Vec<PathBuf>,
    /// One more file of the rover's receiver, joined to its log (may be repeated).
    #[arg(long = "rover", value_name = "FILE", help_heading = "Input")]
    pub(super) more_rover: Vec<PathBuf>,
    /// A further file of the base's receiver, such as that of another hour (may be repeated).
    #[arg(long = "base", value_name = "FILE", help_heading = "Input")]
    pub(super) more_base: Vec<PathBuf>,
    /// Any time within half a week of RTCM 3 logs without a date: 2018-10-09T12:30:00.
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Input")]
    pub(super) date: Option<GpsTime>,
    /// Antenna calibrations of rover and base, found by the antennas' names in the logs.
    #[arg(long, value_name = "FILE.atx", help_heading = "Input")]
    pub(super) antennas: Option<PathBuf>,
    /// The rover's antenna, as the calibrations name it, or `none`.
    #[arg(
        long,
        value_name = "NAME",
        requires = "antennas",
        help_heading = "Input"
    )]
    pub(super) rover_antenna: Option<String>,
    /// The base's antenna, likewise.
    #[arg(
        long,
        value_name = "NAME",
        requires = "antennas",
        help_heading = "Input"
    )]
    pub(super) base_antenna: Option<String>,
    /// Write the positions to this file, as RTKLIB does (`-`: standard output).
    #[arg(short, long, value_name = "FILE.pos")]
    pub(super) output: Option<PathBuf>,
    /// Settings of an RTKLIB configuration file; the options below override them.
    #[arg(long, value_name = "FILE.conf")]
    pub(super) config: Option<PathBuf>,
    /// Write a page with trajectory, status, heights, satellites and residuals.
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
    /// Write the positions of the events in the rover's log.
    #[arg(long, value_name = "FILE.csv")]
    pub(super) events: Option<PathBuf>,
    /// Write NMEA sentences (GGA, RMC, GST).
    #[arg(long, value_name = "FILE.nmea")]
    pub(super) nmea: Option<PathBuf>,
    /// Write the residuals of every satellite and epoch.
    #[arg(long, value_name = "FILE.csv")]
    pub(super) residuals: Option<PathBuf>,
    /// Write the positions of a camera's images: the first of --images at the rover's first event,
    /// and so on.
    #[arg(long, value_name = "FILE.csv", requires = "images")]
    pub(super) image_positions: Option<PathBuf>,
    /// Write heading, pitch and length of the baseline at every epoch (--mode moving-base).
    #[arg(long, value_name = "FILE.csv")]
    pub(super) attitudes: Option<PathBuf>,
    /// The images: a folder, taken in order of their names, or a text file with a name on each
    /// line.
    #[arg(long, value_name = "PATH", requires = "image_positions")]
    pub(super) images: Option<PathBuf>,
    /// Answer as JSON.
    #[arg(long)]
    pub(super) json: bool,

    /// What is estimated.
    #[arg(long, value_parser = named(PositioningMode::ALL, PositioningMode::name), help_heading = "Positioning")]
    pub(super) mode: Option<PositioningMode>,
    /// Direction of processing.
    #[arg(long, value_parser = directions(), help_heading = "Positioning")]
    pub(super) direction: Option<FilterDirection>,
    /// Use the rover's log from this time on: 2018-10-09T12:30:00 in GPS time, with a Z at the end
    /// in UTC.
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Positioning")]
    pub(super) start: Option<GpsTime>,
    /// Use the rover's log up to this time, written likewise.
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Positioning")]
    pub(super) end: Option<GpsTime>,
    /// Position of the base: `header`, `average` (of its single-point positions),
    /// `llh:LATITUDE,LONGITUDE,HEIGHT` (degrees, ellipsoidal m) or `xyz:X,Y,Z` (ECEF, m).
    #[arg(long, value_name = "PLACE", value_parser = base_position, allow_hyphen_values = true,
          help_heading = "Positioning")]
    pub(super) base_position: Option<BasePosition>,
    /// Distance between the two antennas, m (--mode moving-base).
    #[arg(long, value_name = "M", value_parser = positive, help_heading = "Positioning")]
    pub(super) baseline_length: Option<f64>,
    /// Standard deviation of that distance, m.
    #[arg(long, value_name = "M", value_parser = positive, requires = "baseline_length",
          default_value = "0.01", help_heading = "Positioning")]
    pub(super) baseline_sigma: f64,
    /// Systems used, by letter: G GPS, R GLONASS, E Galileo, C BeiDou, J QZSS, I NavIC, S SBAS.
    #[arg(long, value_name = "LETTERS", value_parser = systems, help_heading = "Positioning")]
    pub(super) systems: Option<SystemSet>,
    /// Satellites never used, as G05,R11.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        help_heading = "Positioning"
    )]
    pub(super) exclude: Vec<SatelliteId>,
    /// Frequencies: 1 (L1), 2 (L1 and L2 or E5b), 3 (and L5).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=3),
          help_heading = "Positioning")]
    pub(super) frequencies: Option<u8>,
    /// Elevation mask, degrees.
    #[arg(long, value_name = "DEG", value_parser = elevation_deg, help_heading = "Positioning")]
    pub(super) elevation_mask: Option<f64>,
    /// Least carrier-to-noise density, dB-Hz; signals of unknown strength pass.
    #[arg(long, value_name = "DBHZ", value_parser = positive,
          help_heading = "Positioning")]
    pub(super) cn0_mask: Option<f64>,
    /// Largest age of the base's data, s.
    #[arg(long, value_name = "S", value_parser = positive,
          help_heading = "Positioning")]
    pub(super) max_age: Option<f64>,
    /// Interpolate the base's data to the rover's time tags.
    #[arg(long, help_heading = "Positioning")]
    pub(super) interpolate_base: bool,
    /// Predict the motion from velocity and acceleration.
    #[arg(long, help_heading = "Positioning")]
    pub(super) dynamics: bool,
    /// Give positions from codes where nothing better exists (without --unguarded they are given
    /// anyway).
    #[arg(long, help_heading = "Positioning")]
    pub(super) output_single: bool,

    /// How ambiguities are resolved.
    #[arg(
        long,
        value_parser = named(AmbiguityMode::ALL, AmbiguityMode::name),
        value_name = "MODE",
        help_heading = "Ambiguities and weights"
    )]
    pub(super) ar: Option<AmbiguityMode>,
    /// Whether GLONASS ambiguities are resolved.
    #[arg(
        long,
        value_parser = named(GlonassAmbiguity::ALL, GlonassAmbiguity::name),
        value_name = "MODE",
        help_heading = "Ambiguities and weights"
    )]
    pub(super) glonass_ar: Option<GlonassAmbiguity>,
    /// Least ratio of the second-best to the best set of integers.
    #[arg(long, value_name = "RATIO", value_parser = positive,
          help_heading = "Ambiguities and weights")]
    pub(super) ratio: Option<f64>,
    /// Standard deviation of code over that of phase.
    #[arg(long, value_name = "RATIO", value_parser = positive,
          help_heading = "Ambiguities and weights")]
    pub(super) code_phase_ratio: Option<f64>,
    /// Follow RTKLIB's rules alone: no check of phases by signal strength and residuals, no base data
    /// interpolated across gaps, no satellites left out of a fix that fails with all.
    #[arg(long, help_heading = "Ambiguities and weights")]
    pub(super) unguarded: bool,
    /// Whose rules hold where RTKLIB 2.4.3 and demo5 differ.
    #[arg(long, value_parser = named(RuleSet::ALL, RuleSet::name), help_heading = "Ambiguities and weights")]
    pub(super) rules: Option<RuleSet>,

    /// Coordinates of the output; with a moving base the baseline unless a configuration file states
    /// otherwise.
    #[arg(long, value_parser = frames(), help_heading = "Output")]
    pub(super) format: Option<PosFrame>,
    /// Form of the times.
    #[arg(long, value_parser = named(PosTime::ALL, PosTime::name), help_heading = "Output")]
    pub(super) time_form: Option<PosTime>,
    /// Write velocities, too, into the solution file.
    #[arg(long, help_heading = "Output")]
    pub(super) velocities: bool,
    /// Write positions only whose standard deviation is at most this along every axis, m.
    #[arg(long, value_name = "M", value_parser = positive, help_heading = "Output")]
    pub(super) max_sigma: Option<f64>,
    /// A geoid grid for the heights of every output: NGA WW15MGH.DAC or .GRD, NOAA .gtx,
    /// GeographicLib .pgm or PROJ's GeoTIFF.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(super) geoid: Option<PathBuf>,
    /// Scale of the times.
    #[arg(long, value_parser = named(PosTimeScale::ALL, PosTimeScale::name), help_heading = "Output")]
    pub(super) time_scale: Option<PosTimeScale>,
}
