//! What an autofocus gains on the campaign's flights, with fixed, float and single-point positions.

use std::fmt::Write as _;
use std::path::Path;

use acerra_chain::campaign::{Campaign, Files};
use acerra_chain::correction::PathCorrection;
use acerra_chain::focus::Focused;
use acerra_products::Outcome;

use crate::flights::{Flight, flights};
use crate::page::Page;

/// Positions of a kind, with the deviations of an error that they have throughout (m).
struct Kind {
    name: &'static str,
    /// RTKLIB configuration that makes them; none for the fixed ones of the demonstration.
    conf: Option<&'static str>,
    shift_sigma_m: [f64; 3],
    /// How far from a reflector its peak may stand (m).
    reach_m: f64,
}

const KINDS: [Kind; 3] = [
    Kind {
        name: "fixed",
        conf: None,
        shift_sigma_m: [0.0; 3],
        reach_m: 0.9,
    },
    Kind {
        name: "float",
        conf: Some("pos1-posmode=kinematic\npos2-armode=off\n"),
        shift_sigma_m: [0.4, 0.4, 0.6],
        reach_m: 1.5,
    },
    Kind {
        name: "single-point",
        conf: Some("pos1-posmode=single\n"),
        shift_sigma_m: [2.0, 2.0, 4.0],
        reach_m: 4.0,
    },
];

#[test]
#[ignore = "six images with autofocus; cargo xtask validate, as CI does"]
fn validation_book_autofocus() {
    let mut page = Page::open("autofocus.md");
    let here = tempfile::tempdir().unwrap();
    let mut table = String::from(
        "| flight | points | gain of points left out (dB) | became | reflectors' peaks (dB) | slant error (mm) | \
         reflectors off (m) |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for flight in flights() {
        for kind in &KINDS {
            let outcome = flight.processed(|campaign| kind.set(campaign, here.path()));
            row(&mut table, flight, kind, &outcome);
        }
    }
    println!("{table}");
    page.block("flights", &table);
    page.close();
}

impl Kind {
    /// Has a campaign use such positions, with an autofocus.
    fn set(&self, campaign: &mut Campaign, here: &Path) {
        campaign.autofocus.enabled = true;
        campaign.autofocus.track_shift_sigma_m = self.shift_sigma_m;
        let Some(conf) = self.conf else {
            return;
        };
        let path = here.join(format!("{}.conf", self.name));
        let common = "pos1-frequency=l1\npos1-soltype=combined\nstats-eratio1=300\n";
        std::fs::write(&path, format!("{conf}{common}")).unwrap();
        let gnss = campaign.gnss.as_mut().unwrap();
        gnss.config = Some(path);
        if self.name == "single-point" {
            gnss.base = Files(Vec::new());
            gnss.base_ecef_m = None;
        }
    }
}

fn row(table: &mut String, flight: &Flight, kind: &Kind, outcome: &Outcome) {
    let correction = outcome.prepared.correction.as_ref().unwrap();
    let found = &correction.found;
    let before = outcome.uncorrected.as_ref().unwrap_or(&outcome.focused);
    let of = |image: &Focused| -> Vec<Peak> {
        let corners = flight.flown.scene.corner.iter();
        corners
            .map(|c| peak_near(image, c.position_m, kind.reach_m))
            .collect()
    };
    let (stated, corrected) = (of(before), of(&outcome.focused));
    let decibels = |(a, b): (&Peak, &Peak)| format!("{:+.1}", 20.0 * (b.level / a.level).log10());
    let gains: Vec<String> = stated.iter().zip(&corrected).map(decibels).collect();
    let slant = slant_errors_mm(flight, correction, outcome);
    let pair = |v: [f64; 2]| format!("{:.1} → {:.1}", v[0], v[1]);
    let slant: Vec<String> = slant.into_iter().map(pair).collect();
    let off = |(a, b): (&Peak, &Peak)| format!("{:.2} → {:.2}", a.off_m, b.off_m);
    let off: Vec<String> = stated.iter().zip(&corrected).map(off).collect();
    let track = flight.track.name.replace("track-", "Track ");
    let _ = writeln!(
        table,
        "| {track}, {} | {} | {:.2} ± {:.2} | {:?} | {} | {} | {} |",
        kind.name,
        found.points.len(),
        found.gain_db,
        found.gain_sigma_db,
        found.decision,
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

fn peak_near(focused: &Focused, at_m: [f64; 3], reach_m: f64) -> Peak {
    let grid = &focused.pixels.grid;
    let mut best = Peak {
        level: 0.0,
        off_m: f64::NAN,
    };
    for j in 0..grid.ny {
        for i in 0..grid.nx {
            let off_m = (grid.x_m(i) - at_m[0]).hypot(grid.y_m(j) - at_m[1]);
            let level = f64::from(focused.image[j * grid.nx + i].norm());
            if off_m <= reach_m && level > best.level {
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
