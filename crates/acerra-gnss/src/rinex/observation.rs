//! The body of an observation file.

use super::epoch::EpochLine;
use super::fields::{column, real};
use super::header::ObservationHeader;
use super::types::{Column, Quantity};
use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};
use crate::observations::observation::{EventKind, EventRecord, LossOfLock, SignalObservation};
use crate::observations::recorded::{RecordedEpoch, RecordedSatellite};
use crate::observations::satellite::{SatelliteId, System};
use crate::observations::select::SignalChoice;
use acerra_geo::time::GpsTime;

/// One record of an observation file.
#[derive(Debug, Clone, PartialEq)]
pub enum ObservationRecord {
    /// Measurements.
    Epoch(RecordedEpoch),
    /// An external event (epoch flag 5).
    Event(EventRecord),
}

/// Reader of RINEX 2, 3 and 4 observation data, record by record, with all signals.
#[derive(Debug)]
pub struct RinexObservations<S> {
    source: S,
    header: ObservationHeader,
    report: ReadReport,
    /// Whether the source's current line is not yet used.
    pending: bool,
    place: Place,
    header_changes: u64,
    /// Bytes of the lines so far.
    read_bytes: u64,
}

/// Outcome of reading a satellite's lines.
enum Taken {
    Whole,
    /// An epoch begins where another satellite of the epoch before was expected.
    Interrupted,
    /// The file ended.
    Ended,
}

