//! Gating: keeping the interval of fast time about the surface echo, 2h/c, trace by trace (paper §2, §4).

use std::f64::consts::PI;

use rayon::prelude::*;

use super::{CleanError, check_heights};
use crate::constants::two_way_delay_s;
use crate::radargram::Radargram;
use crate::value::{InPlace, Shape, Value, in_place};
use acerra_control::Cancelled;

/// An interval of fast time relative to 2h/c, with raised-cosine edges.
///
/// The weight is ½ exactly at `start_s` and `end_s` and rises from 0 to 1 over `edge_s` about
/// them, so the interval's integral does not depend on the edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// Start relative to 2h/c, s (the paper's: −6 ns).
    pub start_s: f64,
    /// End relative to 2h/c, s (the paper's: 24 ns).
    pub end_s: f64,
    /// Length of each edge, s; 0 cuts sharply.
    pub edge_s: f64,
}

impl Default for Gate {
    /// The paper's gate, with edges of 1 ns.
    fn default() -> Self {
        Self {
            start_s: -6e-9,
            end_s: 24e-9,
            edge_s: 1e-9,
        }
    }
}

impl Gate {
    /// Weight at `offset_s` of fast time after 2h/c.
    ///
    /// ```
    /// let gate = acerra_radar::clean::Gate::default();
    /// assert_eq!(gate.weight(0.0), 1.0);
    /// assert_eq!(gate.weight(24e-9), 0.5);
    /// assert_eq!(gate.weight(30e-9), 0.0);
    /// ```
    #[must_use]
    pub fn weight(&self, offset_s: f64) -> f64 {
        // Distance inside the nearer border.
        let inside = (offset_s - self.start_s).min(self.end_s - offset_s);
        if self.edge_s <= 0.0 {
            return if inside >= 0.0 { 1.0 } else { 0.0 };
        }
        let x = inside / self.edge_s;
        if x >= 0.5 {
            1.0
        } else if x <= -0.5 {
            0.0
        } else {
            0.5 * (1.0 + (PI * x).sin())
        }
    }
}

/// Multiplies each trace by the gate about its own 2h/c; fast time must be zero-timed.
///
/// # Errors
/// If there is not one finite height a trace, or the gate is no interval.
pub fn apply_gate(
    mut radargram: Radargram,
    height_m: &[f64],
    gate: &Gate,
) -> Result<Radargram, CleanError> {
    check_heights(radargram.traces, height_m)?;
    if let Some(trace) = height_m.iter().position(|h| !h.is_finite()) {
        return Err(CleanError::Height {
            trace,
            height_m: height_m[trace],
        });
    }
    let Gate {
        start_s,
        end_s,
        edge_s,
    } = *gate;
    let sound = end_s > start_s && edge_s >= 0.0 && edge_s <= end_s - start_s;
    if !sound || !start_s.is_finite() || !end_s.is_finite() {
        return Err(CleanError::Gate {
            start_s,
            end_s,
            edge_s,
        });
    }
    let (start, step) = (radargram.fast_time_start_s, radargram.fast_time_step_s);
    in_place(
        &mut radargram,
        &Apply {
            gate,
            height_m,
            start,
            step,
        },
    )?;
    Ok(radargram)
}

struct Apply<'a> {
    gate: &'a Gate,
    height_m: &'a [f64],
    start: f64,
    step: f64,
}

impl InPlace for Apply<'_> {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled> {
        samples
            .par_chunks_exact_mut(shape.samples_per_trace)
            .zip(self.height_m)
            .for_each(|(row, &height_m)| {
                let surface_s = two_way_delay_s(height_m);
                for (j, v) in row.iter_mut().enumerate() {
                    let weight = self
                        .gate
                        .weight(self.start + j as f64 * self.step - surface_s);
                    // Exact zeros and ones stay exact.
                    if weight < 1.0 {
                        *v = V::narrow(v.wide() * weight);
                    }
                }
            });
        Ok(())
    }
}
