//! State of a live image, for any number of observers: no observer delays the imaging.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use acerra_radar::Radargram;
use serde::Serialize;

use crate::latency::Latencies;
use crate::picture::Picture;
use crate::status::Status;

/// Fast-time bins of a shown trace.
pub const BINS: usize = 192;
/// Traces kept to be shown.
const TRACES: usize = 512;
/// Places of the track kept; beyond that every other one goes.
const PLACES: usize = 4096;

/// A place of the track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TrackPlace {
    /// East, north, up (m).
    pub position_m: [f64; 3],
    /// Kind of the positions on both sides.
    pub status: &'static str,
}

/// A clean trace as it is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownTrace {
    /// Number of the pulse among those imaged.
    pub number: u64,
    /// Levels of half a decibel, [`BINS`] of them; 0 means no data.
    pub levels: Vec<u8>,
}

/// Progress of the final image.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum Final {
    /// The recording goes on.
    #[default]
    Recording,
    /// The session was asked to end, and data in transit are still read.
    Ending,
    /// The recording is over, and no final image is made.
    Ended,
    /// The final image is being made.
    Making {
        /// The stage under way.
        stage: String,
        /// Step of the stage.
        step: String,
        /// Progress, 0 to 1.
        share: f64,
    },
    /// The final image exists.
    Made {
        /// The directory of its products.
        directory: String,
        /// Doubts about the image.
        warnings: Vec<String>,
    },
    /// The final image could not be made.
    Failed {
        /// Reason.
        reason: String,
    },
}

/// Data that a display needs at once.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// The picture.
    pub picture: Option<Arc<Picture>>,
    /// Origin of its frame: latitude and longitude (degrees), height (m).
    pub origin_deg_m: Option<[f64; 3]>,
    /// The state.
    pub status: Status,
    /// Progress of the final image.
    pub last: Final,
    /// Whether the recording can be ended from a page now.
    pub can_stop: bool,
    /// Fast time of the traces' first bin and step of a bin (ns).
    pub trace_axis_ns: [f64; 2],
    /// Places of the track so far; numbers begin again when the track is thinned out.
    pub track: Vec<TrackPlace>,
    /// Counts the times that the track was thinned out.
    pub thinned: u64,
}

#[derive(Default)]
struct State {
    shown: Shown,
    traces: VecDeque<ShownTrace>,
    /// Every `n`-th place is kept.
    stride: usize,
    skipped: usize,
    made: Latencies,
    waited: Latencies,
    drawn: Latencies,
    /// Pulses of states that no page has drawn yet.
    undrawn: VecDeque<(u64, Vec<Instant>)>,
    traces_made: u64,
}

/// State that the pages show.
#[derive(Default)]
pub struct Board {
    state: Mutex<State>,
    version: AtomicU64,
    listeners: Mutex<Vec<Box<dyn Fn() + Send>>>,
    stop: Mutex<Option<Box<dyn Fn() + Send>>>,
    /// Number of connected pages, and number of pages still drawing a picture.
    pages: AtomicUsize,
    busy_pages: AtomicUsize,
}

/// A page that looks, until it is dropped.
pub struct Page {
    board: Arc<Board>,
    is_busy: AtomicBool,
}

impl Page {
    /// A new page: earlier pictures do not count as drawn late.
    #[must_use]
    pub fn come(board: Arc<Board>) -> Self {
        board.state().undrawn.clear();
        board.pages.fetch_add(1, Ordering::SeqCst);
        let is_busy = AtomicBool::new(false);
        Self { board, is_busy }
    }

