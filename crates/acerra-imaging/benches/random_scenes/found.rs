//! What images and echoes keep of their promises.

use acerra_imaging::SimdLevel;
use std::collections::BTreeMap;

/// What an image kept of its promise.
pub struct Found {
    pub number: u64,
    pub level: SimdLevel,
    pub kind: String,
    pub engine: &'static str,
    pub accuracy: f64,
    pub error: f64,
    /// Where the error is.
    pub worst: String,
    pub report: String,
}

pub fn tell(found: &[Found], scenes: u64) {
    let broken = found.iter().filter(|f| f.error > f.accuracy).count();
    println!(
        "{scenes} scenes, {} images, {broken} broken promises",
        found.len()
    );
    println!("| engine, level | images | broken | median error / promise | largest |");
    println!("| --- | --- | --- | --- | --- |");
    let mut groups: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for f in found {
        let name = format!("{}, {}", f.engine, f.level);
        groups.entry(name).or_default().push(f.error / f.accuracy);
    }
    for (name, mut shares) in groups {
        shares.sort_by(f64::total_cmp);
        let broken = shares.iter().filter(|s| **s > 1.0).count();
        println!(
            "| {name} | {} | {broken} | {:.2} | {:.2} |",
            shares.len(),
            shares[shares.len() / 2],
            shares[shares.len() - 1]
        );
    }
}
