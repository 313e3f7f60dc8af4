//! Pulses of a chunk that are not read from windows for one block, and ranges as whole bins with a fraction.

use super::job::CHUNK;

/// Pulses of a chunk that gather, and pulses summed in double precision.
#[derive(Default)]
pub(super) struct Unwindowed {
    gathered: [u8; CHUNK],
    gathers: usize,
    reference: [u8; CHUNK],
    references: usize,
}

impl Unwindowed {
    /// Adds a pulse that gathers.
    #[inline(always)]
    pub fn gather(&mut self, pulse: usize) {
        self.gathered[self.gathers] = pulse as u8;
        self.gathers += 1;
    }

    /// Adds a pulse summed in double precision.
    #[inline(always)]
    pub fn refer(&mut self, pulse: usize) {
        self.reference[self.references] = pulse as u8;
        self.references += 1;
    }

    /// Pulses that gather.
    #[inline(always)]
    pub fn gathered(&self) -> &[u8] {
        &self.gathered[..self.gathers]
    }

    /// Pulses summed in double precision.
    #[inline(always)]
    pub fn reference(&self) -> &[u8] {
        &self.reference[..self.references]
    }
}

/// Whole bins and the fraction of a range in bins.
#[inline(always)]
pub(super) fn whole_and_rest(bins: f64) -> (i32, f32) {
    #[allow(clippy::manual_clamp)] // `clamp` would keep NaN
    // SAFETY: the bounds keep it within an i32, and replace NaN.
    let whole = unsafe { bins.max(-1e9).min(1e9).to_int_unchecked::<i32>() };
    (whole, (bins - f64::from(whole)) as f32)
}
