//! Left–right ambiguity: place and level of a target's ghost.

use super::crest::climb_crest;
use super::field::Field;
use super::target::Ghost;
use super::track::LocalTrack;
use crate::psf::cell::Cell;

/// Half the window about the mirrored place, in expected resolution distances along and across:
/// a curved track displaces and smears a ghost by about a cell.
const WINDOW_CELLS: [f64; 2] = [4.0, 1.5];

/// The rectangle, aligned with the local track, in which a target's ghost is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GhostWindow {
    centre_m: [f64; 2],
    tangent: [f64; 2],
    half_m: [f64; 2],
}

impl GhostWindow {
    /// The window for a target at (x, y) = `peak_m`; `None` when the target is nearer to the track
    /// than its resolution, so that target and ghost are one spot.
    pub fn of(track: &LocalTrack, peak_m: [f64; 2], cell: Cell) -> Option<Self> {
        let centre_m = track.mirrored_m(peak_m);
        let apart_m = (centre_m[0] - peak_m[0]).hypot(centre_m[1] - peak_m[1]);
        if apart_m < 2.0 * cell.across_m {
            return None;
        }
        // The window never reaches past the track.
        let half_across = (WINDOW_CELLS[1] * cell.across_m).min(0.5 * apart_m);
        Some(Self {
            centre_m,
            tangent: track.tangent,
            half_m: [WINDOW_CELLS[0] * cell.along_m, half_across],
        })
    }

    /// The mirrored place (x, y), m.
    pub fn centre_m(&self) -> [f64; 2] {
        self.centre_m
    }

    /// Whether (x, y) lies in the window.
    pub fn contains(&self, at_m: [f64; 2]) -> bool {
        let d = [at_m[0] - self.centre_m[0], at_m[1] - self.centre_m[1]];
        let along = d[0] * self.tangent[0] + d[1] * self.tangent[1];
        let across = d[1] * self.tangent[0] - d[0] * self.tangent[1];
        along.abs() <= self.half_m[0] && across.abs() <= self.half_m[1]
    }

    /// Finds the maximum of `field` in the window: sampled at a quarter of the cell, then climbed.
    ///
    /// `None` when the whole window is outside the field.
    pub fn strongest(&self, field: &dyn Field, cell: Cell) -> Option<([f64; 2], f64)> {
        let step = [0.25 * cell.along_m, 0.25 * cell.across_m];
        let count = [0, 1].map(|i| (self.half_m[i] / step[i]).ceil() as i64);
        let mut best: Option<([f64; 2], f64)> = None;
        for j in -count[1]..=count[1] {
            for i in -count[0]..=count[0] {
                let along = (i as f64 * step[0]).clamp(-self.half_m[0], self.half_m[0]);
                let across = (j as f64 * step[1]).clamp(-self.half_m[1], self.half_m[1]);
                let at = [
                    self.centre_m[0] + along * self.tangent[0] - across * self.tangent[1],
                    self.centre_m[1] + along * self.tangent[1] + across * self.tangent[0],
                ];
                let Some(level) = field.amplitude(at[0], at[1]) else {
                    continue;
                };
                if best.is_none_or(|(_, highest)| level > highest) {
                    best = Some((at, level));
                }
            }
        }
        let (start, level) = best?;
        // A climb that leaves the window has found another lobe.
        match climb_crest(field, start, step[0], self.tangent, cell) {
            Some(found) if self.contains(found.0) => Some(found),
            _ => Some((start, level)),
        }
    }
}

/// The ghost of a target of amplitude `peak` at (x, y) = `peak_m`.
pub fn find_ghost(
    field: &dyn Field,
    track: &LocalTrack,
    peak_m: [f64; 2],
    peak: f64,
    cell: Cell,
) -> Option<Ghost> {
    let (place, level) = GhostWindow::of(track, peak_m, cell)?.strongest(field, cell)?;
    Some(Ghost {
        level: level / peak,
        x_m: place[0],
        y_m: place[1],
    })
}
