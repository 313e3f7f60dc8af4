//! From a session's log to the inputs of `focus`: a capture, the receiver's bytes, the clock, a campaign.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use acerra_radar::mrm::read_mrm;
use acerra_radar::{Limits, RadargramOptions};

use super::aside::AsideFile;
use super::campaign::campaign_text;
use super::finish_error::FinishError;
use super::log_content::{LogContent, read_log};
use super::outcome::{CAMPAIGN_NAME, CAPTURE_NAME, CLOCK_NAME, Finished};
use super::session_clock::{SessionClock, TraceTime, session_clock};

/// Writes `radar.mrm`, `rover.ubx`, `radar.clock.json` and `campaign.toml` out of the log in a session's
/// directory, whether the recording ended in order or not. They are written again each time.
///
/// # Errors
/// A log that cannot be read, files that cannot be written.
pub fn finish(directory: &Path) -> Result<Finished, FinishError> {
    let mut finished = Finished::default();
    remove_clock(directory)?;
    let log = read_log(directory, &mut finished)?;
    let traces = describe_scans(directory, &log, &mut finished)?;
    if let (Some(traces), false) = (traces, log.gps.is_empty()) {
        write_clock(directory, &log, &traces, &mut finished)?;
    } else if log.session.gnss.is_some() {
        let remark = "no GPS epoch in the log: trace times are by the radio alone";
        finished.remarks.push(remark.to_owned());
    }
    let text = campaign_text(&log.session, &finished);
    AsideFile::put(directory, CAMPAIGN_NAME, text.as_bytes())?;
    Ok(finished)
}

/// Removes the clock of an earlier call: a log without a clock must not be read with an earlier log's clock.
fn remove_clock(directory: &Path) -> Result<(), FinishError> {
    let path = directory.join(CLOCK_NAME);
    match std::fs::remove_file(&path) {
        Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
            Err(FinishError::Io { path, cause })
        }
        _ => Ok(()),
    }
}

fn describe_scans(
    directory: &Path,
    log: &LogContent,
    finished: &mut Finished,
) -> Result<Option<Vec<TraceTime>>, FinishError> {
    let path = directory.join(CAPTURE_NAME);
    let file = File::open(&path).map_err(|cause| FinishError::Io { path, cause })?;
    let capture = match read_mrm(BufReader::new(file), &Limits::default()) {
        Ok(capture) => capture,
        Err(error) => {
            let remark = format!("{CAPTURE_NAME}: {error}");
            finished.remarks.push(remark);
            return Ok(None);
        }
    };
    finished.scans = capture.report.whole_scans;
    finished.incomplete_scans = capture.report.incomplete_scans;
    let made = match capture.radargram(&RadargramOptions::default()) {
        Ok(made) => made,
        Err(error) => {
            finished.remarks.push(format!("{CAPTURE_NAME}: {error}"));
            return Ok(None);
        }
    };
    if made.other_scans > 0 {
        finished.remarks.push(format!(
            "{} of {} scans are of other runs (before or after a restart of the radio) and are not imaged",
            made.other_scans, finished.scans
        ));
    }
    if log.arrivals.len() > 2 {
        finished
            .remarks
            .push("the recording was interrupted and gone on with".to_owned());
    }
    let scans = made.run.scans.iter().map(|&index| &capture.scans[index]);
    let traces = scans
        .zip(made.radargram.time_s)
        .map(|(scan, radar_s)| TraceTime {
            key: (scan.message_id, scan.timestamp_ms),
            radar_s,
        });
    Ok(Some(traces.collect()))
}

fn write_clock(
    directory: &Path,
    log: &LogContent,
    traces: &[TraceTime],
    finished: &mut Finished,
) -> Result<(), FinishError> {
    let Some(SessionClock { clock, remarks }) = session_clock(log, traces) else {
        return Ok(());
    };
    match clock {
        Ok(clock) => {
            AsideFile::put(directory, CLOCK_NAME, clock.to_json().as_bytes())?;
            finished.clock = Some(clock);
        }
        Err(error) => finished
            .remarks
            .push(format!("trace times are not on GPS time: {error}")),
    }
    finished.remarks.extend(remarks);
    Ok(())
}
