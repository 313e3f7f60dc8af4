//! Progress of a run on the terminal: the stage, and the progress of its long steps.

use std::fmt::Write as _;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use acerra_chain::Progress;
use acerra_chain::journal::stages::{Stage, StageEvent, Stages};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::terminal;

const STAGE: &str = "{spinner} {msg} {elapsed}";
const STEP: &str = "{msg:10} {wide_bar} {percent:>3} %  {rate}  {eta} left";

/// Shows the current stage, and a bar for each step with a count. Silent without a terminal.
#[derive(Debug, Default)]
pub struct Bar {
    shown: Mutex<Shown>,
}

#[derive(Debug, Default)]
struct Shown {
    stage: &'static str,
    bar: Option<ProgressBar>,
}

impl Bar {
    /// A bar that is notified of every stage from now on.
    #[must_use]
    pub fn following(stages: &mut Stages) -> Arc<Self> {
        let bar = Arc::new(Self::default());
        let listener = Arc::clone(&bar);
        stages.listen(move |event| listener.stage(event));
        bar
    }

    /// Takes note of a stage that begins or ends.
    pub fn stage(&self, event: StageEvent<'_>) {
        match event {
            StageEvent::Started(name) => self.show_stage(name),
            StageEvent::Finished(stage) => {
                self.clear();
                terminal::detail(&cost(stage));
            }
        }
    }

    /// Removes what is shown.
    pub fn clear(&self) {
        if let Ok(mut shown) = self.shown.lock()
            && let Some(bar) = shown.bar.take()
        {
            bar.finish_and_clear();
        }
    }

    fn show_stage(&self, name: &'static str) {
        if let Ok(mut shown) = self.shown.lock() {
            shown.stage = name;
        }
        self.show(ProgressBar::no_length(), STAGE, name);
    }

    fn show(&self, bar: ProgressBar, template: &str, name: &str) {
        if !terminal::shows_progress() {
            return;
        }
        self.clear();
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.with_key(
                "rate",
                |state: &ProgressState, to: &mut dyn std::fmt::Write| {
                    // Writing to a buffer in memory cannot fail.
                    let _ = write!(to, "{}/s", with_prefix(state.per_sec()));
                },
            ));
        }
        bar.set_message(name.to_owned());
        bar.set_draw_target(ProgressDrawTarget::stderr());
        bar.enable_steady_tick(Duration::from_millis(200));
        if let Ok(mut shown) = self.shown.lock() {
            shown.bar = Some(bar);
        }
    }
}

impl Progress for Bar {
    fn start(&self, name: &str, total: u64) {
        self.show(ProgressBar::new(total), STEP, name);
    }

    fn at(&self, done: u64) {
        if let Ok(shown) = self.shown.lock()
            && let Some(bar) = shown.bar.as_ref()
        {
            bar.set_position(done);
        }
    }

    fn finish(&self) {
        let stage = self.shown.lock().map_or("", |shown| shown.stage);
        if stage.is_empty() {
            self.clear();
        } else {
            self.show_stage(stage);
        }
    }
}

/// Cost of a stage, in words.
fn cost(stage: &Stage) -> String {
    let mut text = format!("{:<9} {:.2} s", stage.name, stage.seconds);
    if let Some(bytes) = stage.peak_memory_bytes {
        #[expect(clippy::cast_precision_loss, reason = "shown with three digits")]
        let _ = write!(text, ", {}B at most", with_prefix(bytes as f64));
    }
    text
}

/// Three significant digits and an SI prefix, as `13.9 G`.
fn with_prefix(value: f64) -> String {
    const PREFIXES: [&str; 7] = ["", "k", "M", "G", "T", "P", "E"];
    let (mut scaled, mut prefix) = (value, 0);
    // A value that would be rounded to 1000 belongs to the next prefix.
    while scaled >= 999.5 && prefix + 1 < PREFIXES.len() {
        scaled /= 1e3;
        prefix += 1;
    }
    let decimals = match scaled {
        s if s >= 99.95 || value == 0.0 => 0,
        s if s >= 9.995 => 1,
        _ => 2,
    };
    format!("{scaled:.decimals$} {}", PREFIXES[prefix])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_get_prefixes() {
        for (value, text) in [
            (0.0, "0 "),
            (0.25, "0.25 "),
            (7.0, "7.00 "),
            (999.4, "999 "),
            (999.6, "1.00 k"),
            (13_944_000_000.123_4, "13.9 G"),
            (2.5e21, "2500 E"),
        ] {
            assert_eq!(with_prefix(value), text);
        }
    }
}
