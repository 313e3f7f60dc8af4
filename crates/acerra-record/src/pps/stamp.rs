//! The text of a kernel's pulse stamp: `1700000000.000012345#42`.

use std::fmt;
use std::time::Duration;

use thiserror::Error;

/// Longest text of a stamp that is read, bytes; the kernel's are 32 at most.
pub const MAX_STAMP_BYTES: usize = 64;
/// Digits of nanoseconds.
const NANOSECOND_DIGITS: usize = 9;
/// Most digits of seconds: the year 5138.
const MOST_SECOND_DIGITS: usize = 11;

/// A pulse as the kernel stamped it.
///
/// ```
/// use acerra_record::pps::PulseStamp;
/// let stamp = PulseStamp::parse(b"1700000000.000012345#42\n")?;
/// assert_eq!((stamp.unix.subsec_nanos(), stamp.sequence), (12_345, 42));
/// assert_eq!(stamp.to_string(), "1700000000.000012345#42");
/// # Ok::<(), acerra_record::pps::StampError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PulseStamp {
    /// The computer's calendar clock (`CLOCK_REALTIME`) at the edge, since 1970.
    pub unix: Duration,
    /// Edges that the kernel counted, modulo 2³².
    pub sequence: u32,
}

/// Reason why a text is no stamp.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StampError {
    /// No text: the kernel shows none where the device does not stamp this edge.
    #[error(
        "expected a pulse as SECONDS.NANOSECONDS#NUMBER, found nothing: does the device stamp this edge?"
    )]
    Empty,
    /// Too long a text.
    #[error("expected {MAX_STAMP_BYTES} bytes at most, found more")]
    TooLong,
    /// Another text.
    #[error(
        "byte {at}: expected {expected} of a pulse as SECONDS.NANOSECONDS#NUMBER, found {found:?}"
    )]
    Form {
        /// Offset of the first byte that does not fit.
        at: usize,
        /// Expected text.
        expected: &'static str,
        /// Text found from that offset on.
        found: String,
    },
}

impl PulseStamp {
    /// Reads a stamp from the text of a file, with or without the end of its line.
    ///
    /// # Errors
    /// Any other text.
    pub fn parse(text: &[u8]) -> Result<Self, StampError> {
        if text.len() > MAX_STAMP_BYTES {
            return Err(StampError::TooLong);
        }
        let text = text.strip_suffix(b"\n").unwrap_or(text);
        if text.is_empty() {
            return Err(StampError::Empty);
        }
        let mut fields = Fields { text, at: 0 };
        let seconds = fields.number("seconds", 1..=MOST_SECOND_DIGITS)?;
        fields.byte(b'.', "a point")?;
        let nanoseconds = fields.number("nine digits", NANOSECOND_DIGITS..=NANOSECOND_DIGITS)?;
        fields.byte(b'#', "the sign #")?;
        let number_at = fields.at;
        let number = fields.number("a number", 1..=10)?;
        if fields.at < text.len() {
            return Err(fields.wrong("the end"));
        }
        let sequence = u32::try_from(number).map_err(|_| {
            fields.at = number_at;
            fields.wrong("a number below 2^32")
        })?;
        // Nine digits are less than 10⁹.
        let unix = Duration::from_secs(seconds) + Duration::from_nanos(nanoseconds);
        Ok(Self { unix, sequence })
    }
}

/// As the kernel writes it, without the end of the line.
impl fmt::Display for PulseStamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, nanoseconds) = (self.unix.as_secs(), self.unix.subsec_nanos());
        write!(f, "{seconds}.{nanoseconds:09}#{}", self.sequence)
    }
}

/// A text taken from its beginning.
struct Fields<'a> {
    text: &'a [u8],
    at: usize,
}

impl Fields<'_> {
    fn wrong(&self, expected: &'static str) -> StampError {
        let found = self.text.get(self.at..).unwrap_or_default();
        StampError::Form {
            at: self.at,
            expected,
            found: String::from_utf8_lossy(found).into_owned(),
        }
    }

    fn byte(&mut self, byte: u8, expected: &'static str) -> Result<(), StampError> {
        if self.text.get(self.at) != Some(&byte) {
            return Err(self.wrong(expected));
        }
        self.at += 1;
        Ok(())
    }

    /// A number of a given number of digits; 64 bits hold eleven.
    fn number(
        &mut self,
        expected: &'static str,
        digits: std::ops::RangeInclusive<usize>,
    ) -> Result<u64, StampError> {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let found = rest.iter().take_while(|b| b.is_ascii_digit());
        let found: Vec<u64> = found.map(|b| u64::from(b - b'0')).collect();
        if !digits.contains(&found.len()) {
            return Err(self.wrong(expected));
        }
        self.at += found.len();
        Ok(found.iter().fold(0, |number, digit| 10 * number + digit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_the_kernel_writes_is_read() {
        let none_yet = PulseStamp::parse(b"0.000000000#0\n").unwrap();
        assert_eq!((none_yet.unix, none_yet.sequence), (Duration::ZERO, 0));
        let late = PulseStamp::parse(b"99999999999.999999999#4294967295").unwrap();
        assert_eq!(late.sequence, u32::MAX);
        assert_eq!(late.unix.as_nanos(), 99_999_999_999_999_999_999);
    }

    #[test]
    fn other_texts_are_refused_with_their_place() {
        for (text, expected) in [
            ("", "found nothing"),
            ("\n", "found nothing"),
            ("1700000000", "byte 10: expected a point"),
            ("1700000000.12#4", "byte 11: expected nine digits"),
            ("1700000000.0000123450#4", "byte 11: expected nine digits"),
            ("1700000000.000012345", "byte 20: expected the sign #"),
            ("1700000000.000012345#", "byte 21: expected a number"),
            ("1700000000.000012345#-4", "byte 21: expected a number"),
            (
                "1700000000.000012345#4294967296",
                "byte 21: expected a number below 2^32",
            ),
            ("1700000000.000012345#4 ", "byte 22: expected the end"),
            ("1700000000.000012345#4\n5", "byte 22: expected the end"),
            ("-1.000012345#4", "byte 0: expected seconds"),
            ("123456789012.000012345#4", "byte 0: expected seconds"),
        ] {
            let error = PulseStamp::parse(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
        let long = [b'1'; MAX_STAMP_BYTES + 1];
        assert_eq!(PulseStamp::parse(&long), Err(StampError::TooLong));
    }

    proptest! {
        #[test]
        fn stamps_read_back(seconds in 0..=99_999_999_999_u64, ns in 0..1_000_000_000_u32, sequence: u32) {
            let stamp = PulseStamp { unix: Duration::new(seconds, ns), sequence };
            prop_assert_eq!(PulseStamp::parse(stamp.to_string().as_bytes()), Ok(stamp));
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            let _ = PulseStamp::parse(&bytes);
        }
    }
}
