//! Tables of a network analyser: frequency in the first column, then pairs of columns, one pair a sweep or parameter.

use num_complex::Complex32;

use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};
use crate::touchstone::Pair;

/// Lines before the heading that are read.
const MAX_HEAD_LINES: usize = 64;

fn separator(line: &str) -> char {
    let most = [',', ';', '\t']
        .into_iter()
        .max_by_key(|c| line.matches(*c).count());
    most.unwrap_or(',')
}

/// Columns of a heading whose first is a frequency.
fn heading(line: &str) -> Option<Vec<String>> {
    let line = line.trim_start_matches(['!', '#', '%', '\u{feff}']).trim();
    let columns: Vec<String> = line
        .split(separator(line))
        .map(|c| c.trim().trim_matches('"').to_lowercase())
        .collect();
    (columns.len() >= 3 && columns.len() % 2 == 1 && columns[0].starts_with("freq"))
        .then_some(columns)
}

/// Whether a text is a table of an analyser: a heading whose first column is a frequency, with pairs behind it.
#[must_use]
pub fn is_analyser_csv(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    text.lines()
        .take(MAX_HEAD_LINES)
        .any(|line| heading(line).is_some())
}

/// Reads a table. Pairs that are named alike but for a number, or not at all, are sweeps of one channel; pairs of
/// parameters (`S11`, `S21`) are channels.
///
/// # Errors
/// A heading without the quantity of the pairs, a line without numbers, more than `limits` admit.
pub fn read_analyser_csv(text: &str, limits: &Limits) -> Result<Recording, FormatError> {
    let mut lines = text.lines().enumerate();
    let found = lines
        .by_ref()
        .take(MAX_HEAD_LINES)
        .find_map(|(k, line)| Some((k, heading(line)?, separator(line))));
    let Some((head_line, columns, separator)) = found else {
        return Err(FormatError::content(
            Place::Line(1),
            "a heading of a frequency and pairs of columns",
            "none",
        ));
    };
    let at = Place::Line(head_line as u64 + 1);
    let hz = unit(&columns[0]);
    let pair = kind(&columns[1..3]).ok_or_else(|| {
        FormatError::content(
            at,
            "columns named real and imaginary, magnitude and angle, or dB and angle",
            format!("{} and {}", columns[1], columns[2]),
        )
    })?;
    let pairs = columns.len() / 2;
    let mut frequency: Vec<f64> = Vec::new();
    let mut rows: Vec<Complex32> = Vec::new();
    for (k, line) in lines {
        let line = line.trim();
        let at = k as u64 + 1;
        if line.is_empty() || line.starts_with(['!', '#', '%']) {
            continue;
        }
        if line.to_uppercase().starts_with("END") {
            break;
        }
        let numbers = line.split(separator).map(|word| {
            let word = word.trim().trim_matches('"');
            word.parse::<f64>()
                .map_err(|_| FormatError::content(Place::Line(at), "numbers", word))
        });
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        if numbers.len() != columns.len() {
            return Err(FormatError::content(
                Place::Line(at),
                format!("{} numbers", columns.len()),
                numbers.len(),
            ));
        }
        frequency.push(numbers[0] * hz);
        limits.check_trace(Place::Line(at), frequency.len() as u64)?;
        limits.check_samples(Place::Line(at), (rows.len() + pairs) as u64)?;
        rows.extend(numbers[1..].as_chunks::<2>().0.iter().map(|[a, b]| {
            let z = pair.complex(*a, *b);
            Complex32::new(z.re as f32, z.im as f32)
        }));
    }
    if frequency.is_empty() {
        return Err(FormatError::content(Place::Whole, "data", "none"));
    }
    if let Some(i) = frequency.windows(2).position(|w| w[1] <= w[0]) {
        return Err(FormatError::content(
            Place::field("frequency"),
            "growing values",
            format!("{} Hz after {} Hz", frequency[i + 1], frequency[i]),
        ));
    }
    let mut recording = Recording::new(Format::AnalyserCsv);
    recording.fact("heading", columns.join(", "));
    let names: Vec<String> = (0..pairs).map(|p| parameter(&columns[1 + 2 * p])).collect();
    let mut distinct = names.clone();
    distinct.dedup();
    for name in distinct {
        let own: Vec<usize> = (0..pairs).filter(|p| names[*p] == name).collect();
        let values = own
            .iter()
            .flat_map(|&p| rows.iter().skip(p).step_by(pairs))
            .copied()
            .collect();
        if recording.channels.iter().any(|c| c.name == name) {
            continue;
        }
        recording.channels.push(Channel::new(
            name,
            own.len(),
            Axis::Frequency(frequency.clone()),
            Values::Complex(values),
        ));
    }
    recording.checked()
}

fn unit(column: &str) -> f64 {
    [("ghz", 1e9), ("mhz", 1e6), ("khz", 1e3)]
        .into_iter()
        .find(|(unit, _)| column.contains(unit))
        .map_or(1.0, |(_, hz)| hz)
}

fn kind(columns: &[String]) -> Option<Pair> {
    let has = |k: usize, names: &[&str]| names.iter().any(|n| columns[k].contains(n));
    let angle = has(1, &["ang", "deg", "phase", "arg"]);
    if has(0, &["real", "re"]) && has(1, &["imag", "im"]) {
        Some(Pair::RealImaginary)
    } else if has(0, &["db"]) && angle {
        Some(Pair::DecibelAngle)
    } else if has(0, &["mag", "lin", "abs"]) && angle {
        Some(Pair::MagnitudeAngle)
    } else {
        None
    }
}

/// The parameter that a column is named after, as `S21`; `1` where it is named after none.
fn parameter(column: &str) -> String {
    let bytes = column.as_bytes();
    bytes
        .windows(3)
        .find(|w| w[0] == b's' && w[1].is_ascii_digit() && w[2].is_ascii_digit())
        .map_or("1".to_owned(), |w| {
            String::from_utf8_lossy(w).to_uppercase()
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_side_by_side() {
        let text = "!analyser\n# Freq(MHz),re 1,im 1,re 2,im 2\n100,1,2,3,4\n200,5,6,7,8\n";
        assert!(is_analyser_csv(text.as_bytes()));
        let read = read_analyser_csv(text, &Limits::default()).unwrap();
        let channel = &read.channels[0];
        assert_eq!((channel.traces, channel.axis.samples()), (2, 2));
        let Values::Complex(v) = &channel.values else {
            panic!()
        };
        assert_eq!(v[1], Complex32::new(5.0, 6.0));
        assert_eq!(v[2], Complex32::new(3.0, 4.0));
        assert_eq!(channel.axis, Axis::Frequency(vec![1e8, 2e8]));
    }

    #[test]
    fn parameters_are_channels_and_decibels_are_levels() {
        let text =
            "Frequency (Hz);S11 (dB);S11 (deg);S21 (dB);S21 (deg)\n1e9;0;0;-20;90\n2e9;0;0;0;0\n";
        let read = read_analyser_csv(text, &Limits::default()).unwrap();
        let Values::Complex(v) = &read.channel(Some("S21")).unwrap().values else {
            panic!()
        };
        assert!((v[0] - Complex32::new(0.0, 0.1)).norm() < 1e-7);
        assert!(
            read_analyser_csv("freq,re,im\n1,2\n", &Limits::default())
                .unwrap_err()
                .to_string()
                .contains("line 2: expected 3 numbers, found 2")
        );
    }
}
