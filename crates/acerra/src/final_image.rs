//! The final image of a recording, followed on the terminal and on the live page.

use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use acerra_chain::journal::stages::StageEvent;
use acerra_chain::{Control, Journal, Progress};
use acerra_live::{Board, Final};
use acerra_products::{RunRequest, run_campaign_with};

use crate::commands::focus::Order;
use crate::interrupt::cancel_flag;
use crate::progress::Bar;

/// Interval of progress notifications to the page.
const NOTIFY_EVERY: Duration = Duration::from_millis(100);

/// Reports the progress of the final image to a live page.
pub struct Shows {
    board: Arc<Board>,
    state: Mutex<State>,
}

struct State {
    stage: String,
    step: String,
    total: u64,
    notified: Instant,
}

/// A board that reports.
#[must_use]
pub fn shows(board: &Arc<Board>) -> Arc<Shows> {
    Arc::new(Shows {
        board: Arc::clone(board),
        state: Mutex::new(State {
            stage: String::new(),
            step: String::new(),
            total: 0,
            notified: Instant::now(),
        }),
    })
}

impl Shows {
    fn notify(&self, done: u64, change: impl FnOnce(&mut State) -> bool) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if !change(&mut state) {
            return;
        }
        state.notified = Instant::now();
        #[expect(clippy::cast_precision_loss, reason = "a share that is shown")]
        let share = done as f64 / state.total.max(1) as f64;
        self.board.show_final(Final::Making {
            stage: state.stage.clone(),
            step: state.step.clone(),
            share,
        });
    }

    fn stage(&self, name: &str) {
        self.notify(0, |state| {
            (state.stage, state.step, state.total) = (name.to_owned(), String::new(), 0);
            true
        });
    }
}

/// Both the terminal's bar and the page.
struct Both {
    bar: Arc<Bar>,
    page: Arc<Shows>,
}

impl Progress for Both {
    fn start(&self, name: &str, total: u64) {
        self.bar.start(name, total);
        self.page.notify(0, |state| {
            (state.step, state.total) = (name.to_owned(), total);
            true
        });
    }

    fn at(&self, done: u64) {
        self.bar.at(done);
        self.page
            .notify(done, |state| state.notified.elapsed() >= NOTIFY_EVERY);
    }

    fn finish(&self) {
        self.bar.finish();
    }
}

/// Runs the order as `acerra focus` does; returns the doubts about the image.
///
/// # Errors
/// Whatever the chain cannot do; an output that is closed.
pub fn final_image(
    order: &Order<'_>,
    page: &Arc<Shows>,
    out: &mut dyn Write,
) -> anyhow::Result<Vec<String>> {
    let mut journal = Journal::default();
    let bar = Arc::new(Bar::default());
    let (listener, shown) = (Arc::clone(&bar), Arc::clone(page));
    journal.stages.listen(move |event| {
        if let StageEvent::Started(name) = &event {
            shown.stage(name);
        }
        listener.stage(event);
    });
    let both = Both {
        bar: Arc::clone(&bar),
        page: Arc::clone(page),
    };
    let control = Control::default()
        .reporting_to(&both)
        .cancelled_by(cancel_flag());
    let directory = order.directory();
    let request = RunRequest {
        file: order.campaign,
        directory: &directory,
        autofocus: order.autofocus,
        wanted: order.wanted,
    };
    let run = run_campaign_with(request, &mut journal, &control);
    bar.clear();
    let warnings = run
        .as_ref()
        .map(|outcome| outcome.warnings.clone())
        .unwrap_or_default();
    order.print(run, &journal, out)?;
    Ok(warnings)
}
