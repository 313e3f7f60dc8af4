//! Adding images to range bins: step by step, a few pulses at a time.

use crate::control::Meter;
use num_complex::Complex64;

/// Pixels after which single-precision sums are added to those in double precision.
const FLUSH_AFTER: usize = 1 << 16;

/// Destination of the echoes of an image.
pub(crate) enum Echo<'a> {
    /// Spectra `[pulses, N]`.
    Spectra(&'a mut [Complex64]),
    /// Range bins, which [`finish`](super::direct::DirectForward::finish) turns into spectra once for any
    /// number of images.
    Bins {
        /// `[pulses, bins]`
        sums: &'a mut [f64],
        /// Spectra `[pulses, N]`, to which pixels next to the antennas go.
        near_spectra: &'a mut [Complex64],
    },
}

impl<'a> Echo<'a> {
    /// The spectra, to which an engine without bins adds.
    pub fn spectra(self) -> &'a mut [Complex64] {
        match self {
            Self::Spectra(out)
            | Self::Bins {
                near_spectra: out, ..
            } => out,
        }
    }

    /// The destinations of the first `pulses` pulses and of the rest; a pulse has `bins` numbers in its bins
    /// and `n` frequencies.
    pub fn split(self, pulses: usize, [bins, n]: [usize; 2]) -> (Self, Self) {
        match self {
            Self::Spectra(out) => {
                let (own, rest) = out.split_at_mut(pulses * n);
                (Self::Spectra(own), Self::Spectra(rest))
            }
            Self::Bins { sums, near_spectra } => {
                let (own_sums, rest_sums) = sums.split_at_mut(pulses * bins);
                let (own, rest) = near_spectra.split_at_mut(pulses * n);
                let bins = |sums, near_spectra| Self::Bins { sums, near_spectra };
                (bins(own_sums, own), bins(rest_sums, rest))
            }
        }
    }
}

/// The steps of an image that are added to the bins of a few pulses.
pub(super) struct Filling<'a> {
    pub steps: &'a Steps,
    pub add: &'a AddStep<'a>,
    pub meter: &'a Meter<'a>,
}

impl Filling<'_> {
    /// Adds all steps to `sums` and `out` of the pulses from `first` on, through single-precision `bins`;
    /// false once cancelled.
    pub fn fill(
        &self,
        first: usize,
        (length, n): (usize, usize),
        bins: &mut [f32],
        (sums, out): (&mut [f64], &mut [Complex64]),
    ) -> bool {
        bins.fill(0.0);
        let mut pixels = 0;
        for step in 0..self.steps.count {
            if self.meter.is_cancelled() {
                return false;
            }
            let pulses = bins.chunks_exact_mut(length).zip(out.chunks_exact_mut(n));
            for (m, (bins, out)) in pulses.enumerate() {
                (self.add)((step, first + m), bins, out);
            }
            pixels += self.steps.pixels;
            if pixels >= FLUSH_AFTER {
                flush(bins, sums);
                pixels = 0;
            }
        }
        flush(bins, sums);
        let pulses = out.len() / n;
        self.meter.add((self.steps.all_pixels * pulses) as u64);
        true
    }
}

/// Adds a step of an image to a pulse's bins, and pixels next to the antenna to its spectrum.
pub(super) type AddStep<'a> = dyn Fn((usize, usize), &mut [f32], &mut [Complex64]) + Sync + 'a;

/// Pieces of an image that are added one after another.
pub(super) struct Steps {
    pub count: usize,
    /// Pixels of a step, and of all.
    pub pixels: usize,
    pub all_pixels: usize,
}

/// Adds single-precision sums to those in double precision and clears them.
fn flush(bins: &mut [f32], sums: &mut [f64]) {
    for (sum, v) in sums.iter_mut().zip(bins) {
        *sum += f64::from(std::mem::take(v));
    }
}
