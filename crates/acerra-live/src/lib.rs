//! The image that forms while the radar flies.
//!
//! ```text
//! recording ──Tap──┐                ┌─ Positions (NAV-PVT, GGA) ─┐
//! session.log ─────┴─► Pipeline ────┤  RunningClock              ├─► Cleaner ─► Canvas ─► Board
//!                                   └─ Queue of waiting pulses ──┘
//! ```
//!
//! - [`settings`]: settings of the live image in a session file.
//! - [`clock`]: the radio's scans on GPS time, by the stamps so far.
//! - [`hardware_clock`]: the better one by pulses per second and time marks.
//! - [`positions`]: the receiver's own solutions, and the radar's place between them.
//! - [`clean`]: causal cleaning.
//! - [`pipeline`]: from records to an image, without threads.
//! - [`board`]: the data shown: picture, track, traces, status; a slow display delays nothing.
//! - [`worker`]: the thread that images, and [`replay`] of a recorded session at its own pace.
//!
//! Everything here is provisional: positions are those that the receiver computes in flight, the background
//! is the mean of the traces so far. A pulse is imaged when the position after it has arrived; positions are
//! never extrapolated.

pub mod board;
mod canvas;
pub mod clean;
pub mod clock;
mod error;
pub mod hardware_clock;
pub mod latency;
mod nmea;
mod patience;
pub mod picture;
pub mod pipeline;
pub mod place;
pub mod positions;
mod queue;
pub mod replay;
mod scans;
pub mod settings;
mod solutions;
pub mod status;
pub mod worker;

pub use board::{Board, Final};
pub use error::LiveError;
pub use pipeline::Pipeline;
pub use settings::LiveSettings;
pub use worker::Worker;
