//! The viewer: a web server on the loopback interface that shows runs, and the pages it serves.
//!
//! ```text
//! directory ──Run::open──► Run (image, record, targets, track) ──tiles, cursor──┐
//!                           │ inputs named in run.json                          ├─► server ─► page
//!                           └─Engine::open──► Workbench ──radargram, images─────┘
//! ```
//!
//! - [`run`]: the products of a run in memory. They are enough for the image, its cursor, the track,
//!   the targets and the evidence.
//! - [`engine`]: the logs behind a run. They are enough for the radargram, for images of a part of the
//!   pulses, and for images with other settings.
//! - [`server`]: addresses, who may ask, and the page itself, which is embedded.
//! - [`raster`]: tiles of any field of values.
//! - [`LiveServer`]: the page of an image that forms while the radar flies, over a WebSocket; then the final run.
//!
//! Only addresses on this machine are listened to. Requests of other origins or under another host
//! name are refused, and every address begins with a random token. Files are served by their names
//! as products alone.

pub mod engine;
mod error;
pub mod raster;
pub mod run;
pub mod server;

pub use error::{EngineError, RequestError, ViewError};
pub use server::{FinalView, LiveServer, Server, ServerOptions};
