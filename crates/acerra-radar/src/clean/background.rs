//! Removing what does not change from trace to trace: antenna coupling above all (paper §2).

use num_complex::Complex64;
use rayon::prelude::*;

use super::CleanError;
use super::components::remove_components;
use crate::radargram::Radargram;
use crate::value::{InPlace, Value, in_place};

/// Ways of estimating the background. It is estimated over the traces of the radargram given:
/// select traces first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Background {
    /// The mean of all traces (the paper's).
    #[default]
    Mean,
    /// The median of all traces, sample by sample: strong targets leave no shadow.
    Median,
    /// The mean of the traces about each trace: follows a background that drifts.
    Sliding {
        /// Traces in the window (an even number counts as the next odd one).
        window: usize,
    },
    /// The strongest principal components of the traces.
    Components {
        /// How many.
        components: usize,
    },
    /// Nothing is removed.
    None,
}

/// Subtracts the background.
///
/// # Errors
/// If there are too few traces for the method, or its parameter makes no sense.
///
/// ```
/// use acerra_radar::{Radargram, Samples, clean::{Background, remove_background}};
/// let raw = Radargram::new(
///     vec![0.0, 1.0], 0.0, 1e-9, Samples::Real(vec![5.0, 1.0, 5.0, 3.0]),
/// )?;
/// let clean = remove_background(raw, Background::Mean)?;
/// assert_eq!(clean.samples, Samples::Real(vec![0.0, -1.0, 0.0, 1.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn remove_background(
    mut radargram: Radargram,
    background: Background,
) -> Result<Radargram, CleanError> {
    let (traces, n) = (radargram.traces, radargram.samples_per_trace);
    let need = |method, needed| {
        if traces >= needed {
            Ok(())
        } else {
            Err(CleanError::TooFewTraces {
                method,
                needed,
                traces,
            })
        }
    };
    match background {
        Background::None => {}
        Background::Mean => {
            need("mean", 2)?;
            in_place(&mut radargram, &Mean);
        }
        Background::Median => {
            need("median", 3)?;
            in_place(&mut radargram, &Median);
        }
        Background::Sliding { window } => {
            need("sliding window", 3)?;
            if window < 3 {
                return Err(CleanError::Window { window });
            }
            in_place(&mut radargram, &Sliding { half: window / 2 });
        }
        Background::Components { components } => {
            need("principal components", 2)?;
            let most = traces.min(n) - 1;
            if !(1..=most).contains(&components) {
                return Err(CleanError::Components { components, most });
            }
            in_place(&mut radargram, &Components { components });
        }
    }
    Ok(radargram)
}

struct Mean;

impl InPlace for Mean {
    fn run<V: Value>(&self, samples: &mut [V], traces: usize, n: usize) {
        let mut mean = vec![Complex64::default(); n];
        for row in samples.chunks_exact(n) {
            for (sum, v) in mean.iter_mut().zip(row) {
                *sum += v.wide();
            }
        }
        for sum in &mut mean {
            *sum /= traces as f64;
        }
        samples
            .par_chunks_exact_mut(n)
            .for_each(|row| subtract(row, &mean));
    }
}

fn subtract<V: Value>(row: &mut [V], background: &[Complex64]) {
    for (v, b) in row.iter_mut().zip(background) {
        *v = V::narrow(v.wide() - b);
    }
}

struct Median;

impl InPlace for Median {
    fn run<V: Value>(&self, samples: &mut [V], traces: usize, n: usize) {
        let median: Vec<Complex64> = (0..n)
            .into_par_iter()
            .map_init(Vec::new, |column: &mut Vec<f64>, j| {
                let mut of = |part: fn(Complex64) -> f64| {
                    column.clear();
                    column.extend((0..traces).map(|i| part(samples[i * n + j].wide())));
                    median_of(column)
                };
                Complex64::new(of(|z| z.re), of(|z| z.im))
            })
            .collect();
        samples
            .par_chunks_exact_mut(n)
            .for_each(|row| subtract(row, &median));
    }
}

/// Median of values that are then in another order.
pub(super) fn median_of(values: &mut [f64]) -> f64 {
    let (middle, odd) = (values.len() / 2, values.len() % 2 == 1);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if odd {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (lower + upper) / 2.0
}

struct Sliding {
    half: usize,
}

impl InPlace for Sliding {
    fn run<V: Value>(&self, samples: &mut [V], traces: usize, n: usize) {
        let original = samples.to_vec();
        let row = |i: usize| &original[i * n..(i + 1) * n];
        let mut sum = vec![Complex64::default(); n];
        let mut held = 0..0;
        for (i, out) in samples.chunks_exact_mut(n).enumerate() {
            let wanted = i.saturating_sub(self.half)..(i + self.half + 1).min(traces);
            for enters in held.end..wanted.end {
                sum.iter_mut()
                    .zip(row(enters))
                    .for_each(|(s, v)| *s += v.wide());
            }
            for leaves in held.start..wanted.start {
                sum.iter_mut()
                    .zip(row(leaves))
                    .for_each(|(s, v)| *s -= v.wide());
            }
            let count = wanted.len() as f64;
            held = wanted;
            for (v, s) in out.iter_mut().zip(&sum) {
                *v = V::narrow(v.wide() - s / count);
            }
        }
    }
}

struct Components {
    components: usize,
}

impl InPlace for Components {
    fn run<V: Value>(&self, samples: &mut [V], traces: usize, n: usize) {
        remove_components(samples, traces, n, self.components);
    }
}
