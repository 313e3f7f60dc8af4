//! Reading of files with samples of 16 bits: SEG-Y, DZT, DT1 and rd3.
//!
//! `cargo bench -p acerra-formats --bench reading` writes a file of each format with 128 MiB of samples to the folder of
//! temporary files and prints the megabytes a second of processor time at which `open` reads it, files in the system's
//! memory, best of three runs. `megabytes=1024` writes larger files, and `cut` takes an odd byte off the end of
//! each and prints what was skipped or why the file was refused.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use acerra_formats::{Limits, open};

const SAMPLES: usize = 512;
const RUNS: usize = 3;

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let megabytes = std::env::args()
        .find_map(|a| a.strip_prefix("megabytes=")?.parse::<usize>().ok())
        .unwrap_or(128);
    let is_cut = std::env::args().any(|a| a == "cut");
    let traces = (megabytes << 20) / (2 * SAMPLES);
    println!("| format | file (MB) | MB a processor second | found |");
    println!("| --- | --- | --- | --- |");
    let makers: [(&str, Maker); 4] = [("SEG-Y", segy), ("DZT", dzt), ("DT1", dt1), ("rd3", mala)];
    for (name, make) in makers {
        let folder = tempfile::tempdir().unwrap();
        let path = make(folder.path(), traces);
        let bytes = fs::metadata(&path).unwrap().len();
        if is_cut {
            let file = fs::File::options().write(true).open(&path).unwrap();
            file.set_len(bytes - 1).unwrap();
        }
        let mut best_s = f64::INFINITY;
        let mut found = String::new();
        for _ in 0..RUNS {
            let start_s = processor_time_s();
            let read = open(&path, &Limits::default());
            best_s = best_s.min(processor_time_s() - start_s);
            found = match read {
                Ok(read) => format!(
                    "{} traces, {} bytes skipped",
                    read.channels[0].traces, read.skipped_bytes
                ),
                Err(error) => error.to_string(),
            };
        }
        let megabytes = bytes as f64 * 1e-6;
        println!(
            "| {name} | {megabytes:.0} | {:.0} | {found} |",
            megabytes / best_s
        );
    }
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

/// Writes a file of so many traces to a folder.
type Maker = fn(&Path, usize) -> PathBuf;

/// Writes `head`, then every trace after its own header.
fn write(path: PathBuf, head: &[u8], traces: usize, header: impl Fn(usize) -> Vec<u8>) -> PathBuf {
    let mut file = BufWriter::with_capacity(1 << 20, fs::File::create(&path).unwrap());
    file.write_all(head).unwrap();
    for trace in 0..traces {
        file.write_all(&header(trace)).unwrap();
        let sample = |k: usize| (((trace * 31 + k * 7) % 4001) as i16 - 2000).to_le_bytes();
        let samples: Vec<u8> = (0..SAMPLES).flat_map(sample).collect();
        file.write_all(&samples).unwrap();
    }
    file.flush().unwrap();
    path
}

/// Little-endian, as many radars write it.
fn segy(folder: &Path, traces: usize) -> PathBuf {
    let mut head = vec![b' '; 3200];
    head.extend([0; 400]);
    for (at, value) in [(3216, 100u16), (3220, SAMPLES as u16), (3224, 3)] {
        head[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    let header = |trace: usize| {
        let mut header = vec![0; 240];
        header[..4].copy_from_slice(&(trace as i32 + 1).to_le_bytes());
        header[12..16].copy_from_slice(&1i32.to_le_bytes());
        header[72..76].copy_from_slice(&(trace as i32).to_le_bytes());
        header[114..116].copy_from_slice(&(SAMPLES as u16).to_le_bytes());
        header
    };
    write(folder.join("line.sgy"), &head, traces, header)
}

fn dzt(folder: &Path, traces: usize) -> PathBuf {
    let mut head = vec![0u8; 1024];
    for (at, value) in [
        (0, 0xffu16),
        (2, 1),
        (4, SAMPLES as u16),
        (6, 16),
        (8, 3),
        (52, 1),
    ] {
        head[at..at + 2].copy_from_slice(&value.to_le_bytes());
    }
    head[10..14].copy_from_slice(&20.0f32.to_le_bytes());
    head[26..30].copy_from_slice(&50.0f32.to_le_bytes());
    write(folder.join("line.dzt"), &head, traces, |_| Vec::new())
}

fn dt1(folder: &Path, traces: usize) -> PathBuf {
    let hd = format!(
        "1234\nGPR\nNUMBER OF TRACES   = {traces}\nNUMBER OF PTS/TRC  = {SAMPLES}\nTIMEZERO AT POINT  = 2\n\
         TOTAL TIME WINDOW  = 100\nSTEP SIZE USED     = 0.05\nPOSITION UNITS     = m\n"
    );
    fs::write(folder.join("line.HD"), hd).unwrap();
    let header = |trace: usize| {
        let mut header = [0.0f32; 32];
        header[0] = trace as f32 + 1.0;
        header[1] = trace as f32 * 0.05;
        header[2] = SAMPLES as f32;
        header[5] = 2.0;
        header.iter().flat_map(|x| x.to_le_bytes()).collect()
    };
    write(folder.join("line.DT1"), &[], traces, header)
}

fn mala(folder: &Path, traces: usize) -> PathBuf {
    let rad = format!(
        "SAMPLES:{SAMPLES}\nFREQUENCY:2000.0\nSIGNAL POSITION:0\nDISTANCE FLAG:1\nTIME FLAG:0\nTIME INTERVAL:0.1\n\
         DISTANCE INTERVAL:0.05\nTIMEWINDOW:256.0\nLAST TRACE:{traces}\n"
    );
    fs::write(folder.join("line.rad"), rad).unwrap();
    write(folder.join("line.rd3"), &[], traces, |_| Vec::new())
}
