//! Reading an ANTEX file (Rothacher and Schmid, ANTEX: The Antenna Exchange Format, version 1.4).

use std::collections::BTreeMap;

use super::calibration::{AntennaCalibration, FrequencyCalibration};
use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};
use crate::observations::satellite::System;
use crate::rinex::{column, real, text};

/// Largest number of values of a table in one direction: steps of a quarter of a degree.
const MAX_STEPS: f64 = 1441.0;

/// The receiver antennas of an ANTEX file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AntexFile {
    /// Calibrations by antenna type and radome, in the file's order.
    pub antennas: Vec<AntennaCalibration>,
}

impl AntexFile {
    /// The calibration of an antenna by its name in a RINEX header: type, then radome from column 17 on.
    /// Where the radome is not given, or not calibrated, the calibration without a radome (`NONE`) is
    /// returned, under the name found.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<&AntennaCalibration> {
        let wanted: Vec<&str> = name.split_whitespace().collect();
        let named = |radome: &str| {
            let type_ = *wanted.first()?;
            self.antennas.iter().find(|a| {
                let own: Vec<&str> = a.antenna.split_whitespace().collect();
                own.first() == Some(&type_) && own.get(1).copied().unwrap_or("NONE") == radome
            })
        };
        named(wanted.get(1).copied().unwrap_or("NONE")).or_else(|| named("NONE"))
    }
}

/// Reads the receiver antennas of an ANTEX file; satellites' antennas are passed over.
///
/// # Errors
/// [`ReadError`] where the first line is not that of ANTEX 1.x, the variations are relative to
/// another antenna, or the input fails.
pub fn read_antex(source: &mut impl LineSource) -> Result<(AntexFile, ReadReport), ReadError> {
    header(source)?;
    let mut out = AntexFile::default();
    let mut report = ReadReport::default();
    let mut open: Option<Antenna> = None;
    while source.advance()? {
        let (line, place) = (source.line(), Place::Line(source.number()));
        match column(line, 60, 20).trim_ascii_end() {
            b"START OF ANTENNA" => {
                if open.replace(Antenna::default()).is_some() {
                    report.drop_one(DropReason::CutOff, place);
                }
            }
            b"END OF ANTENNA" => match open.take().map(Antenna::finish) {
                Some(Ok(Some(antenna))) => out.antennas.push(antenna),
                Some(Ok(None)) => {}
                Some(Err(reason)) => report.drop_one(reason, place),
                None => report.drop_one(DropReason::StrayLine, place),
            },
            label => {
                if let Some(antenna) = &mut open {
                    antenna.line(label, line);
                }
            }
        }
    }
    if open.is_some() {
        report.drop_one(DropReason::CutOff, Place::Line(source.number()));
    }
    report.absorb(source.take_report());
    report.format = "ANTEX".to_owned();
    Ok((out, report))
}

fn header(source: &mut impl LineSource) -> Result<(), ReadError> {
    if !source.advance()? {
        return Err(ReadError::Empty);
    }
    let (line, number) = (source.line(), source.number());
    if column(line, 60, 20).trim_ascii_end() != b"ANTEX VERSION / SYST" {
        return Err(ReadError::format(number, "ANTEX VERSION / SYST", line));
    }
    let version = real(column(line, 0, 8)).ok().flatten().unwrap_or(0.0);
    if !(1.0..2.0).contains(&version) {
        return Err(ReadError::Unsupported {
            line: number,
            what: format!("ANTEX version {version:.1}"),
        });
    }
    while source.advance()? {
        let (line, number) = (source.line(), source.number());
        match column(line, 60, 20).trim_ascii_end() {
            b"END OF HEADER" => return Ok(()),
            b"PCV TYPE / REFANT" if column(line, 0, 1) != b"A" => {
                return Err(ReadError::Unsupported {
                    line: number,
                    what: "relative phase centre variations".to_owned(),
                });
            }
            _ => {}
        }
    }
    Err(ReadError::MissingHeader {
        line: source.number(),
        missing: "END OF HEADER",
    })
}

/// An antenna whose lines are being read.
#[derive(Default)]
struct Antenna {
    name: String,
    satellite: bool,
    /// Degrees.
    azimuth_step: f64,
    /// First, last and step (degrees).
    zenith: [f64; 3],
    frequency: Option<((System, u8), FrequencyCalibration)>,
    /// Whether the current lines are rms values, which are not calibrations.
    rms: bool,
    frequencies: BTreeMap<(System, u8), FrequencyCalibration>,
    damaged: bool,
}

