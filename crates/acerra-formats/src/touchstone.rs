//! Touchstone 1.1 and 2.0: scattering parameters of a network analyser, one sweep a file.
//!
//! Source: IBIS Open Forum, *Touchstone File Format Specification* 2.0 (2009).

use num_complex::{Complex32, Complex64};

use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};

/// Ports read at most.
const MAX_PORTS: usize = 32;

/// Whether a text is Touchstone: a line of options or of version before any data.
#[must_use]
pub fn is_touchstone(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let first = text
        .lines()
        .map(|line| line.split('!').next().unwrap_or_default().trim())
        .find(|line| !line.is_empty());
    first.is_some_and(|line| {
        let line = line.to_uppercase();
        let has = |unit: &str| line.split_whitespace().any(|word| word == unit);
        line.starts_with("[VERSION]")
            || (line.starts_with('#')
                && ["HZ", "KHZ", "MHZ", "GHZ", "RI", "MA", "DB"]
                    .iter()
                    .any(|u| has(u)))
    })
}

/// Format of a complex number as a pair.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Pair {
    RealImaginary,
    MagnitudeAngle,
    DecibelAngle,
}

impl Pair {
    pub(crate) fn complex(self, a: f64, b: f64) -> Complex64 {
        match self {
            Self::RealImaginary => Complex64::new(a, b),
            Self::MagnitudeAngle => Complex64::from_polar(a, b.to_radians()),
            Self::DecibelAngle => Complex64::from_polar(10f64.powf(a / 20.0), b.to_radians()),
        }
    }
}

/// Content of the lines before the data.
struct Options {
    hz: f64,
    pair: Pair,
    ports: Option<usize>,
    /// The order of two ports is S11, S21, S12, S22 (as in version 1) and not row by row.
    columns_first: bool,
    triangle: Option<Triangle>,
    frequencies: Option<usize>,
    is_two: bool,
}

#[derive(Clone, Copy)]
enum Triangle {
    Lower,
    Upper,
}

/// Reads a sweep. Parameters become channels named `S11`, `S21` and so on.
///
/// # Errors
/// A line that is no option, keyword or number, parameters other than S, a number of values that makes no whole
/// matrices, more than `limits` admit.
pub fn read_touchstone(text: &str, limits: &Limits) -> Result<Recording, FormatError> {
    let mut options = Options {
        hz: 1e9,
        pair: Pair::MagnitudeAngle,
        ports: None,
        columns_first: true,
        triangle: None,
        frequencies: None,
        is_two: false,
    };
    let mut has_options = false;
    let mut rows: Vec<(u64, Vec<f64>)> = Vec::new();
    let mut recording = Recording::new(Format::Touchstone);
    let mut is_reference = false;
    for (k, line) in text.lines().enumerate() {
        let at = k as u64 + 1;
        let (line, comment) = match line.split_once('!') {
            Some((line, comment)) => (line.trim(), comment.trim()),
            None => (line.trim(), ""),
        };
        if rows.is_empty() && !comment.is_empty() {
            recording.fact("comment", comment);
        }
        if line.is_empty() {
            continue;
        }
        if let Some(rest) = line.strip_prefix('#') {
            // Only the first line of options counts.
            if !has_options {
                parse_options(rest, at, &mut options)?;
            }
            has_options = true;
        } else if line.starts_with('[') {
            is_reference = line.to_uppercase().starts_with("[REFERENCE]");
            if !keyword(line, at, &mut options)? {
                break;
            }
        } else {
            let numbers = line.split_whitespace().map(|word| {
                word.parse::<f64>()
                    .map_err(|_| FormatError::content(Place::Line(at), "numbers", word))
            });
            let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
            if is_reference && options.is_two {
                // Impedances may go on over lines; they end at the next keyword.
                continue;
            }
            rows.push((at, numbers));
        }
    }
    if !has_options && !options.is_two {
        return Err(FormatError::content(
            Place::Line(1),
            "a line of options that begins with #",
            "none",
        ));
    }
    let ports = match options.ports {
        Some(ports) => ports,
        None => count_ports(&rows)?,
    };
    if !(1..=MAX_PORTS).contains(&ports) {
        return Err(FormatError::content(
            Place::field("number of ports"),
            format!("1 to {MAX_PORTS}"),
            ports,
        ));
    }
    sweep(&mut recording, &options, ports, &rows, limits)?;
    recording.checked()
}

