//! Samples by source, counted against a limit.

use std::collections::HashMap;

use crate::error::LogError;
use crate::format::LogFormat;
use crate::sample::{
    AttitudeSample, AttitudeSource, ClockPair, Damage, GimbalSample, GimbalSource, PairKind,
    PositionSample, PositionSource, Recording, SourceKind,
};

/// Memory (bytes) that a position takes until the trajectory is made.
const POSITION_BYTES: u64 = 800;
/// Memory (bytes) that the positions of any log may take.
const FREE_BYTES: u64 = 64 << 20;
/// Memory of positions per byte of the log beyond that: a receiver's message has 80 bytes or more in a log that
/// holds attitudes as well.
const MOST_TIMES: u64 = 10;

/// Collects the records of a reader.
#[derive(Debug)]
pub struct Collector {
    format: LogFormat,
    limit: usize,
    positions: Vec<PositionSource>,
    attitudes: Vec<AttitudeSource>,
    gimbals: Vec<GimbalSource>,
    index: HashMap<String, usize>,
    attitude_index: HashMap<String, usize>,
    gimbal_index: HashMap<String, usize>,
    pairs: Vec<ClockPair>,
    /// Bytes that belong to no record.
    pub damage: Damage,
    /// Remarks, as sentences.
    pub remarks: Vec<String>,
}

/// Source of positions.
#[derive(Debug, Clone, Copy)]
pub struct Origin<'a> {
    /// Name of the source.
    pub name: &'a str,
    /// Source of the samples.
    pub kind: SourceKind,
    /// As of [`PositionSource::rank`].
    pub rank: u8,
}

impl<'a> Origin<'a> {
    /// A source that goes before others of its kind.
    pub const fn first(name: &'a str, kind: SourceKind) -> Self {
        Self {
            name,
            kind,
            rank: 0,
        }
    }

    /// A source that is taken where there is none that goes before it.
    pub const fn second(name: &'a str, kind: SourceKind) -> Self {
        Self {
            name,
            kind,
            rank: 1,
        }
    }
}

/// How a format gives the time.
#[derive(Debug, Clone, Copy)]
pub struct ClockSource {
    /// Origin of the readings.
    pub kind: PairKind,
    /// What gives them.
    pub name: &'static str,
    /// Whether times by an unrelated clock suffice.
    pub allows_own: bool,
}

impl Collector {
    /// An empty collection that takes at most `limit` samples of each kind from a source.
    pub fn new(format: LogFormat, limit: usize) -> Self {
        Self {
            format,
            limit,
            positions: Vec::new(),
            attitudes: Vec::new(),
            gimbals: Vec::new(),
            index: HashMap::new(),
            attitude_index: HashMap::new(),
            gimbal_index: HashMap::new(),
            pairs: Vec::new(),
            damage: Damage::default(),
            remarks: Vec::new(),
        }
    }

    fn source(&mut self, Origin { name, kind, rank }: Origin<'_>) -> &mut PositionSource {
        let at = match self.index.get(name) {
            Some(at) => *at,
            None => {
                self.positions.push(PositionSource {
                    name: name.to_owned(),
                    kind,
                    rank,
                    samples: Vec::new(),
                    without_position: 0,
                });
                self.index.insert(name.to_owned(), self.positions.len() - 1);
                self.positions.len() - 1
            }
        };
        &mut self.positions[at]
    }

    fn limit(&self, count: usize, what: &'static str, offset: u64) -> Result<(), LogError> {
        if count < self.limit {
            return Ok(());
        }
        Err(LogError::Limit {
            offset,
            what,
            limit: self.limit as u64,
        })
    }

    /// Takes a position, or counts a record without one.
    ///
    /// # Errors
    /// More positions than the limit.
    pub fn position(
        &mut self,
        origin: Origin<'_>,
        sample: Option<PositionSample>,
        offset: u64,
    ) -> Result<(), LogError> {
        let source = self.source(origin);
        let Some(sample) = sample else {
            source.without_position += 1;
            return Ok(());
        };
        let count = source.samples.len();
        source.samples.push(sample);
        let in_proportion = (FREE_BYTES + MOST_TIMES.saturating_mul(offset)) / POSITION_BYTES;
        if count as u64 >= in_proportion {
            return Err(LogError::Limit {
                offset,
                what: "positions in so short a log",
                limit: in_proportion,
            });
        }
        self.limit(count, "positions", offset)
    }

    /// The latest position of the source `name`.
    pub fn latest(&mut self, name: &str) -> Option<&mut PositionSample> {
        let at = *self.index.get(name)?;
        self.positions[at].samples.last_mut()
    }

