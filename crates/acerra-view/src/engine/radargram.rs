//! The radargram of a track as a field: a column a trace, a row a sample of fast time.

use acerra_chain::Track;
use acerra_radar::{Radargram, Samples};
use num_complex::Complex32;
use serde::Deserialize;

use crate::raster::{Field, Precision, Pyramid, TileIndex};

/// Progress of a radargram.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Zero-timed, otherwise as logged.
    Raw,
    /// Without background, gated.
    Clean,
}

/// Levels of the radargrams of a track.
#[derive(Debug)]
pub struct TrackRadargram {
    raw: Pyramid,
    clean: Pyramid,
}

impl Field for &Radargram {
    fn size(&self) -> [usize; 2] {
        [self.traces, self.samples_per_trace]
    }
    fn at(&self, column: usize, row: usize) -> Complex32 {
        let index = column * self.samples_per_trace + row;
        match &self.samples {
            Samples::Real(values) => Complex32::new(values[index], 0.0),
            Samples::Complex(values) => values[index],
        }
    }
}

impl TrackRadargram {
    /// The levels of a track's radargrams; none where its log holds spectra.
    #[must_use]
    pub fn of(track: &Track) -> Option<Self> {
        let traces = track.cleaned.as_ref()?;
        Some(Self {
            raw: Pyramid::of(&&traces.raw),
            clean: Pyramid::of(&&traces.clean),
        })
    }

    /// Number of levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.clean.count()
    }

    /// A tile of the radargram of `track`; none where there is no such tile.
    #[must_use]
    pub fn tile(&self, track: &Track, stage: Stage, index: TileIndex) -> Option<Vec<u8>> {
        let traces = track.cleaned.as_ref()?;
        match stage {
            Stage::Raw => self.raw.tile(&&traces.raw, index, Precision::Single),
            Stage::Clean => self.clean.tile(&&traces.clean, index, Precision::Single),
        }
    }
}
