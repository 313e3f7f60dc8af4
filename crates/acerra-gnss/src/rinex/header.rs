//! The header of an observation file.

use std::collections::{BTreeMap, HashMap};

use acerra_geo::time::{Calendar, GpsTime};

use super::fields::{column, integer, real, text, version};
use super::types::{Column, column_v3, columns_v2};
use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};
use crate::observations::observation::{AntennaOffset, StationInfo};
use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::SignalCode;

/// Time scale of an observation file's tags.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum TimeSystem {
    /// GPS time, and time scales steered to GPS time (Galileo, QZSS, NavIC).
    #[default]
    Gps,
    /// UTC, which GLONASS files use.
    Utc,
    /// BeiDou time.
    Beidou,
}

impl TimeSystem {
    /// GPS time of a clock reading.
    pub(super) fn gps_time(self, reading: &Calendar) -> Option<GpsTime> {
        match self {
            Self::Gps => Some(GpsTime::from_calendar(reading)),
            Self::Utc => GpsTime::from_utc(reading).ok(),
            Self::Beidou => {
                let t = GpsTime::from_calendar(reading);
                Some(GpsTime::new(
                    t.seconds() + acerra_geo::time::BDT_BEHIND_GPST_S,
                    t.fraction(),
                ))
            }
        }
    }
}

/// Content of an observation file's header.
#[derive(Debug, Clone, Default)]
pub struct ObservationHeader {
    /// Version in hundredths: 210, 304 …
    pub version: u16,
    /// Station, receiver, antenna and place.
    pub station: StationInfo,
    /// GLONASS channels (`GLONASS SLOT / FRQ #`) by satellite number.
    pub glonass_channels: BTreeMap<u8, i8>,
    /// Whether a half-wavelength factor is given (squaring receivers).
    pub half_wavelength: bool,
    pub(super) time_system: TimeSystem,
    time_system_given: bool,
    columns: HashMap<System, Vec<Column>>,
    types_v2: Vec<String>,
    expected_v2: usize,
    declaring: Option<(System, usize)>,
    scaling: Option<(System, f64)>,
    pub(super) lines: u64,
}

impl ObservationHeader {
    /// Reads a header up to `END OF HEADER`. The first line must be the source's current one.
    pub(super) fn read(
        source: &mut impl LineSource,
        report: &mut ReadReport,
    ) -> Result<Self, ReadError> {
        let mut header = Self::first_line(source.line(), source.number())?;
        loop {
            if !source.advance()? {
                return Err(ReadError::MissingHeader {
                    line: source.number(),
                    missing: "END OF HEADER",
                });
            }
            let line = source.line();
            if column(line, 60, 13) == b"END OF HEADER" {
                break;
            }
            header.record(line, source.number(), report);
        }
        header.lines = source.number();
        header.finish(source.number(), report)?;
        Ok(header)
    }

    fn first_line(line: &[u8], number: u64) -> Result<Self, ReadError> {
        let version = version(line, number)?;
        if !matches!(column(line, 20, 1), b"O" | b"o") {
            return Err(ReadError::format(number, "type O (observation data)", line));
        }
        let time_system = match column(line, 40, 1) {
            b"R" => TimeSystem::Utc,
            b"C" => TimeSystem::Beidou,
            _ => TimeSystem::Gps,
        };
        Ok(Self {
            version,
            time_system,
            ..Self::default()
        })
    }

    /// Takes one header record, from the header or from an epoch with flag 3 or 4.
    pub(super) fn record(&mut self, line: &[u8], number: u64, report: &mut ReadReport) {
        let label = String::from_utf8_lossy(column(line, 60, 20))
            .trim_end()
            .to_owned();
        let understood = match label.as_str() {
            "MARKER NAME" => {
                self.station.marker = text(line, 0, 60);
                true
            }
            "REC # / TYPE / VERS" => {
                self.station.receiver = text(line, 20, 20);
                true
            }
            "ANT # / TYPE" => {
                self.station.antenna = text(line, 20, 20);
                true
            }
            "APPROX POSITION XYZ" => self.position(line),
            "ANTENNA: DELTA H/E/N" => triple(line).is_some_and(|[up_m, east_m, north_m]| {
                self.station.antenna_offset = AntennaOffset {
                    up_m,
                    east_m,
                    north_m,
                };
                true
            }),
            "TIME OF FIRST OBS" => self.time_of_first(line),
            "# / TYPES OF OBSERV" => self.types_v2(line),
            "SYS / # / OBS TYPES" => self.types_v3(line),
            "SYS / SCALE FACTOR" => self.scale_factor(line),
            "GLONASS SLOT / FRQ #" => self.glonass_slots(line),
            "WAVELENGTH FACT L1/2" => {
                self.half_wavelength |= column(line, 5, 1) == b"2" || column(line, 11, 1) == b"2";
                true
            }
            _ => true,
        };
        if !understood {
            report.drop_one(DropReason::HeaderRecord(label), Place::Line(number));
        }
    }

    fn position(&mut self, line: &[u8]) -> bool {
        let Some(position) = triple(line) else {
            return false;
        };
        self.station.position_ecef_m = Some(position).filter(|p| p.iter().any(|&x| x != 0.0));
        true
    }

