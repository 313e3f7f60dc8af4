//! What each step of the cleaning is good for: the image without it.

use std::fmt::Write as _;

use acerra_chain::campaign::{Background, Campaign, Gate, ZeroTiming};
use acerra_products::Outcome;
use acerra_products::display::Shown;
use acerra_products::pictures;

use crate::flights::{Flight, flights};
use crate::page::Page;

/// What an image shows of the reflectors and of everything else.
struct Quality {
    /// Amplitude at the reflectors' place (their cell), mean of both.
    reflector: f64,
    /// Strongest pixel within a metre and a half along the track: how far from its reflector (m),
    /// mean of both.
    displaced_m: f64,
    /// Strongest amplitude away from the reflectors.
    strongest: f64,
    /// Median amplitude away from the reflectors.
    median: f64,
    /// Strongest amplitude along the edges of the image, beyond the range of the gate.
    edges: f64,
}

/// Pixels this far to the north or south are the edges.
const EDGE_M: f64 = 7.0;
/// Reflectors, their sidelobes and ghosts stay within this distance along the track.
const ALONG_M: f64 = 1.5;

fn quality(flight: &Flight, outcome: &Outcome) -> Quality {
    let grid = &outcome.focused.pixels.grid;
    let corners = &flight.flown.scene.corner;
    let mut near = vec![0.0_f64; corners.len()];
    let mut most = vec![(0.0_f64, 0.0_f64); corners.len()];
    let (mut strongest, mut edges) = (0.0_f64, 0.0_f64);
    let mut rest = Vec::new();
    for iy in 0..grid.ny {
        for ix in 0..grid.nx {
            let level = f64::from(outcome.focused.image[iy * grid.nx + ix].norm());
            let (x, y) = (grid.x_m(ix), grid.y_m(iy));
            let mut alone = true;
            for (k, corner) in corners.iter().enumerate() {
                let [dx, dy] = [x - corner.position_m[0], y - corner.position_m[1]];
                if dx.abs() <= 0.05 && dy.abs() <= 0.3 {
                    near[k] = near[k].max(level);
                }
                if dx.abs() <= ALONG_M {
                    alone = false;
                    if level > most[k].0 {
                        most[k] = (level, dx.hypot(dy));
                    }
                }
            }
            if alone {
                strongest = strongest.max(level);
                rest.push(level);
                if y.abs() > EDGE_M {
                    edges = edges.max(level);
                }
            }
        }
    }
    rest.sort_by(f64::total_cmp);
    let both = corners.len() as f64;
    Quality {
        reflector: near.iter().sum::<f64>() / both,
        displaced_m: most.iter().map(|m| m.1).sum::<f64>() / both,
        strongest,
        median: rest[rest.len() / 2],
        edges,
    }
}

fn db(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

type Change = fn(&mut Campaign);

const VARIANTS: [(&str, &str, Change); 5] = [
    ("all steps", "", |_| ()),
    ("without background removal", "background", |c| {
        c.preprocess.background = Some(Background::None);
    }),
    ("without gating", "gating", |c| {
        c.preprocess.gate_ns = Gate::None
    }),
    ("without either", "either", |c| {
        c.preprocess.background = Some(Background::None);
        c.preprocess.gate_ns = Gate::None;
    }),
    ("without zero-timing", "zero-timing", |c| {
        c.preprocess.zero_timing = Some(ZeroTiming::None);
    }),
];

#[test]
#[ignore = "ten images at full size; cargo xtask validate, as CI does"]
fn validation_book_steps() {
    let mut page = Page::open("steps.md");
    let mut text = String::from(
        "| | level at the reflectors (dB) | strongest within 1.5 m along track is off by (m) | \
         reflectors over strongest clutter (dB) | over its median (dB) | over the edges (dB) |\n\
         | --- | --- | --- | --- | --- | --- |\n",
    );
    for flight in flights() {
        let mut found = Vec::new();
        for (name, file, change) in VARIANTS {
            let outcome = flight.processed(change);
            let q = quality(flight, &outcome);
            // On Track 1 what is left out shows in the numbers, hardly to the eye.
            let visible = flight.track.name == "track-2" || file == "zero-timing";
            if visible && !file.is_empty() {
                let picture = pictures::image(&outcome, &Shown::of(&outcome)).unwrap();
                page.speckled_picture(&format!("{}-no-{file}", flight.track.name), &picture.png, 3);
            }
            found.push((name, q));
        }
        let whole = found[0].1.reflector;
        for (name, q) in &found {
            let _ = writeln!(
                text,
                "| {}, {name} | {:.1} | {:.2} | {:.1} | {:.1} | {:.0} |",
                flight.track.name.replace("track-", "Track "),
                db(q.reflector / whole),
                q.displaced_m,
                db(q.reflector / q.strongest),
                db(q.reflector / q.median),
                db(q.reflector / q.edges)
            );
        }
        let [all, no_background, no_gating, neither, no_timing] =
            [0, 1, 2, 3, 4].map(|k| &found[k].1);
        println!("{text}");
        // Awnings rise over the far parts of the image, coupling over all of it.
        let over_edges = |q: &Quality| db(q.reflector / q.edges);
        assert!(over_edges(all) - over_edges(no_gating) > 5.0);
        let over_median = |q: &Quality| db(q.reflector / q.median);
        assert!(over_median(all) - over_median(neither) > 5.0);
        assert!(over_median(no_gating) - over_median(neither) > 2.0);
        assert!(
            (over_median(all) - over_median(no_background)).abs() < 0.5,
            "gated all the same"
        );
        // With ranges half a dozen wavelengths too long nothing is where it was.
        assert!(all.displaced_m < 0.3 && no_timing.displaced_m > 3.0);
        assert!(db(no_timing.reflector / whole) < -25.0);
    }
    page.block("steps", &text);
    page.close();
}
