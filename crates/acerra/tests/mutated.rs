//! Real files with bits changed, cut, spliced and with blocks repeated: each is read or refused, without a panic, within
//! 300 MB.
//!
//! `MUTATED_FILES=100000 cargo test --release -p acerra --test mutated -- --nocapture` tries as many, each within 5 s, and
//! prints the slowest and the largest; `MUTATED_SEED` draws others.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures, and why a test is skipped

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use acerra::describe::describe;

/// Longest part of a real file that is mutated (bytes).
const MOST_BYTES: usize = 200_000;
const LONGEST_S: f64 = 5.0;
const MOST_MEMORY_BYTES: u64 = 300_000_000;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `bound`; 0 where that is 0.
    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }
}

/// The files of a folder and of the folders in it.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .collect();
    entries.sort_by_key(fs::DirEntry::path);
    for entry in entries {
        if entry.path().is_dir() {
            files(&entry.path(), found);
        } else {
            found.push(entry.path());
        }
    }
}

/// A file's content, unpacked where it is a gzip stream and the system has the program.
fn unpacked(path: PathBuf) -> (PathBuf, Vec<u8>) {
    if path.extension().is_some_and(|e| e == "gz")
        && let Ok(output) = Command::new("gzip").arg("-dc").arg(&path).output()
        && output.status.success()
    {
        return (path.with_extension(""), output.stdout);
    }
    let bytes = fs::read(&path).unwrap();
    (path, bytes)
}

/// Changes one to four places of a file; `other` gives the bytes that are spliced in.
fn mutate(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        match random.below(7) {
            0 => {
                for _ in 0..=random.below(16) {
                    let place = random.below(bytes.len());
                    if let Some(byte) = bytes.get_mut(place) {
                        *byte ^= 1 << random.below(8);
                    }
                }
            }
            1 => bytes.truncate(at),
            2 => {
                let from = random.below(other.len());
                let to = (from + random.below(4096)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
            3 => {
                let to = (at + random.below(2048)).min(bytes.len());
                let block = bytes[at..to].repeat(1 + random.below(64));
                bytes.splice(at..at, block);
            }
            4 => {
                let to = (at + random.below(1024)).min(bytes.len());
                bytes.drain(at..to);
            }
            5 => {
                // Extreme values where lengths and counts may be.
                let value = [0x00, 0xff, 0x7f, 0x80][random.below(4)];
                let to = (at + 1 + random.below(8)).min(bytes.len());
                bytes[at..to].fill(value);
            }
            _ => {
                // Extreme numbers of texts.
                let number: &[u8] =
                    [&b"1e308"[..], b"-1", b"nan", b"99999999999999999999", b""][random.below(5)];
                let to = (at + number.len()).min(bytes.len());
                bytes.splice(at..to, number.iter().copied());
            }
        }
    }
}

/// Largest memory of the process since the last call (bytes).
fn peak_memory_bytes() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .unwrap();
    let kilobytes: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    // Starts the count again, where the system allows it.
    let _ = fs::write("/proc/self/clear_refs", "5");
    kilobytes * 1024
}

fn number(variable: &str, default: u64) -> u64 {
    let text = std::env::var(variable).ok();
    text.map_or(default, |text| text.parse().unwrap())
}

#[test]
fn mutated_real_files_are_read_or_refused() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let mut paths = Vec::new();
    files(&data, &mut paths);
    if paths.is_empty() {
        println!("skipped: no measured data at {}", data.display());
        return;
    }
    let mut sources: BTreeMap<String, Vec<(PathBuf, Vec<u8>)>> = BTreeMap::new();
    for path in paths {
        let (path, mut bytes) = unpacked(path);
        bytes.truncate(MOST_BYTES);
        let kind = path
            .extension()
            .map_or("none".into(), |e| e.display().to_string());
        sources.entry(kind).or_default().push((path, bytes));
    }
    let sources: Vec<_> = sources.into_iter().collect();
    let folder = tempfile::tempdir().unwrap();
    let seed = number("MUTATED_SEED", 1);
    let mut slowest = (0.0, String::new());
    let mut largest = (0, String::new());
    let mut kinds: BTreeMap<String, [u64; 2]> = BTreeMap::new();
    let mut failures = Vec::new();
    // Beside other tests a time says little.
    let is_measured = std::env::var_os("MUTATED_FILES").is_some();
    for k in 0..number("MUTATED_FILES", 200) {
        let mut random = Random(seed.wrapping_mul(1 << 32).wrapping_add(k));
        // Kinds are drawn alike, however many files there are of each.
        let mut source = || {
            let (kind, files) = &sources[random.below(sources.len())];
            (kind, &files[random.below(files.len())])
        };
        let (kind, (path, bytes)) = source();
        let (_, (_, other)) = source();
        let mut bytes = bytes.clone();
        mutate(&mut bytes, other, &mut random);
        let name = path.file_name().unwrap();
        let mutated = folder.path().join(name);
        fs::write(&mutated, &bytes).unwrap();
        let label = format!("{k} of seed {seed}: {}", name.display());
        peak_memory_bytes();
        let start = Instant::now();
        let answer = catch_unwind(AssertUnwindSafe(|| describe(&mutated).is_ok()));
        let elapsed_s = start.elapsed().as_secs_f64();
        let memory_bytes = peak_memory_bytes();
        if slowest.0 < elapsed_s {
            slowest = (elapsed_s, label.clone());
        }
        if largest.0 < memory_bytes {
            largest = (memory_bytes, label.clone());
        }
        match answer {
            Ok(is_read) => kinds.entry(kind.clone()).or_default()[usize::from(is_read)] += 1,
            Err(_) => failures.push(format!("{label}: panic")),
        }
        if (is_measured && elapsed_s > LONGEST_S) || memory_bytes > MOST_MEMORY_BYTES {
            failures.push(format!("{label}: {elapsed_s:.1} s, {memory_bytes} bytes"));
        }
        fs::remove_file(&mutated).unwrap();
    }
    for (kind, [refused, read]) in &kinds {
        println!("{kind}: {read} read, {refused} refused");
    }
    println!("slowest {:.2} s, {}", slowest.0, slowest.1);
    println!("largest {} MB, {}", largest.0 / 1_000_000, largest.1);
    assert_eq!(failures, [""; 0]);
}
