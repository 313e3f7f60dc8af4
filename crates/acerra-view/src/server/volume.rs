//! Tiles of the planes through a run's volume.

use std::sync::Arc;

use acerra_products::data::Axis;
use axum::Router;
use axum::extract::{Path, Query, State};
use axum::response::Response;
use axum::routing::get;
use serde::Deserialize;

use crate::error::RequestError;
use crate::raster::TileIndex;
use crate::server::answer::{TileForm, bytes};
use crate::server::state::Shared;

/// The addresses.
pub fn routes() -> Router<Arc<Shared>> {
    Router::new().route(
        "/api/run/{run}/volume/{normal}/{index}/{level}/{column}/{row}",
        get(tile),
    )
}

/// The axis to which a plane is normal.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Normal {
    X,
    Y,
    Z,
}

/// A tile of a plane.
#[derive(Clone, Copy, Debug, Deserialize)]
struct PlaneTile {
    run: usize,
    normal: Normal,
    index: usize,
    level: usize,
    column: usize,
    row: usize,
}

async fn tile(
    State(shared): State<Arc<Shared>>,
    Path(at): Path<PlaneTile>,
    Query(form): Query<TileForm>,
) -> Result<Response, RequestError> {
    let normal = match at.normal {
        Normal::X => Axis::X,
        Normal::Y => Axis::Y,
        Normal::Z => Axis::Z,
    };
    let index = TileIndex {
        level: at.level,
        column: at.column,
        row: at.row,
    };
    let tile = shared.in_background(at.run, move |shown| {
        let volume = shown.run.volume.as_ref();
        let volume = volume.ok_or(RequestError::Absent { what: "volume" })?;
        let plane = volume.plane(normal, at.index)?;
        let tile = plane.pyramid.tile(
            plane.as_ref(),
            index,
            form.precision(shown.run.display.half),
        );
        tile.ok_or(RequestError::Absent { what: "tile" })
    });
    tile.await.map(bytes)
}
