//! The layout of a solution file.

use std::io;
use std::sync::Arc;

use acerra_geo::geodesy::Geodetic;
use acerra_geo::geoid::GeoidGrid;
use acerra_geo::time::GpsTime;

/// Coordinates of a solution file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosFrame {
    /// Latitude and longitude in degrees, ellipsoidal height; covariance in axes at the solution.
    #[default]
    Geodetic,
    /// Earth-centred, Earth-fixed.
    Ecef,
    /// Baseline from the base, in its local axes.
    EnuBaseline,
}

/// Form of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosTime {
    /// `yyyy/mm/dd hh:mm:ss.sss`.
    #[default]
    Calendar,
    /// Week and seconds of week.
    WeekTow,
}

/// The scale of the times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PosTimeScale {
    /// GPS time.
    #[default]
    Gps,
    /// Coordinated universal time.
    Utc,
    /// Japan standard time, UTC + 9 h.
    Jst,
}

/// The layout of a solution file.
#[derive(Debug, Clone, PartialEq)]
pub struct PosFormat {
    /// Coordinates.
    pub frame: PosFrame,
    /// Form of the times.
    pub time: PosTime,
    /// Scale of the times.
    pub scale: PosTimeScale,
    /// Decimals of the seconds.
    pub decimals: usize,
    /// Whether the lines about inputs and options are written.
    pub header: bool,
    /// Whether velocities are written (m/s): north, east, up with geodetic positions, else along the axes of
    /// the positions. Where no velocity was estimated the line ends before these columns.
    pub velocity: bool,
    /// The geoid from which heights of geodetic positions count (RTKLIB's `out-height = geodetic`); `None`
    /// for heights above the ellipsoid.
    pub geoid: Option<Arc<GeoidGrid>>,
}

impl PosFormat {
    /// Height above the geoid, or above the ellipsoid without a geoid (m).
    pub(super) fn height_m(&self, place: &Geodetic) -> io::Result<f64> {
        let Some(geoid) = &self.geoid else {
            return Ok(place.height_m);
        };
        let (latitude, longitude) = (place.latitude_deg(), place.longitude_deg());
        let separation_m = geoid.height_m(latitude, longitude).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("the geoid grid does not cover {latitude:.6}° {longitude:.6}°"),
            )
        })?;
        Ok(place.height_m - separation_m)
    }
}

impl Default for PosFormat {
    fn default() -> Self {
        Self {
            frame: PosFrame::default(),
            time: PosTime::default(),
            scale: PosTimeScale::default(),
            decimals: 3,
            header: true,
            velocity: false,
            geoid: None,
        }
    }
}

/// A time in the form of the file.
pub(super) fn time_text(time: GpsTime, format: &PosFormat) -> String {
    let jst_s = 9.0 * 3600.0;
    match (format.time, format.scale) {
        (PosTime::WeekTow, PosTimeScale::Gps) => time.format_week_tow(format.decimals),
        (PosTime::Calendar, PosTimeScale::Gps) => time.format_calendar(format.decimals),
        (PosTime::Calendar, PosTimeScale::Utc) => time.format_utc(format.decimals),
        (PosTime::Calendar, PosTimeScale::Jst) => (time + jst_s).format_utc(format.decimals),
        // Weeks of a scale other than GPS time: the same clock reading, counted in weeks.
        (PosTime::WeekTow, scale) => {
            let ahead_s = if scale == PosTimeScale::Jst {
                jst_s
            } else {
                0.0
            };
            let reading = (time + ahead_s).rounded(format.decimals).to_utc();
            GpsTime::from_calendar(&reading).format_week_tow(format.decimals)
        }
    }
}
