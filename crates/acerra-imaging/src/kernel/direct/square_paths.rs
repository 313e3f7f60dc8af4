//! Choice between windows, gathers and the double-precision sum for each pulse and block of squares.

use super::job::{CHUNK, PixelWeight, SIDE};
use super::square_corners::ways as of_corners;
use super::square_expansion::{Expansion, Groups};
use super::square_rays::TwoWays;
use super::square_setup::{RAY_ROWS, SquareBlock, SquareSetup};
use super::unwindowed::Unwindowed;
use crate::kernel::lanes::Lanes;
use crate::kernel::two_ways::spreading;

/// Pulses of a chunk by the way in which they are read for one block.
pub(super) struct SquarePaths {
    /// Pulses with parameters in [`SquareSetup::windowed`], whose windows are one register or two.
    pub narrow: usize,
    pub wide: usize,
    /// Whether the rays of a pulse with windows need the third order of ways, or the second of weights.
    pub is_bent: bool,
    pub others: Unwindowed,
}

impl SquarePaths {
    /// The slot of the next pulse whose windows are of one register, or of two.
    #[inline(always)]
    fn slot(&mut self, is_narrow: bool) -> usize {
        if is_narrow {
            self.narrow += 1;
            self.narrow - 1
        } else {
            self.wide += 1;
            CHUNK - self.wide
        }
    }
}

/// Expands the ranges of all pulses of a chunk and decides how each pulse is read. All degrees of tables
/// share this function.
#[inline(never)]
pub(super) fn expand<
    S: Lanes,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
>(
    block: &SquareBlock<S>,
    setup: &mut SquareSetup,
) -> SquarePaths {
    block.s.vectorize(
        #[inline(always)]
        |_| expand_here::<S, CUBIC, WIDE, RELIEF, RAYS>(block, setup),
    )
}

#[inline(always)]
fn expand_here<
    S: Lanes,
    const CUBIC: bool,
    const WIDE: bool,
    const RELIEF: bool,
    const RAYS: bool,
>(
    block: &SquareBlock<S>,
    setup: &mut SquareSetup,
) -> SquarePaths {
    let (s, job, n) = (block.s, block.job, S::N);
    let table = &job.table;
    let groups = Groups::of::<RELIEF>(block, &setup.frame);
    let tolerance = s.splat(job.tolerance_bins as f32);
    let window = if WIDE { 2 * n } else { n };
    let last_window = s.splat(table.stride as f32 - 2.0 - window as f32);
    let [narrowest, widest] = [n, window].map(|entries| s.splat((entries - 1) as f32 - 0.05));
    let zero = s.splat(0.0);
    let mut paths = SquarePaths {
        narrow: 0,
        wide: 0,
        is_bent: false,
        others: Unwindowed::default(),
    };
    for m in 0..block.pulses.len() {
        if RAYS && (job.rays.is_some() || block.corners.is_some()) {
            // Tables hold no weights and rays no near field: every place is read from tables.
            let (ways, weight_tolerance) = match (&job.rays, block.corners) {
                (Some(rays), _) => {
                    let of_pulse = (rays, m, block.pulses.start + m);
                    let ways = TwoWays::of(s, &groups, setup, of_pulse, table.bin_m);
                    (ways, rays.weight_tolerance)
                }
                (None, Some(corners)) => {
                    let in_bins = (setup.fraction[m], table.bin_m);
                    let at = (block.row / SIDE, m);
                    (
                        of_corners(s, corners, at, in_bins),
                        corners.weight_tolerance(),
                    )
                }
                (None, None) => continue,
            };
            let (span, windows) = match block.corners {
                Some(_) => ways.windows(s),
                None => ways.half.windows::<CUBIC, RELIEF>(s),
            };
            let negative = s.max(s.sub(zero, windows[0]), s.sub(zero, windows[1]));
            let whole = s.splat(setup.whole[m] as f32);
            let most = s.add(whole, s.max(windows[0], windows[1]));
            let fits = job.windows
                && s.all_le(span, widest)
                && s.all_le(ways.half.truncation_error, tolerance)
                && ways.has_smooth_weight(s, weight_tolerance)
                && s.all_le(negative, whole)
                && s.all_le(most, last_window);
            if !fits {
                match block.corners {
                    Some(_) => paths.others.refer(m),
                    None => paths.others.gather(m),
                }
                continue;
            }
            let slot = paths.slot(!WIDE || s.all_le(span, narrowest));
            let length = RAY_ROWS * n;
            let rows = &mut setup.windowed.0[slot * length..][..length];
            let start = (m * table.pulse_stride) as i32 + setup.whole[m];
            ways.half.store::<RELIEF>(s, windows, start, rows);
            ways.store(s, rows);
            let tolerance_bins = job.tolerance_bins as f32;
            paths.is_bent |= !ways.is_flat(s, tolerance_bins, weight_tolerance);
            continue;
        }
        let sent = Expansion::of::<CUBIC, RELIEF>(s, &groups, setup, (0, m), table.bin_m);
        let (mut expansion, mut received) = (sent, sent);
        if job.antennas_m.len() > 1 {
            received = Expansion::of::<CUBIC, RELIEF>(s, &groups, setup, (1, m), table.bin_m);
            expansion = sent.mean::<CUBIC>(s, received, groups.uneven_m);
        }
        if !s.all_le(groups.near_m, expansion.range_m) {
            paths.others.refer(m);
            continue;
        }
        let (span, windows) = expansion.windows::<CUBIC, RELIEF>(s);
        let whole = s.splat(setup.whole[m] as f32);
        let negative = s.max(s.sub(zero, windows[0]), s.sub(zero, windows[1]));
        let most = s.add(whole, s.max(windows[0], windows[1]));
        let fits = job.windows
            && s.all_le(span, widest)
            && s.all_le(expansion.truncation_error, tolerance)
            && s.all_le(negative, whole)
            && s.all_le(most, last_window);
        if !fits {
            paths.others.gather(m);
            continue;
        }
        let length = SquareSetup::rows(RELIEF, false) * n;
        let slot = paths.slot(!WIDE || s.all_le(span, narrowest));
        let rows = &mut setup.windowed.0[slot * length..][..length];
        let start = (m * table.pulse_stride) as i32 + setup.whole[m];
        expansion.store::<RELIEF>(s, windows, start, rows);
        if let Some(PixelWeight::Ways) = job.weight {
            let weight = spreading(s, sent.range_m, received.range_m);
            let row = &mut rows[SquareSetup::weight_row(RELIEF) * n..];
            assert!(row.len() >= n);
            // SAFETY: the row holds N numbers.
            unsafe { s.store(row.as_mut_ptr(), weight) };
        }
    }
    paths
}