    /// The page has drawn the picture sent, or is ready for the next.
    pub fn is_busy(&self, is_busy: bool) {
        if self.is_busy.swap(is_busy, Ordering::SeqCst) != is_busy {
            let count = &self.board.busy_pages;
            match is_busy {
                true => count.fetch_add(1, Ordering::SeqCst),
                false => count.fetch_sub(1, Ordering::SeqCst),
            };
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.is_busy(false);
        self.board.pages.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Board {
    /// An empty one.
    #[must_use]
    pub fn new() -> Arc<Self> {
        Arc::default()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `listener` after every change; `listener` must return quickly.
    pub fn listen(&self, listener: impl Fn() + Send + 'static) {
        let mut listeners = self
            .listeners
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        listeners.push(Box::new(listener));
    }

    fn changed(&self) {
        self.version.fetch_add(1, Ordering::SeqCst);
        let listeners = self
            .listeners
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        listeners.iter().for_each(|listener| listener());
    }

    /// Counts the changes.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.version.load(Ordering::SeqCst)
    }

    /// State that the pages show now.
    #[must_use]
    pub fn shown(&self) -> Shown {
        self.state().shown.clone()
    }

    /// Whether the recording continues: it was not asked to end.
    #[must_use]
    pub fn is_recording(&self) -> bool {
        self.state().shown.last == Final::Recording
    }

    /// Traces from number `from` on that are still kept.
    #[must_use]
    pub fn traces_from(&self, from: u64) -> Vec<ShownTrace> {
        let state = self.state();
        let wanted = state.traces.iter().filter(|trace| trace.number >= from);
        wanted.cloned().collect()
    }

    /// Whether a new picture would be shown now: a page is ready, or there is no page to wait for.
    #[must_use]
    pub fn is_picture_wanted(&self) -> bool {
        let busy = self.busy_pages.load(Ordering::SeqCst);
        busy == 0 || busy < self.pages.load(Ordering::SeqCst)
    }

    /// A page has drawn a state of the picture.
    pub fn drawn(&self, sequence: u64, now: Instant) {
        let mut state = self.state();
        while state
            .undrawn
            .front()
            .is_some_and(|(own, _)| *own <= sequence)
        {
            let Some((_, pulses)) = state.undrawn.pop_front() else {
                break;
            };
            for came in pulses {
                state.drawn.push(now.saturating_duration_since(came));
            }
        }
    }

    /// A new state of the picture, with its new pulses: times of arrival and times at which their imaging
    /// began.
    pub fn show_picture(&self, picture: Picture, came: &[Instant], begun: Instant) {
        let now = Instant::now();
        let mut state = self.state();
        for came in came {
            state.made.push(now.saturating_duration_since(*came));
            state.waited.push(begun.saturating_duration_since(*came));
        }
        state.undrawn.push_back((picture.sequence, came.to_vec()));
        // Without a page nobody draws.
        if state.undrawn.len() > 1000 {
            state.undrawn.pop_front();
        }
        state.shown.picture = Some(Arc::new(picture));
        drop(state);
        self.changed();
    }

    /// Places that were imaged from.
    pub fn show_track(&self, places: impl Iterator<Item = TrackPlace>) {
        let mut state = self.state();
        state.stride = state.stride.max(1);
        for place in places {
            state.skipped += 1;
            if state.skipped < state.stride {
                continue;
            }
            state.skipped = 0;
            state.shown.track.push(place);
            if state.shown.track.len() > PLACES {
                let mut keep = false;
                state.shown.track.retain(|_| {
                    keep = !keep;
                    keep
                });
                state.shown.thinned += 1;
                state.stride *= 2;
            }
        }
    }

    /// Clean traces.
    pub fn show_traces(&self, traces: &Radargram) {
        let mut state = self.state();
        let per_bin = traces.samples_per_trace.div_ceil(BINS).max(1);
        let start_ns = 1e9 * traces.fast_time_start_s;
        state.shown.trace_axis_ns = [start_ns, 1e9 * traces.fast_time_step_s * per_bin as f64];
        for k in 0..traces.traces {
            let start = k * traces.samples_per_trace;
            let levels = (0..BINS).map(|bin| {
                let from = (bin * per_bin).min(traces.samples_per_trace);
                let to = ((bin + 1) * per_bin).min(traces.samples_per_trace);
                let samples = (from..to).map(|i| traces.samples.at(start + i).norm());
                level_of(samples.fold(0.0, f64::max))
            });
            let number = state.traces_made;
            let levels = levels.collect();
            state.traces_made += 1;
            state.traces.push_back(ShownTrace { number, levels });
            if state.traces.len() > TRACES {
                state.traces.pop_front();
            }
        }
    }

    /// The state of the imaging, shown at once; latencies are put in.
    pub fn show_status(&self, status: Status, origin_deg_m: Option<[f64; 3]>) {
        self.keep_status(status, origin_deg_m);
        self.changed();
    }

    /// A new state shown with the next picture: a page that draws a state by itself would not be ready for a
    /// picture meanwhile.
    pub fn keep_status(&self, status: Status, origin_deg_m: Option<[f64; 3]>) {
        let mut state = self.state();
        state.shown.status = Status {
            latency: state.made.figures(),
            waiting: state.waited.figures(),
            drawn: state.drawn.figures(),
            ..status
        };
        state.shown.origin_deg_m = origin_deg_m;
    }

    /// Publishes the progress of the final image.
    pub fn show_final(&self, last: Final) {
        let mut state = self.state();
        state.shown.can_stop &= last == Final::Recording;
        state.shown.last = last;
        drop(state);
        self.changed();
    }

    /// Lets pages end the recording: `stop` is called once at most, while the recording goes on.
    pub fn let_stop(&self, stop: impl Fn() + Send + 'static) {
        *self.stop.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(stop));
        let mut state = self.state();
        state.shown.can_stop = state.shown.last == Final::Recording;
    }

    /// Ends the recording in order; whether there was one to end.
    ///
    /// ```
    /// use acerra_live::{Board, Final};
    /// let board = Board::new();
    /// assert!(!board.ask_to_stop());
    /// board.let_stop(|| {});
    /// assert!(board.ask_to_stop() && !board.ask_to_stop());
    /// assert_eq!(board.shown().last, Final::Ending);
    /// ```
    pub fn ask_to_stop(&self) -> bool {
        let mut state = self.state();
        if !std::mem::replace(&mut state.shown.can_stop, false) {
            return false;
        }
        state.shown.last = Final::Ending;
        drop(state);
        let stop = self.stop.lock().unwrap_or_else(PoisonError::into_inner);
        stop.iter().for_each(|stop| stop());
        drop(stop);
        self.changed();
        true
    }
}

/// Levels of half a decibel above a hundredth of a count.
fn level_of(modulus: f64) -> u8 {
    if modulus > 0.0 {
        let half_db = 2.0 * 20.0 * (100.0 * modulus).log10();
        half_db.round().clamp(1.0, 255.0) as u8
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_imaging::PlaneGrid;
    use std::time::Duration;

    #[test]
    fn drawing_a_state_settles_all_before_it() {
        let board = Board::default();
        let mut picture = Picture::new(PlaneGrid::new([0.0; 3], 0.1, [4, 4]).unwrap());
        let came = Instant::now();
        for _ in 0..3 {
            picture.update(&[num_complex::Complex32::new(1.0, 0.0); 16]);
            board.show_picture(picture.clone(), &[came], came);
        }
        board.drawn(2, came + Duration::from_millis(80));
        board.drawn(2, came + Duration::from_millis(500));
        board.show_status(Status::default(), None);
        let drawn = board.shown().status.drawn.unwrap();
        assert_eq!((drawn.pulses, drawn.most_ms.round()), (2, 80.0));
        assert_eq!(board.version(), 4);
    }

    #[test]
    fn a_state_that_is_kept_comes_with_the_picture() {
        let board = Board::default();
        let mut picture = Picture::new(PlaneGrid::new([0.0; 3], 0.1, [4, 4]).unwrap());
        let status = Status {
            positions: 7,
            ..Status::default()
        };
        board.keep_status(status, None);
        assert_eq!((board.version(), board.shown().status.positions), (0, 7));
        picture.update(&[num_complex::Complex32::new(1.0, 0.0); 16]);
        board.show_picture(picture, &[], Instant::now());
        assert_eq!(board.version(), 1);
    }

    #[test]
    fn a_picture_is_wanted_where_a_page_is_ready_for_it() {
        let board = Board::new();
        assert!(board.is_picture_wanted());
        let [first, second] = [0; 2].map(|_| Page::come(Arc::clone(&board)));
        for page in [&first, &second, &first] {
            page.is_busy(true);
        }
        assert!(!board.is_picture_wanted());
        second.is_busy(false);
        assert!(board.is_picture_wanted());
        second.is_busy(true);
        drop(second);
        assert!(!board.is_picture_wanted());
        drop(first);
        assert!(board.is_picture_wanted());
    }

    #[test]
    fn a_long_track_is_thinned_out() {
        let board = Board::default();
        let place = |k: i32| TrackPlace {
            position_m: [f64::from(k), 0.0, 0.0],
            status: "fixed",
        };
        board.show_track((0..20_000).map(place));
        let shown = board.shown();
        assert!(shown.track.len() <= PLACES && shown.thinned > 0);
        let end = shown.track.last().unwrap().position_m[0];
        assert!(end > 19_980.0, "{end}");
    }
}