    fn time_of_first(&mut self, line: &[u8]) -> bool {
        let system = match column(line, 48, 3) {
            b"GPS" | b"GAL" | b"QZS" | b"IRN" => TimeSystem::Gps,
            b"GLO" | b"UTC" => TimeSystem::Utc,
            b"BDT" | b"BDS" => TimeSystem::Beidou,
            b"   " | b"" => return true,
            _ => return false,
        };
        // A second time system in mid-file (flag 4) would shift tags already read: the first is kept.
        let agrees = !self.time_system_given || self.time_system == system;
        if !self.time_system_given {
            self.time_system = system;
            self.time_system_given = true;
        }
        agrees
    }

    fn types_v2(&mut self, line: &[u8]) -> bool {
        if let Some(count) = integer(column(line, 0, 6)) {
            self.expected_v2 = count;
            self.types_v2.clear();
        }
        for i in 0..9 {
            let name = text(line, 10 + 6 * i, 2);
            if self.types_v2.len() < self.expected_v2 {
                self.types_v2.push(name);
            }
        }
        self.columns.clear();
        for system in System::ALL {
            self.columns
                .insert(system, columns_v2(&self.types_v2, system, self.version));
        }
        true
    }

    fn types_v3(&mut self, line: &[u8]) -> bool {
        if let &[letter @ b'A'..=b'Z'] = column(line, 0, 1) {
            let (system, count) = (
                System::from_letter(char::from(letter)),
                integer(column(line, 3, 3)),
            );
            let (Some(system), Some(count)) = (system, count) else {
                self.declaring = None;
                return false;
            };
            self.declaring = Some((system, count));
            self.columns.insert(system, Vec::new());
        }
        let Some((system, count)) = self.declaring else {
            return false;
        };
        let columns = self.columns.entry(system).or_default();
        for i in 0..13 {
            if columns.len() < count {
                columns.push(column_v3(&text(line, 7 + 4 * i, 3), system, self.version));
            }
        }
        true
    }

    fn scale_factor(&mut self, line: &[u8]) -> bool {
        if let &[letter @ b'A'..=b'Z'] = column(line, 0, 1) {
            let factor = integer(column(line, 2, 4)).filter(|f| matches!(f, 1 | 10 | 100 | 1000));
            let (Some(system), Some(factor)) = (System::from_letter(char::from(letter)), factor)
            else {
                self.scaling = None;
                return false;
            };
            #[expect(clippy::cast_precision_loss, reason = "at most 1000")]
            let factor = factor as f64;
            self.scaling = Some((system, factor));
            if integer(column(line, 8, 2)).unwrap_or(0) == 0 {
                for column in self.columns.entry(system).or_default() {
                    column.scale = factor;
                }
                return true;
            }
        }
        let Some((system, factor)) = self.scaling else {
            return false;
        };
        let columns = self.columns.entry(system).or_default();
        let names: Vec<String> = (0..12)
            .map(|i| text(line, 11 + 4 * i, 3))
            .filter(|n| !n.is_empty())
            .collect();
        for column in columns.iter_mut().filter(|c| names.contains(&c.name)) {
            column.scale = factor;
        }
        true
    }

    fn glonass_slots(&mut self, line: &[u8]) -> bool {
        let mut good = true;
        for i in 0..8 {
            let (name, channel) = (text(line, 4 + 7 * i, 3), text(line, 8 + 7 * i, 2));
            if name.is_empty() {
                continue;
            }
            let satellite = name
                .parse::<SatelliteId>()
                .ok()
                .filter(|s| s.system() == System::Glonass);
            match (satellite, channel.parse::<i8>()) {
                (Some(satellite), Ok(channel @ -7..=6)) => {
                    self.glonass_channels.insert(satellite.number(), channel);
                }
                _ => good = false,
            }
        }
        good
    }

    /// Checks that the header suffices to read the body.
    fn finish(&mut self, line: u64, report: &mut ReadReport) -> Result<(), ReadError> {
        if self.columns.values().all(Vec::is_empty) {
            let missing = if self.version < 300 {
                "# / TYPES OF OBSERV"
            } else {
                "SYS / # / OBS TYPES"
            };
            return Err(ReadError::MissingHeader { line, missing });
        }
        if self.half_wavelength {
            report
                .remarks
                .push("half-wavelength factors in the header: phases count half cycles".to_owned());
        }
        let short = |expected: usize, found: usize| expected > found;
        if self.version < 300 && short(self.expected_v2, self.types_v2.len()) {
            report.drop_one(
                DropReason::HeaderRecord("# / TYPES OF OBSERV".to_owned()),
                Place::Line(line),
            );
        }
        Ok(())
    }

    /// The columns of a system's records.
    pub(super) fn columns(&self, system: System) -> Option<&[Column]> {
        self.columns
            .get(&system)
            .map(Vec::as_slice)
            .filter(|c| !c.is_empty())
    }

    /// The signals that the header lists for a system, in its order.
    pub fn signals(&self, system: System) -> Vec<SignalCode> {
        let mut out = Vec::new();
        for column in self.columns(system).unwrap_or(&[]) {
            for &code in column.meaning.iter().flat_map(|(_, codes)| codes) {
                if !out.contains(&code) {
                    out.push(code);
                }
            }
        }
        out
    }
}

fn triple(line: &[u8]) -> Option<[f64; 3]> {
    let mut out = [0.0; 3];
    for (i, value) in out.iter_mut().enumerate() {
        *value = real(column(line, 14 * i, 14)).ok()??;
    }
    Some(out)
}
