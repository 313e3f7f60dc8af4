//! What all requests share.

use std::sync::Arc;

use crate::engine::Engine;
use crate::error::RequestError;
use crate::run::Run;
use crate::server::guard::Basemap;

/// A run and the data behind it.
#[derive(Debug)]
pub struct Shown {
    /// The run.
    pub run: Run,
    /// The data behind it.
    pub engine: Engine,
}

/// The runs that are shown.
#[derive(Debug)]
pub struct Shared {
    runs: Vec<Arc<Shown>>,
    /// Map tiles under the image, as the user gives them.
    pub basemap: Option<Basemap>,
}

impl Shared {
    /// Runs, their data not asked for yet.
    pub fn new(runs: Vec<Run>, basemap: Option<Basemap>) -> Self {
        let shown = |run| {
            let engine = Engine::default();
            Arc::new(Shown { run, engine })
        };
        Self {
            runs: runs.into_iter().map(shown).collect(),
            basemap,
        }
    }

    /// All of them.
    pub fn runs(&self) -> &[Arc<Shown>] {
        &self.runs
    }

    /// Run `number`, from 0.
    ///
    /// # Errors
    /// No such run.
    pub fn run(&self, number: usize) -> Result<Arc<Shown>, RequestError> {
        let run = self.runs.get(number);
        run.map(Arc::clone)
            .ok_or(RequestError::Absent { what: "run" })
    }
}
