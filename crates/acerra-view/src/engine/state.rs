//! State of the data of a run: not requested, being read, ready, or failed.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use acerra_chain::Control;
use acerra_chain::campaign::Campaign;
use acerra_chain::read::inputs::InputFile;
use serde::Serialize;

use crate::engine::edits::Edits;
use crate::engine::work::{Current, ImageOrder, Made, Workbench};
use crate::error::{EngineError, RequestError};
use crate::run::{Record, Run};

/// The data of a run. They are read at the first request.
#[derive(Debug, Default)]
pub struct Engine {
    state: Mutex<State>,
    /// Cancels the image that is being made.
    newest: Mutex<Arc<AtomicBool>>,
}

#[derive(Clone, Debug, Default)]
enum State {
    #[default]
    Idle,
    Reading,
    Ready(Arc<Workbench>),
    Failed(EngineError),
}

/// Report on an engine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "state", rename_all = "lowercase")]
pub enum EngineStatus {
    /// No request for the data yet.
    Idle,
    /// They are being read and cleaned.
    Reading,
    /// They can be imaged.
    Ready,
    /// They cannot be had.
    Failed {
        /// Cause.
        reason: String,
    },
}

impl Engine {
    /// Location of the data.
    #[must_use]
    pub fn status(&self) -> EngineStatus {
        match &*self.state() {
            State::Idle => EngineStatus::Idle,
            State::Reading => EngineStatus::Reading,
            State::Ready(_) => EngineStatus::Ready,
            State::Failed(error) => EngineStatus::Failed {
                reason: error.to_string(),
            },
        }
    }

    /// Takes it upon the caller to [`open`](Self::open) the data; false where another has done so.
    #[must_use]
    pub fn claim(&self) -> bool {
        let mut state = self.state();
        let is_idle = matches!(*state, State::Idle);
        if is_idle {
            *state = State::Reading;
        }
        is_idle
    }

    /// Reads and cleans the logs of a run; it takes as long as the run's first stages did.
    pub fn open(&self, run: &Run) {
        let opened = read(&run.record);
        *self.state() = match opened {
            Ok(bench) => State::Ready(Arc::new(bench)),
            Err(error) => State::Failed(error),
        };
    }

    /// The data with the settings tried last.
    ///
    /// # Errors
    /// Data that are not ready or cannot be had.
    pub fn current(&self) -> Result<Arc<Current>, EngineError> {
        Ok(self.bench()?.current())
    }

    /// The campaign with changes.
    ///
    /// # Errors
    /// Data that are not ready, settings that are impossible.
    pub fn campaign(&self, edits: &Edits) -> Result<Campaign, RequestError> {
        self.bench()?.campaign(edits)
    }

    /// A flag for the newest image; the one before it is cancelled.
    #[must_use]
    pub fn supersede(&self) -> Arc<AtomicBool> {
        let own = Arc::new(AtomicBool::new(false));
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        newest.store(true, Ordering::Relaxed);
        *newest = Arc::clone(&own);
        own
    }

    /// Makes an image; `cancel` is the flag from [`supersede`](Self::supersede).
    ///
    /// # Errors
    /// Data that are not ready, settings or pixels that are impossible, a newer request.
    pub fn image(&self, order: &ImageOrder, cancel: &AtomicBool) -> Result<Made, RequestError> {
        let control = Control::default().cancelled_by(cancel);
        self.bench()?.image(order, &control)
    }

    fn bench(&self) -> Result<Arc<Workbench>, EngineError> {
        match &*self.state() {
            State::Idle | State::Reading => Err(EngineError::NotReady),
            State::Ready(bench) => Ok(Arc::clone(bench)),
            State::Failed(error) => Err(error.clone()),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads the logs that a record names, if they are those that the run read.
fn read(record: &Record) -> Result<Workbench, EngineError> {
    let campaign = record.campaign()?;
    let campaign_file = record.inputs.first().map(|input| input.path.as_path());
    for input in &record.inputs {
        // The campaign file may have been edited since: its settings are in the record.
        if Some(input.path.as_path()) == campaign_file {
            continue;
        }
        let found = InputFile::record(&input.path).map_err(|cause| EngineError::Input {
            path: input.path.clone(),
            cause: cause.to_string(),
        })?;
        if found.sha256 != input.sha256 {
            return Err(EngineError::Changed {
                path: input.path.clone(),
                expected: input.sha256.clone(),
            });
        }
    }
    Workbench::open(campaign, &Control::default())
        .map_err(|error| EngineError::Chain(error.to_string()))
}
