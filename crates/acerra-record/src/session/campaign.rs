//! The campaign file of a session.

use toml::{Table, Value};

use super::outcome::{CAPTURE_NAME, Finished, ROVER_NAME};
use super::settings::Session;

/// The campaign: the tables that the session states, with the files of the recording.
pub(super) fn campaign_text(session: &Session, finished: &Finished) -> String {
    let mut campaign = session.campaign.clone();
    let mut set = |table: &str, key: &str, value: Value| {
        let entry = campaign
            .entry(table)
            .or_insert_with(|| Value::Table(Table::new()));
        if let Value::Table(entries) = entry {
            entries.entry(key).or_insert(value);
        }
    };
    set("radar", "file", CAPTURE_NAME.into());
    if let Some(delay_ns) = session.flight.delay_ns {
        set("radar", "delay_ns", delay_ns.into());
    }
    if finished.gnss_bytes > 0 {
        set("gnss", "rover", ROVER_NAME.into());
    }
    if finished.clock.is_some() {
        set("trajectory", "time_offset_s", "logged".into());
    }
    let mut text = String::from("# Written by acerra record.\n");
    for remark in &finished.remarks {
        text.push_str(&format!("# {}\n", remark.replace(['\n', '\r'], " ")));
    }
    for (table, key, what) in [
        ("gnss", "base", "the log of the receiver on the ground"),
        ("image", "x_m", "where the image is to be"),
    ] {
        let is_there = campaign.get(table).is_some_and(|t| t.get(key).is_some());
        if !is_there && (table != "gnss" || finished.gnss_bytes > 0) {
            text.push_str(&format!("# To be added: [{table}] {key}, {what}.\n"));
        }
    }
    text.push_str(&toml::to_string(&campaign).unwrap_or_default());
    text
}
