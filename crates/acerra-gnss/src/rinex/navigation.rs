//! Navigation files.

use super::fields::{calendar, column, integer, real, version};
use super::navigation_record::NavigationRecord;
use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};
use crate::observations::satellite::{SatelliteId, System};
use crate::orbits::navigation::{Klobuchar, Navigation};

/// Columns of the fields of a navigation record.
#[derive(Debug, Clone, Copy)]
struct Layout {
    /// First column and width of the time of clock.
    time: (usize, usize),
    /// First column of the values on a record's first line, and on those after it.
    values: (usize, usize),
}

const VERSION_2: Layout = Layout {
    time: (3, 19),
    values: (22, 3),
};
/// Index of the first spare value of a record.
const FIRST_SPARE: usize = 29;

const VERSION_3: Layout = Layout {
    time: (4, 19),
    values: (23, 4),
};

/// Reads RINEX 2, 3 or 4 navigation data.
///
/// RINEX 4 messages other than LNAV, FDMA, INAV, FNAV, D1, D2 and SBAS (their CNAV kin, time,
/// earth-orientation and other ionosphere models) are counted and skipped.
///
/// # Errors
/// [`ReadError`] where the header is not that of navigation data or the input fails.
pub fn read_navigation_lines(
    source: &mut impl LineSource,
) -> Result<(Navigation, ReadReport), ReadError> {
    let mut reader = Reader::header(source)?;
    reader.body(source)?;
    let Reader {
        version,
        mut navigation,
        mut report,
        alpha,
        beta,
        ..
    } = reader;
    if let (Some(alpha), Some(beta)) = (alpha, beta)
        && alpha.iter().chain(&beta).any(|&x| x != 0.0)
    {
        navigation.klobuchar = Some(Klobuchar { alpha, beta });
    }
    report.absorb(source.take_report());
    report.format = format!("RINEX {}.{:02} navigation", version / 100, version % 100);
    navigation.normalise();
    Ok((navigation, report))
}

/// Lines of one record, collected until the next begins.
struct Record {
    first: u64,
    /// RINEX 4 message line, as `EPH G05 LNAV`.
    message: Option<String>,
    lines: Vec<Vec<u8>>,
    /// The file ended on the last line, without a line feed.
    unterminated: bool,
}

struct Reader {
    version: u16,
    layout: Layout,
    /// System of satellites without a letter.
    system: System,
    navigation: Navigation,
    alpha: Option<[f64; 4]>,
    beta: Option<[f64; 4]>,
    report: ReadReport,
}

impl Reader {
    fn header(source: &mut impl LineSource) -> Result<Self, ReadError> {
        loop {
            if !source.advance()? {
                return Err(ReadError::Empty);
            }
            if !source.line().trim_ascii().is_empty() {
                break;
            }
        }
        let (line, number) = (source.line(), source.number());
        let version = version(line, number)?;
        let system = match column(line, 20, 1) {
            b"G" => System::Glonass,
            b"H" => System::Sbas,
            b"L" => System::Galileo,
            b"J" => System::Qzss,
            b"N" => column(line, 40, 1)
                .first()
                .and_then(|&l| System::from_letter(char::from(l)))
                .filter(|_| version >= 300)
                .unwrap_or(System::Gps),
            _ => return Err(ReadError::format(number, "type N (navigation data)", line)),
        };
        let mut reader = Self {
            version,
            layout: if version < 300 { VERSION_2 } else { VERSION_3 },
            system,
            navigation: Navigation::default(),
            alpha: None,
            beta: None,
            report: ReadReport::default(),
        };
        while source.advance()? {
            let line = source.line();
            match column(line, 60, 20).trim_ascii_end() {
                b"END OF HEADER" => return Ok(reader),
                b"ION ALPHA" => reader.alpha = four(line, 2),
                b"ION BETA" => reader.beta = four(line, 2),
                b"IONOSPHERIC CORR" if column(line, 0, 4) == b"GPSA" => {
                    reader.alpha = four(line, 5);
                }
                b"IONOSPHERIC CORR" if column(line, 0, 4) == b"GPSB" => {
                    reader.beta = four(line, 5);
                }
                _ => {}
            }
        }
        Err(ReadError::MissingHeader {
            line: source.number(),
            missing: "END OF HEADER",
        })
    }

    fn body(&mut self, source: &mut impl LineSource) -> Result<(), ReadError> {
        let mut record: Option<Record> = None;
        let mut message: Option<String> = None;
        while source.advance()? {
            let line = source.line();
            let number = source.number();
            if line.trim_ascii().is_empty() {
                continue;
            }
            if self.version >= 400 && line.first() == Some(&b'>') {
                if let Some(done) = record.take() {
                    self.take(&done);
                }
                message = Some(String::from_utf8_lossy(&line[1..]).trim().to_owned());
                continue;
            }
            let label = column(line, 60, 20).trim_ascii_end();
            if label == b"RINEX VERSION / TYPE" || label == b"END OF HEADER" {
                // Concatenated files: header lines of the second file are skipped.
                self.report
                    .drop_one(DropReason::StrayLine, Place::Line(number));
                continue;
            }
            let begins = !column(line, 0, self.layout.values.1)
                .trim_ascii()
                .is_empty();
            if begins {
                if let Some(done) = record.take() {
                    self.take(&done);
                }
                record = Some(Record {
                    first: number,
                    message: message.take(),
                    lines: vec![line.to_vec()],
                    unterminated: !source.terminated(),
                });
            } else if let Some(record) = record.as_mut().filter(|r| r.lines.len() < 16) {
                record.lines.push(line.to_vec());
                record.unterminated = !source.terminated();
            } else if let (Some(text), None) = (&message, &record) {
                // A RINEX 4 message whose first line has no satellite: STO, EOP, ION.
                record = Some(Record {
                    first: number,
                    message: Some(text.clone()),
                    lines: vec![line.to_vec()],
                    unterminated: !source.terminated(),
                });
                message = None;
            } else {
                self.report
                    .drop_one(DropReason::StrayLine, Place::Line(number));
            }
        }
        if let Some(done) = record {
            self.take(&done);
        }
        Ok(())
    }

