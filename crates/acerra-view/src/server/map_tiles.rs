//! The address of map tiles in a directory.

use std::sync::Arc;

use axum::Router;
use axum::extract::{Path, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use crate::error::RequestError;
use crate::server::answer::in_background;
use crate::server::state::Shared;

/// The address.
pub fn routes() -> Router<Arc<Shared>> {
    Router::new().route("/map/{z}/{x}/{y}", get(tile))
}

async fn tile(
    State(shared): State<Arc<Shared>>,
    Path(numbers): Path<[u32; 3]>,
) -> Result<Response, RequestError> {
    let tile = in_background(move || match &shared.basemap {
        Some(map) => map.tile(numbers),
        None => Err(RequestError::Absent { what: "map tile" }),
    });
    let (kind, picture) = tile.await?;
    Ok(([(CONTENT_TYPE, kind)], picture).into_response())
}
