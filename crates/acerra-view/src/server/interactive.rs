//! Addresses that answer from the data behind a run: radargram, hyperbola, range ring, new images.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use acerra_chain::Track;
use acerra_imaging::refraction::Layer;
use axum::extract::{Path, Query, State};
use axum::http::HeaderValue;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE, HeaderName};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::engine::{
    Current, Edits, EngineStatus, ImageOrder, Made, Stage, TrackSky, checked_echo, checked_place,
    expected_spread, has_sky, hyperbola, ring,
};
use crate::error::RequestError;
use crate::raster::TileIndex;
use crate::server::answer::{bytes, in_background};
use crate::server::state::Shared;

/// The addresses.
pub fn routes() -> Router<Arc<Shared>> {
    Router::new()
        .route("/api/run/{run}/engine", get(engine))
        .route("/api/run/{run}/hyperbola", get(echoes_of_place))
        .route("/api/run/{run}/ring", get(places_of_echo))
        .route("/api/run/{run}/spread", get(spread_at_place))
        .route("/api/run/{run}/sky/{track}", get(sky))
        .route(
            "/api/run/{run}/radargram/{track}/{stage}/{level}/{column}/{row}",
            get(tile),
        )
        .route("/api/run/{run}/image", post(image))
        .route("/api/run/{run}/campaign", post(campaign))
}

/// Where the data are; the first to ask sets their reading off.
async fn engine(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
) -> Result<Json<Value>, RequestError> {
    let shown = shared.run(number)?;
    if shown.engine.claim() {
        let shown = Arc::clone(&shown);
        // The answer is the current status, also for later requests.
        drop(tokio::task::spawn_blocking(move || {
            shown.engine.open(&shown.run);
        }));
    }
    let status = shown.engine.status();
    let mut answer = json!(status);
    if status == EngineStatus::Ready {
        let current = shown.engine.current()?;
        answer["data"] = describe(&current);
    }
    Ok(Json(answer))
}

/// Tracks, axes of their radargrams and settings in force.
fn describe(current: &Current) -> Value {
    let prepared = &current.prepared;
    let track = |(number, (track, levels)): (usize, (&Track, &Option<_>))| {
        let levels: Option<&crate::engine::TrackRadargram> = levels.as_ref();
        let radargram = track.cleaned.as_ref().map(|traces| {
            json!({
                "traces": traces.clean.traces,
                "samples": traces.clean.samples_per_trace,
                "fast_time_start_ns": 1e9 * traces.clean.fast_time_start_s,
                "fast_time_step_ns": 1e9 * traces.clean.fast_time_step_s,
                "levels": levels.map(crate::engine::TrackRadargram::levels),
                "shift_ns": 1e9 * traces.shift_s,
                "gate_ns": traces.gate_s.map(|gate| gate.map(|s| 1e9 * s)),
                "maximum_raw": maximum(&traces.raw),
                "maximum_clean": maximum(&traces.clean),
            })
        });
        json!({
            "name": track.name,
            "unit": track.radar.unit,
            "first_pulse": track.range.start,
            "pulses": track.range.len(),
            "time_offset_s": track.time_offset_s,
            "radargram": radargram,
            "has_sky": has_sky(current, number),
        })
    };
    let tracks: Vec<Value> = prepared
        .tracks
        .iter()
        .zip(&current.radargrams)
        .enumerate()
        .map(track)
        .collect();
    json!({
        "revision": current.revision,
        "tracks": tracks,
        "trace": prepared.aligned.traces,
        "time_s": prepared.aligned.time_s,
        "position_m": prepared.aligned.position_m,
        "line_starts": prepared.aligned.line_starts,
        "height_m": prepared.aligned.height_m,
        "settings": current.campaign,
        "light_speed_m_s": prepared.scene.light_speed_m_s,
        "soil": soil(current),
    })
}

/// Thickness (m; none of the last) and refractive index of every layer below ground, from the top; empty for runs
/// without ground.
fn soil(current: &Current) -> Vec<(Option<f64>, f64)> {
    let pixels = current.prepared.scene.pixels.clone();
    let ground = current.campaign.image_request(pixels).underground;
    let layer = |layer: Layer| {
        let thickness_m = Some(layer.thickness_m).filter(|metres| metres.is_finite());
        (thickness_m, layer.soil.relative_permittivity.sqrt())
    };
    let layers = ground.into_iter().flat_map(|ground| ground.layers);
    layers.map(layer).collect()
}

