//! Range tables in batches of pulses.
//!
//! Tables of all pulses are kept for any number of runs where memory holds them. Where it does not,
//! each run takes the pulses in batches: the tables of a batch are built, its image is added to the
//! sum, and the next batch takes the same memory.

use super::direct::{Direct, DirectSpec};
use super::factorized::aperture::partition_aperture;
use super::factorized::coarse::coarse_bytes;
use super::factorized::merged::{Factorized, Setting};
use super::factorized::spec::FactorizedSpec;
use super::tables::build::RangeTable;
use super::weights::WeightedPulses;
use crate::control::{Control, Meter};
use crate::error::ImagingError;
use crate::grid::image::{ImageGrid, Patch};
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Tally;
use crate::kernel::level::SimdLevel;
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

/// Share of the memory allowed that batches fill: building tables takes a little beside them.
const FILLED: f64 = 0.8;

/// An engine that images from range tables.
pub(crate) trait TableEngine: Sized + Sync {
    /// Its parameters.
    type Spec: Copy + Sync;

    /// Runs of pulses that stay together, and the bytes that each takes.
    fn parts(
        echoes: &WeightedPulses,
        ranges_m: &[[f64; 2]],
        grid: &TiltedGrid,
        spec: &Self::Spec,
    ) -> Vec<(Range<usize>, u128)>;

    /// The engine for some pulses, divided into `parts`.
    ///
    /// # Errors
    /// Cancellation.
    fn build(
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        ranges_m: &[[f64; 2]],
        spec: Self::Spec,
        parts: Vec<Range<usize>>,
        setting: Setting,
    ) -> Result<Self, ImagingError>;

    /// Images `patch` into `out` `[rows, columns]`. After cancellation `out` is incomplete.
    fn image(
        &self,
        echoes: &WeightedPulses,
        patch: &Patch,
        out: &mut [Complex32],
        meter: &Meter,
    ) -> Tally;

    /// Estimated run time on the threads of the current pool, s.
    fn estimate_s(&self, echoes: &WeightedPulses, grid: &ImageGrid, control: Control) -> f64;
}

/// The division of the pulses that the memory allowed asks for.
#[derive(Debug, Clone)]
pub(crate) struct Division {
    /// Batches of neighbouring parts.
    pub batches: Vec<Vec<Range<usize>>>,
    /// Bytes that a run takes beside the image.
    pub bytes: u128,
}

impl Division {
    /// One batch where it fits beside an image of `output_bytes`; else as few as do, with the image of
    /// a batch beside the sum. A part that does not fit is a batch of its own.
    pub fn of(parts: &[(Range<usize>, u128)], output_bytes: u128, limit_bytes: u128) -> Self {
        let bytes = parts.iter().map(|p| p.1).sum();
        if bytes + output_bytes <= limit_bytes {
            let all = parts.iter().map(|p| p.0.clone()).collect();
            return Self {
                batches: vec![all],
                bytes,
            };
        }
        let room = ((limit_bytes as f64 * FILLED) as u128).saturating_sub(2 * output_bytes);
        let mut batches: Vec<Vec<Range<usize>>> = vec![vec![]];
        let (mut filled, mut most) = (0, 0);
        for (part, bytes) in parts {
            if filled > 0 && filled + bytes > room {
                batches.push(vec![]);
                filled = 0;
            }
            filled += bytes;
            most = most.max(filled);
            if let Some(batch) = batches.last_mut() {
                batch.push(part.clone());
            }
        }
        Self {
            batches,
            bytes: most + output_bytes,
        }
    }
}

/// An engine with the tables of all pulses, or one that is built anew for every batch of them.
#[derive(Debug)]
pub(crate) enum Imager<E: TableEngine> {
    /// All pulses.
    Whole { spec: E::Spec, engine: E },
    /// A batch at a time.
    Batched(Batched<E::Spec>),
}

/// What every batch needs.
#[derive(Debug)]
pub(crate) struct Batched<S> {
    spec: S,
    batches: Vec<Vec<Range<usize>>>,
    ranges_m: Vec<[f64; 2]>,
    grid: TiltedGrid,
    level: SimdLevel,
}

impl<E: TableEngine> Imager<E> {
    /// Builds the tables where there is one batch.
    ///
    /// # Errors
    /// Cancellation.
    pub fn new(
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        ranges_m: &[[f64; 2]],
        spec: E::Spec,
        mut division: Division,
        setting: Setting,
    ) -> Result<Self, ImagingError> {
        if division.batches.len() > 1 {
            return Ok(Self::Batched(Batched {
                spec,
                batches: division.batches,
                ranges_m: ranges_m.to_vec(),
                grid: *grid,
                level: setting.level,
            }));
        }
        let parts = division.batches.pop().unwrap_or_default();
        let engine = E::build(echoes, grid, ranges_m, spec, parts, setting)?;
        Ok(Self::Whole { spec, engine })
    }

