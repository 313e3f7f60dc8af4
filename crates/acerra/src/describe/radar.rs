//! Radar logs.

use std::io::{Read, Seek};

use acerra_radar::{
    Limits, NeutralContent, NeutralFile, OpenError, RadarFile, RadarLog, RadargramOptions,
    ReadError, Samples,
};

use super::description::Description;

/// Whether the first bytes belong to a radar log.
pub fn is_radar(head: &[u8]) -> bool {
    // Whatever else is wrong with a short piece, its kind is recognised or not.
    let read = acerra_radar::read(std::io::Cursor::new(head), &Limits::default());
    !matches!(read, Err(OpenError::Read(ReadError::Unrecognised { .. })))
}

/// Whether the first bytes belong to a log of scans.
pub fn is_log(head: &[u8]) -> bool {
    let read = acerra_radar::read(std::io::Cursor::new(head), &Limits::default());
    matches!(read, Ok(RadarFile::Log(_)))
}

pub fn describe(reader: impl Read + Seek) -> anyhow::Result<Description> {
    match acerra_radar::read(reader, &Limits::default())? {
        RadarFile::Log(log) => describe_log(&log),
        RadarFile::Neutral(neutral) => Ok(describe_neutral(&neutral)),
    }
}

fn describe_log(log: &RadarLog) -> anyhow::Result<Description> {
    let mut d = Description::new(log.format.to_string());
    let made = log.radargram(&RadargramOptions::default())?;
    let window = made.run.window;
    d.fact("traces", made.radargram.traces);
    d.fact("samples", made.radargram.samples_per_trace);
    d.fact("sample_interval_s", made.radargram.fast_time_step_s);
    d.fact("positions", false);
    d.fact("whole_scans", log.report.whole_scans);
    d.fact("incomplete_scans", log.report.incomplete_scans);
    d.fact("filtering", made.run.filtering.to_string());
    d.fact("samples_per_scan", window.samples);
    d.fact("window_start_ns", f64::from(window.start_ps) * 1e-3);
    d.fact("window_stop_ns", f64::from(window.stop_ps) * 1e-3);
    d.fact("sample_step_ps", window.step_s() * 1e12);
    d.fact("scan_interval_ms", made.clock.interval_s * 1e3);
    d.fact("scan_rate_hz", 1.0 / made.clock.interval_s);
    d.fact("time_stamp_residual_ms", made.clock.residual_rms_s * 1e3);
    d.fact("lost_scans", made.clock.lost_scans);
    d.fact(
        "duration_s",
        made.radargram.time_s.last().copied().unwrap_or(0.0),
    );
    d.fact("antenna_id", made.run.antenna_id);
    if let Some(config) = made.run.config {
        d.fact("node_id", config.node_id);
        d.fact("integration_index", config.integration_index);
        d.fact("transmit_gain", config.transmit_gain);
        d.fact("code_channel", config.code_channel);
        d.fact("antenna_mode", config.antenna_mode);
    }
    levels(&mut d, &made.radargram.samples);
    for (event, count) in &log.report.other_events {
        d.notes.push(format!("{count} {event} messages"));
    }
    if made.other_scans > 0 {
        d.notes.push(format!(
            "{} scans of other filterings or windows",
            made.other_scans
        ));
    }
    let listed = 20;
    d.notes.extend(
        log.report
            .blemishes
            .iter()
            .take(listed)
            .map(ToString::to_string),
    );
    let more = log.report.blemish_count.saturating_sub(listed as u64);
    if more > 0 {
        d.notes.push(format!("{more} more such places"));
    }
    Ok(d)
}

fn describe_neutral(neutral: &NeutralFile) -> Description {
    let mut d = match &neutral.content {
        NeutralContent::Radargram(r) => {
            let mut d = Description::new("NPZ radargram");
            d.fact("traces", r.traces);
            d.fact("samples", r.samples_per_trace);
            d.fact("sample_interval_s", r.fast_time_step_s);
            d.fact("samples_per_trace", r.samples_per_trace);
            d.fact("complex", r.samples.is_complex());
            d.fact("fast_time_start_ns", r.fast_time_start_s * 1e9);
            d.fact("fast_time_end_ns", r.fast_time_end_s() * 1e9);
            d.fact("fast_time_step_ps", r.fast_time_step_s * 1e12);
            levels(&mut d, &r.samples);
            d
        }
        NeutralContent::Spectrum(s) => {
            let mut d = Description::new("NPZ spectra");
            d.fact("traces", s.traces());
            d.fact("samples", s.frequency_hz.len());
            d.fact(
                "frequency_hz",
                serde_json::json!({
                    "first": s.frequency_hz.first(),
                    "last": s.frequency_hz.last(),
                    "count": s.frequency_hz.len(),
                }),
            );
            d.fact("frequencies", s.frequency_hz.len());
            d.fact(
                "first_frequency_ghz",
                s.frequency_hz.first().map(|f| f * 1e-9),
            );
            d.fact(
                "last_frequency_ghz",
                s.frequency_hz.last().map(|f| f * 1e-9),
            );
            d
        }
    };
    let time_s = neutral.content.time_s();
    if neutral.time_missing {
        d.notes.push("no time_s: traces are numbered".to_owned());
    } else if let (Some(first), Some(last)) = (time_s.first(), time_s.last()) {
        d.fact("first_time_s", *first);
        d.fact("last_time_s", *last);
    }
    d.fact("positions", neutral.position_m.is_some());
    d.notes.extend(
        neutral
            .ignored
            .iter()
            .map(|name| format!("array {name} is not used")),
    );
    d
}

/// Largest and root-mean-square amplitude.
fn levels(d: &mut Description, samples: &Samples) {
    let squares: Vec<f64> = match samples {
        Samples::Real(v) => v.iter().map(|x| f64::from(*x).powi(2)).collect(),
        Samples::Complex(v) => v.iter().map(|x| f64::from(x.norm_sqr())).collect(),
    };
    let largest = squares.iter().copied().fold(0.0, f64::max).sqrt();
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let rms = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    d.fact("largest_amplitude", largest);
    d.fact("rms_amplitude", rms);
}
