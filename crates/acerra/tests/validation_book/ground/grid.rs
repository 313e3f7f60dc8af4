//! A grid of lines over burials in three dimensions, simulated by gprMax (`docs/validation/ground-3d`).

use std::fmt::Write as _;
use std::path::Path;

use acerra_chain::campaign::Campaign;
use acerra_chain::{Control, Journal, MemorySink};
use acerra_products::{NamedCampaign, Outcome, process};

use super::scene::{DEPTH_SHARE, LATERAL_M};

/// A buried object.
struct Burial {
    kind: &'static str,
    /// Middle (m).
    x_m: f64,
    y_m: f64,
    z_m: f64,
    /// Height of the near side, where the wave is reflected first (m).
    near_z_m: f64,
}

const BURIALS: [Burial; 4] = [
    sphere([0.30, 0.30, -0.10]),
    sphere([0.50, 0.35, -0.15]),
    sphere([0.56, 0.56, -0.12]),
    Burial {
        kind: "plastic disk",
        x_m: 0.36,
        y_m: 0.54,
        z_m: -0.075,
        near_z_m: -0.05,
    },
];

const fn sphere([x_m, y_m, z_m]: [f64; 3]) -> Burial {
    Burial {
        kind: "metal sphere",
        x_m,
        y_m,
        z_m,
        near_z_m: z_m + 0.03,
    }
}

/// The image of the scene with the ground stated as it is.
pub fn run() -> Outcome {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/validation/ground-3d");
    let text = std::fs::read_to_string(folder.join("burials.toml")).unwrap();
    let campaign = NamedCampaign {
        name: "burials".to_owned(),
        campaign: Campaign::parse(&text).unwrap().resolved_in(&folder),
    };
    process(
        campaign,
        &mut MemorySink::default(),
        &mut Journal::default(),
        &Control::default(),
    )
    .unwrap()
}

/// The table of the burials: where each was found, and the other targets that exceed the clutter.
pub fn table(outcome: &Outcome) -> String {
    let mut text = "| burial | x, y (m) | near side, depth (m) | target, off across (m) | depth (m) | level (dB) | exceeds \
                    the clutter |\n| --- | --- | --- | --- | --- | --- | --- |\n"
        .to_owned();
    let targets = outcome.measured.targets.iter();
    let mut left: Vec<_> = targets
        .zip(outcome.exceeds_clutter.iter().copied())
        .collect();
    let mut found = 0;
    for burial in &BURIALS {
        let off = |x_m: f64, y_m: f64| (x_m - burial.x_m).hypot(y_m - burial.y_m);
        let fits = left.iter().position(|(target, _)| {
            off(target.x_m, target.y_m) <= LATERAL_M
                && (target.z_m - burial.near_z_m).abs() <= -DEPTH_SHARE * burial.z_m
        });
        let place = format!(
            "| {} | {:.2}, {:.2} | {:.3} |",
            burial.kind, burial.x_m, burial.y_m, -burial.near_z_m
        );
        let _ = match fits.map(|k| left.remove(k)) {
            Some((target, exceeds)) => {
                found += 1;
                let across_m = off(target.x_m, target.y_m);
                let level_db = target.level_db;
                let said = if exceeds { "yes" } else { "no" };
                writeln!(
                    text,
                    "{place} {across_m:.3} | {:.3} | {level_db:.1} | {said} |",
                    -target.z_m
                )
            }
            None => writeln!(text, "{place} – | – | – | – |"),
        };
    }
    let others = left.iter().filter(|(_, exceeds)| *exceeds).count();
    let _ = writeln!(text, "| others | | | | | | {others} of {} |", left.len());
    println!("{text}");
    assert!(found >= 3 && others <= 1, "{found} found, {others} others");
    text
}
