//! Answers: errors as JSON with a status, values as bytes, work outside the server's thread.

use axum::Json;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::json;

use crate::error::{EngineError, RequestError};
use crate::raster::Precision;

impl IntoResponse for RequestError {
    fn into_response(self) -> Response {
        let status = match &self {
            Self::Absent { .. } => StatusCode::NOT_FOUND,
            Self::Superseded | Self::Engine(EngineError::NotReady) => StatusCode::CONFLICT,
            Self::Invalid { .. } | Self::Campaign(_) | Self::Grid(_) => StatusCode::BAD_REQUEST,
            Self::Chain(_) | Self::Autofocus(_) | Self::Image(_) | Self::Engine(_) => {
                StatusCode::UNPROCESSABLE_ENTITY
            }
            Self::File { .. } | Self::Volume(_) | Self::Write(_) | Self::GivenUp => {
                StatusCode::INTERNAL_SERVER_ERROR
            }
        };
        (status, Json(json!({ "error": self.to_string() }))).into_response()
    }
}

/// Bytes that no browser takes for anything else.
pub fn bytes(values: Vec<u8>) -> Response {
    ([(CONTENT_TYPE, "application/octet-stream")], values).into_response()
}

/// Form of the numbers of a tile.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct TileForm {
    /// In half precision; in single precision by default.
    #[serde(default)]
    half: bool,
}

impl TileForm {
    /// Single precision, or the half precision of a run.
    pub fn precision(self, half: Precision) -> Precision {
        if self.half { half } else { Precision::Single }
    }
}

/// Executes work on a separate thread.
///
/// # Errors
/// Errors of the work; work that ended without an answer.
pub async fn in_background<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, RequestError> + Send + 'static,
) -> Result<T, RequestError> {
    let done = tokio::task::spawn_blocking(work).await;
    done.unwrap_or(Err(RequestError::GivenUp))
}
