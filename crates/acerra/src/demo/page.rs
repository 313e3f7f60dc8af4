//! The page over both tracks.

use std::path::Path;

use acerra_imaging::resolution::displacement_m;
use anyhow::Context;

use super::{Flown, Found, Track, rms_m};
use acerra_products::report::{ComparisonTable, Fact, IndexEntry, IndexPage, index_page};

/// Writes the page over the tracks whose folders lie in `directory`.
///
/// # Errors
/// Products that are not where they should be.
pub fn demonstration_page(flights: &[(Track, &Flown)], directory: &Path) -> anyhow::Result<String> {
    let entries = flights
        .iter()
        .map(|(track, flown)| entry(track, flown, directory))
        .collect::<anyhow::Result<_>>()?;
    Ok(index_page(&IndexPage {
        title: "The paper's campaign, simulated and processed".to_owned(),
        summary: "Two trihedral reflectors 10 m apart, overflown twice by a small drone with a P440 radar \
                  and a single-frequency GNSS receiver. The logs were simulated as the instruments would \
                  have written them, from before take-off to after landing; the chain that processed them \
                  found the offset between their clocks from the climbs, and was given the values measured \
                  on site: the base's position, the lever arm, and the height of the ground."
            .to_owned(),
        entries,
        tables: vec![places(flights), resolutions(flights), positions(flights)],
        remarks: remarks(flights),
    }))
}

fn entry(track: &Track, flown: &Flown, directory: &Path) -> anyhow::Result<IndexEntry> {
    let outcome = &flown.outcome;
    let png = directory.join(track.name).join("products/image.png");
    Ok(IndexEntry {
        title: track.title.to_owned(),
        report: format!("{}/products/report.html", track.name),
        png: std::fs::read(&png).with_context(|| format!("{}", png.display()))?,
        facts: vec![
            Fact::new("Traces", outcome.prepared.aligned.traces.len().to_string()),
            Fact::new("At fixed positions", flown.fixed().to_string()),
            Fact::new("Targets", outcome.measured.targets.len().to_string()),
        ],
        warnings: outcome.warnings.len(),
    })
}

/// The part of a track's title before the colon.
fn short(track: &Track) -> &str {
    track.title.split(':').next().unwrap_or(track.name)
}

/// One row for each reflector of each track.
fn reflectors(
    flights: &[(Track, &Flown)],
    cells: impl Fn(&Track, &Found) -> Vec<String>,
) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for (track, flown) in flights {
        for found in flown.found() {
            let mut row = vec![format!("{}, reflector {}", short(track), found.number)];
            row.extend(
                cells(track, &found)
                    .into_iter()
                    .map(|c| c.replace('-', "−")),
            );
            rows.push(row);
        }
    }
    rows
}

fn places(flights: &[(Track, &Flown)]) -> ComparisonTable {
    let head = [
        "",
        "off along track (mm)",
        "off across track (mm)",
        "Eq. (14) for the height error (mm)",
        "level (dB)",
        "ghost",
    ];
    ComparisonTable {
        caption: "Places of the reflectors in the image, relative to their true places. The fourth column \
                  is how far the largest height error of the flight may move them across the track."
            .to_owned(),
        head: head.map(str::to_owned).to_vec(),
        rows: reflectors(flights, |_, f| {
            let [x, y] = f.off_m();
            vec![
                format!("{:+.0}", x * 1e3),
                format!("{:+.0}", y * 1e3),
                format!("±{:.0}", f.across_bound_m * 1e3),
                format!("{:.1}", f.target.level_db),
                f.target
                    .ghost
                    .map_or("–".to_owned(), |g| format!("{:.2}", g.level)),
            ]
        }),
    }
}

fn resolutions(flights: &[(Track, &Flown)]) -> ComparisonTable {
    let head = [
        "",
        "along (m)",
        "theory",
        "paper's experiment",
        "across (m)",
        "theory",
        "paper's experiment",
    ];
    let metres = |v: Option<f64>| v.map_or("–".to_owned(), |v| format!("{v:.3}"));
    ComparisonTable {
        caption:
            "Rayleigh resolution (peak to first minimum), compared with Table 4 of Catapano et al. 2020"
                .to_owned(),
        head: head.map(str::to_owned).to_vec(),
        rows: reflectors(flights, |track, f| {
            let k = (f.number - 1).min(1);
            vec![
                metres(f.target.along.rayleigh_m),
                format!("{:.2}", track.theory_along_m),
                format!("{:.2}", track.paper_along_m[k]),
                metres(f.target.across.rayleigh_m),
                format!("{:.2}", track.theory_across_m),
                format!("{:.2}", track.paper_across_m[k]),
            ]
        }),
    }
}

fn positions(flights: &[(Track, &Flown)]) -> ComparisonTable {
    let head = [
        "",
        "error, rms (cm)",
        "error, largest (cm)",
        "stated σ, largest (cm)",
        "paper: stated σ, largest (cm)",
    ];
    let centimetres = |v: [f64; 3]| v.map(|v| format!("{:.1}", 1e2 * v)).join(" / ");
    let rows = flights
        .iter()
        .map(|(track, flown)| {
            let error_m = flown.error_m();
            let largest_m =
                [0, 1, 2].map(|i| error_m.iter().map(|e| e[i].abs()).fold(0.0, f64::max));
            vec![
                short(track).to_owned(),
                centimetres(rms_m(&error_m)),
                centimetres(largest_m),
                centimetres(flown.largest_sigma_m()),
                centimetres(track.paper_sigma_m),
            ]
        })
        .collect();
    ComparisonTable {
        caption: "Positions by carrier phase against the truth (x / y / z), compared with Table 3"
            .to_owned(),
        head: head.map(str::to_owned).to_vec(),
        rows,
    }
}

fn remarks(flights: &[(Track, &Flown)]) -> Vec<String> {
    let mut remarks = Vec::new();
    let distances: Vec<String> = flights
        .iter()
        .filter_map(|(track, flown)| {
            let metres = flown.distance_m()?;
            Some(format!("{metres:.3} m on {}", short(track)))
        })
        .collect();
    if !distances.is_empty() {
        remarks.push(format!(
            "The reflectors are 10.000 m apart; in the images, {}.",
            distances.join(" and ")
        ));
    }
    if let Ok(Some(moved_m)) = displacement_m(4.0, 0.0, 0.03) {
        remarks.push(format!(
            "Straight below the track the image cannot distinguish a small height error from a shift \
             across: by Eq. (14), 3 cm of height move a target at nadir by {moved_m:.1} m from a height of \
             4 m. Across the track, Track 1 is therefore to be read with that in mind; along the track \
             there is no such shift."
        ));
    }
    remarks
}
