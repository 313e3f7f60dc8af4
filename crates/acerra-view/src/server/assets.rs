//! The page: embedded when the program is built.

use std::sync::{Arc, LazyLock};

use axum::Router;
use axum::extract::Path;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use crate::error::RequestError;
use crate::server::state::Shared;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const PICTURE: &str = "image/svg+xml";

macro_rules! script {
    ($name:literal) => {
        (
            concat!("js/", $name),
            SCRIPT,
            include_str!(concat!("../../web/js/", $name)),
        )
    };
}

const PAGE_TEXT: &str = include_str!("../../web/index.html");

/// Names, types and texts of the page's files.
const ASSETS: &[(&str, &str, &str)] = &[
    ("style.css", CSS, include_str!("../../web/style.css")),
    ("icon.svg", PICTURE, include_str!("../../web/icon.svg")),
    script!("api.js"),
    script!("basemap.js"),
    script!("camera.js"),
    script!("cuts-pane.js"),
    script!("display-panel.js"),
    script!("drawing.js"),
    script!("export.js"),
    script!("findings-panel.js"),
    script!("form.js"),
    script!("gestures.js"),
    script!("gl.js"),
    script!("image-pane.js"),
    script!("layers.js"),
    script!("main.js"),
    script!("palettes.js"),
    script!("pane.js"),
    script!("radargram-pane.js"),
    script!("readout.js"),
    script!("settings-panel.js"),
    script!("store.js"),
    script!("terrain.js"),
    script!("theme.js"),
    script!("tiles.js"),
    script!("track-strip.js"),
    script!("volume-panel.js"),
];

/// The addresses of the page.
pub fn routes() -> Router<Arc<Shared>> {
    Router::new()
        .route(
            "/{name}",
            get(|Path(name): Path<String>| async move { asset(&name) }),
        )
        .route(
            "/js/{name}",
            get(|Path(name): Path<String>| async move { asset(&format!("js/{name}")) }),
        )
}

/// The page itself, which asks for all modules at once.
pub async fn page() -> Response {
    static PAGE: LazyLock<String> = LazyLock::new(|| {
        let scripts = ASSETS.iter().filter(|(_, kind, _)| *kind == SCRIPT);
        let link = |(name, ..): &(&str, &str, &str)| {
            format!("<link rel=\"modulepreload\" href=\"{name}\">")
        };
        let links: Vec<String> = scripts.map(link).collect();
        PAGE_TEXT.replace("<!-- modules -->", &links.join("\n  "))
    });
    ([(CONTENT_TYPE, HTML)], PAGE.as_str()).into_response()
}

fn asset(name: &str) -> Response {
    match ASSETS.iter().find(|(own, ..)| *own == name) {
        Some((_, kind, text)) => ([(CONTENT_TYPE, *kind)], *text).into_response(),
        None => RequestError::Absent { what: "page" }.into_response(),
    }
}
