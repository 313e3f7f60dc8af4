//! Report of the data that a reader dropped.

use std::fmt;

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Line number, from 1 (of the file as stored: for Hatanaka-compressed input, the compressed
    /// lines; for gzip, the lines inside).
    Line(u64),
    /// Byte offset, from 0 (after gzip decompression).
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
        }
    }
}

/// Reason for which data of a file were dropped.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum DropReason {
    /// A field that should hold a number does not; taken as absent.
    UnreadableNumber,
    /// A satellite identifier of no supported system; the satellite's observations are skipped.
    UnknownSatellite(String),
    /// An observation column whose type is not code, phase, Doppler or strength (X1, I1 …).
    PseudoObservation(String),
    /// An epoch line that cannot be read; lines up to the next epoch are skipped.
    UnreadableEpoch,
    /// A line between records that belongs to no record.
    StrayLine,
    /// The file ends inside an epoch or record, which is dropped.
    CutOff,
    /// A satellite twice in one epoch; the first is kept.
    DuplicateSatellite,
    /// A second epoch with the tag of an earlier one.
    DuplicateEpoch,
    /// An epoch earlier than the one before it (kept; the order is restored).
    EpochOutOfOrder,
    /// Cycle-slip records (epoch flag 6): not observations.
    CycleSlipRecord,
    /// A header record with a value outside its range; ignored.
    HeaderRecord(String),
    /// A navigation record that cannot be read as a whole.
    UnreadableNavigationRecord,
    /// A navigation message of a kind that is not used (RINEX 4 `CNAV`, `STO` …).
    UnusedNavigationMessage(String),
    /// A broadcast record that was read before.
    DuplicateNavigationRecord,
    /// A Hatanaka difference that is damaged or refers to a missing arc.
    BrokenDifference,
    /// UBX: checksum mismatch.
    Checksum,
    /// UBX: bytes outside any frame (NMEA, RTCM or noise).
    OutsideFrames,
    /// UBX: a well-formed message that this reader does not use, named by class and identifier.
    UnusedMessage {
        /// Message class.
        class: u8,
        /// Message identifier.
        id: u8,
    },
    /// UBX: a known message whose payload length or content is impossible.
    MalformedMessage {
        /// Message class.
        class: u8,
        /// Message identifier.
        id: u8,
    },
    /// UBX: a time mark that the receiver calls invalid.
    TimeNotValid,
    /// UBX: a measurement epoch with no week number yet.
    NoWeek,
    /// Observations of a system for which the header declares no types.
    UndeclaredSystem(char),
    /// An epoch all of whose observations are of signals that the processing does not use.
    UnusedSignals,
    /// A signal that is not mapped to a RINEX observation code.
    UnknownSignal,
    /// A carrier phase that the receiver itself marks as not usable.
    PhaseNotUsable,
    /// A navigation frame with wrong parity or content that contradicts itself.
    InvalidNavigationFrame,
    /// RTCM 3: bytes outside any message.
    OutsideMessages,
    /// RTCM 3: a well-formed message that this reader does not use.
    UnusedRtcmMessage {
        /// Message number.
        number: u16,
    },
    /// RTCM 3: a message shorter than its content, or with content that is impossible.
    MalformedRtcmMessage {
        /// Message number.
        number: u16,
    },
    /// RTCM 3: an epoch whose last message announces another that is missing; the present ones are kept.
    IncompleteEpoch,
    /// RTCM 3: observations of another reference station than the first.
    OtherStation,
    /// ANTEX: the calibration of an antenna with an incomplete table.
    UnreadableCalibration(String),
    /// A GLONASS phase whose frequency channel is not known.
    UnknownChannel,
}

