//! Report and figures of a point spread function.

use std::fmt::Write as _;
use std::path::Path;

use acerra_imaging::Complex32;
use acerra_imaging::metrics::{AcrossTrack, AlongTrack, Field, Ghost, LocalTrack};
use acerra_imaging::psf::{Analysis, PsfField, Retrieved, Theory};
use serde::Serialize;

use super::scene::Scene;
use acerra_figure::{GhostMark, ImageDb, LevelWindow, PixelValues, TargetMark, cut_plot};
use acerra_products::staging::Staging;

/// A place, m.
#[derive(Serialize)]
struct Place {
    x_m: f64,
    y_m: f64,
}

/// The answer in JSON.
#[derive(Serialize)]
pub(super) struct Answer {
    peak: Place,
    along: AlongTrack,
    across: AcrossTrack,
    ghost: Option<Ghost>,
    pslr_db: Option<f64>,
    islr_db: Option<f64>,
    theory: Theory,
    /// Only with options on positioning errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity: Option<super::blur::Answer>,
}

impl Answer {
    pub fn of(found: &Analysis, sensitivity: Option<super::blur::Answer>) -> Self {
        Self {
            peak: Place {
                x_m: found.peak_m[0],
                y_m: found.peak_m[1],
            },
            along: found.along,
            across: found.across,
            ghost: found.ghost,
            pslr_db: found.pslr_db,
            islr_db: found.islr_db,
            theory: found.theory,
            sensitivity,
        }
    }
}

/// The answer for people.
pub(super) fn text(found: &Analysis) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<28}{value}");
    };
    let metres = |v: Option<f64>| v.map_or_else(|| "unbounded".to_owned(), |v| format!("{v:.4} m"));
    let decibel = |v: Option<f64>| v.map_or_else(|| "unknown".to_owned(), |v| format!("{v:.1} dB"));
    line(
        "peak",
        format!("({:.4}, {:.4}) m", found.peak_m[0], found.peak_m[1]),
    );
    line(
        "along track",
        format!(
            "{} to the first minimum, {} at −3 dB, {} at −6 dB",
            metres(found.along.rayleigh_m),
            metres(found.along.width_3db_m),
            metres(found.along.width_6db_m)
        ),
    );
    line(
        "across track",
        format!(
            "{} ({} inner, {} outer), {} at −3 dB, {} at −6 dB",
            metres(found.across.rayleigh_m),
            metres(found.across.inner_m),
            metres(found.across.outer_m),
            metres(found.across.width_3db_m),
            metres(found.across.width_6db_m)
        ),
    );
    line(
        "sidelobes",
        format!(
            "PSLR {}, ISLR {}",
            decibel(found.pslr_db),
            decibel(found.islr_db)
        ),
    );
    line(
        "ghost",
        found.ghost.map_or_else(
            || "no separate ghost: the target lies within its resolution of the track".to_owned(),
            |g| {
                format!(
                    "{:.3} of the target at ({:.3}, {:.3}) m",
                    g.level, g.x_m, g.y_m
                )
            },
        ),
    );
    line(
        "theory of a straight track",
        format!(
            "along {:.4} m (Eq. 6), range {:.4} m (Eq. 8), across {:.4} m (Eq. 9)",
            found.theory.along_m, found.theory.range_m, found.theory.across_m
        ),
    );
    text
}

/// Level at which pictures end, dB.
const FLOOR_DB: f64 = -40.0;

fn picture<'a>(
    scene: &Scene,
    image: &'a [Complex32],
    track_m: &'a [[f64; 2]],
    title: String,
) -> ImageDb<'a> {
    let grid = scene.grid;
    let pixels = PixelValues::Complex(image);
    let mut figure =
        ImageDb::new(title, pixels, grid.nx, grid.ny).at(grid.x0_m, grid.y0_m, grid.pixel_m);
    figure.window = LevelWindow::Fixed { floor_db: FLOOR_DB };
    figure.track_m = track_m;
    figure
}

fn ground_track(scene: &Scene) -> (Vec<[f64; 2]>, String) {
    let position_m = scene.spread.position_m();
    let mut csv = "x_m,y_m,z_m\n".to_owned();
    for p in position_m {
        let _ = writeln!(csv, "{:.4},{:.4},{:.4}", p[0], p[1], p[2]);
    }
    (position_m.iter().map(|p| [p[0], p[1]]).collect(), csv)
}

