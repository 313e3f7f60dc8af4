//! The thread that images.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use acerra_imaging::{Control, ImagingError};
use acerra_record::session::{SilenceWatch, Tapped};

use crate::board::{Board, TrackPlace};
use crate::error::LiveError;
use crate::picture::Picture;
use crate::pipeline::{Pipeline, Step};
use crate::status::{Status, doubts};

/// Records that may wait for the imaging: 20 s of usual ones.
pub const QUEUE_RECORDS: usize = 8_192;
/// How soon a picture that no page was ready for is offered again.
const LOOK_AGAIN: Duration = Duration::from_millis(3);
/// Interval between status updates.
const REPORT_EVERY: Duration = Duration::from_millis(250);
/// Pulses whose positions are there and that may wait to be imaged: beyond that imaging is too slow, and older
/// ones are given up.
const MOST_BEHIND: usize = 256;

/// The thread that images, until its source ends or it is dropped.
pub struct Worker {
    cancel: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<(), LiveError>>>,
}

impl Worker {
    /// Images the pulses of `source` onto `board`. `missed` counts records that the source dropped.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(
        pipeline: Pipeline,
        source: Receiver<Tapped>,
        missed: Arc<AtomicU64>,
        board: Arc<Board>,
    ) -> Result<Self, LiveError> {
        let cancel = Arc::new(AtomicBool::new(false));
        let work = Work {
            pipeline,
            source,
            missed,
            board,
            picture: None,
            unseen: None,
            reported: Instant::now(),
            shown: Instant::now(),
            silences: SilenceWatch::default(),
            is_over: false,
            cancel: Arc::clone(&cancel),
        };
        let thread = std::thread::Builder::new()
            .name("live image".to_owned())
            .spawn(move || work.run())
            .map_err(LiveError::Thread)?;
        Ok(Self {
            cancel,
            thread: Some(thread),
        })
    }

    /// Waits until the source has ended and all its data are imaged.
    ///
    /// # Errors
    /// Reason why the imaging ended before.
    pub fn finish(mut self) -> Result<(), LiveError> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(outcome)) => outcome,
            // A thread that panicked has printed its message.
            Some(Err(_)) | None => Ok(()),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            // Whoever drops it does not ask how it ended.
            let _ = thread.join();
        }
    }
}

struct Work {
    pipeline: Pipeline,
    source: Receiver<Tapped>,
    missed: Arc<AtomicU64>,
    board: Arc<Board>,
    picture: Option<Picture>,
    /// Pulses that are imaged and in no picture yet, and when their imaging began.
    unseen: Option<(Vec<Instant>, Instant)>,
    reported: Instant,
    /// When a picture was shown last.
    shown: Instant,
    silences: SilenceWatch,
    /// Whether the source has ended: no further messages are expected.
    is_over: bool,
    cancel: Arc<AtomicBool>,
}

impl Work {
    fn run(mut self) -> Result<(), LiveError> {
        let outcome = match self.until_over() {
            Err(LiveError::Imaging(ImagingError::Cancelled)) => Ok(()),
            outcome => outcome,
        };
        self.report(outcome.as_ref().err());
        outcome
    }

    fn until_over(&mut self) -> Result<(), LiveError> {
        while !self.is_over && !self.cancel.load(Ordering::SeqCst) {
            let patience = match self.unseen {
                Some(_) => LOOK_AGAIN,
                None => Duration::from_millis(50),
            };
            match self.source.recv_timeout(patience) {
                Ok(tapped) => self.hear(&tapped),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.is_over = true,
            }
            loop {
                // Data that arrived meanwhile go into the same picture.
                while let Ok(tapped) = self.source.try_recv() {
                    self.hear(&tapped);
                }
                self.pipeline.drop_behind(MOST_BEHIND);
                let cancel = Arc::clone(&self.cancel);
                let control = Control::default().cancelled_by(&cancel);
                let Some(step) = self.pipeline.step(control)? else {
                    break;
                };
                self.take_in(step);
                self.show_if_wanted();
                self.tell_if_due();
            }
            self.show_if_wanted();
            self.tell_if_due();
        }
        self.show();
        Ok(())
    }

    fn hear(&mut self, tapped: &Tapped) {
        self.silences.hear(tapped.record.kind, tapped.came);
        self.pipeline.take(&tapped.record, tapped.came);
    }

    /// Publishes the status separately, where no picture is due to carry it.
    fn tell_if_due(&mut self) {
        if self.reported.elapsed() >= REPORT_EVERY && self.shown.elapsed() >= REPORT_EVERY {
            self.report(None);
        }
    }

    fn show_if_wanted(&mut self) {
        if self.board.is_picture_wanted() {
            self.show();
        }
    }

    /// Reads the new pulses of the image; their picture is made when a page is ready.
    fn take_in(&mut self, step: Step) {
        self.board.show_traces(&step.clean.traces);
        self.board
            .show_track(step.places.iter().map(|place| TrackPlace {
                position_m: place.position_m,
                status: place.status.name(),
            }));
        let (came, _) = self.unseen.get_or_insert((Vec::new(), step.begun));
        came.extend(step.came);
    }

    fn show(&mut self) {
        let Some((came, begun)) = self.unseen.take() else {
            return;
        };
        let Some((grid, image)) = self.pipeline.image() else {
            return;
        };
        let picture = self.picture.get_or_insert_with(|| Picture::new(*grid));
        picture.update(image.image());
        let picture = picture.clone();
        if self.reported.elapsed() >= REPORT_EVERY {
            let status = self.status(None);
            self.board.keep_status(status, self.pipeline.origin_deg_m());
        }
        self.shown = Instant::now();
        self.board.show_picture(picture, &came, begun);
    }

    fn report(&mut self, failure: Option<&LiveError>) {
        let status = self.status(failure);
        self.board.show_status(status, self.pipeline.origin_deg_m());
    }

    fn status(&mut self, failure: Option<&LiveError>) -> Status {
        self.reported = Instant::now();
        let mut status = self.pipeline.status();
        status.pulses.missed_records = self.missed.load(Ordering::Relaxed);
        // Stopped instruments are no longer expected to send.
        if !self.is_over && self.board.is_recording() {
            status.silent = self.silences.silent(Instant::now());
        }
        status.doubts = doubts(&status, self.pipeline.settings().is_height_stated);
        status
            .doubts
            .extend(failure.map(|failure| format!("the live image ended: {failure}")));
        status
    }
}
