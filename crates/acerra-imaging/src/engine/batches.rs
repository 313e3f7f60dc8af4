//! Engines for pieces of the aperture, kept in memory or built batch by batch.
//!
//! Pieces of the aperture may have engines of different parameters; the images of the pieces are summed.
//! Range tables of all pulses are kept for any number of runs where they fit in memory. Otherwise each run
//! takes the pulses in batches: the tables of a batch are built, its image is added to the sum, and the next
//! batch takes the same memory.

use super::direct::{Direct, DirectSpec};
use super::factorized::aperture::partition_aperture;
use super::factorized::merged::{Factorized, Setting};
use super::factorized::spec::FactorizedSpec;
use super::ray_records::RayRecords;
use super::tables::build::RangeTable;
use super::weights::WeightedPulses;
use crate::control::Meter;
use crate::error::ImagingError;
use crate::grid::image::{ImageGrid, Patch};
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Tally;
use crate::kernel::level::SimdLevel;
use acerra_control::Control;
use num_complex::Complex32;
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

/// Share of the allowed memory that batches fill: building tables needs a little more.
const FILLED: f64 = 0.8;

/// Neighbouring pulses that share an engine.
#[derive(Debug, Clone)]
pub(crate) struct Piece<S> {
    pub pulses: Range<usize>,
    /// Parameters of the engine.
    pub spec: S,
    /// Least and greatest range looked up for each pulse, m.
    pub ranges_m: Vec<[f64; 2]>,
}

/// Runs of pulses that stay together.
pub(crate) struct Parts {
    /// Runs of pulses, each with the bytes that it takes.
    runs: Vec<(Range<usize>, u128)>,
    /// Bytes of a run in addition to the tables, however many pulses the engine has.
    making: u128,
}

/// An engine that images from range tables.
pub(crate) trait TableEngine: Sized + Sync {
    /// Parameters of the engine.
    type Spec: Copy + Sync;

    /// The divisible runs of a piece's pulses, counted from the piece's first pulse.
    fn parts(echoes: &WeightedPulses, grid: &ImageGrid, piece: &Piece<Self::Spec>) -> Parts;

    /// Builds the engine for some pulses, divided into `parts`.
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

/// Pulses that one engine takes: a piece, or a batch of its parts.
#[derive(Debug)]
struct Job<S> {
    pulses: Range<usize>,
    /// Runs of pulses, counted from the first of `pulses`.
    parts: Vec<Range<usize>>,
    spec: S,
    ranges_m: Vec<[f64; 2]>,
}

/// The division of the pulses that the memory allowed asks for.
#[derive(Debug)]
pub(crate) struct Division<S> {
    jobs: Vec<Job<S>>,
    /// Whether memory holds the engines of all jobs together.
    kept: bool,
    /// Bytes of a run in addition to the image.
    pub bytes: u128,
}

impl<S: Copy + Sync> Division<S> {
    /// The pieces unchanged where they fit into memory together with an image of `output_bytes` (and a second
    /// one to sum several pieces); otherwise their parts in as few batches as possible. A part that does not
    /// fit is a separate batch.
    pub fn of<E: TableEngine<Spec = S>>(
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        pieces: &[Piece<S>],
        [output_bytes, limit_bytes]: [u128; 2],
    ) -> Result<Self, ImagingError> {
        let mut parts = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let of_piece = echoes.slice(piece.pulses.clone())?;
            parts.push(E::parts(&of_piece, grid, piece));
        }
        let sum = if pieces.len() > 1 { output_bytes } else { 0 };
        // Pieces are imaged one after the other.
        let making = parts.iter().map(|parts| parts.making).max().unwrap_or(0);
        let runs = parts.iter().flat_map(|parts| &parts.runs);
        let bytes = runs.map(|run| run.1).sum::<u128>() + making + sum;
        if bytes + output_bytes <= limit_bytes {
            let all = |(piece, parts): (&Piece<S>, Parts)| {
                Job::of(piece, parts.runs.into_iter().map(|run| run.0).collect())
            };
            return Ok(Self {
                jobs: pieces.iter().zip(parts).map(all).collect(),
                kept: true,
                bytes,
            });
        }
        let room = ((limit_bytes as f64 * FILLED) as u128).saturating_sub(2 * output_bytes);
        let mut jobs = Vec::new();
        let mut most = 0;
        for (piece, parts) in pieces.iter().zip(&parts) {
            for (batch, bytes) in batches(&parts.runs, room.saturating_sub(parts.making)) {
                jobs.push(Job::of(piece, batch));
                most = most.max(bytes + parts.making);
            }
        }
        Ok(Self {
            jobs,
            kept: false,
            bytes: most + output_bytes,
        })
    }
}

