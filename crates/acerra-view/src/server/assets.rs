//! The page: embedded when the program is built.

use std::sync::LazyLock;

use axum::Router;
use axum::extract::Path;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use crate::error::RequestError;

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
const LIVE_TEXT: &str = include_str!("../../web/live.html");

/// Names, types and texts of the page's files.
const ASSETS: &[(&str, &str, &str)] = &[
    ("style.css", CSS, include_str!("../../web/style.css")),
    ("icon.svg", PICTURE, include_str!("../../web/icon.svg")),
    script!("api.js"),
    script!("basemap.js"),
    script!("camera.js"),
    script!("coloured.js"),
    script!("cuts-pane.js"),
    script!("depth.js"),
    script!("display-panel.js"),
    script!("drawing.js"),
    script!("export.js"),
    script!("findings-panel.js"),
    script!("form.js"),
    script!("gestures.js"),
    script!("gl.js"),
    script!("image-pane.js"),
    script!("layers.js"),
    script!("live-link.js"),
    script!("live-picture.js"),
    script!("live-status.js"),
    script!("live-traces.js"),
    script!("live.js"),
    script!("main.js"),
    script!("palettes.js"),
    script!("pane.js"),
    script!("radargram-pane.js"),
    script!("readout.js"),
    script!("scrubber.js"),
    script!("settings-panel.js"),
    script!("shaders.js"),
    script!("sky-panel.js"),
    script!("store.js"),
    script!("terrain.js"),
    script!("theme.js"),
    script!("tiles.js"),
    script!("track-strip.js"),
    script!("volume-panel.js"),
];

/// The addresses of the page.
pub fn routes<S: Clone + Send + Sync + 'static>() -> Router<S> {
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

/// The page of runs, which asks for all its modules at once.
pub async fn page() -> Response {
    static PAGE: LazyLock<String> = LazyLock::new(|| with_modules(PAGE_TEXT, false));
    ([(CONTENT_TYPE, HTML)], PAGE.as_str()).into_response()
}

/// The page of a live image.
pub async fn live_page() -> Response {
    static PAGE: LazyLock<String> = LazyLock::new(|| with_modules(LIVE_TEXT, true));
    ([(CONTENT_TYPE, HTML)], PAGE.as_str()).into_response()
}

/// Modules that the live page has of the other.
const LIVE_SHARES: [&str; 6] = [
    "js/api.js",
    "js/camera.js",
    "js/drawing.js",
    "js/gestures.js",
    "js/palettes.js",
    "js/theme.js",
];

fn with_modules(text: &str, live: bool) -> String {
    let is_wanted = |name: &str| {
        let is_live = name.starts_with("js/live");
        is_live == live || live && LIVE_SHARES.contains(&name)
    };
    let scripts = ASSETS
        .iter()
        .filter(|(name, kind, _)| *kind == SCRIPT && is_wanted(name));
    let link =
        |(name, ..): &(&str, &str, &str)| format!("<link rel=\"modulepreload\" href=\"{name}\">");
    let links: Vec<String> = scripts.map(link).collect();
    text.replace("<!-- modules -->", &links.join("\n  "))
}

fn asset(name: &str) -> Response {
    match ASSETS.iter().find(|(own, ..)| *own == name) {
        Some((_, kind, text)) => ([(CONTENT_TYPE, *kind)], *text).into_response(),
        None => RequestError::Absent { what: "page" }.into_response(),
    }
}
