//! Removal of signals that are constant from trace to trace: mainly antenna coupling (paper §2).

use std::fmt;
use std::ops::Range;
use std::slice::from_ref;
use std::str::FromStr;

use num_complex::Complex64;
use rayon::prelude::*;

use super::CleanError;
use super::components::remove_components;
use crate::radargram::Radargram;
use crate::value::{InPlace, Shape, Value, in_place};
use acerra_control::{Cancelled, Control};

/// Ways of estimating the background over all traces of the radargram: select traces first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Background {
    /// The mean of all traces, as in the paper.
    #[default]
    Mean,
    /// The median of all traces, sample by sample: strong targets leave no shadow.
    Median,
    /// The mean of the traces of the same line about each trace: follows a background that drifts.
    Sliding {
        /// Traces in the window (an even number counts as the next odd one).
        window: usize,
    },
    /// The strongest principal components of the traces.
    Components {
        /// Number.
        components: usize,
    },
    /// Nothing is removed.
    None,
}

/// As in messages: `mean`, `median`, `none`, `window 51`, `components 2`; [`FromStr`] reads this form.
impl fmt::Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mean => f.pad("mean"),
            Self::Median => f.pad("median"),
            Self::Sliding { window } => write!(f, "window {window}"),
            Self::Components { components } => write!(f, "components {components}"),
            Self::None => f.pad("none"),
        }
    }
}

/// A text that names no way of estimating the background.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a background of \"mean\", \"median\", \"none\", \"window N\" or \
     \"components N\", found {found:?}"
)]
pub struct UnknownBackground {
    /// The text.
    pub found: String,
}

impl FromStr for Background {
    type Err = UnknownBackground;

    fn from_str(text: &str) -> Result<Self, UnknownBackground> {
        let mut words = text.split_whitespace();
        let (name, number) = (words.next().unwrap_or_default(), words.next());
        let count = number.and_then(|n| n.parse().ok());
        let known = match (name, number, count) {
            ("mean", None, _) => Some(Self::Mean),
            ("median", None, _) => Some(Self::Median),
            ("none", None, _) => Some(Self::None),
            ("window", _, Some(window)) => Some(Self::Sliding { window }),
            ("components", _, Some(components)) => Some(Self::Components { components }),
            _ => None,
        };
        known
            .filter(|_| words.next().is_none())
            .ok_or_else(|| UnknownBackground {
                found: text.to_owned(),
            })
    }
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
    radargram: Radargram,
    background: Background,
) -> Result<Radargram, CleanError> {
    let line = 0..radargram.traces;
    remove_background_with(radargram, background, from_ref(&line), Control::default())
}

/// Removes the background as [`remove_background`] does from traces of several lines; can be cancelled.
///
/// `lines` are ranges of the traces, one after another. A sliding window ends at the ends of its line; the
/// other methods use the traces of all lines together.
///
/// # Errors
/// As [`remove_background`], and [`CleanError::Cancelled`].
///
/// ```
/// use acerra_radar::{Control, Radargram, Samples};
/// use acerra_radar::clean::{Background, remove_background_with};
/// let (one, other) = ([5.0, 1.0].repeat(3), [9.0, 3.0].repeat(3));
/// let time_s = (0..6).map(f64::from).collect();
/// let raw = Radargram::new(time_s, 0.0, 1e-9, Samples::Real([one, other].concat()))?;
/// let window = Background::Sliding { window: 101 };
/// let clean = remove_background_with(raw, window, &[0..3, 3..6], Control::default())?;
/// assert_eq!(clean.samples, Samples::Real(vec![0.0; 12]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn remove_background_with(
    mut radargram: Radargram,
    background: Background,
    lines: &[Range<usize>],
    control: Control<'_>,
) -> Result<Radargram, CleanError> {
    control.check()?;
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
            in_place(&mut radargram, &Mean)?;
        }
        Background::Median => {
            need("median", 3)?;
            in_place(&mut radargram, &Median { control })?;
        }
        Background::Sliding { window } => {
            need("sliding window", 3)?;
            if window < 3 {
                return Err(CleanError::Window { window });
            }
            in_place(
                &mut radargram,
                &Sliding {
                    half: window / 2,
                    lines,
                    control,
                },
            )?;
        }
        Background::Components { components } => {
            need("principal components", 2)?;
            let most = traces.min(n) - 1;
            if !(1..=most).contains(&components) {
                return Err(CleanError::Components { components, most });
            }
            in_place(
                &mut radargram,
                &Components {
                    components,
                    control,
                },
            )?;
        }
    }
    Ok(radargram)
}

struct Mean;

impl InPlace for Mean {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let (traces, n) = (shape.traces, shape.samples_per_trace);
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
        Ok(())
    }
}

fn subtract<V: Value>(row: &mut [V], background: &[Complex64]) {
    for (v, b) in row.iter_mut().zip(background) {
        *v = V::narrow(v.wide() - b);
    }
}

struct Median<'a> {
    control: Control<'a>,
}

impl InPlace for Median<'_> {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let (traces, n) = (shape.traces, shape.samples_per_trace);
        let median: Vec<Complex64> = (0..n)
            .into_par_iter()
            .map_init(Vec::new, |column: &mut Vec<f64>, j| {
                self.control.check()?;
                let mut of = |part: fn(Complex64) -> f64| {
                    column.clear();
                    column.extend((0..traces).map(|i| part(samples[i * n + j].wide())));
                    median_of(column)
                };
                Ok(Complex64::new(of(|z| z.re), of(|z| z.im)))
            })
            .collect::<Result<_, _>>()?;
        samples
            .par_chunks_exact_mut(n)
            .for_each(|row| subtract(row, &median));
        Ok(())
    }
}

/// Median of values, which are reordered.
pub(super) fn median_of(values: &mut [f64]) -> f64 {
    let (middle, odd) = (values.len() / 2, values.len() % 2 == 1);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if odd {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (lower + upper) / 2.0
}

struct Sliding<'a> {
    half: usize,
    lines: &'a [Range<usize>],
    control: Control<'a>,
}

impl InPlace for Sliding<'_> {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let n = shape.samples_per_trace;
        for line in self.lines {
            let held = line.start.min(shape.traces)..line.end.min(shape.traces);
            self.line(&mut samples[held.start * n..held.end * n], n)?;
        }
        Ok(())
    }
}

impl Sliding<'_> {
    /// Removes the means from the traces of a line, of `n` samples each.
    fn line<V: Value>(&self, samples: &mut [V], n: usize) -> Result<(), Cancelled> {
        let traces = samples.len() / n;
        let original = samples.to_vec();
        let row = |i: usize| &original[i * n..(i + 1) * n];
        let mut sum = vec![Complex64::default(); n];
        let mut held = 0..0;
        for (i, out) in samples.chunks_exact_mut(n).enumerate() {
            if i % 64 == 0 {
                self.control.check()?;
            }
            let wanted = i.saturating_sub(self.half)..i.saturating_add(self.half + 1).min(traces);
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
        Ok(())
    }
}

struct Components<'a> {
    components: usize,
    control: Control<'a>,
}

impl InPlace for Components<'_> {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        let (traces, n) = (shape.traces, shape.samples_per_trace);
        remove_components(samples, [traces, n], self.components, self.control)
    }
}