    /// The engine's parameters.
    pub fn spec(&self) -> &E::Spec {
        match self {
            Self::Whole { spec, .. } => spec,
            Self::Batched(batched) => &batched.spec,
        }
    }

    /// Number of batches.
    pub fn batches(&self) -> usize {
        match self {
            Self::Whole { .. } => 1,
            Self::Batched(batched) => batched.batches.len(),
        }
    }

    /// Images `grid` into `out` `[rows, columns]`. After cancellation `out` is incomplete.
    ///
    /// # Errors
    /// Cancellation while tables are built.
    pub fn run(
        &self,
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        out: &mut [Complex32],
        meter: &Meter,
    ) -> Result<(), ImagingError> {
        let batched = match self {
            Self::Whole { engine, .. } => {
                engine.image(echoes, &grid.whole(), out, meter);
                return Ok(());
            }
            Self::Batched(batched) => batched,
        };
        out.fill(Complex32::ZERO);
        let mut image = vec![Complex32::ZERO; out.len()];
        batched.each::<E>(echoes, meter.control(), |engine, echoes| {
            engine.image(echoes, &grid.whole(), &mut image, meter);
            out.par_iter_mut()
                .zip(&image)
                .for_each(|(sum, value)| *sum += value);
        })
    }

    /// Images pieces of the grid, each by itself, with the paths that their vectors took.
    ///
    /// # Errors
    /// Cancellation.
    pub fn pieces(
        &self,
        echoes: &WeightedPulses,
        pieces: &[Patch],
        control: Control,
    ) -> Result<Vec<(Vec<Complex32>, Tally)>, ImagingError> {
        let image = |engine: &E, echoes: &WeightedPulses, patch: &Patch| {
            let mut out = vec![Complex32::ZERO; patch.grid.columns * patch.grid.rows];
            let tally = engine.image(echoes, patch, &mut out, &Meter::silent(control));
            (out, tally)
        };
        let found = match self {
            Self::Whole { engine, .. } => pieces
                .par_iter()
                .map(|patch| image(engine, echoes, patch))
                .collect(),
            Self::Batched(batched) => {
                let nothing = |patch: &Patch| {
                    let zeros = vec![Complex32::ZERO; patch.grid.columns * patch.grid.rows];
                    (zeros, Tally::default())
                };
                let mut sums: Vec<(Vec<Complex32>, Tally)> = pieces.iter().map(nothing).collect();
                batched.each::<E>(echoes, control, |engine, echoes| {
                    sums.par_iter_mut().zip(pieces).for_each(|(sum, patch)| {
                        let (values, tally) = image(engine, echoes, patch);
                        for (sum, value) in sum.0.iter_mut().zip(values) {
                            *sum += value;
                        }
                        sum.1.add(tally);
                    });
                })?;
                sums
            }
        };
        control.check()?;
        Ok(found)
    }

    /// Estimated seconds of a run; of batches by building the tables of one and running it in part.
    /// Once cancelled, the value has no meaning.
    pub fn estimate_s(&self, echoes: &WeightedPulses, grid: &ImageGrid, control: Control) -> f64 {
        match self {
            Self::Whole { engine, .. } => engine.estimate_s(echoes, grid, control),
            Self::Batched(batched) => {
                let start = Instant::now();
                let Ok((engine, of_batch)) = batched.build::<E>(echoes, 0, control) else {
                    return f64::NAN;
                };
                let built_s = start.elapsed().as_secs_f64();
                let share = echoes.len() as f64 / of_batch.len().max(1) as f64;
                (built_s + engine.estimate_s(&of_batch, grid, control)) * share
            }
        }
    }
}

impl<S: Copy + Sync> Batched<S> {
    /// Builds one engine after another and hands it over with its pulses.
    fn each<E: TableEngine<Spec = S>>(
        &self,
        echoes: &WeightedPulses,
        control: Control,
        mut take: impl FnMut(&E, &WeightedPulses),
    ) -> Result<(), ImagingError> {
        for k in 0..self.batches.len() {
            let (engine, of_batch) = self.build(echoes, k, control)?;
            take(&engine, &of_batch);
            control.check()?;
        }
        Ok(())
    }

