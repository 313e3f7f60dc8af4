//! Work on all tracks of a survey, side by side.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::control::Control;
use crate::journal::warnings::Warnings;

/// The results of `work` for every track, in the tracks' order; several tracks are worked on at a time.
///
/// Remarks are added in the tracks' order, up to those of the first track that fails; tracks behind it are not begun once
/// it has failed. The progress of a single track is that of its own steps; of several, the tracks done are counted as a
/// step called `name`.
///
/// # Errors
/// That of the first track that fails.
pub(crate) fn each_track<T: Send, R: Send, E: Send>(
    name: &str,
    tracks: Vec<T>,
    (warnings, control): (&mut Warnings, &Control<'_>),
    work: impl Fn(T, &mut Warnings, &Control<'_>) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let count = tracks.len();
    if count == 1 {
        let each = tracks.into_iter();
        return each.map(|track| work(track, warnings, control)).collect();
    }
    control.start(name, count as u64);
    let (done, silent) = (AtomicU64::new(0), control.silent());
    let first_failed = AtomicUsize::new(count);
    let found: Vec<Option<(Result<R, E>, Warnings)>> = tracks
        .into_par_iter()
        .enumerate()
        .map(|(number, track)| {
            if number > first_failed.load(Ordering::Relaxed) {
                return None;
            }
            let mut own = Warnings::default();
            let result = work(track, &mut own, &silent);
            if result.is_err() {
                first_failed.fetch_min(number, Ordering::Relaxed);
            }
            control.at(1 + done.fetch_add(1, Ordering::Relaxed));
            Some((result, own))
        })
        .collect();
    control.finish();
    // Only tracks behind a failure are missing.
    let each = found.into_iter().flatten().map(|(result, own)| {
        warnings.extend(own);
        result
    });
    each.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Results and remarks have the tracks' order; those after the first failure are not heard of.
    #[test]
    fn results_and_remarks_have_the_order_of_the_tracks() {
        let work = |track: usize, warnings: &mut Warnings, _: &Control<'_>| {
            warnings.add(format!("remark {track}"));
            if track >= 40 {
                Err(track)
            } else {
                Ok(2 * track)
            }
        };
        let mut warnings = Warnings::default();
        let control = Control::default();
        let tracks = (0..30).collect();
        let found = each_track("tracks", tracks, (&mut warnings, &control), work);
        assert_eq!(found, Ok((0..30).map(|k| 2 * k).collect()));
        let said = |end: usize| (0..end).map(|k| format!("remark {k}")).collect::<Vec<_>>();
        assert_eq!(warnings.said(), said(30));
        let tracks = (0..60).collect();
        let failed = each_track("tracks", tracks, (&mut warnings, &control), work);
        assert_eq!(failed, Err(40));
        assert_eq!(warnings.said(), said(41));
    }
}
