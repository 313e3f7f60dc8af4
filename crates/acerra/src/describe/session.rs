//! A recorded session as one MCAP file.

use std::io::Read;

use acerra_record::mcap::{MAGIC, McapReader, acerra_topics};

use super::description::Description;

/// Whether a file is an MCAP file of this program: its first topic is behind the header.
pub fn is_session(head: &[u8]) -> bool {
    let [first, ..] = acerra_topics();
    let name = first.name.as_bytes();
    let schema = first.schema.as_bytes();
    let has = |text: &[u8]| head.windows(text.len()).any(|part| part == text);
    head.starts_with(&MAGIC) && has(schema) && has(name)
}

pub fn describe(reader: impl Read) -> anyhow::Result<Description> {
    let mut reader = McapReader::new(reader)?;
    let mut d = Description::new("recorded session (MCAP)".to_owned());
    let mut span_ns: Option<[u64; 2]> = None;
    let outcome = loop {
        match reader.next_message() {
            Ok(Some(message)) => {
                let at = message.log_ns;
                let [from, to] = span_ns.unwrap_or([at; 2]);
                span_ns = Some([from.min(at), to.max(at)]);
            }
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    d.fact("written_by", reader.library().to_owned());
    for topic in reader.topics() {
        d.fact(
            &topic.name,
            format!("{} messages of {}", topic.messages, topic.schema),
        );
    }
    if let Some([from, to]) = span_ns {
        d.fact("duration_s", 1e-9 * (to - from) as f64);
    }
    match outcome {
        Err(error) => d.notes.push(error.to_string()),
        Ok(()) if !reader.is_whole() => d.notes.push("the file is cut off".to_owned()),
        Ok(()) => {}
    }
    Ok(d)
}