impl<S: LineSource> RinexObservations<S> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`ReadError`] where the header is not that of RINEX observation data.
    pub fn new(mut source: S) -> Result<Self, ReadError> {
        loop {
            if !source.advance()? {
                return Err(ReadError::Empty);
            }
            if !source.line().trim_ascii().is_empty() {
                break;
            }
        }
        let mut report = ReadReport::default();
        let header = ObservationHeader::read(&mut source, &mut report)?;
        let place = Place::Line(source.number());
        Ok(Self {
            source,
            header,
            report,
            pending: false,
            place,
            header_changes: 0,
            read_bytes: 0,
        })
    }

    /// The header, with the changes that the body has made so far.
    pub fn header(&self) -> &ObservationHeader {
        &self.header
    }

    /// Place at which the record last returned began.
    pub fn place(&self) -> Place {
        self.place
    }

    /// Bytes of the body's lines that were read so far, as unpacked.
    pub(crate) fn read_bytes(&self) -> u64 {
        self.read_bytes
    }

    /// Number of changes of the header by the body so far.
    pub(crate) fn header_changes(&self) -> u64 {
        self.header_changes
    }

    /// RTKLIB's choice of signals for this file: per file from the header in version 3 and later,
    /// per satellite before.
    pub fn signal_choice(&self) -> SignalChoice {
        if self.header.version < 300 {
            return SignalChoice::PerSatellite;
        }
        SignalChoice::per_file(System::ALL.into_iter().flat_map(|s| {
            self.header
                .signals(s)
                .into_iter()
                .map(move |code| (s, code))
        }))
    }

    /// Data dropped so far; the report starts again.
    pub fn take_report(&mut self) -> ReadReport {
        let mut report = std::mem::take(&mut self.report);
        report.absorb(self.source.take_report());
        report
    }

    /// The next epoch or event; `None` at the end.
    ///
    /// # Errors
    /// [`ReadError`] where the input fails or a second header inside cannot be read.
    pub fn next_record(&mut self) -> Result<Option<ObservationRecord>, ReadError> {
        let mut skipping = false;
        while self.next_line()? {
            let line = self.source.line();
            if line.trim_ascii().is_empty() {
                continue;
            }
            if column(line, 60, 20) == b"RINEX VERSION / TYPE" {
                self.second_header()?;
                continue;
            }
            let epoch = if self.header.version < 300 {
                EpochLine::parse_v2(line)
            } else {
                EpochLine::parse_v3(line)
            };
            let Some(epoch) = epoch else {
                // Lines after an unreadable epoch belong to that epoch, up to the next readable epoch line.
                if !skipping {
                    skipping = true;
                    self.report
                        .drop_one(DropReason::UnreadableEpoch, self.here());
                }
                continue;
            };
            skipping = false;
            self.place = self.here();
            if let Some(record) = self.take_record(&epoch)? {
                return Ok(Some(record));
            }
        }
        Ok(None)
    }

    fn here(&self) -> Place {
        Place::Line(self.source.number())
    }

    fn next_line(&mut self) -> Result<bool, ReadError> {
        if std::mem::take(&mut self.pending) {
            return Ok(true);
        }
        let has_line = self.source.advance()?;
        self.read_bytes += self.source.line().len() as u64;
        Ok(has_line)
    }

    /// Reads the header in the middle of concatenated files, which then applies.
    fn second_header(&mut self) -> Result<(), ReadError> {
        let number = self.source.number();
        let header = ObservationHeader::read(&mut self.source, &mut self.report)?;
        self.header_changes += 1;
        self.report
            .remarks
            .push(format!("another header at line {number}"));
        if header.station.marker != self.header.station.marker {
            self.report.remarks.push(format!(
                "the marker changes from {:?} to {:?}: two stations in one file?",
                self.header.station.marker, header.station.marker
            ));
        }
        let (station, channels) = (
            self.header.station.clone(),
            self.header.glonass_channels.clone(),
        );
        self.header = header;
        self.header.station = station;
        self.header.glonass_channels.extend(channels);
        Ok(())
    }

    fn take_record(&mut self, epoch: &EpochLine) -> Result<Option<ObservationRecord>, ReadError> {
        match epoch.flag {
            3 | 4 => self.header_lines(epoch.count).map(|()| None),
            5 => self.event(epoch),
            2 if epoch.time.is_none() => self.header_lines(epoch.count).map(|()| None),
            _ => self.observations(epoch),
        }
    }

    fn header_lines(&mut self, count: usize) -> Result<(), ReadError> {
        self.header_changes += 1;
        for _ in 0..count {
            if !self.next_line()? {
                self.report.drop_one(DropReason::CutOff, self.here());
                return Ok(());
            }
            let (line, number) = (self.source.line(), self.source.number());
            self.header.record(line, number, &mut self.report);
        }
        Ok(())
    }

    /// Time of an epoch line; an unreadable one is counted as dropped.
    fn gps_time(&mut self, epoch: &EpochLine, place: Place) -> Option<GpsTime> {
        let time = (epoch.time.as_ref()).and_then(|t| self.header.time_system.gps_time(t));
        if time.is_none() {
            self.report.drop_one(DropReason::UnreadableEpoch, place);
        }
        time
    }

    fn event(&mut self, epoch: &EpochLine) -> Result<Option<ObservationRecord>, ReadError> {
        let place = self.here();
        for _ in 0..epoch.count {
            if !self.next_line()? {
                self.report.drop_one(DropReason::CutOff, self.here());
                break;
            }
        }
        let Some(time) = self.gps_time(epoch, place) else {
            return Ok(None);
        };
        Ok(Some(ObservationRecord::Event(EventRecord {
            time,
            kind: EventKind::External,
            count: None,
            accuracy_s: None,
        })))
    }

    fn observations(&mut self, epoch: &EpochLine) -> Result<Option<ObservationRecord>, ReadError> {
        let place = self.here();
        let mut satellites = Vec::new();
        let taken = if self.header.version < 300 {
            self.satellites_v2(epoch, &mut satellites)?
        } else {
            self.satellites_v3(epoch, &mut satellites)?
        };
        match taken {
            Taken::Whole => {}
            Taken::Interrupted | Taken::Ended => {
                self.report.drop_one(DropReason::CutOff, place);
                return Ok(None);
            }
        }
        if epoch.flag == 6 {
            self.report.drop_one(DropReason::CycleSlipRecord, place);
            return Ok(None);
        }
        let Some(time) = self.gps_time(epoch, place) else {
            return Ok(None);
        };
        Ok(Some(ObservationRecord::Epoch(RecordedEpoch {
            time,
            receiver_clock_s: epoch.receiver_clock_s,
            satellites,
        })))
    }

    fn satellites_v3(
        &mut self,
        epoch: &EpochLine,
        out: &mut Vec<RecordedSatellite>,
    ) -> Result<Taken, ReadError> {
        for _ in 0..epoch.count {
            if !self.next_line()? {
                return Ok(Taken::Ended);
            }
            let line = self.source.line();
            if line.first() == Some(&b'>') {
                self.pending = true;
                return Ok(Taken::Interrupted);
            }
            let values = line.get(3..).unwrap_or(&[]);
            if !self.source.terminated() && (values.len() < 14 || cut_in_value(values)) {
                return Ok(Taken::Ended);
            }
            let place = Place::Line(self.source.number());
            let name = column(line, 0, 3);
            let Some(satellite) = satellite(name) else {
                if matches!(epoch.flag, 2) && line.len() > 60 {
                    self.header
                        .record(line, self.source.number(), &mut self.report);
                } else {
                    let name = String::from_utf8_lossy(name).into_owned();
                    self.report
                        .drop_one(DropReason::UnknownSatellite(name), place);
                }
                continue;
            };
            let Some(columns) = self.header.columns(satellite.system()) else {
                let letter = satellite.system().letter();
                self.report
                    .drop_one(DropReason::UndeclaredSystem(letter), place);
                continue;
            };
            let signals = take_signals(columns, values.chunks(16), place, &mut self.report);
            push_satellite(out, satellite, signals, place, &mut self.report);
        }
        Ok(Taken::Whole)
    }

    fn satellites_v2(
        &mut self,
        epoch: &EpochLine,
        out: &mut Vec<RecordedSatellite>,
    ) -> Result<Taken, ReadError> {
        // The satellites are 12 to a line, from column 33.
        let mut names: Vec<[u8; 3]> = Vec::new();
        if matches!(epoch.flag, 2) && column(self.source.line(), 32, 36).trim_ascii().is_empty() {
            self.header_lines(epoch.count)?;
            return Ok(Taken::Whole);
        }
        for i in 0..epoch.count {
            if i > 0 && i % 12 == 0 {
                if !self.next_line()? {
                    return Ok(Taken::Ended);
                }
                if !column(self.source.line(), 0, 32).trim_ascii().is_empty() {
                    self.pending = true;
                    return Ok(Taken::Interrupted);
                }
            }
            let mut name = [b' '; 3];
            for (to, &from) in name
                .iter_mut()
                .zip(column(self.source.line(), 32 + 3 * (i % 12), 3))
            {
                *to = from;
            }
            names.push(name);
        }
        let types = self.header.columns(System::Gps).map_or(0, <[Column]>::len);
        let rows = types.div_ceil(5).max(1);
        for name in names {
            let mut values = Vec::with_capacity(80 * rows);
            for row in 0..rows {
                if !self.next_line()? {
                    return Ok(Taken::Ended);
                }
                let line = self.source.line();
                if EpochLine::interrupts_v2(line) || column(line, 60, 20) == b"RINEX VERSION / TYPE"
                {
                    self.pending = true;
                    return Ok(Taken::Interrupted);
                }
                if !self.source.terminated()
                    && (line.len() < 14 || cut_in_value(line) || row + 1 < rows)
                {
                    return Ok(Taken::Ended);
                }
                values.extend_from_slice(&line[..line.len().min(80)]);
                values.resize(80 * (row + 1), b' ');
            }
            let place = Place::Line(self.source.number());
            let Some(satellite) = satellite(&name) else {
                let name = String::from_utf8_lossy(&name).into_owned();
                self.report
                    .drop_one(DropReason::UnknownSatellite(name), place);
                continue;
            };
            let Some(columns) = self.header.columns(satellite.system()) else {
                continue;
            };
            let signals = take_signals(columns, values.chunks(16), place, &mut self.report);
            push_satellite(out, satellite, signals, place, &mut self.report);
        }
        Ok(Taken::Whole)
    }
}

