//! `acerra live`: a recording, and the image that forms while it goes on.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::Duration;

use acerra_live::replay::{recorded_session, replay};
use acerra_live::worker::QUEUE_RECORDS;
use acerra_live::{Board, Final, LiveSettings, Pipeline, Worker};
use acerra_products::{Wanted, failure_text};
use acerra_record::driver::{RequestOptions, WatchOptions};
use acerra_record::session::{CAMPAIGN_NAME, Recorder, Session, Tap, finish};
use acerra_view::{FinalView, LiveServer};
use anyhow::Context;

use super::focus::Order;
use super::{record, values, view};
use crate::final_image::{final_image, shows};
use crate::interrupt;
use crate::terminal::note;

/// Record a flight and watch its image form in the browser; afterwards the final image is made.
///
/// Records exactly as `acerra record` does, and images each pulse with the receiver's own positions (NAV-PVT,
/// NAV-HPPOSLLH or GGA) once the position after it has arrived. That image is provisional, and the page
/// states the positions used. The page's Stop button, Ctrl-C or the session's stop_after_s ends the
/// recording. Then positions are computed by PPK and the final image is made of the recording, as by `acerra
/// focus`. A directory instead of a session file replays the session recorded in it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra record --example > session.toml
  acerra live session.toml -o flight
  acerra live session.toml -o flight --no-final --port 8080 --no-open
  acerra live flight --speed 2")]
pub struct Args {
    /// The session file (TOML), or the directory of a recorded session to replay.
    #[arg(value_name = "SESSION.toml|DIR")]
    source: PathBuf,
    /// Directory of the recording. An interrupted recording is continued.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// The page's port; any free one by default.
    #[arg(short, long, default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the page's address and open no browser.
    #[arg(long)]
    no_open: bool,
    /// Make no final image.
    #[arg(long)]
    no_final: bool,
    /// End when everything is done; by default the page is served until interrupted.
    #[arg(long)]
    quit: bool,
    /// Seconds of a replayed session in a second.
    #[arg(long, default_value_t = 1.0, value_parser = values::positive)]
    speed: f64,
}

/// Runs the command.
///
/// # Errors
/// A session that cannot be read, instruments that do not answer, a log that cannot be written, a final image
/// that cannot be made.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    let stop = interrupt::stop_in_order();
    let source = Source::of(args)?;
    let at = || args.source.display().to_string();
    let pipeline = Pipeline::new(LiveSettings::of(&source.session).with_context(at)?);
    let board = Board::new();
    if let Kind::Instruments(_) = source.kind {
        board.let_stop(move || stop.store(true, Ordering::SeqCst));
    }
    let page = Page::open(&board, args, out)?;
    let done = source
        .image(pipeline, &board, stop, out)
        .and_then(|directory| finish_up(args, &directory, &board, &page.last, out));
    if let Err(error) = &done {
        let reason = failure_text(error);
        board.show_final(Final::Failed { reason });
    }
    out.flush()?;
    if done.is_ok() && !args.quit {
        note("the page is served until interrupted (Ctrl-C)");
        let stop = interrupt::wait_again();
        while !stop.load(Ordering::SeqCst) {
            std::thread::sleep(Duration::from_millis(100));
        }
    }
    page.close()?;
    done
}

/// What is imaged.
struct Source<'a> {
    session: Session,
    kind: Kind<'a>,
}

