//! The two difference codes of compact RINEX.

/// Highest order of differences accepted (the compressor's own maximum is 9; it writes 3).
const MAX_ORDER: usize = 9;

/// Applies a text difference to `text`: a blank keeps the character, `&` makes a blank, anything else
/// replaces; characters beyond the end are appended.
pub(super) fn patch_text(text: &mut Vec<u8>, difference: &[u8]) {
    for (i, &d) in difference.iter().enumerate() {
        let kept = text.get(i).copied();
        let new = match (d, kept) {
            (b' ', Some(old)) => old,
            (b' ' | b'&', _) => b' ',
            _ => d,
        };
        match kept {
            Some(_) => text[i] = new,
            None => text.push(new),
        }
    }
}

/// An arc of integers coded as differences. `sums[k]` is the k-th difference at the last epoch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    order: usize,
    reached: usize,
    sums: [i64; MAX_ORDER + 1],
}

impl Arc {
    /// Starts an arc, or continues `arc`, with one field of a compact line.
    ///
    /// Returns `None` for a field that is damaged or refers to a missing arc; the arc is then lost until a
    /// field restarts it.
    pub(super) fn step(arc: Option<Self>, field: &[u8]) -> Option<Self> {
        if let [digit @ b'0'..=b'9', b'&', value @ ..] = field {
            let mut sums = [0; MAX_ORDER + 1];
            sums[0] = integer(value)?;
            return Some(Self {
                order: usize::from(digit - b'0'),
                reached: 0,
                sums,
            });
        }
        let mut arc = arc?;
        arc.reached = (arc.reached + 1).min(arc.order);
        let value = integer(field)?;
        if arc.reached == 0 {
            arc.sums[0] = value;
            return Some(arc);
        }
        arc.sums[arc.reached] = value;
        for k in (0..arc.reached).rev() {
            arc.sums[k] = arc.sums[k].checked_add(arc.sums[k + 1])?;
        }
        Some(arc)
    }

    /// The value at the current epoch, in units of the last decimal.
    pub(super) fn value(&self) -> i64 {
        self.sums[0]
    }
}

fn integer(field: &[u8]) -> Option<i64> {
    std::str::from_utf8(field).ok()?.parse().ok()
}

/// `value`·10^(−`decimals`) right-aligned in `width` characters; `None` where it does not fit.
pub(super) fn fixed_point(value: i64, decimals: usize, width: usize) -> Option<String> {
    let scale = 10_u64.pow(u32::try_from(decimals).ok()?);
    let (whole, rest) = (value.unsigned_abs() / scale, value.unsigned_abs() % scale);
    let sign = if value < 0 { "-" } else { "" };
    // No zero before the point, as Fortran and the original tool write.
    let whole = if whole == 0 {
        String::new()
    } else {
        whole.to_string()
    };
    let text = format!("{sign}{whole}.{rest:0decimals$}");
    (text.len() <= width).then(|| format!("{text:>width$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_differences() {
        let mut text = b"&abc".to_vec();
        patch_text(&mut text, b"  X&YZ");
        assert_eq!(text, b"&aX YZ");
        patch_text(&mut text, b"");
        assert_eq!(text, b"&aX YZ");
        let mut text = b"ab".to_vec();
        patch_text(&mut text, b"    &c");
        assert_eq!(text, b"ab   c");
    }

    /// A cubic sequence coded to third order: after the start, one constant difference.
    #[test]
    fn differences_of_a_cubic() {
        let f = |t: i64| 5 * t * t * t - 40 * t * t + 3 * t + 123_456_789;
        let fields: Vec<String> = (0..8)
            .map(|t| match t {
                0 => format!("3&{}", f(0)),
                1 => (f(1) - f(0)).to_string(),
                2 => (f(2) - 2 * f(1) + f(0)).to_string(),
                _ => (f(t) - 3 * f(t - 1) + 3 * f(t - 2) - f(t - 3)).to_string(),
            })
            .collect();
        assert_eq!(fields[4], "30");
        let mut arc = None;
        for (t, field) in fields.iter().enumerate() {
            arc = Arc::step(arc, field.as_bytes());
            assert_eq!(arc.expect("arc").value(), f(t as i64));
        }
    }

    #[test]
    fn damaged_fields_end_the_arc() {
        assert!(Arc::step(None, b"17").is_none());
        let arc = Arc::step(None, b"3&17");
        assert!(arc.is_some());
        assert!(Arc::step(arc, b"1x").is_none());
        let huge = Arc::step(None, b"1&9223372036854775807");
        assert!(Arc::step(huge, b"1").is_none());
    }

    #[test]
    fn fixed_point_text() {
        assert_eq!(
            fixed_point(23_629_347_915, 3, 14).unwrap(),
            "  23629347.915"
        );
        assert_eq!(fixed_point(-353, 3, 14).unwrap(), "         -.353");
        assert_eq!(fixed_point(-123_456_789, 9, 12).unwrap(), " -.123456789");
        assert_eq!(fixed_point(99_999_999_999_999, 3, 14), None);
    }
}
