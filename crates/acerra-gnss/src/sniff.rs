//! Recognising a file by its first bytes.

use crate::input::{BYTE_ORDER_MARK, FileKind, line_end};

/// Number of leading bytes that [`sniff`] reads; more are ignored.
pub(crate) const SNIFF_BYTES: usize = 1 << 16;

/// Kind of a file by its first bytes (64 KiB are read, a few hundred usually suffice).
///
/// ```
/// use acerra_gnss::input::{FileKind, sniff};
/// assert_eq!(sniff(&[0x1f, 0x8b, 8, 0]), FileKind::Gzip);
/// assert_eq!(sniff(b"% program   : RTKLIB ver.2.4.3\n"), FileKind::RtklibPos);
/// assert_eq!(sniff(b""), FileKind::Empty);
/// ```
pub fn sniff(head: &[u8]) -> FileKind {
    let head = &head[..head.len().min(SNIFF_BYTES)];
    if head.is_empty() {
        return FileKind::Empty;
    }
    match head {
        [0x1f, 0x8b, ..] => return FileKind::Gzip,
        [0x1f, 0x9d, ..] => return FileKind::UnixCompress,
        [b'P', b'K', 3, 4, ..] => return FileKind::Zip,
        _ => {}
    }
    if let Some(kind) = rinex_kind(head) {
        return kind;
    }
    // Real frames are checked, so that two stray bytes in a text do not decide.
    if crate::ubx::frame::first_valid(head) {
        return FileKind::Ubx;
    }
    if crate::rtcm::frame::first_valid(head) {
        return FileKind::Rtcm3;
    }
    let text = String::from_utf8_lossy(&head[..head.len().min(8192)]);
    let mut lines = text.lines().map(str::trim_end).filter(|l| !l.is_empty());
    let first = lines.next().unwrap_or("");
    if first.starts_with("%") && text.contains("GPST") || first.starts_with("% program") {
        return FileKind::RtklibPos;
    }
    if (first.starts_with("#c") || first.starts_with("#d") || first.starts_with("#a"))
        && first.len() >= 50
    {
        return FileKind::Sp3;
    }
    let option_line = |line: &str| {
        line.split_once('=').is_some_and(|(key, _)| {
            [
                "pos1-", "pos2-", "out-", "stats-", "ant1-", "ant2-", "misc-", "file-",
            ]
            .iter()
            .any(|prefix| key.trim_start().starts_with(prefix))
        })
    };
    if std::iter::once(first)
        .chain(lines)
        .take(40)
        .any(option_line)
    {
        return FileKind::RtklibConf;
    }
    if text
        .lines()
        .take(5)
        .any(|l| l.starts_with("$G") && l.contains('*'))
    {
        return FileKind::Nmea;
    }
    if matches!(head, [0xd3, second, ..] if second & 0xfc == 0) {
        return FileKind::Rtcm3;
    }
    FileKind::Unknown
}

/// The kind named in the first line of a RINEX or CRINEX file; blank lines before it are skipped.
fn rinex_kind(head: &[u8]) -> Option<FileKind> {
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let end = line_end(head);
    let line = head
        .split(|&b| b == end)
        .take(5)
        .find(|line| line.iter().any(|b| !b.is_ascii_whitespace()))?;
    let label = line.get(60..)?;
    if label.starts_with(b"CRINEX VERS") {
        return Some(FileKind::Crinex);
    }
    // Clock files of version 3.04 have their labels five columns further right.
    let clock = line.get(20..22).is_some_and(|kind| kind.contains(&b'C'));
    if clock
        && label
            .trim_ascii_start()
            .starts_with(b"RINEX VERSION / TYPE")
    {
        return Some(FileKind::RinexClock);
    }
    if label.starts_with(b"ANTEX VERSION / SYST") {
        return Some(FileKind::Antex);
    }
    if !label.starts_with(b"RINEX VERSION / TYPE") {
        return None;
    }
    Some(match line[20].to_ascii_uppercase() {
        b'O' => FileKind::RinexObservation,
        b'N' | b'G' | b'H' | b'L' | b'J' => FileKind::RinexNavigation,
        _ => FileKind::RinexOther,
    })
}