fn parse_options(rest: &str, at: u64, options: &mut Options) -> Result<(), FormatError> {
    let words: Vec<String> = rest.split_whitespace().map(str::to_uppercase).collect();
    let mut words = words.iter().map(String::as_str);
    while let Some(word) = words.next() {
        match word {
            "HZ" => options.hz = 1.0,
            "KHZ" => options.hz = 1e3,
            "MHZ" => options.hz = 1e6,
            "GHZ" => options.hz = 1e9,
            "RI" => options.pair = Pair::RealImaginary,
            "MA" => options.pair = Pair::MagnitudeAngle,
            "DB" => options.pair = Pair::DecibelAngle,
            "S" => {}
            "R" => {
                words.next();
            }
            _ => {
                return Err(FormatError::content(
                    Place::Line(at),
                    "a unit of frequency, S, RI, MA or DB, and R with an impedance",
                    word,
                ));
            }
        }
    }
    Ok(())
}

/// Whether data may follow.
fn keyword(line: &str, at: u64, options: &mut Options) -> Result<bool, FormatError> {
    let (name, value) = line.split_once(']').unwrap_or((line, ""));
    let value = value.trim();
    let count = || {
        value
            .parse::<usize>()
            .map_err(|_| FormatError::content(Place::Line(at), "a whole number", value))
    };
    match name.trim_start_matches('[').to_uppercase().as_str() {
        "VERSION" => {
            options.is_two = true;
            options.columns_first = false;
        }
        "NUMBER OF PORTS" => options.ports = Some(count()?),
        "NUMBER OF FREQUENCIES" => options.frequencies = Some(count()?),
        "TWO-PORT DATA ORDER" | "TWO-PORT ORDER" => options.columns_first = value == "21_12",
        "MATRIX FORMAT" => {
            options.triangle = match value.to_uppercase().as_str() {
                "FULL" => None,
                "LOWER" => Some(Triangle::Lower),
                "UPPER" => Some(Triangle::Upper),
                _ => {
                    return Err(FormatError::content(
                        Place::Line(at),
                        "Full, Lower or Upper",
                        value,
                    ));
                }
            };
        }
        "MIXED-MODE ORDER" => {
            return Err(FormatError::content(
                Place::Line(at),
                "single-ended parameters",
                "mixed modes",
            ));
        }
        "NOISE DATA" | "END" => return Ok(false),
        _ => {}
    }
    Ok(true)
}

/// Ports from the numbers of a line: 3 are one port, 9 two, or four where lines of 8 follow; 1 + 2n are n.
fn count_ports(rows: &[(u64, Vec<f64>)]) -> Result<usize, FormatError> {
    let Some((at, first)) = rows.first() else {
        return Err(FormatError::content(Place::Whole, "data", "none"));
    };
    let second = rows.get(1).map(|(_, row)| row.len());
    match first.len() {
        3 => Ok(1),
        9 if second == Some(8) => Ok(4),
        9 => Ok(2),
        7 => Ok(3),
        found => Err(FormatError::content(
            Place::Line(*at),
            "3, 7 or 9 numbers (for more ports, their number by [Number of Ports])",
            found,
        )),
    }
}