impl fmt::Display for DropReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnreadableNumber => f.write_str("unreadable number"),
            Self::UnknownSatellite(name) => write!(f, "unknown satellite {name:?}"),
            Self::PseudoObservation(code) => write!(f, "pseudo-observation {code}"),
            Self::UnreadableEpoch => f.write_str("unreadable epoch"),
            Self::StrayLine => f.write_str("stray line"),
            Self::CutOff => f.write_str("cut off"),
            Self::DuplicateSatellite => f.write_str("satellite twice in one epoch"),
            Self::DuplicateEpoch => f.write_str("epoch repeated"),
            Self::EpochOutOfOrder => f.write_str("epoch out of order"),
            Self::CycleSlipRecord => f.write_str("cycle-slip record"),
            Self::HeaderRecord(label) => write!(f, "header record {label}"),
            Self::UnreadableNavigationRecord => f.write_str("unreadable navigation record"),
            Self::UnusedNavigationMessage(kind) => write!(f, "unused navigation message {kind}"),
            Self::DuplicateNavigationRecord => f.write_str("navigation record repeated"),
            Self::BrokenDifference => f.write_str("broken Hatanaka difference"),
            Self::Checksum => f.write_str("checksum mismatch"),
            Self::OutsideFrames => f.write_str("bytes outside UBX frames"),
            Self::UnusedMessage { class, id } => write!(f, "unused message {class:02X} {id:02X}"),
            Self::MalformedMessage { class, id } => {
                write!(f, "malformed message {class:02X} {id:02X}")
            }
            Self::TimeNotValid => f.write_str("time mark not valid"),
            Self::NoWeek => f.write_str("no week number"),
            Self::UndeclaredSystem(letter) => {
                write!(f, "no observation types declared for system {letter}")
            }
            Self::UnusedSignals => f.write_str("epoch without a signal that is used"),
            Self::UnknownSignal => f.write_str("unknown signal"),
            Self::PhaseNotUsable => f.write_str("phase not usable"),
            Self::InvalidNavigationFrame => f.write_str("invalid navigation frame"),
            Self::OutsideMessages => f.write_str("bytes outside RTCM messages"),
            Self::UnusedRtcmMessage { number } => write!(f, "unused message {number}"),
            Self::MalformedRtcmMessage { number } => write!(f, "malformed message {number}"),
            Self::IncompleteEpoch => f.write_str("epoch with a message missing"),
            Self::OtherStation => f.write_str("observations of another reference station"),
            Self::UnreadableCalibration(antenna) => {
                write!(f, "unreadable calibration of {antenna}")
            }
            Self::UnknownChannel => f.write_str("GLONASS phase of unknown frequency channel"),
        }
    }
}

/// One reason with its number of occurrences and the first place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dropped {
    /// The reason.
    pub reason: DropReason,
    /// Number of items (values, satellites, epochs, messages or bytes, by reason).
    pub count: u64,
    /// The first place.
    pub first: Place,
}

/// Format that a reader recognised, and the data that it dropped.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReadReport {
    /// The format in words, such as `RINEX 3.04 observation, Hatanaka 3.0, gzip`.
    pub format: String,
    /// Dropped items by reason, in order of first appearance.
    pub dropped: Vec<Dropped>,
    /// Further remarks for a user of the file (a second header, half wavelengths …).
    pub remarks: Vec<String>,
}

impl ReadReport {
    /// Largest number of distinct reasons; further reasons of a file are merged into
    /// [`DropReason::StrayLine`], which bounds the report's size.
    const MAX_REASONS: usize = 256;

    /// Counts `count` items under `reason`.
    pub fn drop_many(&mut self, reason: DropReason, place: Place, count: u64) {
        if count == 0 {
            return;
        }
        if let Some(entry) = self.dropped.iter_mut().find(|d| d.reason == reason) {
            entry.count += count;
        } else if self.dropped.len() < Self::MAX_REASONS || reason == DropReason::StrayLine {
            self.dropped.push(Dropped {
                reason,
                count,
                first: place,
            });
        } else {
            self.drop_many(DropReason::StrayLine, place, count);
        }
    }

    /// Counts one item under `reason`.
    pub fn drop_one(&mut self, reason: DropReason, place: Place) {
        self.drop_many(reason, place, 1);
    }

    /// Number of items dropped for `reason`.
    pub fn count(&self, reason: &DropReason) -> u64 {
        self.dropped
            .iter()
            .find(|d| d.reason == *reason)
            .map_or(0, |d| d.count)
    }

    /// Adds the drops of another report (of an inner layer, or of another file).
    pub fn absorb(&mut self, other: Self) {
        for d in other.dropped {
            self.drop_many(d.reason, d.first, d.count);
        }
        self.remarks.extend(other.remarks);
    }
}

impl fmt::Display for ReadReport {
    /// The format on the first line, then one line for each reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.format)?;
        for remark in &self.remarks {
            write!(f, "\n  {remark}")?;
        }
        for d in &self.dropped {
            write!(f, "\n  {}: {}, first at {}", d.reason, d.count, d.first)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_by_reason_and_keeps_the_first_place() {
        let mut report = ReadReport::default();
        report.drop_one(DropReason::CutOff, Place::Line(9));
        report.drop_many(DropReason::CutOff, Place::Line(12), 4);
        report.drop_many(DropReason::Checksum, Place::Byte(0), 0);
        assert_eq!(report.count(&DropReason::CutOff), 5);
        assert_eq!(report.dropped.len(), 1);
        assert_eq!(report.dropped[0].first, Place::Line(9));
    }

    #[test]
    fn noise_cannot_grow_the_report_without_bound() {
        let mut report = ReadReport::default();
        for n in 0..10_000 {
            report.drop_one(DropReason::UnknownSatellite(format!("{n}")), Place::Line(n));
        }
        assert!(report.dropped.len() <= ReadReport::MAX_REASONS + 1);
        assert_eq!(report.dropped.iter().map(|d| d.count).sum::<u64>(), 10_000);
    }
}
