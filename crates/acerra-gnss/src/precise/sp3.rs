//! SP3-c and SP3-d orbit files (Hilla, The Extended Standard Product 3 Orbit Format, 2016).

use acerra_geo::time::{Calendar, GpsTime};

use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};
use crate::observations::satellite::SatelliteId;
use crate::orbits::products::PreciseProducts;
use crate::rinex::{calendar, column, real};

/// Value of an unknown clock (µs).
const NO_CLOCK_US: f64 = 999_999.0;
/// Positions of satellites lie between these distances from the Earth's centre (m).
const RADII_M: std::ops::Range<f64> = 6.4e6..1e8;
/// TAI − GPST (s).
const TAI_AHEAD_OF_GPST_S: f64 = 19.0;

/// The time scale of a file's epochs.
#[derive(Debug, Clone, Copy)]
enum Scale {
    Gps,
    Utc,
    Glonass,
    Beidou,
    Tai,
}

impl Scale {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"GPS" | b"GAL" | b"QZS" | b"IRN" | b"ccc" | b"   " => Self::Gps,
            b"UTC" => Self::Utc,
            b"GLO" => Self::Glonass,
            b"BDT" | b"BDS" => Self::Beidou,
            b"TAI" => Self::Tai,
            _ => return None,
        })
    }

    fn gps_time(self, reading: &Calendar) -> Option<GpsTime> {
        let as_is = GpsTime::from_calendar(reading);
        match self {
            Self::Gps => Some(as_is),
            // SP3's GLO is UTC, without the three hours of Moscow time.
            Self::Utc | Self::Glonass => GpsTime::from_utc(reading).ok(),
            Self::Beidou => Some(as_is + acerra_geo::time::BDT_BEHIND_GPST_S as f64),
            Self::Tai => Some(as_is - TAI_AHEAD_OF_GPST_S),
        }
    }
}

/// Reads an SP3 file.
///
/// # Errors
/// [`ReadError`] where the first line is not one of SP3-c or SP3-d, the time system is not known,
/// or the input fails.
pub(crate) fn read_sp3_lines(
    source: &mut impl LineSource,
) -> Result<(PreciseProducts, ReadReport), ReadError> {
    let mut reader = Reader::first_line(source)?;
    while source.advance()? {
        let line = source.line();
        let place = Place::Line(source.number());
        match line.first() {
            Some(b'%') if line.starts_with(b"%c") => reader.scale(line, source.number())?,
            Some(b'#' | b'+' | b'%' | b'/') | None => {}
            Some(b'*') => reader.epoch(line, place),
            Some(b'P') => {
                if !source.terminated() && line.len() < 60 {
                    reader.report.drop_one(DropReason::CutOff, place);
                    continue;
                }
                reader.position(line, place);
            }
            // Velocities, and correlations of positions and velocities.
            Some(b'V' | b'E') => {}
            _ => reader.report.drop_one(DropReason::StrayLine, place),
        }
    }
    let Reader {
        version,
        products,
        mut report,
        ..
    } = reader;
    report.absorb(source.take_report());
    report.format = format!("SP3-{version}");
    Ok((products, report))
}

struct Reader {
    version: char,
    scale: Option<Scale>,
    now: Option<GpsTime>,
    products: PreciseProducts,
    report: ReadReport,
}

impl Reader {
    fn first_line(source: &mut impl LineSource) -> Result<Self, ReadError> {
        if !source.advance()? {
            return Err(ReadError::Empty);
        }
        let (line, number) = (source.line(), source.number());
        let version = match column(line, 0, 2) {
            b"#c" => 'c',
            b"#d" => 'd',
            &[b'#', other @ (b'a' | b'b')] => {
                return Err(ReadError::Unsupported {
                    line: number,
                    what: format!("SP3-{}", char::from(other)),
                });
            }
            _ => return Err(ReadError::format(number, "SP3-c or SP3-d (#c, #d)", line)),
        };
        Ok(Self {
            version,
            scale: None,
            now: None,
            products: PreciseProducts::default(),
            report: ReadReport::default(),
        })
    }

    /// The first of the two `%c` lines names the time system.
    fn scale(&mut self, line: &[u8], number: u64) -> Result<(), ReadError> {
        if self.scale.is_none() {
            let name = column(line, 9, 3);
            let scale = Scale::from_name(name)
                .ok_or_else(|| ReadError::format(number, "a time system such as GPS", name))?;
            self.scale = Some(scale);
        }
        Ok(())
    }

    fn epoch(&mut self, line: &[u8], place: Place) {
        let scale = self.scale.unwrap_or(Scale::Gps);
        self.now = calendar(column(line, 3, 28)).and_then(|c| scale.gps_time(&c));
        if self.now.is_none() {
            self.report.drop_one(DropReason::UnreadableEpoch, place);
        }
    }

    fn position(&mut self, line: &[u8], place: Place) {
        let Some(now) = self.now else {
            return self.report.drop_one(DropReason::StrayLine, place);
        };
        let name = String::from_utf8_lossy(column(line, 1, 3)).into_owned();
        let Ok(satellite) = name.parse::<SatelliteId>() else {
            let reason = DropReason::UnknownSatellite(name);
            return self.report.drop_one(reason, place);
        };
        let mut values = [0.0; 4];
        for (k, value) in values.iter_mut().enumerate() {
            match real(column(line, 4 + 14 * k, 14)) {
                Ok(Some(number)) => *value = number,
                // A clock may be left blank.
                Ok(None) if k == 3 => *value = NO_CLOCK_US,
                _ => return self.report.drop_one(DropReason::UnreadableNumber, place),
            }
        }
        let [x, y, z, clock_us] = values;
        let position = [x, y, z].map(|km| km * 1e3);
        let radius_m = position.iter().map(|x| x * x).sum::<f64>().sqrt();
        // A position of zeros means that there is none.
        if radius_m > 0.0 {
            if !RADII_M.contains(&radius_m) {
                return self.report.drop_one(DropReason::UnreadableNumber, place);
            }
            let series = self.products.orbits.entry(satellite).or_default();
            series.insert(now, position);
        }
        if clock_us.abs() < NO_CLOCK_US {
            let series = self.products.orbit_clocks.entry(satellite).or_default();
            series.insert(now, clock_us * 1e-6);
        }
    }
}