/// Writes picture, cuts and numbers of one target.
pub(super) fn write_single(
    directory: &Path,
    scene: &Scene,
    image: &[Complex32],
    found: &Analysis,
    answer: &Answer,
) -> anyhow::Result<()> {
    let (track_m, track_csv) = ground_track(scene);
    let [x, y, z] = found.target_m;
    let title = format!(
        "Image of a point at ({x}, {y}, {z}) m on the plane z = {} m",
        scene.grid.z_m
    );
    let mut figure = picture(scene, image, &track_m, title);
    figure.targets = vec![TargetMark {
        x_m: found.peak_m[0],
        y_m: found.peak_m[1],
        label: "target".to_owned(),
    }];
    figure.ghosts = found
        .ghost
        .iter()
        .map(|g| GhostMark {
            x_m: g.x_m,
            y_m: g.y_m,
            label: format!("ghost {:.2}", g.level),
        })
        .collect();

    let scene_m = [found.target_m];
    let field = PsfField::new(&scene.spread, &scene_m, scene.grid.z_m);
    let along = cut(
        &field,
        found,
        found.track.tangent,
        found.along.rayleigh_m,
        found.cell.along_m,
    );
    let across = cut(
        &field,
        found,
        found.track.left(),
        found.across.rayleigh_m,
        found.cell.across_m,
    );
    let plot = cut_plot(
        "Cuts through the peak",
        &[
            ("along track", &along.0, &along.1),
            ("across track (left is positive)", &across.0, &across.1),
        ],
        FLOOR_DB,
    );
    let mut cuts_csv = "direction,distance_m,level_db\n".to_owned();
    for (name, cut) in [("along", &along), ("across", &across)] {
        for (s, level) in cut.0.iter().zip(&cut.1) {
            let _ = writeln!(cuts_csv, "{name},{s:.5},{level:.3}");
        }
    }

    let staging = Staging::new(directory)?;
    staging.write("psf.png", figure.draw()?.to_png()?)?;
    staging.write("cuts.png", plot.draw()?.to_png()?)?;
    staging.write("cuts.csv", cuts_csv)?;
    staging.write("track.csv", track_csv)?;
    staging.write("psf.json", serde_json::to_vec_pretty(answer)?)?;
    staging.publish()
}

/// Distances and levels (dB below the peak) of a cut five resolutions to either side.
fn cut(
    field: &PsfField<'_>,
    found: &Analysis,
    direction: [f64; 2],
    rayleigh_m: Option<f64>,
    expected_m: f64,
) -> (Vec<f64>, Vec<f64>) {
    const HALF_POINTS: i32 = 300;
    let reach_m = 5.0 * rayleigh_m.unwrap_or(expected_m);
    (-HALF_POINTS..=HALF_POINTS)
        .map(|k| {
            let s = reach_m * f64::from(k) / f64::from(HALF_POINTS);
            let at = [0, 1].map(|i| found.peak_m[i] + s * direction[i]);
            let amplitude = field.amplitude(at[0], at[1]).unwrap_or(0.0) / found.amplitude;
            (s, 20.0 * amplitude.max(1e-6).log10())
        })
        .unzip()
}

/// Writes picture and table of several targets.
pub(super) fn write_targets(
    directory: &Path,
    scene: &Scene,
    image: &[Complex32],
    found: &[Retrieved],
) -> anyhow::Result<()> {
    let (track_m, track_csv) = ground_track(scene);
    let title = format!(
        "{} targets on the plane z = {} m",
        found.len(),
        scene.grid.z_m
    );
    let mut figure = picture(scene, image, &track_m, title);
    figure.targets = found
        .iter()
        .enumerate()
        .filter(|(_, r)| r.detected)
        .map(|(k, r)| TargetMark {
            x_m: r.found_m[0],
            y_m: r.found_m[1],
            label: format!("T{}", k + 1),
        })
        .collect();
    figure.ghosts = found
        .iter()
        .filter(|r| r.detected && r.mirrored)
        .filter_map(|r| {
            let at = [r.found_m[0], r.found_m[1], scene.grid.z_m];
            let track = LocalTrack::at(scene.spread.position_m(), at)?;
            let [x_m, y_m] = track.mirrored_m(r.found_m);
            Some(GhostMark {
                x_m,
                y_m,
                label: String::new(),
            })
        })
        .collect();
    let mut staging = Staging::new(directory)?;
    if directory.join("psf.json").is_file() {
        // Products of a single target, from an earlier call.
        staging.supersede(["psf.json", "cuts.png", "cuts.csv"].map(str::to_owned));
    }
    staging.write("psf.png", figure.draw()?.to_png()?)?;
    staging.write("track.csv", track_csv)?;
    staging.write("targets.csv", super::targets::csv(found))?;
    let answer = super::targets::Answer::of(scene.grid.z_m, found);
    staging.write("targets.json", serde_json::to_vec_pretty(&answer)?)?;
    staging.publish()
}
