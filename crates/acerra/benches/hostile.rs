//! Time and memory of files of 20 MB that are made to cost much.
//!
//! `cargo bench -p acerra --bench hostile` writes each file to the folder of temporary files and prints a table of the
//! processor time and memory of `acerra info`: any such file is to be answered or refused within 5 s and 300 MB. Rows beyond that are marked.
//! `megabytes=5` writes shorter files.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::fs;
use std::path::Path;

use acerra::describe::describe;

const LONGEST_S: f64 = 5.0;
const MOST_BYTES: u64 = 300_000_000;

/// A line of a RINEX header.
fn header(text: &str, label: &str) -> String {
    format!("{text:<60}{label:<20}\n")
}

/// The header of observations, with one type of observation.
fn rinex(version: u8) -> String {
    let (types, label) = match version {
        2 => ("     1    C1", "# / TYPES OF OBSERV"),
        _ => ("G    1 C1C", "SYS / # / OBS TYPES"),
    };
    let first = "  2020    01    01    00    00    0.0000000     GPS";
    [
        header(
            &format!("     {version}.00           OBSERVATION DATA    M"),
            "RINEX VERSION / TYPE",
        ),
        header(types, label),
        header(first, "TIME OF FIRST OBS"),
        header("", "END OF HEADER"),
    ]
    .concat()
}

fn compact_rinex() -> String {
    let version = header(
        "3.0                 COMPACT RINEX FORMAT",
        "CRINEX VERS   / TYPE",
    );
    version + &header("x", "CRINEX PROG / DATE") + &rinex(3)
}

/// A file: what it begins with, and the `k`-th part of what follows.
struct File {
    name: &'static str,
    head: Vec<u8>,
    part: fn(u64) -> Vec<u8>,
}

fn file(name: &'static str, head: impl Into<Vec<u8>>, part: fn(u64) -> Vec<u8>) -> File {
    let head = head.into();
    File { name, head, part }
}

/// A UBX message with its checksum.
fn ubx(class: u8, id: u8, payload: &[u8]) -> Vec<u8> {
    acerra_gnss::ubx::frame::encode(class, id, payload).unwrap()
}

/// RXM-RAWX of one satellite.
fn rawx(k: u64) -> Vec<u8> {
    let mut payload = (k as f64 * 0.05).to_le_bytes().to_vec();
    payload.extend(2200_u16.to_le_bytes());
    payload.extend([18, 1, 1, 1, 0, 0]);
    payload.extend(2.1e7_f64.to_le_bytes());
    payload.extend(1.1e8_f64.to_le_bytes());
    payload.extend([0, 0, 0, 0, 0, 1, 0, 0, 96, 234, 45, 1, 1, 1, 7, 0]);
    ubx(0x02, 0x15, &payload)
}

/// A ULog message.
fn ulog(kind: u8, payload: &[u8]) -> Vec<u8> {
    let mut message = (payload.len() as u16).to_le_bytes().to_vec();
    message.push(kind);
    message.extend(payload);
    message
}

fn ulog_head() -> Vec<u8> {
    let mut head = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
    head.extend(ulog(b'B', &[0; 40]));
    head.extend(ulog(
        b'F',
        b"vehicle_gps_position:uint64_t timestamp;int32_t lat;int32_t lon;int32_t alt;uint64_t time_utc_usec;\
          uint8_t fix_type;",
    ));
    head.extend(ulog(b'A', b"\0\0\0vehicle_gps_position"));
    head
}

fn ulog_position(k: u64) -> Vec<u8> {
    let mut payload = vec![0, 0];
    payload.extend((k * 100_000).to_le_bytes());
    for value in [470_000_000 + k as i32, 80_000_000, 100_000] {
        payload.extend(value.to_le_bytes());
    }
    payload.extend((1_600_000_000_000_000 + k * 100_000).to_le_bytes());
    payload.push(6);
    ulog(b'D', &payload)
}