    /// The engine of batch `k` and its pulses.
    fn build<'a, E: TableEngine<Spec = S>>(
        &self,
        echoes: &WeightedPulses<'a>,
        k: usize,
        control: Control,
    ) -> Result<(E, WeightedPulses<'a>), ImagingError> {
        let batch = &self.batches[k];
        let first = batch.first().map_or(0, |part| part.start);
        let last = batch.last().map_or(0, |part| part.end);
        let parts = batch
            .iter()
            .map(|part| part.start - first..part.end - first)
            .collect();
        let of_batch = echoes.slice(first..last)?;
        let ranges_m = &self.ranges_m[first..last];
        let setting = Setting {
            level: self.level,
            control,
        };
        let engine = E::build(&of_batch, &self.grid, ranges_m, self.spec, parts, setting)?;
        Ok((engine, of_batch))
    }
}

/// Bytes of one pulse's table.
fn table_bytes(spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128 {
    RangeTable::bytes_for(&spec.table, ranges_m) / ranges_m.len().max(1) as u128
}

impl TableEngine for Direct {
    type Spec = DirectSpec;

    fn parts(
        echoes: &WeightedPulses,
        ranges_m: &[[f64; 2]],
        _: &TiltedGrid,
        spec: &DirectSpec,
    ) -> Vec<(Range<usize>, u128)> {
        let bytes = table_bytes(spec, ranges_m);
        (0..echoes.len()).map(|m| (m..m + 1, bytes)).collect()
    }

    fn build(
        echoes: &WeightedPulses,
        _: &TiltedGrid,
        ranges_m: &[[f64; 2]],
        spec: DirectSpec,
        _: Vec<Range<usize>>,
        setting: Setting,
    ) -> Result<Self, ImagingError> {
        Self::new(echoes, ranges_m, spec, setting.level, setting.control)
    }

    fn image(
        &self,
        echoes: &WeightedPulses,
        patch: &Patch,
        out: &mut [Complex32],
        meter: &Meter,
    ) -> Tally {
        self.run(echoes, 0..echoes.len(), patch, out, meter)
    }

    fn estimate_s(&self, echoes: &WeightedPulses, grid: &ImageGrid, control: Control) -> f64 {
        self.estimate_run_time_s(echoes, grid, control)
    }
}

impl TableEngine for Factorized {
    type Spec = (FactorizedSpec, DirectSpec);

    fn parts(
        echoes: &WeightedPulses,
        ranges_m: &[[f64; 2]],
        grid: &TiltedGrid,
        (spec, inner): &Self::Spec,
    ) -> Vec<(Range<usize>, u128)> {
        let table = table_bytes(inner, ranges_m);
        // One coarse image more is in the making.
        let [one, two] = [1, 2].map(|parts| coarse_bytes(grid, spec.coarse, parts - 1));
        let bytes = |(k, part): (usize, Range<usize>)| {
            let making = if k == 0 { one } else { 0 };
            let bytes = part.len() as u128 * table + (two - one) + making;
            (part, bytes)
        };
        partition_aperture(&echoes.pulses, spec.pulses)
            .into_iter()
            .enumerate()
            .map(bytes)
            .collect()
    }

    fn build(
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        ranges_m: &[[f64; 2]],
        spec: Self::Spec,
        parts: Vec<Range<usize>>,
        setting: Setting,
    ) -> Result<Self, ImagingError> {
        Self::new(echoes, grid, ranges_m, spec, parts, setting)
    }

    fn image(
        &self,
        echoes: &WeightedPulses,
        patch: &Patch,
        out: &mut [Complex32],
        meter: &Meter,
    ) -> Tally {
        self.run(echoes, &patch.grid, out, meter);
        Tally::default()
    }

    fn estimate_s(&self, echoes: &WeightedPulses, grid: &ImageGrid, control: Control) -> f64 {
        self.estimate_run_time_s(echoes, grid.plane(), control)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_stay_together_and_in_order_and_batches_within_the_room() {
        let parts: Vec<_> = (0..7usize).map(|k| (10 * k..10 * k + 10, 30)).collect();
        let whole = Division::of(&parts, 40, 250);
        assert_eq!((whole.batches.len(), whole.bytes), (1, 210));
        // 0.8 · 200 − 2 · 40 = 80: two parts a batch.
        let divided = Division::of(&parts, 40, 200);
        assert_eq!(divided.bytes, 60 + 40);
        let lengths: Vec<_> = divided.batches.iter().map(Vec::len).collect();
        assert_eq!(lengths, [2, 2, 2, 1]);
        assert_eq!(
            divided.batches.concat(),
            parts.iter().map(|p| p.0.clone()).collect::<Vec<_>>()
        );
        // What does not fit at all is left to the check of memory.
        let tight = Division::of(&parts, 40, 100);
        assert_eq!((tight.batches.len(), tight.bytes), (7, 70));
    }
}
