//! What is said on stderr beside failures, and how much of it.

use std::io::{IsTerminal, Write};
use std::sync::OnceLock;

use acerra_products::{failure_text, plain_text};

/// How much is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verbosity {
    /// Failures and warnings alone: no progress, no notes, no summary.
    Quiet,
    /// Progress on a terminal, notes, the answer.
    #[default]
    Normal,
    /// The cost of each stage as well.
    Verbose,
}

static VERBOSITY: OnceLock<Verbosity> = OnceLock::new();

/// Settles the verbosity of the process, once.
pub fn set_verbosity(verbosity: Verbosity) {
    // A second call changes nothing.
    let _ = VERBOSITY.set(verbosity);
}

/// The verbosity of the process.
#[must_use]
pub fn verbosity() -> Verbosity {
    VERBOSITY.get().copied().unwrap_or_default()
}

/// Whether progress is shown: on a terminal, unless everything is to be quiet.
#[must_use]
pub fn shows_progress() -> bool {
    verbosity() > Verbosity::Quiet && std::io::stderr().is_terminal()
}

/// Tells the user something that stops nothing.
pub fn note(text: &str) {
    if verbosity() > Verbosity::Quiet {
        say(&format!("note: {text}"));
    }
}

/// Warns the user of something that makes the result doubtful; said however quiet all else is.
pub fn warn(text: &str) {
    say(&format!("warning: {text}"));
}

/// Says why something failed, however quiet all else is.
pub fn fail(error: &anyhow::Error) {
    say(&failure_text(error));
}

/// Tells what only those who ask for more want to know.
pub fn detail(text: &str) {
    if verbosity() == Verbosity::Verbose {
        say(text);
    }
}

fn say(text: &str) {
    // Nothing is left to report if stderr is closed.
    let _ = writeln!(std::io::stderr(), "acerra: {}", plain_text(text));
}
