//! Kind of a trajectory file by its first bytes.

use super::csv_columns::Columns;
use super::error::quoted;
use super::{ReadError, TrajectoryFormat, nmea, pos};
use crate::line_end::lines_of;

/// The kind of trajectory file that begins like this; none when no reader knows it.
///
/// The first [`SNIFF_BYTES`](super::SNIFF_BYTES) are plenty; fewer serve as long as they reach
/// the first line of data or the header line.
///
/// ```
/// use acerra_geo::read::{TrajectoryFormat, sniff};
/// assert_eq!(sniff(b"time_s,x_m,y_m,z_m\n"), Some(TrajectoryFormat::Csv));
/// assert_eq!(sniff(b"Format Version,1.23,Take Name,Flight 3\n"), Some(TrajectoryFormat::Motive));
/// assert_eq!(sniff(b"\x89PNG\r\n"), None);
/// ```
#[must_use]
pub fn sniff(start: &[u8]) -> Option<TrajectoryFormat> {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let text = String::from_utf8_lossy(start);
    let mut lines = lines_of(&text).map(str::trim).filter(|l| !l.is_empty());
    let first = lines.clone().next()?;

    if first.starts_with("Format Version,") {
        return Some(TrajectoryFormat::Motive);
    }
    // A receiver's log may begin in the middle of a sentence, or with binary messages.
    if lines.clone().take(200).any(nmea::has_known_sentence) {
        return Some(TrajectoryFormat::Nmea);
    }
    if start.contains(&0) {
        return None;
    }
    if first.starts_with('%') {
        // Comments alone may be anybody's: RTKLIB's column line, or a line of its data, decides.
        return lines
            .any(|l| pos::is_column_line(l) || (!l.starts_with('%') && pos::is_data_line(l)))
            .then_some(TrajectoryFormat::RtklibPos);
    }
    if pos::is_data_line(first) {
        return Some(TrajectoryFormat::RtklibPos);
    }
    let header = lines.find(|l| !l.starts_with('#'))?;
    Columns::recognised(header).then_some(TrajectoryFormat::Csv)
}

/// The error for a file that no reader recognises, with a guess at its kind.
pub(super) fn unknown(start: &[u8]) -> ReadError {
    let found = if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
        "the mark of UTF-16 text: save it as UTF-8".to_owned()
    } else if start.starts_with(b"\x1f\x8b") {
        "the mark of gzip: unpack it first".to_owned()
    } else {
        match std::str::from_utf8(&start[..start.len().min(400)]) {
            Ok(text) if !text.contains('\0') => {
                quoted(lines_of(text.trim_start()).next().unwrap_or_default())
            }
            Err(e) if e.error_len().is_none() => {
                let text = String::from_utf8_lossy(start);
                quoted(lines_of(text.trim_start()).next().unwrap_or_default())
            }
            _ => {
                let bytes: Vec<String> = start.iter().take(8).map(|b| format!("{b:02x}")).collect();
                format!("the bytes {}", bytes.join(" "))
            }
        }
    };
    ReadError::UnknownFormat { found }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_from_their_first_lines() {
        use TrajectoryFormat::{Csv, Motive, Nmea, RtklibPos};
        for (start, want) in [
            (
                "% program   : RTKLIB\n%  GPST                  latitude(deg) longitude(deg)\n",
                Some(RtklibPos),
            ),
            (
                "2005/04/02 00:00:00.000   35.132057068  139.624306577    73.9077   1   7\n",
                Some(RtklibPos),
            ),
            (
                "1316 518400.000  -3976219.2318   3382372.3615   3652511.4737   2   7\n",
                Some(RtklibPos),
            ),
            ("% a remark of LaTeX\n\\documentclass{article}\n", None),
            ("\n\nTime (s); X [mm]; Y [mm]; Z [mm]\n", Some(Csv)),
            ("# our own\ntime_s,lat,lon,height\n", Some(Csv)),
            ("name,price,colour\n", None),
            (
                "1234,56*7F\r\n$GNGGA,123519.00,4807.038,N,01131.000,E,4,08,0.9,545.4,M,46.9,M,,*72\r\n",
                Some(Nmea),
            ),
            ("Format Version,1.23,Take Name,A\r\n", Some(Motive)),
            (
                "# carriage returns alone\rtime_s,x,y,z\r0,1,2,3\r",
                Some(Csv),
            ),
            (
                "% program   : RTKLIB\r%  GPST                  latitude(deg) longitude(deg)\r",
                Some(RtklibPos),
            ),
            (
                "     3.04           OBSERVATION DATA    M                   RINEX VERSION / TYPE\n",
                None,
            ),
            ("", None),
            ("\n \n", None),
        ] {
            assert_eq!(sniff(start.as_bytes()), want, "{start}");
        }
    }

    #[test]
    fn the_unknown_is_described() {
        let text = |start: &[u8]| unknown(start).to_string();
        assert!(text(b"\x89PNG\r\n\x1a\n\0").ends_with("the bytes 89 50 4e 47 0d 0a 1a 0a"));
        assert!(text(b"\xff\xfet\0").contains("UTF-16"));
        assert!(text(b"name,price\n1,2\n").ends_with("begins with 'name,price'"));
    }
}