fn sweep(
    recording: &mut Recording,
    options: &Options,
    ports: usize,
    rows: &[(u64, Vec<f64>)],
    limits: &Limits,
) -> Result<(), FormatError> {
    // Rows and columns of the matrix in the file's order.
    let all = (0..ports).flat_map(|i| (0..ports).map(move |j| (i, j)));
    let cells: Vec<(usize, usize)> = match options.triangle {
        Some(Triangle::Lower) => all.filter(|(i, j)| j <= i).collect(),
        Some(Triangle::Upper) => all.filter(|(i, j)| j >= i).collect(),
        None if ports == 2 && options.columns_first => vec![(0, 0), (1, 0), (0, 1), (1, 1)],
        None => all.collect(),
    };
    let record = 1 + 2 * cells.len();
    let mut hz: Vec<f64> = Vec::new();
    let mut values: Vec<Vec<Complex32>> = vec![Vec::new(); cells.len()];
    let mut numbers: Vec<f64> = Vec::with_capacity(record);
    let mut noise_lines = 0;
    for (at, row) in rows {
        // Noise parameters follow the sweep of two ports: frequencies begin again.
        let begins = numbers.is_empty();
        let goes_back = hz
            .last()
            .zip(row.first())
            .is_some_and(|(last, f)| f * options.hz <= *last);
        let is_noise = begins && ports == 2 && row.len() == 5 && goes_back;
        if noise_lines > 0 || is_noise {
            noise_lines += 1;
            continue;
        }
        numbers.extend(row);
        if numbers.len() > record {
            return Err(FormatError::content(
                Place::Line(*at),
                format!("{record} numbers for {ports} ports"),
                numbers.len(),
            ));
        }
        if numbers.len() == record {
            let frequency = numbers[0] * options.hz;
            if hz.last().is_some_and(|last| frequency <= *last) {
                return Err(FormatError::content(
                    Place::Line(*at),
                    "a growing frequency",
                    format!("{frequency} Hz"),
                ));
            }
            hz.push(frequency);
            limits.check_trace(Place::Line(*at), hz.len() as u64)?;
            for (k, to) in values.iter_mut().enumerate() {
                let z = options.pair.complex(numbers[1 + 2 * k], numbers[2 + 2 * k]);
                to.push(Complex32::new(z.re as f32, z.im as f32));
            }
            numbers.clear();
        }
    }
    if !numbers.is_empty() {
        return Err(FormatError::content(
            Place::Whole,
            format!("{record} numbers for the last frequency"),
            numbers.len(),
        ));
    }
    if hz.is_empty() {
        return Err(FormatError::content(Place::Whole, "data", "none"));
    }
    if let Some(stated) = options.frequencies {
        recording.compare(
            "frequencies: file, [Number of Frequencies]",
            [hz.len() as f64, stated as f64],
            "frequencies",
            0.0,
        );
    }
    if noise_lines > 0 {
        recording.remarks.push(format!(
            "{noise_lines} lines of noise parameters are not read"
        ));
    }
    // Zero is no frequency of a radar.
    let from = hz.iter().take_while(|f| **f == 0.0).count();
    if from > 0 {
        recording
            .remarks
            .push("the value at 0 Hz is left out".to_owned());
    }
    for ((i, j), values) in cells.into_iter().zip(values) {
        recording.channels.push(Channel::new(
            format!("S{}{}", i + 1, j + 1),
            1,
            Axis::Frequency(hz[from..].to_vec()),
            Values::Complex(values[from..].to_vec()),
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(recording: &Recording, name: &str, k: usize) -> Complex32 {
        let Values::Complex(v) = &recording.channel(Some(name)).unwrap().values else {
            panic!()
        };
        v[k]
    }

    #[test]
    fn two_ports_of_version_1_are_by_columns_and_noise_is_left_out() {
        let text = "! made by hand\n# MHz S DB R 50\n100 0 0 -20 90 -6.0206 180 0 0\n200 0 0 -40 0 0 0 0 0\n100 1 2 3 4\n";
        let read = read_touchstone(text, &Limits::default()).unwrap();
        assert_eq!(read.channels.len(), 4);
        let s21 = value(&read, "S21", 0);
        assert!((s21 - Complex32::new(0.0, 0.1)).norm() < 1e-6, "{s21}");
        let s12 = value(&read, "S12", 0);
        assert!((s12 - Complex32::new(-0.5, 0.0)).norm() < 1e-5, "{s12}");
        assert_eq!(read.channels[0].axis, Axis::Frequency(vec![1e8, 2e8]));
        assert!(read.remarks[0].contains("noise"));
    }

    #[test]
    fn version_2_says_order_and_ports() {
        let text = "[Version] 2.0\n# GHz S RI R 50\n[Number of Ports] 2\n[Two-Port Data Order] 12_21\n\
                    [Number of Frequencies] 1\n[Reference] 50\n75\n[Network Data]\n1 1 0 2 0\n3 0 4 0\n[End]\n";
        let read = read_touchstone(text, &Limits::default()).unwrap();
        assert_eq!(value(&read, "S12", 0).re, 2.0);
        assert_eq!(value(&read, "S21", 0).re, 3.0);
    }

    #[test]
    fn broken_lines_are_named() {
        let cases = [
            (
                "# GHz S RI R 50\n1 2 x\n",
                "line 2: expected numbers, found x",
            ),
            ("# GHz Z RI R 50\n1 2 3\n", "line 1"),
            (
                "# GHz S RI R 50\n1 2 3\n1 2 3\n",
                "line 3: expected a growing frequency",
            ),
            ("# GHz S RI R 50\n", "expected data"),
            ("# GHz S RI R 50\n1 2 3\n2 2\n", "for the last frequency"),
        ];
        for (text, expected) in cases {
            let error = read_touchstone(text, &Limits::default())
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