enum Kind<'a> {
    /// Instruments that are recorded, into a directory.
    Instruments(&'a Path),
    /// A recorded session, at a speed.
    Recorded(&'a Path, f64),
}

impl<'a> Source<'a> {
    fn of(args: &'a Args) -> anyhow::Result<Self> {
        if args.source.is_dir() {
            anyhow::ensure!(
                args.output.is_none(),
                "{}: a recorded session is replayed from its directory; expected no -o",
                args.source.display()
            );
            return Ok(Self {
                session: recorded_session(&args.source)?,
                kind: Kind::Recorded(&args.source, args.speed),
            });
        }
        let Some(output) = &args.output else {
            anyhow::bail!(
                "{}: expected -o DIR, the directory of the recording",
                args.source.display()
            );
        };
        Ok(Self {
            session: record::open(&args.source)?,
            kind: Kind::Instruments(output),
        })
    }

    /// Images until the source ends; returns the recording's directory.
    fn image(
        &self,
        pipeline: Pipeline,
        board: &Arc<Board>,
        stop: &'static AtomicBool,
        out: &mut dyn Write,
    ) -> anyhow::Result<PathBuf> {
        match self.kind {
            Kind::Instruments(directory) => {
                self.record(directory, pipeline, board, stop, out)?;
                Ok(directory.to_owned())
            }
            Kind::Recorded(directory, speed) => {
                let (send, receive) = sync_channel(QUEUE_RECORDS);
                let missed = Arc::new(AtomicU64::new(0));
                let worker = Worker::start(pipeline, receive, missed, Arc::clone(board))?;
                let replayed = replay(directory, speed, &send, stop);
                drop(send);
                worker.finish()?;
                replayed?;
                Ok(directory.to_owned())
            }
        }
    }

    fn record(
        &self,
        directory: &Path,
        pipeline: Pipeline,
        board: &Arc<Board>,
        stop: &'static AtomicBool,
        out: &mut dyn Write,
    ) -> anyhow::Result<()> {
        let (tap, receive) = Tap::new(QUEUE_RECORDS);
        let worker = Worker::start(pipeline, receive, tap.missed(), Arc::clone(board))?;
        // The log keeps the session as it holds wherever its directory lies.
        let text = toml::to_string(&self.session)?;
        let recorder = Recorder {
            session: &self.session,
            text: &text,
            directory,
            stop,
            requests: RequestOptions::default(),
            watch: WatchOptions::default(),
            tap: Some(tap),
        };
        let recorded = recorder.run(&mut |progress| record::say(&progress));
        drop(recorder);
        // A failure of the live image is reported; the recording continues.
        if let Err(error) = worker.finish() {
            crate::terminal::warn(&format!("the live image ended: {error}"));
        }
        let finished = finish(directory);
        recorded?;
        record::print_summary(out, directory, &finished?)
    }
}

/// Makes the final image of a recording, unless it is disabled.
fn finish_up(
    args: &Args,
    directory: &Path,
    board: &Arc<Board>,
    last: &FinalView,
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    if args.no_final {
        board.show_final(Final::Ended);
        return Ok(());
    }
    let campaign = directory.join(CAMPAIGN_NAME);
    // A replayed session may have been worked on since: its files are only made where they are missing.
    if !campaign.exists() {
        finish(directory)?;
    }
    let order = Order {
        campaign: &campaign,
        output: None,
        autofocus: false,
        wanted: Wanted::All,
        json: false,
        explain: false,
    };
    let products = order.directory();
    let warnings = final_image(&order, &shows(board), out)?;
    last.show(&products)?;
    board.show_final(Final::Made {
        directory: products.display().to_string(),
        warnings,
    });
    Ok(())
}

/// The page, served by a separate thread.
struct Page {
    over: Arc<AtomicBool>,
    last: FinalView,
    thread: JoinHandle<Result<(), acerra_view::ViewError>>,
}

impl Page {
    fn open(board: &Arc<Board>, args: &Args, out: &mut dyn Write) -> anyhow::Result<Self> {
        let server = LiveServer::open(Arc::clone(board), args.port)?;
        writeln!(out, "{}", server.address())?;
        out.flush()?;
        if !args.no_open && !view::open(server.address()) {
            note("no browser could be started: open the address above");
        }
        let over = Arc::new(AtomicBool::new(false));
        let is_over = Arc::clone(&over);
        let last = server.final_view();
        let thread = std::thread::Builder::new()
            .name("page".to_owned())
            .spawn(move || server.run(move || is_over.load(Ordering::SeqCst)))
            .context("cannot start a thread")?;
        Ok(Self { over, last, thread })
    }

    fn close(self) -> anyhow::Result<()> {
        self.over.store(true, Ordering::SeqCst);
        match self.thread.join() {
            Ok(served) => Ok(served?),
            // A thread that panicked has printed its message.
            Err(_) => Ok(()),
        }
    }
}
