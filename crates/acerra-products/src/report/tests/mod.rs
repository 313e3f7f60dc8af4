//! Tests of the pages' content and markup.

mod content;
mod markup;
mod positioning;
mod sample;

use positioning::simulated_run;
use sample::{findings, full};

use super::*;

/// For looking at: ACERRA_FIGURES=/some/dir cargo test -p acerra report
fn keep(name: &str, html: &str) {
    if let Ok(dir) = std::env::var("ACERRA_FIGURES") {
        std::fs::write(format!("{dir}/{name}.html"), html).unwrap();
    }
}
