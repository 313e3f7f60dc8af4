//! `.Z` streams of realistic size, written here and checked by gzip where it is installed.

use std::collections::HashMap;
use std::io::{Read, Write};
use std::process::{Command, Stdio};

use acerra_gnss::input::{FileKind, Limits, ReadError, UnixCompressed};
use acerra_gnss::read_gnss;

/// Writes codes as `compress` does: lowest bit first, in groups of eight of one width.
struct Codes {
    out: Vec<u8>,
    group: Vec<usize>,
    width: usize,
}

impl Codes {
    fn push(&mut self, code: usize) {
        self.group.push(code);
        if self.group.len() == 8 {
            self.flush(true);
        }
    }

    fn flush(&mut self, whole: bool) {
        if self.group.is_empty() {
            return;
        }
        let bits = self.width * self.group.len();
        let mut bytes = vec![0_u8; if whole { self.width } else { bits.div_ceil(8) }];
        for (i, code) in self.group.drain(..).enumerate() {
            for bit in (0..self.width).filter(|bit| code >> bit & 1 == 1) {
                bytes[(self.width * i + bit) / 8] |= 1 << ((self.width * i + bit) % 8);
            }
        }
        self.out.extend(bytes);
    }
}

/// LZW with block mode; the table is emptied after so many codes.
fn compress(data: &[u8], max_bits: usize, clear_after: usize) -> Vec<u8> {
    let mut codes = Codes {
        out: vec![0x1F, 0x9D, 0x80 | u8::try_from(max_bits).unwrap()],
        group: Vec::new(),
        width: 9,
    };
    let mut table: HashMap<(usize, u8), usize> = HashMap::new();
    let (mut next, mut since) = (257, 0);
    let mut prefix: Option<usize> = None;
    for &byte in data {
        let Some(code) = prefix else {
            prefix = Some(usize::from(byte));
            continue;
        };
        if let Some(&longer) = table.get(&(code, byte)) {
            prefix = Some(longer);
            continue;
        }
        codes.push(code);
        since += 1;
        prefix = Some(usize::from(byte));
        // The reader's table lags by one entry.
        if next > (1 << codes.width) - 1 && codes.width < max_bits {
            codes.flush(true);
            codes.width += 1;
        }
        if next < 1 << max_bits {
            table.insert((code, byte), next);
            next += 1;
        }
        if since == clear_after {
            codes.push(prefix.unwrap());
            codes.push(256);
            codes.flush(true);
            codes.width = 9;
            table.clear();
            (next, since, prefix) = (257, 0, None);
        }
    }
    if let Some(code) = prefix {
        codes.push(code);
    }
    codes.flush(false);
    codes.out
}

fn decoded(stream: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    UnixCompressed::new(stream).read_to_end(&mut out)?;
    Ok(out)
}

/// What gzip makes of it, or `None` (and a printed reason) where there is none.
fn by_gzip(stream: &[u8]) -> Option<Vec<u8>> {
    let child = Command::new("gzip")
        .arg("-dc")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn();
    let Ok(mut child) = child else {
        println!("skipped: gzip is not installed");
        return None;
    };
    let mut stdin = child.stdin.take().unwrap();
    let stream = stream.to_vec();
    let writer = std::thread::spawn(move || stdin.write_all(&stream));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success());
    Some(output.stdout)
}

/// Text of numbers, as in RINEX, from a multiplicative generator.
fn text(bytes: usize) -> Vec<u8> {
    let mut state = 1_u64;
    let mut out = Vec::new();
    while out.len() < bytes {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        out.extend(format!("{:14.3}\n", (state >> 40) as f64 * 1e-3).bytes());
    }
    out
}

#[test]
fn widths_grow_to_their_limit_and_tables_are_emptied() {
    let data = text(400_000);
    for (max_bits, clear_after) in [(16, usize::MAX), (12, usize::MAX), (16, 5_000), (9, 77)] {
        let stream = compress(&data, max_bits, clear_after);
        assert!(
            decoded(&stream).unwrap() == data,
            "{max_bits} bits, clear after {clear_after}"
        );
        if let Some(theirs) = by_gzip(&stream) {
            assert!(
                theirs == data,
                "gzip: {max_bits} bits, clear after {clear_after}"
            );
        }
    }
}

#[test]
fn observations_in_compress() {
    let mut rinex = Vec::new();
    for (content, label) in [
        (
            "     2.11           OBSERVATION DATA    G (GPS)",
            "RINEX VERSION / TYPE",
        ),
        ("     1    C1", "# / TYPES OF OBSERV"),
        ("", "END OF HEADER"),
    ] {
        rinex.extend(format!("{content:<60}{label}\n").bytes());
    }
    for second in 0..60 {
        rinex.extend(format!(" 26 11 21 12  0 {second:2}.0000000  0  1G07\n").bytes());
        rinex.extend(b"  20311445.258\n");
    }
    let stream = compress(&rinex, 16, usize::MAX);
    let file = read_gnss(&stream[..], Limits::default()).unwrap();
    assert_eq!(file.kind, FileKind::RinexObservation);
    assert_eq!(file.report.format, "RINEX 2.11 observation, compress");
    assert_eq!(file.observations.unwrap().epochs.len(), 60);
    // Cut off: what is whole is kept, and the cut is said.
    let cut = read_gnss(&stream[..stream.len() - 100], Limits::default()).unwrap();
    let epochs = cut.observations.unwrap().epochs.len();
    assert!((1..60).contains(&epochs), "{epochs}");
    // Damaged: refused or read, never a panic.
    for at in 3..stream.len() {
        let mut damaged = stream.clone();
        damaged[at] ^= 0x55;
        let _ = read_gnss(&damaged[..], Limits::default());
    }
    let small = Limits {
        max_bytes: 1000,
        ..Limits::default()
    };
    let answer = read_gnss(&stream[..], small);
    assert!(matches!(answer, Err(ReadError::Limit { .. })), "{answer:?}");
}
