//! `acerra record`: drives the radio and logs the receiver.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use acerra_products::plain_text;
use acerra_record::driver::{RequestOptions, WatchOptions};
use acerra_record::session::{
    CAMPAIGN_NAME, Finished, Health, MCAP_NAME, Progress, Recorder, Session, doubts, finish,
    write_mcap,
};
use anyhow::Context;

use crate::interrupt;
use crate::terminal::{Verbosity, verbosity};

/// A session file to begin with.
const EXAMPLE: &str = include_str!("session.toml");

/// Record a flight: drive the radio, log the GNSS receiver, put both on one clock.
///
/// Recording goes on until it is interrupted (Ctrl-C) or the session's stop_after_s is over. Every message
/// and every byte is written to session.log, on the disk each second; radar.mrm, rover.ubx, radar.clock.json
/// and campaign.toml are derived from session.log at the end, or by --finish after a power cut.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  acerra record --example > session.toml
  acerra record session.toml -o flight
  acerra record session.toml -o flight --mcap
  acerra record --finish flight && acerra focus flight/campaign.toml")]
pub struct Args {
    /// The session file (TOML).
    #[arg(value_name = "SESSION.toml", required_unless_present_any = ["example", "finish"])]
    session: Option<PathBuf>,
    /// Directory of the recording. An interrupted recording is continued.
    #[arg(short, long, value_name = "DIR", required_unless_present_any = ["example", "finish"])]
    output: Option<PathBuf>,
    /// Make the files that `focus` takes out of the log in DIR, without recording.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["session", "output", "example"])]
    finish: Option<PathBuf>,
    /// Write session.mcap as well: the whole recording in one file, as ROS 2 messages that other tools read.
    #[arg(long, conflicts_with = "example")]
    mcap: bool,
    /// Print a commented session file, to begin with.
    #[arg(long, conflicts_with_all = ["session", "output"])]
    example: bool,
}

/// Runs the command.
///
/// # Errors
/// A session that cannot be read, instruments that do not answer or refuse, a log that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> anyhow::Result<()> {
    if let Some(directory) = &args.finish {
        print_summary(out, directory, &finish(directory)?)?;
        return args.write_mcap(directory, out);
    }
    let (Some(file), Some(directory)) = (&args.session, &args.output) else {
        write!(out, "{EXAMPLE}")?;
        return Ok(());
    };
    let session = open(file)?;
    // The log keeps the session as it holds wherever its directory lies.
    let resolved = toml::to_string(&session).with_context(|| file.display().to_string())?;
    let recorder = Recorder {
        session: &session,
        text: &resolved,
        directory,
        stop: interrupt::stop_in_order(),
        requests: RequestOptions::default(),
        watch: WatchOptions::default(),
        tap: None,
    };
    let recorded = recorder.run(&mut |progress| say(&progress));
    if recorded.is_err() {
        // The data recorded before are finished; the failure of the recording is the one reported.
        let _ = finish(directory);
    }
    recorded?;
    print_summary(out, directory, &finish(directory)?)?;
    args.write_mcap(directory, out)
}

impl Args {
    /// Writes the recording as one MCAP file, where requested.
    fn write_mcap(&self, directory: &Path, out: &mut dyn Write) -> anyhow::Result<()> {
        if !self.mcap {
            return Ok(());
        }
        let messages = write_mcap(directory)?;
        if verbosity() != Verbosity::Quiet {
            let path = directory.join(MCAP_NAME);
            writeln!(out, "{messages} messages in {}", path.display())?;
        }
        Ok(())
    }
}

/// Reads a session file; prints doubts, and refuses settings that would make a recording useless.
pub(super) fn open(file: &Path) -> anyhow::Result<Session> {
    let at = || format!("{}", file.display());
    let text = std::fs::read_to_string(file).with_context(at)?;
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let session = Session::parse(&text).with_context(at)?.resolved_in(folder);
    refuse_doubtful(&session).with_context(at)?;
    Ok(session)
}

/// Prints doubts, and refuses settings that would make a recording useless.
fn refuse_doubtful(session: &Session) -> anyhow::Result<()> {
    for doubt in doubts(&session.radio, &session.flight) {
        anyhow::ensure!(!doubt.is_fatal, "{}", doubt.text);
        say(&Progress::Warning(doubt.text));
    }
    Ok(())
}

/// Informs the pilot: warnings with a beep, the state on one line.
pub(super) fn say(progress: &Progress) {
    let mut stderr = std::io::stderr();
    let is_terminal = stderr.is_terminal();
    let [begin, end] = if is_terminal {
        ["\r\x1b[K", ""]
    } else {
        ["", "\n"]
    };
    // If stderr is closed nothing can be reported: recording continues.
    let _ = match progress {
        Progress::Warning(text) => {
            let beep = if is_terminal { "\x07" } else { "" };
            writeln!(stderr, "{begin}{beep}warning: {}", plain_text(text))
        }
        _ if verbosity() == Verbosity::Quiet => Ok(()),
        Progress::Note(text) => writeln!(stderr, "{begin}{}", plain_text(text)),
        Progress::Health(health) => write!(stderr, "{begin}{}{end}", line(health)),
    };
}

fn line(health: &Health) -> String {
    let temperature = health
        .temperature_c
        .map(|c| format!(", {c:.1} °C"))
        .unwrap_or_default();
    let saturated = match health.saturated_scans {
        0 => String::new(),
        scans => format!(", {scans} scans saturated"),
    };
    let fix = match health.fix {
        Some(fix) if fix.has_fix => format!(", {} satellites", fix.satellites),
        Some(fix) => format!(", NO FIX ({} satellites)", fix.satellites),
        None => String::new(),
    };
    let pulses = match (health.pulses, health.missed_pulses) {
        (0, _) => String::new(),
        (pulses, 0) => format!(", {pulses} pulses"),
        (pulses, missed) => format!(", {pulses} pulses ({missed} missed)"),
    };
    format!(
        "{:.0} s: {}{temperature}{saturated}; GNSS {} kB{fix}{pulses}; log {} MB",
        health.elapsed_s,
        health.radio,
        health.gnss_bytes / 1000,
        health.log_bytes / 1_000_000
    )
}

pub(super) fn print_summary(
    out: &mut dyn Write,
    directory: &Path,
    finished: &Finished,
) -> anyhow::Result<()> {
    if verbosity() == Verbosity::Quiet {
        return Ok(());
    }
    for remark in &finished.remarks {
        writeln!(out, "note: {remark}")?;
    }
    let damage = finished.damage;
    if damage.torn_bytes + damage.damaged_bytes > 0 {
        writeln!(
            out,
            "note: session.log: {} bytes of a torn record at its end, {} damaged bytes in {} places",
            damage.torn_bytes, damage.damaged_bytes, damage.damaged_places
        )?;
    }
    if let Some(clock) = &finished.clock {
        writeln!(
            out,
            "trace times on GPS time to {:.2} ms ({:.2} ms without the latencies' doubt)",
            1e3 * clock.sigma_s,
            1e3 * clock.sigma_stamps_s
        )?;
    }
    writeln!(
        out,
        "{} whole scans, {} incomplete, {} bytes of GNSS; process with: acerra focus {}",
        finished.scans,
        finished.incomplete_scans,
        finished.gnss_bytes,
        directory.join(CAMPAIGN_NAME).display()
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_is_a_session_that_nothing_speaks_against() {
        let session = Session::parse(EXAMPLE).unwrap();
        assert_eq!(doubts(&session.radio, &session.flight), []);
    }
}