fn dzt_head() -> Vec<u8> {
    let mut head = vec![0; 1024];
    for (at, value) in [(0, 0xff_u16), (2, 1), (4, 2), (6, 8), (8, 3), (52, 1)] {
        head[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    head[10..14].copy_from_slice(&20.0_f32.to_le_bytes());
    head[26..30].copy_from_slice(&50.0_f32.to_le_bytes());
    head
}

fn segy_head() -> Vec<u8> {
    let mut head = vec![b' '; 3200];
    head.extend([0; 400]);
    for (at, value) in [(3216, 100_u16), (3220, 2), (3224, 8)] {
        head[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    head
}

fn segy_trace(_: u64) -> Vec<u8> {
    let mut trace = vec![0; 242];
    trace[3] = 1;
    trace[12] = 1;
    trace[114] = 2;
    trace
}

fn gga(k: u64) -> Vec<u8> {
    let clock = format!("{:02}{:02}{:02}", k / 3600 % 24, k / 60 % 60, k % 60);
    let body = format!("GPGGA,{clock},47,N,8,E,4,10,1,1,M,4,M,,");
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

fn files() -> Vec<File> {
    let bytes = |bytes: &[u8]| bytes.to_vec();
    vec![
        file(
            "RTCM 3, messages of 1 kB at every third byte",
            bytes(b""),
            |_| vec![0xD3, 0x03, 0xFF],
        ),
        file("RTCM 3, empty messages", bytes(b""), |_| vec![0xD3, 0, 0]),
        file("UBX, a satellite an epoch", bytes(b""), |k| {
            rawx(k % 10_000_000)
        }),
        file("UBX, messages cut off", ubx(1, 7, &[0; 92]), |_| {
            vec![0xB5, 0x62, 2, 0x15, 0, 0x20]
        }),
        file("RINEX 3, a satellite an epoch", rinex(3), |k| {
            format!(
                "> 2020 01 01 {:02} {:02} {:10.7}  0  1\nG01             1\n",
                k / 3600 % 24,
                k / 60 % 60,
                (k % 60) as f64
            )
            .into_bytes()
        }),
        file("RINEX 3, the same epoch", rinex(3), |_| {
            b"> 2020 01 01 00 00  0.0000000  0  1\nG01             1\n".to_vec()
        }),
        file("RINEX 2, a satellite an epoch", rinex(2), |k| {
            format!(
                " 20 01 01 {:02} {:02} {:10.7}  0  1G01\n             1\n",
                k / 3600 % 24,
                k / 60 % 60,
                (k % 60) as f64
            )
            .into_bytes()
        }),
        file("Hatanaka, the same epoch", compact_rinex(), |_| {
            b"> 2020 01 01 00 00  0.0000000  0  1      G01\n\n3&1\n".to_vec()
        }),
        file("Hatanaka, empty lines", compact_rinex(), |_| vec![b'\n']),
        file("CSV, short rows", bytes(b"time_s,x_m,y_m,z_m\n"), |k| {
            format!("{k},1,1,1\n").into_bytes()
        }),
        file("CSV, backwards", bytes(b"time_s,x_m,y_m,z_m\n"), |k| {
            format!("{},1,1,1\n", 9_999_999 - k % 9_000_000).into_bytes()
        }),
        file("NMEA, short sentences", bytes(b""), gga),
        file("ULog, positions alone", ulog_head(), ulog_position),
        file("ULog, zeros", ulog_head(), |_| vec![0]),
        file("ULog, data of no topic", ulog_head(), |_| {
            ulog(b'D', &[5, 0])
        }),
        file("DZT, two samples a trace", dzt_head(), |_| vec![0]),
        file("SEG-Y, two samples a trace", segy_head(), segy_trace),
        file("HDF5, signatures", bytes(b""), |_| {
            b"\x89HDF\r\n\x1a\n".to_vec()
        }),
        file(
            "MCAP, empty records",
            bytes(b"\x89MCAP0\r\n\x01\x08\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"),
            |_| vec![0; 9],
        ),
        file(
            "ASCII grid",
            bytes(b"ncols 5000\nnrows 2000\nxllcorner 0\nyllcorner 0\ncellsize 1\n"),
            bytes_of_row,
        ),
    ]
}

fn bytes_of_row(k: u64) -> Vec<u8> {
    if k.is_multiple_of(5000) {
        b"1\n".to_vec()
    } else {
        b"1 ".to_vec()
    }
}

/// Memory of the process by the line `name` of its status (bytes; Linux).
fn memory_bytes(name: &str) -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(name));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}

/// Processor time of all threads so far, s (Linux).
fn processor_time_s() -> f64 {
    fs::read_dir("/proc/self/task")
        .unwrap()
        .flatten()
        .filter_map(|t| fs::read_to_string(t.path().join("schedstat")).ok())
        .filter_map(|s| s.split(' ').next()?.parse::<f64>().ok())
        .sum::<f64>()
        * 1e-9
}

fn write(path: &Path, file: &File, length: usize) {
    let mut content = file.head.clone();
    let mut k = 0;
    while content.len() < length {
        content.extend((file.part)(k));
        k += 1;
    }
    fs::write(path, content).unwrap();
}

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let megabytes = std::env::args()
        .find_map(|a| a.strip_prefix("megabytes=")?.parse::<usize>().ok())
        .unwrap_or(20);
    let folder = tempfile::tempdir().unwrap();
    println!("| file of {megabytes} MB | s | MB | answer |");
    println!("| --- | --- | --- | --- |");
    for file in files() {
        let path = folder.path().join("hostile");
        write(&path, &file, megabytes * 1_000_000);
        // Starts the count of the largest memory again, where the system allows it.
        let _ = fs::write("/proc/self/clear_refs", "5");
        let memory_before_bytes = memory_bytes("VmRSS");
        let start_s = processor_time_s();
        let answer = describe(&path);
        let elapsed_s = processor_time_s() - start_s;
        let memory_bytes = memory_bytes("VmHWM").saturating_sub(memory_before_bytes);
        let answer = match answer {
            Ok(description) => description.kind,
            Err(error) => format!("{error:#}"),
        };
        let answer = answer.replace(&path.display().to_string(), "");
        let answer: String = answer.chars().take(90).collect();
        let beyond = if elapsed_s > LONGEST_S || memory_bytes > MOST_BYTES {
            " **beyond**"
        } else {
            ""
        };
        println!(
            "| {} | {elapsed_s:.2}{beyond} | {} | {answer} |",
            file.name,
            memory_bytes / 1_000_000
        );
    }
}