    fn take(&mut self, record: &Record) {
        let place = Place::Line(record.first);
        if let Some(message) = &record.message {
            let mut words = message.split_whitespace();
            let (kind, satellite, format) = (
                words.next().unwrap_or(""),
                words.next().unwrap_or(""),
                words.next().unwrap_or(""),
            );
            match (kind, format) {
                ("EPH", "LNAV" | "FDMA" | "INAV" | "FNAV" | "D1" | "D2" | "D1D2" | "SBAS") => {}
                ("ION", "LNAV") if satellite.starts_with('G') => {
                    self.ionosphere_v4(record, place);
                    return;
                }
                _ => {
                    let name = format!("{kind} {format}").trim_end().to_owned();
                    self.report
                        .drop_one(DropReason::UnusedNavigationMessage(name), place);
                    return;
                }
            }
        } else if self.version >= 400 {
            self.report.drop_one(DropReason::StrayLine, place);
            return;
        }
        match self.record(record) {
            Ok(ephemeris) => self.navigation.ephemerides.push(ephemeris),
            Err(reason) => self.report.drop_one(reason, place),
        }
    }

    fn record(&self, record: &Record) -> Result<crate::orbits::navigation::Ephemeris, DropReason> {
        let first = &record.lines[0];
        let satellite = self.satellite(first).ok_or_else(|| {
            let name = String::from_utf8_lossy(column(first, 0, self.layout.values.1 - 1));
            DropReason::UnknownSatellite(name.trim().to_owned())
        })?;
        let needed = NavigationRecord::lines_needed(satellite.system());
        if record.lines.len() < needed {
            return Err(DropReason::CutOff);
        }
        let layout = self.layout_of(first);
        let toc = calendar(column(first, layout.time.0, layout.time.1))
            .ok_or(DropReason::UnreadableNavigationRecord)?;
        let mut values = Vec::with_capacity(4 * needed);
        for (i, line) in record.lines[..needed].iter().enumerate() {
            let (start, count) = if i == 0 {
                (layout.values.0, 3)
            } else {
                (layout.values.1, 4)
            };
            // A file that ends inside a number would yield a wrong one.
            let over = line.len().saturating_sub(start) % 19;
            if record.unterminated && i + 1 == record.lines.len() && over > 0 {
                return Err(DropReason::CutOff);
            }
            for k in 0..count {
                let field = column(line, start + 19 * k, 19);
                let value = match real(field) {
                    Ok(value) => value.unwrap_or(f64::NAN),
                    // The spare fields at the end are ignored.
                    Err(_) if values.len() >= FIRST_SPARE => f64::NAN,
                    Err(_) => return Err(DropReason::UnreadableNavigationRecord),
                };
                values.push(value);
            }
        }
        NavigationRecord {
            satellite,
            toc,
            values,
        }
        .ephemeris()
        .ok_or(DropReason::UnreadableNavigationRecord)
    }

    /// Version 2.12 writes satellites of QZSS and Galileo with their letter, and columns as version 3 has them.
    fn layout_of(&self, line: &[u8]) -> Layout {
        if line.first().is_some_and(u8::is_ascii_alphabetic) {
            VERSION_3
        } else {
            self.layout
        }
    }

    fn satellite(&self, line: &[u8]) -> Option<SatelliteId> {
        if self.version < 300 && !line.first().is_some_and(u8::is_ascii_alphabetic) {
            let number = integer(column(line, 0, 2))?;
            return SatelliteId::new(self.system, u8::try_from(number).ok()?);
        }
        let &[letter, tens, units] = column(line, 0, 3) else {
            return None;
        };
        let system = match letter {
            b' ' => self.system,
            letter => System::from_letter(char::from(letter))?,
        };
        let number = integer(&[tens, units])?;
        SatelliteId::new(system, u8::try_from(number).ok()?)
    }

    /// RINEX 4 `ION … LNAV`: α0–α2 after the time, then α3, β0–β2, then β3.
    fn ionosphere_v4(&mut self, record: &Record, place: Place) {
        let mut values = [0.0; 8];
        let fields = [
            (0, 23),
            (0, 42),
            (0, 61),
            (1, 4),
            (1, 23),
            (1, 42),
            (1, 61),
            (2, 4),
        ];
        for (value, (row, start)) in values.iter_mut().zip(fields) {
            let field = record.lines.get(row).map(|line| column(line, start, 19));
            match field.map(real) {
                Some(Ok(Some(number))) => *value = number,
                _ => {
                    self.report
                        .drop_one(DropReason::UnreadableNavigationRecord, place);
                    return;
                }
            }
        }
        let [a0, a1, a2, a3, b0, b1, b2, b3] = values;
        self.alpha = Some([a0, a1, a2, a3]);
        self.beta = Some([b0, b1, b2, b3]);
    }
}

/// Four D12.4 numbers from `start`; `None` where one is missing or unreadable.
fn four(line: &[u8], start: usize) -> Option<[f64; 4]> {
    let mut out = [0.0; 4];
    for (i, value) in out.iter_mut().enumerate() {
        *value = real(column(line, start + 12 * i, 12)).ok()??;
    }
    Some(out)
}
