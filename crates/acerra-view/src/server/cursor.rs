//! Data under the pointer: place, value, and range and delay of the place.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use axum::routing::get;
use axum::{Json, Router};
use num_complex::Complex32;
use serde::{Deserialize, Serialize};

use crate::engine::{checked_place, seen_from};
use crate::error::RequestError;
use crate::raster::Field;
use crate::run::{Run, Seen};
use crate::server::state::{Shared, Shown};

/// The addresses.
pub fn routes() -> Router<Arc<Shared>> {
    Router::new().route("/api/run/{run}/cursor", get(cursor))
}

/// A place on the image or in the volume.
#[derive(Clone, Copy, Debug, Deserialize)]
struct CursorQuery {
    x_m: f64,
    y_m: f64,
    /// The slice of the volume; the image by default.
    slice: Option<usize>,
    /// Height of the place (m); by default that of the pixel.
    z_m: Option<f64>,
    /// The pulse for which range and delay are given, counted over all tracks of the run's data; by default
    /// the nearest trace of the run's track.
    pulse: Option<usize>,
}

/// The answer.
#[derive(Debug, Serialize)]
struct Cursor {
    /// East, north and up (m).
    place_m: [f64; 3],
    /// Latitude, longitude (degrees) and ellipsoidal height (m).
    place_deg_m: Option<[f64; 3]>,
    /// Column and row.
    pixel: Option<[usize; 2]>,
    /// Real and imaginary part.
    value: Option<[f64; 2]>,
    /// Level below the image's maximum (dB).
    level_db: Option<f64>,
    /// Phase (degrees).
    phase_deg: Option<f64>,
    /// Range and incidence.
    seen: Option<Seen>,
}

async fn cursor(
    State(shared): State<Arc<Shared>>,
    Path(number): Path<usize>,
    Query(at): Query<CursorQuery>,
) -> Result<Json<Cursor>, RequestError> {
    checked_place([at.x_m, at.y_m, at.z_m.unwrap_or(0.0)])?;
    let answer = shared.in_background(number, move |shown| answer(shown, &at));
    answer.await.map(Json)
}

fn answer(shown: &Shown, at: &CursorQuery) -> Result<Cursor, RequestError> {
    let run = &shown.run;
    let pixel = run.image.pixel_at(at.x_m, at.y_m);
    let (value, height_m) = match at.slice {
        Some(slice) => in_slice(run, pixel, slice)?,
        None => (
            pixel.map(|[column, row]| run.image.at(column, row)),
            run.image.height_m(at.x_m, at.y_m),
        ),
    };
    let place_m = [at.x_m, at.y_m, at.z_m.unwrap_or(height_m)];
    let level_db = value.map(|v| 20.0 * f64::from(v.norm()).log10() - run.display.maximum_db);
    Ok(Cursor {
        place_m,
        place_deg_m: run.place_deg_m(place_m),
        pixel,
        value: value.map(|v| [v.re, v.im].map(f64::from)),
        level_db,
        phase_deg: value.map(|v| f64::from(v.arg()).to_degrees()),
        seen: match at.pulse {
            Some(pulse) => Some(seen_from(
                &shown.engine.current()?.prepared,
                pulse,
                place_m,
            )?),
            None => run.track.nearest(place_m),
        },
    })
}

/// The value of a slice's pixel, and the slice's height (m).
fn in_slice(
    run: &Run,
    pixel: Option<[usize; 2]>,
    slice: usize,
) -> Result<(Option<Complex32>, f64), RequestError> {
    let volume = run.volume.as_ref();
    let volume = volume.ok_or(RequestError::Absent { what: "volume" })?;
    let height_m = volume.height_m(slice);
    let height_m = height_m.ok_or(RequestError::Absent { what: "slice" })?;
    let value = pixel
        .map(|[i, j]| volume.value([i, j, slice]))
        .transpose()?;
    Ok((value, height_m))
}
