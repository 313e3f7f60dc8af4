//! Fixed columns and the numbers in them.

use crate::input::ReadError;
use acerra_geo::time::{Calendar, full_year};

/// Columns `start..start + width` (from 0) of a line, cut at the line's end.
pub(crate) fn column(line: &[u8], start: usize, width: usize) -> &[u8] {
    let end = line.len().min(start + width);
    line.get(start..end).unwrap_or(&[])
}

/// A text column without its surrounding blanks.
pub(crate) fn text(line: &[u8], start: usize, width: usize) -> String {
    String::from_utf8_lossy(column(line, start, width).trim_ascii()).into_owned()
}

/// A field that is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotANumber;

/// A real number with exponent letter E or D, or without one before the sign of a three-digit exponent, as Fortran writes
/// it; `None` where the field is blank.
pub(crate) fn real(field: &[u8]) -> Result<Option<f64>, NotANumber> {
    let field = field.trim_ascii();
    if field.is_empty() {
        return Ok(None);
    }
    let mut copy = [0_u8; 40];
    if field.len() >= copy.len() {
        return Err(NotANumber);
    }
    let mut length = 0_usize;
    let mut has_letter = false;
    for &from in field {
        has_letter |= from.is_ascii_alphabetic();
        let before = length.checked_sub(1).map(|at| copy[at]);
        if matches!(from, b'+' | b'-')
            && !has_letter
            && before.is_some_and(|b| b.is_ascii_digit() || b == b'.')
        {
            copy[length] = b'e';
            length += 1;
            has_letter = true;
        }
        let to = copy.get_mut(length).ok_or(NotANumber)?;
        length += 1;
        *to = match from {
            b'D' | b'd' | b'E' | b'e' => b'e',
            b'0'..=b'9' | b'+' | b'-' | b'.' => from,
            // "nan" and "inf" parse in Rust and are no measurements.
            _ => return Err(NotANumber),
        };
    }
    let value: f64 = std::str::from_utf8(&copy[..length])
        .ok()
        .and_then(|s| s.parse().ok())
        .ok_or(NotANumber)?;
    if value.is_finite() {
        Ok(Some(value))
    } else {
        Err(NotANumber)
    }
}

/// Version in hundredths (210, 304 …) on the first line of a RINEX file, which has this line number.
///
/// # Errors
/// [`ReadError::Format`] for any other line, [`ReadError::Unsupported`] for a version outside 2 to 4.
pub(super) fn version(line: &[u8], number: u64) -> Result<u16, ReadError> {
    let version = real(column(line, 0, 9)).ok().flatten();
    let labelled = column(line, 60, 20) == b"RINEX VERSION / TYPE";
    let Some(version) = version.filter(|_| labelled) else {
        return Err(ReadError::format(number, "RINEX VERSION / TYPE", line));
    };
    if !(2.0..5.0).contains(&version) {
        return Err(ReadError::Unsupported {
            line: number,
            what: format!("RINEX version {version:.2}"),
        });
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "2.0 to 5.0"
    )]
    let hundredths = (version * 100.0).round() as u16;
    Ok(hundredths)
}

/// An unsigned integer; `None` where blank or unreadable.
pub(crate) fn integer(field: &[u8]) -> Option<usize> {
    std::str::from_utf8(field.trim_ascii()).ok()?.parse().ok()
}

/// A date and clock reading of six blank-separated numbers; two-digit years are completed. `None` for
/// anything else.
pub(crate) fn calendar(field: &[u8]) -> Option<Calendar> {
    let mut parts = field
        .split(u8::is_ascii_whitespace)
        .filter(|p| !p.is_empty());
    let mut next = || std::str::from_utf8(parts.next()?).ok();
    let year: i32 = next()?.parse().ok()?;
    let month: u8 = next()?.parse().ok()?;
    let day: u8 = next()?.parse().ok()?;
    let hour: u8 = next()?.parse().ok()?;
    let minute: u8 = next()?.parse().ok()?;
    let second = real(next()?.as_bytes()).ok()??;
    if next().is_some() {
        return None;
    }
    Calendar::new(full_year(year), month, day, hour, minute, second).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_fortran_and_others() {
        assert_eq!(real(b" .146791804582D-03 "), Ok(Some(0.146_791_804_582e-3)));
        assert_eq!(real(b"-5.2E+01"), Ok(Some(-52.0)));
        // Fortran drops the letter before three digits of an exponent.
        assert_eq!(
            real(b" 0.499063314480-269"),
            Ok(Some(0.499_063_314_480e-269))
        );
        assert_eq!(real(b"-0.5+001"), Ok(Some(-5.0)));
        assert_eq!(real(b"0.5-315-1"), Err(NotANumber));
        assert_eq!(real(b"   "), Ok(None));
        for bad in ["nan", "inf", "1 2", "--1", "1e999", "12:3"] {
            assert_eq!(real(bad.as_bytes()), Err(NotANumber), "{bad}");
        }
    }

    #[test]
    fn columns_past_the_end_are_short_or_empty() {
        assert_eq!(column(b"abcd", 2, 5), b"cd");
        assert_eq!(column(b"abcd", 9, 5), b"");
    }

    #[test]
    fn dates() {
        let c = calendar(b" 05  4  2  0  0 30.5000000").unwrap();
        assert_eq!((c.year, c.month, c.second, c.fraction), (2005, 4, 30, 0.5));
        assert!(calendar(b" 05  4  2  0  0").is_none());
        assert!(calendar(b" 05 14  2  0  0 0.0").is_none());
        assert!(calendar(b" 05  4  2  0  0 0.0 1").is_none());
    }
}
