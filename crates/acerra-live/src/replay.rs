//! A recorded session as if it were being recorded.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

use acerra_record::log::{LogReader, RecordKind};
use acerra_record::session::{LOG_NAME, Session, Tapped};

use crate::error::LiveError;

/// Interval at which a waiting replay checks whether it is to stop.
const LOOK: Duration = Duration::from_millis(50);

/// The session that a directory's log was recorded with last.
///
/// # Errors
/// A log that cannot be read or holds no session.
pub fn recorded_session(directory: &Path) -> Result<Session, LiveError> {
    let failed = |cause: String| LiveError::Log {
        path: directory.join(LOG_NAME),
        cause,
    };
    let mut reader = open(directory)?;
    let mut text = None;
    while let Some(record) = reader.next_record().map_err(|e| failed(e.to_string()))? {
        if record.kind == RecordKind::Settings {
            text = Some(String::from_utf8_lossy(&record.payload).into_owned());
        }
    }
    let text =
        text.ok_or_else(|| failed("expected the settings of a session, found none".to_owned()))?;
    Session::parse(&text).map_err(|error| failed(error.to_string()))
}

/// Sends the records of a session's log as they came, `speed` seconds in a second. Unlike a recording it waits
/// for who takes them. Each start of the recording begins where the one before ended.
///
/// # Errors
/// A log that cannot be read.
pub fn replay(
    directory: &Path,
    speed: f64,
    send: &SyncSender<Tapped>,
    stop: &AtomicBool,
) -> Result<(), LiveError> {
    let failed = |cause: String| LiveError::Log {
        path: directory.join(LOG_NAME),
        cause,
    };
    let mut reader = open(directory)?;
    let mut begun = Instant::now();
    let mut began_ns = None;
    while let Some(record) = reader.next_record().map_err(|e| failed(e.to_string()))? {
        if record.kind == RecordKind::Settings {
            (begun, began_ns) = (Instant::now(), None);
        }
        let began_ns = *began_ns.get_or_insert(record.at_ns);
        let after_s = 1e-9 * record.at_ns.saturating_sub(began_ns) as f64 / speed;
        // A stamp that is damaged does not hold a replay for ever.
        let came = begun + Duration::from_secs_f64(after_s.min(86_400.0));
        let mut tapped = Tapped { record, came };
        loop {
            if stop.load(Ordering::SeqCst) {
                return Ok(());
            }
            let left = came.saturating_duration_since(Instant::now());
            if !left.is_zero() {
                std::thread::sleep(left.min(LOOK));
                continue;
            }
            tapped = match send.try_send(tapped) {
                Ok(()) => break,
                Err(TrySendError::Disconnected(_)) => return Ok(()),
                Err(TrySendError::Full(tapped)) => tapped,
            };
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    Ok(())
}

fn open(directory: &Path) -> Result<LogReader<BufReader<File>>, LiveError> {
    let path = directory.join(LOG_NAME);
    let file = File::open(&path).map_err(|cause| LiveError::Log {
        path: path.clone(),
        cause: cause.to_string(),
    })?;
    LogReader::new(BufReader::new(file)).map_err(|cause| LiveError::Log {
        path,
        cause: cause.to_string(),
    })
}