/// A satellite's name; a blank letter means GPS.
fn satellite(name: &[u8]) -> Option<SatelliteId> {
    let &[letter, tens, units] = name else {
        return None;
    };
    let letter = if letter == b' ' {
        b'G'
    } else {
        letter.to_ascii_uppercase()
    };
    let tens = if tens == b' ' { b'0' } else { tens };
    std::str::from_utf8(&[letter, tens, units])
        .ok()?
        .parse()
        .ok()
}

/// Whether a line without its line feed ends inside a value: a whole value has 14 characters, and
/// blanks behind it may be missing.
fn cut_in_value(values: &[u8]) -> bool {
    let over = values.len() % 16;
    let last = values.len() - over;
    over > 0 && over < 14 && !values[last..].trim_ascii().is_empty()
}

fn push_satellite(
    out: &mut Vec<RecordedSatellite>,
    satellite: SatelliteId,
    signals: Vec<SignalObservation>,
    place: Place,
    report: &mut ReadReport,
) {
    if out.iter().any(|s| s.satellite == satellite) {
        report.drop_one(DropReason::DuplicateSatellite, place);
    } else if !signals.is_empty() {
        out.push(RecordedSatellite { satellite, signals });
    }
}

/// The signals of one satellite from its 16-character fields.
fn take_signals<'a>(
    columns: &[Column],
    fields: impl Iterator<Item = &'a [u8]>,
    place: Place,
    report: &mut ReadReport,
) -> Vec<SignalObservation> {
    let mut signals: Vec<SignalObservation> = Vec::new();
    for (column, field) in columns.iter().zip(fields) {
        let Some((quantity, codes)) = &column.meaning else {
            if !field.trim_ascii().is_empty() {
                report.drop_one(DropReason::PseudoObservation(column.name.clone()), place);
            }
            continue;
        };
        let value = real(&field[..field.len().min(14)]).unwrap_or_else(|_| {
            report.drop_one(DropReason::UnreadableNumber, place);
            None
        });
        // Some writers use exactly zero in place of blanks.
        let value = value.filter(|&v| v != 0.0).map(|v| v / column.scale);
        let lock = match field.get(14) {
            None | Some(b' ') => LossOfLock(0),
            Some(&digit @ b'0'..=b'9') => LossOfLock((digit - b'0') & 3),
            // An unreadable flag counts as a possible loss of lock.
            Some(_) => LossOfLock(LossOfLock::SLIP),
        };
        let lock = if *quantity == Quantity::Phase {
            lock
        } else {
            LossOfLock(0)
        };
        if value.is_none() && lock == LossOfLock(0) {
            continue;
        }
        for &code in codes {
            let at = signals
                .iter()
                .position(|s| s.code == code)
                .unwrap_or_else(|| {
                    signals.push(SignalObservation::empty(code));
                    signals.len() - 1
                });
            let signal = &mut signals[at];
            match quantity {
                Quantity::Pseudorange => signal.pseudorange_m = value,
                Quantity::Phase => {
                    signal.phase_cycles = value;
                    signal.loss_of_lock = lock;
                }
                Quantity::Doppler => signal.doppler_hz = value,
                Quantity::Strength => signal.cn0_db_hz = value,
            }
        }
    }
    signals
}
