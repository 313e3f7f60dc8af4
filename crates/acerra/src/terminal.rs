//! Messages on stderr other than failures, and verbosity.

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
    // A second call has no effect.
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

/// Prints a note for the user.
pub fn note(text: &str) {
    if verbosity() > Verbosity::Quiet {
        say(&format!("note: {text}"));
    }
}

/// Warns the user of a doubt about the result; printed at every verbosity.
pub fn warn(text: &str) {
    say(&format!("warning: {text}"));
}

/// Prints the cause of a failure; printed at every verbosity.
pub fn fail(error: &anyhow::Error) {
    say(&failure_text(error));
}

/// Prints details, at higher verbosity only.
pub fn detail(text: &str) {
    if verbosity() == Verbosity::Verbose {
        say(text);
    }
}

fn say(text: &str) {
    // If stderr is closed nothing can be reported.
    let _ = writeln!(std::io::stderr(), "acerra: {}", plain_text(text));
}