impl Antenna {
    fn line(&mut self, label: &[u8], line: &[u8]) {
        match label {
            b"TYPE / SERIAL NO" => {
                self.name = text(line, 0, 20);
                // Satellites have their number and code where receivers have a serial number.
                self.satellite = !text(line, 40, 20).is_empty();
            }
            b"DAZI" => self.azimuth_step = self.number(column(line, 2, 6)),
            b"ZEN1 / ZEN2 / DZEN" => {
                self.zenith = [2, 8, 14].map(|at| self.number(column(line, at, 6)));
            }
            b"START OF FREQUENCY" => self.start(column(line, 3, 3)),
            b"NORTH / EAST / UP" => {
                let [north, east, up] = [0, 10, 20].map(|at| self.number(column(line, at, 10)));
                if let Some((_, open)) = &mut self.frequency {
                    open.offset_enu_m = [east, north, up].map(|mm| mm * 1e-3);
                }
            }
            b"END OF FREQUENCY" => {
                if let Some((key, done)) = self.frequency.take() {
                    self.frequencies.entry(key).or_insert(done);
                }
            }
            b"START OF FREQ RMS" => self.rms = true,
            b"END OF FREQ RMS" => self.rms = false,
            _ if self.frequency.is_some() && !self.rms => self.variations(line),
            _ => {}
        }
    }

    /// A mandatory number.
    fn number(&mut self, field: &[u8]) -> f64 {
        match real(field) {
            Ok(Some(value)) => value,
            _ => {
                self.damaged = true;
                0.0
            }
        }
    }

    fn start(&mut self, name: &[u8]) {
        let key = match *name {
            [letter, tens, units] => System::from_letter(match letter {
                b' ' => 'G',
                letter => char::from(letter),
            })
            .filter(|_| matches!(tens, b'0' | b' '))
            .zip(units.is_ascii_digit().then(|| units.wrapping_sub(b'0'))),
            _ => None,
        };
        let [first, last, step] = self.zenith;
        let sane = |first: f64, last: f64, step: f64| {
            step > 0.0 && last > first && (last - first) / step <= MAX_STEPS
        };
        if !sane(first, last, step)
            || (self.azimuth_step != 0.0 && !sane(0.0, 360.0, self.azimuth_step))
        {
            self.damaged = true;
        }
        self.frequency = key.map(|key| {
            let empty = FrequencyCalibration {
                offset_enu_m: [0.0; 3],
                zenith_rad: self.zenith.map(f64::to_radians),
                variation_m: Vec::new(),
                azimuth_variation_m: Vec::new(),
                azimuth_step_rad: self.azimuth_step.to_radians(),
            };
            (key, empty)
        });
    }

    /// A line of variations (mm): `NOAZI` or an azimuth, then one for each zenith angle.
    fn variations(&mut self, line: &[u8]) {
        if self.damaged {
            return;
        }
        let [first, last, step] = self.zenith;
        let count = ((last - first) / step).round() as usize + 1;
        let mut values = Vec::with_capacity(count);
        for k in 0..count {
            values.push(self.number(column(line, 8 + 8 * k, 8)) * 1e-3);
        }
        let azimuth = column(line, 0, 8).trim_ascii();
        let Some((_, open)) = &mut self.frequency else {
            return;
        };
        if azimuth == b"NOAZI" {
            open.variation_m = values;
            return;
        }
        let due = open.azimuth_variation_m.len() as f64 * self.azimuth_step;
        let here = real(azimuth).ok().flatten();
        if here.is_none_or(|here| (here - due).abs() > 0.01) || due > 360.0 {
            self.damaged = true;
        } else {
            open.azimuth_variation_m.push(values);
        }
    }

    /// The calibration; `None` for satellites' antennas.
    fn finish(self) -> Result<Option<AntennaCalibration>, DropReason> {
        if self.satellite {
            return Ok(None);
        }
        let step = self.azimuth_step;
        let rows = if step > 0.0 {
            (360.0 / step).round() as usize + 1
        } else {
            0
        };
        let whole = |c: &FrequencyCalibration| {
            !c.variation_m.is_empty()
                && (c.azimuth_variation_m.is_empty() || c.azimuth_variation_m.len() == rows)
        };
        let good = !self.damaged
            && self.frequency.is_none()
            && !self.name.is_empty()
            && self.frequencies.values().all(whole);
        if !good {
            return Err(DropReason::UnreadableCalibration(self.name));
        }
        Ok(Some(AntennaCalibration {
            antenna: self.name,
            frequencies: self.frequencies,
        }))
    }
}