    /// Takes an attitude of the source `name`.
    ///
    /// # Errors
    /// More attitudes than the limit.
    pub fn attitude(
        &mut self,
        name: &str,
        sample: AttitudeSample,
        offset: u64,
    ) -> Result<(), LogError> {
        self.ranked_attitude(name, 0, sample, offset)
    }

    /// Adds an attitude of a source of that rank.
    ///
    /// # Errors
    /// More attitudes than the limit.
    pub fn ranked_attitude(
        &mut self,
        name: &str,
        rank: u8,
        sample: AttitudeSample,
        offset: u64,
    ) -> Result<(), LogError> {
        let at = match self.attitude_index.get(name) {
            Some(at) => *at,
            None => {
                self.attitudes.push(AttitudeSource {
                    name: name.to_owned(),
                    rank,
                    samples: Vec::new(),
                });
                self.attitude_index
                    .insert(name.to_owned(), self.attitudes.len() - 1);
                self.attitudes.len() - 1
            }
        };
        let count = self.attitudes[at].samples.len();
        self.attitudes[at].samples.push(sample);
        self.limit(count, "attitudes", offset)
    }

    /// Adds an attitude of the gimbal `name`, of a kind of message of that rank, or counts a record without
    /// one.
    ///
    /// # Errors
    /// More attitudes than the limit.
    pub fn gimbal(
        &mut self,
        name: &str,
        rank: u8,
        sample: Option<GimbalSample>,
        offset: u64,
    ) -> Result<(), LogError> {
        let at = match self.gimbal_index.get(name) {
            Some(at) => *at,
            None => {
                self.gimbals.push(GimbalSource {
                    name: name.to_owned(),
                    rank,
                    samples: Vec::new(),
                    without_attitude: 0,
                });
                self.gimbal_index
                    .insert(name.to_owned(), self.gimbals.len() - 1);
                self.gimbals.len() - 1
            }
        };
        let Some(sample) = sample else {
            self.gimbals[at].without_attitude += 1;
            return Ok(());
        };
        let count = self.gimbals[at].samples.len();
        self.gimbals[at].samples.push(sample);
        self.limit(count, "attitudes of a gimbal", offset)
    }

    /// The attitudes of the gimbal `name` so far.
    pub fn gimbal_samples(&mut self, name: &str) -> &mut [GimbalSample] {
        match self.gimbal_index.get(name) {
            Some(at) => &mut self.gimbals[*at].samples,
            None => &mut [],
        }
    }

    /// Counts the attitudes of the gimbal `name` as none.
    pub fn drop_gimbal(&mut self, name: &str) {
        if let Some(at) = self.gimbal_index.get(name) {
            let gimbal = &mut self.gimbals[*at];
            gimbal.without_attitude += gimbal.samples.len();
            gimbal.samples.clear();
        }
    }

    /// Takes a reading of the clocks.
    ///
    /// # Errors
    /// More readings than the limit.
    pub fn pair(&mut self, pair: ClockPair, offset: u64) -> Result<(), LogError> {
        self.pairs.push(pair);
        self.limit(self.pairs.len() - 1, "clock readings", offset)
    }

    /// The collected data of a file of `bytes` bytes.
    ///
    /// # Errors
    /// More than a twentieth of the file belongs to no record.
    pub fn finish(self, clock: ClockSource, bytes: u64) -> Result<Recording, LogError> {
        if self.damage.bytes > bytes / 20 {
            return Err(LogError::Damaged {
                offset: self.damage.first_offset,
                bytes: self.damage.bytes,
                total: bytes,
                format: self.format,
            });
        }
        Ok(Recording {
            format: self.format,
            positions: self.positions,
            attitudes: self.attitudes,
            gimbals: self.gimbals,
            pairs: self.pairs,
            pair_kind: clock.kind,
            pair_source: clock.name,
            allows_own_clock: clock.allows_own,
            damage: self.damage,
            bytes,
            remarks: self.remarks,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{HeightDatum, Place, Stamp};

    #[test]
    fn positions_are_in_proportion_to_the_log() {
        let place = Place::on_earth([47.0, 8.0, 400.0], HeightDatum::Ellipsoid).expect("a place");
        let most = |offset: u64| {
            let mut collector = Collector::new(LogFormat::Px4, 1_000_000);
            let mut taken = 0;
            let sample = PositionSample {
                stamp: Stamp::Boot(1.0),
                arrival_s: None,
                place,
                sigma_m: None,
                velocity_m_s: None,
                status: None,
                satellites: None,
            };
            let origin = Origin::first("gps", SourceKind::Gnss);
            while taken < 200_000 && collector.position(origin, Some(sample), offset).is_ok() {
                taken += 1;
            }
            taken
        };
        assert_eq!(most(0), (64 << 20) / 800);
        assert_eq!(most(200_000 * 80), 200_000);
    }
}
