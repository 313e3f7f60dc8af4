//! Phase history data.

use std::io::{Read, Seek};

use acerra_cphd::{ReadOptions, read_cphd};

use super::description::Description;

pub fn describe(reader: impl Read + Seek) -> anyhow::Result<Description> {
    let file = read_cphd(reader, &ReadOptions::default())?;
    let mut d = Description::new("CPHD phase history");
    let history = &file.history;
    d.fact("collection", history.description.name.as_str());
    d.fact("collector", history.description.collector.as_str());
    if let Some(start) = history.start {
        d.fact("start_utc", start.format_utc(3));
    }
    let origin = history.frame.origin();
    d.fact("origin_latitude_deg", origin.latitude_deg());
    d.fact("origin_longitude_deg", origin.longitude_deg());
    d.fact("origin_height_m", origin.height_m);
    for channel in &history.channels {
        d.fact("channel", channel.name.as_str());
        d.fact("traces", channel.time_s.len());
        d.fact("samples", channel.frequency.count);
        let last_hz = channel.frequency.step_hz.mul_add(
            channel.frequency.count.saturating_sub(1) as f64,
            channel.frequency.first_hz,
        );
        d.fact(
            "frequency_hz",
            serde_json::json!({
                "first": channel.frequency.first_hz,
                "last": last_hz,
                "count": channel.frequency.count,
            }),
        );
        d.fact("positions", true);
        d.fact("pulses", channel.time_s.len());
        d.fact("frequencies", channel.frequency.count);
        d.fact("first_frequency_ghz", 1e-9 * channel.frequency.first_hz);
        d.fact("frequency_step_hz", channel.frequency.step_hz);
        if let [first, .., last] = channel.time_s.as_slice() {
            d.fact("duration_s", last - first);
        }
    }
    for name in &file.other_channels {
        d.notes.push(format!("another channel: {name}"));
    }
    if file.left_out > 0 {
        d.notes
            .push(format!("{} vectors without a signal", file.left_out));
    }
    Ok(d)
}
