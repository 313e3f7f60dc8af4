//! State shared by all requests, and answers from a run and from its data.

use std::sync::Arc;

use axum::Json;
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use crate::engine::{Current, Engine};
use crate::error::RequestError;
use crate::run::Run;
use crate::server::answer::in_background;
use crate::server::basemap::Basemap;

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
    /// Runs without their data.
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

    /// Executes work on a run, on a separate thread.
    ///
    /// # Errors
    /// No such run; errors of the work.
    pub async fn in_background<T: Send + 'static>(
        &self,
        number: usize,
        work: impl FnOnce(&Shown) -> Result<T, RequestError> + Send + 'static,
    ) -> Result<T, RequestError> {
        let shown = self.run(number)?;
        in_background(move || work(&shown)).await
    }

    /// Answers in JSON from the data behind a run with the settings tried last.
    ///
    /// # Errors
    /// No such run; data that are not ready or failed; errors of the work.
    pub async fn with_data<T: Serialize>(
        &self,
        number: usize,
        work: impl FnOnce(&Current) -> Result<T, RequestError> + Send + 'static,
    ) -> Result<Response, RequestError> {
        self.in_background(number, move |shown| {
            let current = shown.engine.current()?;
            Ok(Json(work(&current)?).into_response())
        })
        .await
    }
}
