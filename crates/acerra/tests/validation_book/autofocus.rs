//! What an autofocus gains on the campaign's flights, with fixed and with float positions.

use std::fmt::Write as _;

use acerra_chain::Focused;
use acerra_chain::autofocus::{Decision, PathCorrection};
use acerra_products::Outcome;

use crate::flights::{Flight, flights};
use crate::page::Page;
use crate::positions::unfixed;

/// How far from a reflector its peak may stand (m).
const REACH_M: f64 = 1.2;
/// Loss of a reflector's peak that counts as harm (dB).
const HARM_DB: f64 = 0.1;

#[test]
#[ignore = "four images at full size; cargo xtask validate, as CI does"]
fn validation_book_autofocus() {
    let mut page = Page::open("autofocus.md");
    let here = tempfile::tempdir().unwrap();
    let mut table = String::from(
        "| flight | points | gain of points left out (dB) | became | reflectors' peaks (dB) | slant error (mm) | \
         reflectors off (m) |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for flight in flights() {
        let fixed = flight.processed(|campaign| campaign.autofocus.enabled = true);
        let unfixed = unfixed(here.path());
        let float = flight.processed(|campaign| {
            campaign.autofocus.enabled = true;
            unfixed(campaign);
        });
        for (kind, outcome) in [("fixed", fixed), ("float", float)] {
            row(&mut table, flight, kind, &outcome);
        }
    }
    println!("{table}");
    page.block("flights", &table);
    page.close();
}

fn row(table: &mut String, flight: &Flight, kind: &str, outcome: &Outcome) {
    let correction = outcome.prepared.correction.as_ref().unwrap();
    let found = &correction.found;
    let before = outcome.uncorrected.as_ref().unwrap_or(&outcome.focused);
    let of = |image: &Focused| -> Vec<Peak> {
        let corners = flight.flown.scene.corner.iter();
        corners.map(|c| peak_near(image, c.position_m)).collect()
    };
    let (stated, corrected) = (of(before), of(&outcome.focused));
    let gain_db = |(a, b): (&Peak, &Peak)| 20.0 * (b.level / a.level).log10();
    let gains_db: Vec<f64> = stated.iter().zip(&corrected).map(gain_db).collect();
    assert!(gains_db.iter().all(|g| *g > -HARM_DB), "{gains_db:?}");
    let gains: Vec<String> = gains_db.iter().map(|g| format!("{g:+.1}")).collect();
    let slant = slant_errors_mm(flight, correction, outcome);
    let pair = |v: [f64; 2]| format!("{:.1} → {:.1}", v[0], v[1]);
    let slant: Vec<String> = slant.into_iter().map(pair).collect();
    let off = |(a, b): (&Peak, &Peak)| format!("{:.2} → {:.2}", a.off_m, b.off_m);
    let off: Vec<String> = stated.iter().zip(&corrected).map(off).collect();
    let track = flight.track.name.replace("track-", "Track ");
    let _ = writeln!(
        table,
        "| {track}, {kind} | {} | {:.2} ± {:.2} | {} | {} | {} | {} |",
        found.points.len(),
        found.gain_db,
        found.gain_sigma_db,
        became(found.decision, found.ghosts),
        gains.join(", "),
        slant.join(", "),
        off.join(", "),
    );
}

/// A peak's amplitude, and how far from its reflector it stands.
struct Peak {
    level: f64,
    off_m: f64,
}

fn became(decision: Decision, ghosts: usize) -> &'static str {
    match decision {
        Decision::Applied if ghosts > 0 => "applied, doubtful: ghosts",
        Decision::Applied => "applied",
        Decision::NotSignificant => "as stated: not significant",
        Decision::LonePoint => "as stated: a single point",
        Decision::Worsens => "as stated: a point is weaker",
        Decision::AgainstPrior => "as stated: against the prior",
        _ => "as stated: no points",
    }
}

fn peak_near(focused: &Focused, at_m: [f64; 3]) -> Peak {
    let grid = &focused.pixels.grid;
    let mut best = Peak {
        level: 0.0,
        off_m: f64::NAN,
    };
    for j in 0..grid.ny {
        for i in 0..grid.nx {
            let off_m = (grid.x_m(i) - at_m[0]).hypot(grid.y_m(j) - at_m[1]);
            let level = f64::from(focused.image[j * grid.nx + i].norm());
            if off_m <= REACH_M && level > best.level {
                best = Peak { level, off_m };
            }
        }
    }
    best
}

/// Rms of the range error to each reflector after removing mean and trend, as stated and corrected (mm).
fn slant_errors_mm(
    flight: &Flight,
    correction: &PathCorrection,
    outcome: &Outcome,
) -> Vec<[f64; 2]> {
    let corrected = &outcome.prepared.aligned.position_m;
    let of = |position_m: &[[f64; 3]], at_m: [f64; 3]| {
        let range = |p: &[f64; 3]| (0..3).map(|i| (p[i] - at_m[i]).powi(2)).sum::<f64>().sqrt();
        let pairs = position_m.iter().zip(&flight.flown.truth_m);
        let error: Vec<f64> = pairs.map(|(p, q)| range(p) - range(q)).collect();
        1e3 * rms_about_trend(&error)
    };
    let corners = flight.flown.scene.corner.iter().map(|c| c.position_m);
    corners
        .map(|at_m| [of(&correction.stated_m, at_m), of(corrected, at_m)])
        .collect()
}

fn rms_about_trend(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let centre = 0.5 * (count - 1.0);
    let mean = values.iter().sum::<f64>() / count;
    let (mut square, mut cross) = (0.0, 0.0);
    for (i, v) in values.iter().enumerate() {
        square += (i as f64 - centre).powi(2);
        cross += (i as f64 - centre) * v;
    }
    let left = |(i, v): (usize, &f64)| (v - mean - cross / square * (i as f64 - centre)).powi(2);
    (values.iter().enumerate().map(left).sum::<f64>() / count).sqrt()
}