/// The largest modulus of a radargram.
fn maximum(radargram: &acerra_radar::Radargram) -> f32 {
    use acerra_radar::Samples;
    match &radargram.samples {
        Samples::Real(values) => values.iter().fold(0.0, |most, v| v.abs().max(most)),
        Samples::Complex(values) => values.iter().fold(0.0, |most, v| v.norm().max(most)),
    }
}

async fn tile(
    State(shared): State<Arc<Shared>>,
    Path((number, track, stage, level, column, row)): Path<(
        usize,
        usize,
        Stage,
        usize,
        usize,
        usize,
    )>,
) -> Result<Response, RequestError> {
    let index = TileIndex { level, column, row };
    let tile = shared.in_background(number, move |shown| {
        let current = shown.engine.current()?;
        let own = current.prepared.tracks.get(track);
        let levels = current.radargrams.get(track).and_then(Option::as_ref);
        let tile = own
            .zip(levels)
            .and_then(|(own, levels)| levels.tile(own, stage, index));
        tile.ok_or(RequestError::Absent { what: "tile" })
    });
    tile.await.map(bytes)
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct PlaceQuery {
    x_m: f64,
    y_m: f64,
    /// On the ground by default.
    z_m: Option<f64>,
}

async fn echoes_of_place(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
    Query(place): Query<PlaceQuery>,
) -> Result<Response, RequestError> {
    let PlaceQuery { x_m, y_m, z_m } = place;
    checked_place([x_m, y_m, z_m.unwrap_or(0.0)])?;
    let echoes = shared.with_data(number, move |current| {
        let ground_m = current.prepared.scene.ground.below_m(x_m, y_m);
        let place_m = [x_m, y_m, z_m.unwrap_or(ground_m)];
        hyperbola(current, place_m)
    });
    echoes.await
}

async fn spread_at_place(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
    Query(place): Query<PlaceQuery>,
) -> Result<Response, RequestError> {
    let [x_m, y_m] = checked_place([place.x_m, place.y_m])?;
    let spread = move |current: &Current| expected_spread(current, x_m, y_m);
    shared.with_data(number, spread).await
}

/// Directions and signal strengths of the satellites in a track's GNSS log.
async fn sky(
    State(shared): State<Arc<Shared>>,
    Path((number, track)): Path<(usize, usize)>,
) -> Result<Response, RequestError> {
    let sky = move |current: &Current| TrackSky::of(current, track);
    shared.with_data(number, sky).await
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct EchoQuery {
    pulse: usize,
    fast_time_ns: f64,
}

async fn places_of_echo(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
    Query(echo): Query<EchoQuery>,
) -> Result<Response, RequestError> {
    checked_echo(echo.fast_time_ns)?;
    let places = move |current: &Current| ring(&current.prepared, echo.pulse, echo.fast_time_ns);
    shared.with_data(number, places).await
}

/// Cancels work whose answer nobody waits for any more.
struct CancelOnDrop(Arc<AtomicBool>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// An image of the view: pairs of single-precision numbers, with further data in the header `x-acerra-image`.
async fn image(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
    Json(order): Json<ImageOrder>,
) -> Result<Response, RequestError> {
    let shown = shared.run(number)?;
    let cancel = shown.engine.supersede();
    let guard = CancelOnDrop(Arc::clone(&cancel));
    let made = in_background(move || shown.engine.image(&order, &cancel)).await?;
    drop(guard);
    Ok(answer(made))
}

fn answer(made: Made) -> Response {
    let details = json!({
        "maximum_db": made.maximum_db,
        "pulses": made.pulses,
        "cleaning_ms": made.cleaning_ms,
        "imaging_ms": made.imaging_ms,
        "revision": made.revision,
    });
    let values = made.values.iter().flat_map(|v| [v.re, v.im]);
    let mut response = bytes(values.flat_map(f32::to_le_bytes).collect());
    if let Ok(details) = HeaderValue::from_str(&details.to_string()) {
        let name = HeaderName::from_static("x-acerra-image");
        response.headers_mut().insert(name, details);
    }
    response
}

/// The campaign file with changes.
async fn campaign(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
    Json(edits): Json<Edits>,
) -> Result<Response, RequestError> {
    let text = shared.in_background(number, move |shown| {
        let campaign = shown.engine.campaign(&edits)?;
        let head = "# Settings tried in acerra view; everything left to the data is stated.\n";
        Ok(format!("{head}{}", toml::to_string(&campaign)?))
    });
    let headers = [
        (CONTENT_TYPE, "application/toml; charset=utf-8"),
        (
            CONTENT_DISPOSITION,
            "attachment; filename=\"campaign.toml\"",
        ),
    ];
    Ok((headers, text.await?).into_response())
}
