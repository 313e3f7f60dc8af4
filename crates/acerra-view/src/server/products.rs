//! Addresses that answer from a run's products: record, tiles of the image, track, files.

use std::sync::Arc;

use acerra_figure::Palette;
use acerra_products::data::Axis;
use acerra_products::names::PRODUCTS;
use axum::extract::{Path, Query, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};

use crate::error::RequestError;
use crate::raster::{TILE, TileIndex};
use crate::run::{Run, Volume};
use crate::server::answer::{TileForm, bytes};
use crate::server::state::{Shared, Shown};

/// The addresses.
pub fn routes() -> Router<Arc<Shared>> {
    Router::new()
        .route("/api/runs", get(runs))
        .route("/api/run/{run}", get(run))
        .route("/api/run/{run}/gain", get(gain))
        .route("/api/run/{run}/track", get(track))
        .route("/api/run/{run}/terrain", get(terrain))
        .route("/api/run/{run}/image/{level}/{column}/{row}", get(tile))
        .route("/run/{run}/{name}", get(file))
}

async fn runs(State(shared): State<Arc<Shared>>) -> Json<Value> {
    let one =
        |run: &Run| json!({ "name": run.name, "directory": run.directory.display().to_string() });
    let runs: Vec<Value> = shared.runs().iter().map(|shown| one(&shown.run)).collect();
    Json(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "runs": runs,
        "basemap": shared.basemap,
        "tile": TILE,
    }))
}

/// The addresses of palettes, which every page has.
pub fn palettes<S: Clone + Send + Sync + 'static>() -> Router<S> {
    Router::new().route("/api/palette/{name}", get(palette))
}

/// Colours of a palette.
const COLOURS: usize = 256;

/// A palette as red, green, blue and opacity of even steps.
async fn palette(Path(name): Path<String>) -> Result<Response, RequestError> {
    let palette = match name.as_str() {
        "inferno" => Palette::Inferno,
        "viridis" => Palette::Viridis,
        "cividis" => Palette::Cividis,
        "greys" => Palette::Greys,
        "bluered" => Palette::BlueRed,
        _ => return Err(RequestError::Absent { what: "palette" }),
    };
    let colour = |k: usize| {
        let [r, g, b] = palette.at(k as f64 / (COLOURS - 1) as f64);
        [r, g, b, 255]
    };
    Ok(bytes((0..COLOURS).flat_map(colour).collect()))
}

async fn run(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
) -> Result<Json<Value>, RequestError> {
    let shown = shared.run(number)?;
    let run = &shown.run;
    let (grid, display) = (&run.image.grid, &run.display);
    let files: Vec<&str> = PRODUCTS
        .into_iter()
        .filter(|name| run.directory.join(name).is_file())
        .collect();
    Ok(Json(json!({
        "name": run.name,
        "grid": {
            "x0_m": grid.x0_m, "y0_m": grid.y0_m, "z_m": grid.z_m, "pixel_m": grid.pixel_m,
            "nx": grid.nx, "ny": grid.ny, "uneven": run.image.is_uneven(),
        },
        "levels": run.pyramid.count(),
        "display": {
            "zero_db": display.zero_db, "maximum_db": display.maximum_db,
            "floor_db": display.floor_db, "half_db": display.half.scale_db(), "gain": display.gain_db.is_some(),
        },
        "volume": run.volume.as_ref().map(describe),
        "origin_deg_m": run.record.origin_deg_m,
        "record": run.record.json,
        "targets": run.targets,
        "files": files,
    })))
}

/// Heights of a volume's slices, and levels of the planes normal to each axis.
fn describe(volume: &Volume) -> Value {
    json!({
        "z0_m": volume.z0_m, "step_m": volume.step_m, "slices": volume.slices(),
        "levels": {
            "x": volume.levels(Axis::X), "y": volume.levels(Axis::Y), "z": volume.levels(Axis::Z),
        },
    })
}

async fn gain(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
) -> Result<Response, RequestError> {
    let shown = shared.run(number)?;
    let nodes = shown.run.display.gain_db.as_ref();
    let nodes = nodes.ok_or(RequestError::Absent { what: "gain" })?;
    Ok(bytes(nodes.iter().flat_map(|v| v.to_le_bytes()).collect()))
}

async fn track(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
) -> Result<Response, RequestError> {
    let track = |shown: &Shown| Ok(Json(&shown.run.track).into_response());
    shared.in_background(number, track).await
}

/// Heights of the ground under an image that is on terrain.
async fn terrain(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
) -> Result<Response, RequestError> {
    let terrain = |shown: &Shown| {
        // The heights of a volume's image are those of the volume's strongest values.
        let is_ground = shown.run.volume.is_none();
        let terrain = shown.run.image.terrain().filter(|_| is_ground);
        let terrain = terrain.ok_or(RequestError::Absent { what: "terrain" })?;
        Ok(Json(terrain).into_response())
    };
    shared.in_background(number, terrain).await
}

async fn tile(
    State(shared): State<Arc<Shared>>,
    Path((number, level, column, row)): Path<(usize, usize, usize, usize)>,
    Query(form): Query<TileForm>,
) -> Result<Response, RequestError> {
    let index = TileIndex { level, column, row };
    let tile = shared.in_background(number, move |shown| {
        let run = &shown.run;
        let precision = form.precision(run.display.half);
        let tile = run.pyramid.tile(&run.image, index, precision);
        tile.ok_or(RequestError::Absent { what: "tile" })
    });
    tile.await.map(bytes)
}

/// A product, by its name alone.
async fn file(
    State(shared): State<Arc<Shared>>,
    Path((number, name)): Path<(usize, String)>,
) -> Result<Response, RequestError> {
    let known = PRODUCTS.into_iter().find(|product| *product == name);
    let name = known.ok_or(RequestError::Absent { what: "product" })?;
    let read = shared.in_background(number, move |shown| {
        let path = shown.run.directory.join(name);
        // A directory, or a link to a file that is no product, is no file of the run.
        if !std::fs::symlink_metadata(&path).is_ok_and(|data| data.is_file()) {
            return Err(RequestError::Absent { what: "product" });
        }
        std::fs::read(&path).map_err(|cause| RequestError::File {
            name: name.to_owned(),
            cause,
        })
    });
    let content = read.await?;
    let kind = match name.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("png") => "image/png",
        Some("json" | "geojson") => "application/json",
        Some("csv") => "text/csv; charset=utf-8",
        _ => "application/octet-stream",
    };
    // The report includes its style and pictures, and needs no script.
    let policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox";
    let headers = [(CONTENT_TYPE, kind), (CONTENT_SECURITY_POLICY, policy)];
    Ok((headers, content).into_response())
}
