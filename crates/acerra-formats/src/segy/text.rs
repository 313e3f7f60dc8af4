//! Texts in EBCDIC or ASCII.

/// EBCDIC (code page 037) of 0x40 to 0xff in ASCII; a blank where ASCII has no such character.
const EBCDIC: &[u8; 192] = b"           .<(+|&         !$*); -/         ,%_>?         `:#@'=\" abcdefghi       jklmnopqr       ~stuvwxyz      ^         []    {ABCDEFGHI      }JKLMNOPQR      \\ STUVWXYZ      0123456789      ";

/// The text, one line each 80 characters, without blanks at the ends of lines.
pub fn decode(bytes: &[u8]) -> String {
    // Letters and blanks of EBCDIC lie above those of ASCII.
    let ascii = bytes.iter().filter(|b| (0x20..0x7f).contains(*b)).count();
    let high = bytes.iter().filter(|b| **b >= 0x80 || **b == 0x40).count();
    let is_ebcdic = high > ascii.saturating_sub(bytes.iter().filter(|b| **b == 0x40).count());
    let character = |b: &u8| -> char {
        let c = if is_ebcdic {
            b.checked_sub(0x40).map_or(b' ', |i| EBCDIC[usize::from(i)])
        } else {
            *b
        };
        if (0x20..0x7f).contains(&c) {
            char::from(c)
        } else {
            ' '
        }
    };
    let lines = bytes.chunks(80).map(|line| {
        let line: String = line.iter().map(character).collect();
        line.trim_end().to_owned()
    });
    let lines: Vec<String> = lines.collect();
    lines.join("\n").trim_end().to_owned()
}

/// A sample interval that a line of the text states in picoseconds or nanoseconds (ps). Other units are those of the
/// standard's own template, whatever the numbers are.
pub fn interval_in_text_ps(text: &str) -> Option<f64> {
    let text = text.to_ascii_lowercase();
    let of_line = |line: &str| -> Option<f64> {
        let at = ["sample interval", "sampling interval"]
            .iter()
            .find_map(|name| Some(line.find(name)? + name.len()))?;
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '.';
        let mut words = line[at..].split(|c| !is_part(c)).filter(|w| !w.is_empty());
        let first = words.next()?;
        // A number with its unit attached, behind it, or before it in brackets.
        let digits = first.len() - first.trim_start_matches(|c: char| !c.is_alphabetic()).len();
        let (number, unit) = match (digits, words.next()) {
            (0, number) => (number?, first),
            (n, unit) if n == first.len() => (first, unit?),
            (n, _) => first.split_at(n),
        };
        let number: f64 = number.parse().ok()?;
        let ps = match unit {
            "ps" | "picosecond" | "picoseconds" => 1.0,
            "ns" | "nanosecond" | "nanoseconds" => 1e3,
            _ => return None,
        };
        Some(ps * number).filter(|ps| ps.is_finite() && *ps > 0.0)
    };
    text.lines().find_map(of_line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_texts_need_a_unit_of_radars() {
        for (text, expected) in [
            ("C 1 GPR\nC 5 SAMPLE INTERVAL 100 ps", Some(100.0)),
            ("C 5 Sampling interval: 0.1ns", Some(100.0)),
            ("C 5 SAMPLE INTERVAL (ns): 0.25", Some(250.0)),
            ("C 5 SAMPLE INTERVAL 4000 us", None),
            ("C 5 SAMPLE INTERVAL         SAMPLES/TRACE", None),
            ("C 5 SAMPLE INTERVAL", None),
        ] {
            assert_eq!(interval_in_text_ps(text), expected, "{text}");
        }
    }

    #[test]
    fn both_alphabets_are_read() {
        // "C 1 Line 9" in code page 037.
        let ebcdic = [0xc3, 0x40, 0xf1, 0x40, 0xd3, 0x89, 0x95, 0x85, 0x40, 0xf9];
        assert_eq!(decode(&ebcdic), "C 1 Line 9");
        assert_eq!(decode(b"C 1 GPR, ps   "), "C 1 GPR, ps");
        assert_eq!(EBCDIC[0x4b - 0x40], b'.');
        assert_eq!(EBCDIC[0xe9 - 0x40], b'Z');
        assert_eq!(EBCDIC[0x6b - 0x40], b',');
        assert_eq!(EBCDIC[0xa2 - 0x40], b's');
        assert_eq!(EBCDIC[0x7a - 0x40], b':');
    }
}
