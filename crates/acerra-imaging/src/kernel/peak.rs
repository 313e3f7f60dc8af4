//! Peak arithmetic speed of a level.

use super::dispatch::dispatch;
use super::lanes::{Lanes, MAX_LANES};
use super::level::SimdLevel;
use crate::error::ImagingError;

impl SimdLevel {
    /// Measured peak of this level on one thread: fused multiply-adds of single numbers a second
    /// (twice that in FLOP/s). Takes a few milliseconds.
    ///
    /// # Errors
    /// [`ImagingError::NoSuchLevel`] where the processor lacks it.
    pub fn measure_peak(self) -> Result<f64, ImagingError> {
        self.checked()?;
        const ROUNDS: u32 = 400_000;
        const CHAINS: usize = 12;
        let mut best = f64::INFINITY;
        for _ in 0..4 {
            let start = std::time::Instant::now();
            let sum = dispatch!(self, s => multiply_add(s, ROUNDS, std::hint::black_box(0.999)));
            best = best.min(start.elapsed().as_secs_f64());
            std::hint::black_box(sum);
        }
        Ok(f64::from(ROUNDS) * (CHAINS * self.lanes()) as f64 / best)
    }
}

/// `rounds` steps of twelve independent chains of fused multiply-adds.
#[inline(always)]
fn multiply_add<S: Lanes>(s: S, rounds: u32, factor: f32) -> f32 {
    let (a, b) = (s.splat(factor), s.splat(0.001));
    let mut chains: [S::V; 12] = std::array::from_fn(|k| s.splat(k as f32));
    for _ in 0..rounds {
        for c in &mut chains {
            *c = s.mul_add(*c, a, b);
        }
    }
    let mut out = [0f32; MAX_LANES];
    let sum = chains.into_iter().reduce(|a, b| s.add(a, b));
    // SAFETY: `out` has MAX_LANES ≥ N places.
    unsafe { s.store(out.as_mut_ptr(), sum.unwrap_or(a)) };
    out.iter().sum()
}
