//! Helpers of the integration tests.

#![allow(clippy::unwrap_used, clippy::print_stdout, dead_code)] // each test file uses some of them

use acerra_radar::{Filtering, Scan, ScanWindow};

/// Real data beside the project, or `None` (with the reason printed) where it is absent.
pub fn shared(path: &str) -> Option<Vec<u8>> {
    let path = format!("{}/../../../shared/data/{path}", env!("CARGO_MANIFEST_DIR"));
    match std::fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(e) => {
            println!("skipped: {path}: {e}");
            None
        }
    }
}

/// Scan `i` of a synthetic flight: `samples` numbers that tell scan and sample apart.
pub fn scan(i: usize, samples: usize) -> Scan {
    let start_ps = 16_670;
    Scan {
        source_id: 100,
        message_id: i as u16,
        timestamp_ms: (570_444.3 + 21.573 * i as f64) as u32,
        host_time_s: None,
        window: ScanWindow {
            start_ps,
            stop_ps: start_ps + (samples as f64 * 61.035_156_25) as i32,
            step_bins: 32,
            samples,
        },
        filtering: Filtering::Raw,
        antenna_id: 2,
        operation_mode: 1,
        samples: (0..samples as i32)
            .map(|j| j * 7919 - 1_000_003 * i as i32)
            .collect(),
    }
}

/// `count` such scans.
pub fn scans(count: usize, samples: usize) -> Vec<Scan> {
    (0..count).map(|i| scan(i, samples)).collect()
}