impl<S: Copy> Job<S> {
    /// The job of neighbouring parts of a piece.
    fn of(piece: &Piece<S>, parts: Vec<Range<usize>>) -> Self {
        let first = parts.first().map_or(0, |part| part.start);
        let last = parts.last().map_or(0, |part| part.end);
        let start = piece.pulses.start;
        Self {
            pulses: start + first..start + last,
            parts: (parts.into_iter())
                .map(|part| part.start - first..part.end - first)
                .collect(),
            spec: piece.spec,
            ranges_m: piece.ranges_m[first..last].to_vec(),
        }
    }
}

/// Neighbouring parts that take at most `room` bytes together, and the bytes that they take.
fn batches(parts: &[(Range<usize>, u128)], room: u128) -> Vec<(Vec<Range<usize>>, u128)> {
    let mut batches: Vec<(Vec<Range<usize>>, u128)> = Vec::new();
    for (part, bytes) in parts {
        match batches.last_mut() {
            Some((batch, filled)) if *filled + bytes <= room => {
                batch.push(part.clone());
                *filled += bytes;
            }
            _ => batches.push((vec![part.clone()], *bytes)),
        }
    }
    batches
}

/// Engines of one kind that image all pulses together: kept, or built again for every job.
#[derive(Debug)]
pub(crate) struct Imager<E: TableEngine> {
    jobs: Vec<Job<E::Spec>>,
    /// One engine a job; empty where memory does not hold all of them together.
    engines: Vec<E>,
    grid: TiltedGrid,
    level: SimdLevel,
}

impl<E: TableEngine> Imager<E> {
    /// Builds the engines that are kept.
    ///
    /// # Errors
    /// Cancellation.
    pub fn new(
        echoes: &WeightedPulses,
        grid: &TiltedGrid,
        division: Division<E::Spec>,
        setting: Setting,
    ) -> Result<Self, ImagingError> {
        let mut imager = Self {
            jobs: division.jobs,
            engines: Vec::new(),
            grid: *grid,
            level: setting.level,
        };
        if division.kept {
            let built =
                (imager.jobs.iter()).map(|job| Ok(imager.build(job, echoes, setting.control)?.0));
            imager.engines = built.collect::<Result<_, ImagingError>>()?;
        }
        Ok(imager)
    }

    /// Parameters of the engines, one a job.
    pub fn specs(&self) -> impl Iterator<Item = &E::Spec> {
        self.jobs.iter().map(|job| &job.spec)
    }

    /// Batches in which every run builds its engines; one where they are kept.
    pub fn batches(&self) -> usize {
        if self.engines.is_empty() {
            self.jobs.len()
        } else {
            1
        }
    }

    /// The engine that images all pulses, where there is a single one and it is kept.
    pub fn only(&self) -> Option<&E> {
        match &self.engines[..] {
            [engine] => Some(engine),
            _ => None,
        }
    }

    /// Drops the engines, which every run then builds again.
    pub fn forget_tables(&mut self) {
        self.engines = Vec::new();
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
        if let [_] = &self.jobs[..] {
            return self.each(echoes, meter.control(), |engine, echoes| {
                engine.image(echoes, &grid.whole(), out, meter);
            });
        }
        out.fill(Complex32::ZERO);
        let mut image = vec![Complex32::ZERO; out.len()];
        self.each(echoes, meter.control(), |engine, echoes| {
            engine.image(echoes, &grid.whole(), &mut image, meter);
            out.par_iter_mut()
                .zip(&image)
                .for_each(|(sum, value)| *sum += value);
        })
    }

    /// Images patches of the grid one by one, and counts how the vectors of each were read.
    ///
    /// # Errors
    /// Cancellation.
    pub fn patches(
        &self,
        echoes: &WeightedPulses,
        patches: &[Patch],
        control: Control,
    ) -> Result<Vec<(Vec<Complex32>, Tally)>, ImagingError> {
        let nothing = |patch: &Patch| {
            let zeros = vec![Complex32::ZERO; patch.grid.columns * patch.grid.rows];
            (zeros, Tally::default())
        };
        let mut sums: Vec<(Vec<Complex32>, Tally)> = patches.iter().map(nothing).collect();
        self.each(echoes, control, |engine, echoes| {
            sums.par_iter_mut().zip(patches).for_each(|(sum, patch)| {
                let mut values = nothing(patch).0;
                let tally = engine.image(echoes, patch, &mut values, &Meter::silent(control));
                for (sum, value) in sum.0.iter_mut().zip(values) {
                    *sum += value;
                }
                sum.1.add(tally);
            });
        })?;
        Ok(sums)
    }

