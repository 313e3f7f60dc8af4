//! Numbers as a reader wants them.

/// A value with `decimals` places and a true minus sign; a dash where there is none.
pub(super) fn fixed(value: impl Into<Option<f64>>, decimals: usize) -> String {
    match value.into() {
        Some(value) if value.is_finite() => {
            let text = format!("{value:.decimals$}");
            // −0.00 says nothing that 0.00 does not.
            let zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
            let text = if zero {
                text.trim_start_matches('-').to_owned()
            } else {
                text
            };
            text.replace('-', "−")
        }
        _ => "–".to_owned(),
    }
}

/// A value with its unit, to as many places as `sigma` deserves (two significant digits of it), or
/// to four significant digits where no standard deviation is known. Shares are said in per cent.
pub(super) fn measured(value: Option<f64>, sigma: Option<f64>, unit: &str) -> String {
    if let Some(whole) = unit.strip_prefix("share") {
        let percent = |share: Option<f64>| share.map(|share| 1e2 * share);
        return match percent(value).filter(|value| value.is_finite()) {
            Some(value) => format!("{}\u{a0}%{whole}", significant(value, percent(sigma), 3)),
            None => "–".to_owned(),
        };
    }
    match value.filter(|value| value.is_finite()) {
        Some(value) => format!("{}\u{a0}{unit}", significant(value, sigma, 4))
            .trim_end()
            .to_owned(),
        None => "–".to_owned(),
    }
}

/// A number to two digits of `sigma`, or to as many `digits` of its own.
fn significant(value: f64, sigma: Option<f64>, digits: i32) -> String {
    let places = |scale: f64, digits: i32| {
        let magnitude = scale.abs().log10().floor();
        if magnitude.is_finite() {
            (f64::from(digits - 1) - magnitude).clamp(0.0, 9.0) as usize
        } else {
            0
        }
    };
    let decimals = match sigma {
        Some(sigma) => places(sigma, 2),
        None => places(value, digits),
    };
    if value.abs() >= 1e6 || (value != 0.0 && value.abs() < 1e-6) {
        format!("{value:.2e}").replace('-', "−")
    } else {
        fixed(value, decimals)
    }
}

/// Words with the true minus sign before their numbers; names and exponents keep their hyphens.
pub(super) fn with_minus_signs(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    let mut before = None;
    let mut letters = words.chars().peekable();
    while let Some(letter) = letters.next() {
        let begins =
            before.is_none_or(|c: char| c.is_whitespace() || matches!(c, '(' | '[' | '±' | '…'));
        let is_sign = letter == '-' && begins && letters.peek().is_some_and(char::is_ascii_digit);
        text.push(if is_sign { '−' } else { letter });
        before = Some(letter);
    }
    text
}

/// Bytes in the largest binary unit that keeps at least one whole.
pub(super) fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = count as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 {
        format!("{count} B")
    } else {
        format!("{value:.1} {}", UNITS[unit])
    }
}

/// Seconds with three significant digits or so.
pub(super) fn seconds(value: f64) -> String {
    match value {
        v if v >= 100.0 => format!("{v:.0} s"),
        v if v >= 1.0 => format!("{v:.2} s"),
        v => format!("{:.1} ms", v * 1e3),
    }
}

/// The quantile `share` of the finite values, by nearest rank.
pub(super) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(sorted[(share * last as f64).round() as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(fixed(-1.234, 2), "−1.23");
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(fixed(None, 2), "–");
        assert_eq!(fixed(f64::NAN, 2), "–");
        assert_eq!(
            measured(Some(-12.34567), Some(0.034), "ns"),
            "−12.346\u{a0}ns"
        );
        assert_eq!(measured(Some(0.0512), None, "m"), "0.05120\u{a0}m");
        assert_eq!(measured(Some(3.0), Some(12.0), ""), "3");
        assert_eq!(measured(None, Some(1.0), "m"), "–");
        let share = "share of the image";
        assert_eq!(
            measured(Some(0.4938), None, share),
            "49.4\u{a0}% of the image"
        );
        assert_eq!(
            measured(Some(0.5), Some(0.012), share),
            "50.0\u{a0}% of the image"
        );
        assert_eq!(measured(Some(1.0), None, share), "100\u{a0}% of the image");
        assert_eq!(measured(None, None, share), "–");
        assert_eq!(measured(Some(f64::NAN), None, "m"), "–");
        assert_eq!(
            with_minus_signs("-10.0 ns (-4 mm) at 1e-3, AVX-512, flight-1.mrm"),
            "−10.0 ns (−4 mm) at 1e-3, AVX-512, flight-1.mrm"
        );
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(seconds(0.0123), "12.3 ms");
        assert_eq!(seconds(12.345), "12.35 s");
        assert_eq!(
            quantile([3.0, 1.0, f64::NAN, 2.0].into_iter(), 0.5),
            Some(2.0)
        );
        assert_eq!(quantile([].into_iter(), 0.5), None);
    }
}
