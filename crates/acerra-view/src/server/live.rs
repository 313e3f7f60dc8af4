//! The server of a live image: its page, its WebSocket, the end of the recording, and the final run once it is
//! there.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use acerra_live::Board;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use serde_json::json;
use tower_service::Service;

use super::doorway::Doorway;
use super::guard::Guard;
use super::live_socket::{Clients, socket};
use super::{assets, products, run_at};
use crate::error::ViewError;

/// Where the final run is shown, under the live page's address.
const FINAL: &str = "view";

/// A server of a live image that listens and does not answer yet.
#[derive(Debug)]
pub struct LiveServer {
    doorway: Doorway,
    address: String,
    router: Router,
    last: FinalView,
}

/// Where the final run appears.
#[derive(Clone, Debug)]
pub struct FinalView {
    path: String,
    router: Arc<OnceLock<Router>>,
}

impl FinalView {
    /// Shows the run in a directory from now on, under the live page's address; only the first one is.
    ///
    /// # Errors
    /// A directory that holds no run.
    pub fn show(&self, directory: &Path) -> Result<(), ViewError> {
        let router = run_at(&self.path, directory)?;
        // A second one has no place.
        let _ = self.router.set(router);
        Ok(())
    }

    async fn answer(self, request: Request) -> Response {
        let Some(router) = self.router.get() else {
            return StatusCode::NOT_FOUND.into_response();
        };
        match router.clone().call(request).await {
            Ok(response) => response,
            Err(never) => match never {},
        }
    }
}

/// A page's wish to end the recording.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StopForm {
    /// Whether the one at the page has confirmed it.
    confirmed: bool,
}

/// Ends the recording in order, where it goes on and that is confirmed.
async fn stop(State(board): State<Arc<Board>>, Json(form): Json<StopForm>) -> Response {
    let refused =
        |status: StatusCode, error: &str| (status, Json(json!({ "error": error }))).into_response();
    if !form.confirmed {
        let error = "expected the end of the recording to be confirmed";
        return refused(StatusCode::BAD_REQUEST, error);
    }
    if !board.ask_to_stop() {
        let error = "no recording goes on here that could be ended";
        return refused(StatusCode::CONFLICT, error);
    }
    StatusCode::NO_CONTENT.into_response()
}

impl LiveServer {
    /// Takes an address on the loopback interface for the page of what `board` shows.
    ///
    /// # Errors
    /// An address that cannot be had.
    pub fn open(board: Arc<Board>, port: u16) -> Result<Self, ViewError> {
        let doorway = Doorway::open(port)?;
        let token = &doorway.token;
        let last = FinalView {
            path: format!("/{token}/{FINAL}"),
            router: Arc::default(),
        };
        let stopped = Arc::clone(&board);
        let clients = Clients::of(board);
        let pages = Router::new()
            .merge(assets::routes())
            .merge(products::palettes())
            .route("/live", get(socket))
            .with_state(clients)
            .merge(Router::new().route("/stop", post(stop)).with_state(stopped));
        let answers = last.clone();
        let router = Router::new()
            .nest(&format!("/{token}"), pages)
            .route(&format!("/{token}/"), get(assets::live_page))
            .fallback(move |request| answers.clone().answer(request));
        let router = Guard::new(doorway.port, None).around(router);
        Ok(Self {
            address: doorway.address(),
            doorway,
            router,
            last,
        })
    }

    /// The address of the page, with the token that gives access.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Where the final run will appear.
    #[must_use]
    pub fn final_view(&self) -> FinalView {
        self.last.clone()
    }

    /// Answers requests until `stop` returns true.
    ///
    /// # Errors
    /// A failure of the system.
    pub fn run(self, stop: impl Fn() -> bool + Send + 'static) -> Result<(), ViewError> {
        self.doorway.serve(self.router, stop)
    }
}