    /// Estimated seconds of a run; with batches, by building the tables of one batch and running it in part.
    /// Once cancelled, the value is meaningless.
    pub fn estimate_s(&self, echoes: &WeightedPulses, grid: &ImageGrid, control: Control) -> f64 {
        if let [engine] = &self.engines[..] {
            return engine.estimate_s(echoes, grid, control);
        }
        let mut seconds = 0.0;
        for (job, engine) in self.jobs.iter().zip(&self.engines) {
            let Ok(of_job) = echoes.slice(job.pulses.clone()) else {
                return f64::NAN;
            };
            seconds += engine.estimate_s(&of_job, grid, control);
        }
        let (Some(job), true) = (self.jobs.first(), self.engines.is_empty()) else {
            return seconds;
        };
        let start = Instant::now();
        let Ok((engine, of_job)) = self.build(job, echoes, control) else {
            return f64::NAN;
        };
        let built_s = start.elapsed().as_secs_f64();
        let share = echoes.len() as f64 / of_job.len().max(1) as f64;
        (built_s + engine.estimate_s(&of_job, grid, control)) * share
    }

    /// Calls `take` with one engine after another and the pulses of each.
    fn each(
        &self,
        echoes: &WeightedPulses,
        control: Control,
        mut take: impl FnMut(&E, &WeightedPulses),
    ) -> Result<(), ImagingError> {
        for (k, job) in self.jobs.iter().enumerate() {
            match self.engines.get(k) {
                Some(engine) => take(engine, &echoes.slice(job.pulses.clone())?),
                None => {
                    let (engine, of_job) = self.build(job, echoes, control)?;
                    take(&engine, &of_job);
                }
            }
            control.check()?;
        }
        Ok(())
    }

    /// The engine of a job and its pulses.
    fn build<'a>(
        &self,
        job: &Job<E::Spec>,
        echoes: &WeightedPulses<'a>,
        control: Control,
    ) -> Result<(E, WeightedPulses<'a>), ImagingError> {
        let of_job = echoes.slice(job.pulses.clone())?;
        let (level, parts) = (self.level, job.parts.clone());
        let setting = Setting { level, control };
        let engine = E::build(&of_job, &self.grid, &job.ranges_m, job.spec, parts, setting)?;
        Ok((engine, of_job))
    }
}

/// Bytes of one pulse's table.
fn table_bytes(spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128 {
    RangeTable::bytes_for(&spec.table, ranges_m) / ranges_m.len().max(1) as u128
}

impl TableEngine for Direct {
    type Spec = DirectSpec;

    fn parts(echoes: &WeightedPulses, _: &ImageGrid, piece: &Piece<DirectSpec>) -> Parts {
        let bytes = table_bytes(&piece.spec, &piece.ranges_m);
        let law = echoes.weights.law.as_ref().filter(|law| law.is_apart());
        Parts {
            runs: (0..echoes.len()).map(|m| (m..m + 1, bytes)).collect(),
            making: law.map_or(0, |law| RayRecords::bytes_for(echoes, law, &piece.ranges_m)),
        }
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

    fn parts(echoes: &WeightedPulses, grid: &ImageGrid, piece: &Piece<Self::Spec>) -> Parts {
        let (spec, inner) = &piece.spec;
        let table = table_bytes(inner, &piece.ranges_m);
        let parts = partition_aperture(&echoes.pulses, spec.outer.pulses);
        let [making, each] = spec.coarse_bytes(grid, &parts);
        let with_bytes = |part: Range<usize>| {
            let bytes = part.len() as u128 * table + each;
            (part, bytes)
        };
        Parts {
            runs: parts.into_iter().map(with_bytes).collect(),
            making,
        }
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
        self.run(echoes, patch, out, meter);
        Tally::default()
    }

    fn estimate_s(&self, echoes: &WeightedPulses, grid: &ImageGrid, control: Control) -> f64 {
        self.estimate_run_time_s(echoes, &grid.whole(), control)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_stay_in_order_and_within_the_room() {
        let parts: Vec<_> = (0..7usize).map(|k| (10 * k..10 * k + 10, 30)).collect();
        let found = batches(&parts, 80);
        let taken: Vec<_> = found.iter().map(|b| (b.0.len(), b.1)).collect();
        assert_eq!(taken, [(2, 60), (2, 60), (2, 60), (1, 30)]);
        let in_order: Vec<_> = found.into_iter().flat_map(|b| b.0).collect();
        assert_eq!(
            in_order,
            parts.iter().map(|p| p.0.clone()).collect::<Vec<_>>()
        );
        // A part that does not fit is left to the check of memory.
        assert_eq!(batches(&parts, 20).len(), 7);
    }
}
