//! Tick positions and their labels.

use super::font;

/// One tick: its value and its label.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub label: String,
}

/// Even ticks over `[low, high]` drawn along `length` pixels: the finest of the steps
/// {1, 2, 5} × 10ᵏ whose labels stay apart.
///
/// `across` states that labels are side by side (x axis) and must not touch by width; otherwise labels are
/// above each other (y axis).
pub(super) fn linear(low: f64, high: f64, length: f32, size: f32, across: bool) -> Vec<Tick> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return Vec::new();
    }
    let first_power = (span / 100.0).log10().floor() as i32;
    for power in first_power..first_power + 5 {
        for mantissa in [1.0, 2.0, 5.0] {
            let step = mantissa * 10f64.powi(power);
            let count = span / step;
            if count > 60.0 {
                continue;
            }
            let ticks = even(low, high, step, power);
            let pitch = length * (step / span) as f32;
            let widest = ticks
                .iter()
                .map(|t| font::width(&t.label, size))
                .fold(0.0_f32, f32::max);
            let room = if across {
                (widest + 1.4 * size).max(44.0)
            } else {
                3.6 * size
            };
            if pitch >= room || ticks.len() <= 2 {
                return ticks;
            }
        }
    }
    Vec::new()
}

fn even(low: f64, high: f64, step: f64, power: i32) -> Vec<Tick> {
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let largest = low.abs().max(high.abs());
    (first..=last)
        .map(|k| {
            let value = k as f64 * step;
            Tick {
                value,
                label: format_value(value, power, largest),
            }
        })
        .collect()
}

/// A number with the decimals that steps of 10^`power` need; in powers of ten where the axis'
/// largest value is far from one.
fn format_value(value: f64, power: i32, largest: f64) -> String {
    let text = if largest >= 1e6 || (largest < 1e-3 && largest > 0.0) {
        let exponent = largest.log10().floor() as i32;
        let decimals = (exponent - power).max(0) as usize;
        if value == 0.0 {
            "0".to_owned()
        } else {
            let mantissa = value / 10f64.powi(exponent);
            format!("{mantissa:.decimals$}×10{}", superscript(exponent))
        }
    } else {
        format!("{value:.*}", (-power).max(0) as usize)
    };
    text.replace('-', "−")
}

/// An exponent in superscript digits.
pub(super) fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect()
}

/// Ticks of a logarithmic axis at 1, 2, 5 × 10ᵏ where there is room, else at powers of ten, else at
/// every n-th power.
pub(super) fn logarithmic(low: f64, high: f64, length: f32, size: f32, across: bool) -> Vec<Tick> {
    if !(low > 0.0 && high > low && high.is_finite()) {
        return Vec::new();
    }
    let position = |value: f64| ((value / low).ln() / (high / low).ln()) as f32 * length;
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let steps: [(&[f64], usize); 5] = [
        (&[1.0, 2.0, 5.0], 1),
        (&[1.0, 3.0], 1),
        (&[1.0], 1),
        (&[1.0], 2),
        (&[1.0], 5),
    ];
    for (mantissas, every) in steps {
        let ticks: Vec<Tick> = (first..=last)
            .filter(|power| power.rem_euclid(every as i32) == 0)
            .flat_map(|power| {
                mantissas
                    .iter()
                    .map(move |m| (m * 10f64.powi(power), power))
            })
            .filter(|(value, _)| *value >= low * (1.0 - 1e-9) && *value <= high * (1.0 + 1e-9))
            .map(|(value, power)| Tick {
                value,
                label: log_label(value, power),
            })
            .collect();
        let apart = ticks.windows(2).all(|pair| {
            let room = if across {
                (font::width(&pair[0].label, size) + font::width(&pair[1].label, size)) / 2.0 + size
            } else {
                1.8 * size
            };
            position(pair[1].value) - position(pair[0].value) >= room
        });
        if apart {
            return ticks;
        }
    }
    Vec::new()
}

fn log_label(value: f64, power: i32) -> String {
    let mantissa = (value / 10f64.powi(power)).round() as i64;
    if (-3..=3).contains(&power) {
        format!("{value:.*}", (-power).max(0) as usize)
    } else if mantissa == 1 {
        format!("10{}", superscript(power))
    } else {
        format!("{mantissa}×10{}", superscript(power))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|t| t.label.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        let ticks = linear(-9.0, 9.0, 400.0, 12.0, true);
        assert_eq!(
            labels(&ticks),
            ["−8", "−6", "−4", "−2", "0", "2", "4", "6", "8"]
        );
        let fine = linear(0.12, 0.16, 300.0, 12.0, false);
        assert!(
            fine.iter()
                .all(|t| t.value >= 0.12 - 1e-12 && t.value <= 0.16 + 1e-12)
        );
        assert!(fine.len() >= 3);
    }

    #[test]
    fn labels_never_overlap_for_any_span_or_length() {
        for power in -12..12 {
            for (low, high) in [(0.0, 1.0), (-3.7, 9.1), (1000.0, 1000.5), (-1.0, -0.97)] {
                for length in [30.0, 120.0, 640.0] {
                    let factor = 10f64.powi(power);
                    let (low, high) = (low * factor, high * factor);
                    let ticks = linear(low, high, length, 12.0, true);
                    for pair in ticks.windows(2) {
                        let pitch = (pair[1].value - pair[0].value) / (high - low);
                        let pitch = pitch as f32 * length;
                        let need = (font::width(&pair[0].label, 12.0)
                            + font::width(&pair[1].label, 12.0))
                            / 2.0;
                        assert!(
                            pitch > need || ticks.len() <= 2,
                            "{low}..{high} over {length}: {:?}",
                            labels(&ticks)
                        );
                        assert_ne!(pair[0].label, pair[1].label, "{low}..{high}");
                    }
                }
            }
        }
    }

    #[test]
    fn degenerate_ranges_have_no_ticks() {
        assert!(linear(1.0, 1.0, 100.0, 12.0, true).is_empty());
        assert!(linear(f64::NAN, 1.0, 100.0, 12.0, true).is_empty());
        assert!(logarithmic(0.0, 1.0, 100.0, 12.0, true).is_empty());
    }

    #[test]
    fn log_ticks_thin_out_with_the_room() {
        let wide = logarithmic(0.1, 10.0, 600.0, 12.0, true);
        assert_eq!(labels(&wide), ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        let narrow = logarithmic(1e-6, 1e6, 200.0, 12.0, true);
        assert!(
            narrow.len() >= 2 && narrow.len() <= 7,
            "{:?}",
            labels(&narrow)
        );
    }
}
