//! The pictures of a run: the image and the radargrams.

use acerra_imaging::Complex32;
use acerra_imaging::metrics::Target;
use acerra_radar::{Radargram, Samples};

use crate::display::{DARK_SHARE, Shown, WINDOW};
use crate::outcome::Outcome;
use crate::report::Picture;
use crate::surveyed::SurveyRecord;
use acerra_chain::choices::Background;
use acerra_chain::clean::CleanedTraces;
use acerra_chain::position::Positions;
use acerra_figure::{
    FastTimeCurve, FigureError, GhostMark, ImageDb, PixelValues, Radargram as RadargramFigure,
    RadargramColours, TargetMark,
};

/// Explanation of `image.png`.
#[must_use]
pub fn image_caption(outcome: &Outcome, shown: &Shown) -> String {
    let pixels = &outcome.focused.pixels;
    let grid = &pixels.grid;
    let mut caption = format!(
        "Modulus of Eq. (3) on {} × {} pixels of {} m {}. Colours span the levels from the {:.0}th \
         percentile of the pixels up to the maximum. Circles are targets, dotted circles their \
         left–right ghosts; numbers are those of the table.",
        grid.nx,
        grid.ny,
        grid.pixel_m,
        pixels.describe(),
        100.0 * DARK_SHARE
    );
    if shown.gain.is_some() {
        caption.push_str(
            " For display alone, levels are multiplied by R², R being the distance to the nearest \
             point of the track; image.npz and the table of targets are not.",
        );
    }
    caption
}

/// `image.png`: the image in decibels below its maximum, with track, targets, ghosts and surveyed
/// points.
///
/// # Errors
/// A picture too large to hold.
pub fn image(outcome: &Outcome, shown: &Shown) -> Result<Picture, FigureError> {
    let grid = &outcome.focused.pixels.grid;
    let mut track: Vec<[f64; 2]> = Vec::new();
    let aligned = &outcome.prepared.aligned;
    for line in aligned.lines(0..aligned.position_m.len()) {
        track.extend(aligned.position_m[line].iter().map(|p| [p[0], p[1]]));
        track.push([f64::NAN; 2]);
    }
    let pixels: &[Complex32] = &outcome.focused.image;
    let mut figure = ImageDb::new(
        format!("Focused image {}", outcome.focused.pixels.describe()),
        PixelValues::Complex(pixels),
        grid.nx,
        grid.ny,
    )
    .at(grid.x0_m, grid.y0_m, grid.pixel_m);
    figure.track_m = &track;
    figure.window = WINDOW;
    figure.gain.clone_from(&shown.gain);
    let mut figure = figure.with_levels(shown.levels);
    figure.survey = outcome.surveyed.iter().map(SurveyRecord::mark).collect();
    for (k, target) in outcome.measured.targets.iter().enumerate() {
        figure.targets.push(mark(target, k));
        if let Some(ghost) = target.ghost {
            figure.ghosts.push(GhostMark {
                x_m: ghost.x_m,
                y_m: ghost.y_m,
                label: format!("ghost of {}", k + 1),
            });
        }
    }
    Picture::drawn(
        |width_px| {
            figure.width_px = width_px;
            figure.draw()
        },
        "The focused image in decibels below its maximum, with the radar's track, the targets and their left–right ghosts",
        image_caption(outcome, shown),
    )
}

/// Pictures of looks and volumes with their file names, where there are any.
///
/// # Errors
/// A picture too large to hold.
pub fn of_stacks(outcome: &Outcome) -> Result<Vec<(String, Picture)>, FigureError> {
    let grid = &outcome.focused.pixels.grid;
    let mut made = Vec::new();
    if let Some(multilook) = &outcome.focused.multilook {
        let amplitude: Vec<f32> = multilook.power.iter().map(|p| p.sqrt()).collect();
        let looks = multilook.traces.len();
        let mut figure = ImageDb::new(
            format!("Mean power of {looks} looks"),
            PixelValues::Amplitude(&amplitude),
            grid.nx,
            grid.ny,
        )
        .at(grid.x0_m, grid.y0_m, grid.pixel_m);
        figure.window = WINDOW;
        made.push((
            "multilook.png".to_owned(),
            Picture::drawn(
                |width_px| {
                    figure.width_px = width_px;
                    figure.draw()
                },
                "The mean power of the looks in decibels below its maximum",
                format!(
                    "Mean power of {looks} looks along the track (looks.npz): less speckle, \
                     coarser along the track."
                ),
            )?,
        ));
    }
    if let Some(seen) = &outcome.focused.projections {
        let volume = &seen.volume;
        for (name, from, axis, values, n, start_m) in [
            ("front", "south", "x", &seen.front, grid.nx, grid.x0_m),
            ("side", "west", "y", &seen.side, grid.ny, grid.y0_m),
        ] {
            let (even, rows) = square(values, n, volume.nz, volume.step_m / grid.pixel_m);
            let title = format!("Volume from the {from}: greatest level along the other axis");
            let mut figure = ImageDb::new(title, PixelValues::Amplitude(&even), n, rows).at(
                start_m,
                volume.base.z_m,
                grid.pixel_m,
            );
            figure.window = WINDOW;
            figure.x_label = axis.to_owned();
            figure.y_label = "z".to_owned();
            made.push((
                format!("volume-{name}.png"),
                Picture::drawn(
                    |width_px| {
                        figure.width_px = width_px;
                        figure.draw()
                    },
                    &format!(
                        "The volume seen from the {from}: greatest level over {axis} and height, \
                         in decibels below the maximum"
                    ),
                    format!(
                        "{} slices of {} m (volume.npz) seen from the {from}: the greatest level \
                         along the other axis.",
                        volume.nz, volume.step_m
                    ),
                )?,
            ));
        }
    }
    Ok(made)
}

/// Rows `step` pixels apart brought to one pixel apart, each the nearest of the given.
fn square(values: &[f32], n: usize, rows: usize, step: f64) -> (Vec<f32>, usize) {
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of rows of a picture"
    )]
    let (wanted, nearest) = {
        let wanted = ((rows - 1) as f64 * step).round().clamp(0.0, 1e5) as usize + 1;
        let nearest = move |k: usize| ((k as f64 / step).round() as usize).min(rows - 1);
        (wanted, nearest)
    };
    let even = (0..wanted)
        .flat_map(|k| values[nearest(k) * n..(nearest(k) + 1) * n].iter().copied())
        .collect();
    (even, wanted)
}

fn mark(target: &Target, k: usize) -> TargetMark {
    TargetMark {
        x_m: target.x_m,
        y_m: target.y_m,
        label: (k + 1).to_string(),
    }
}

/// `radargram-raw.png`: the selected traces, zero-timed, with 2h/c, gate and surface picks.
///
/// # Errors
/// A picture too large to hold.
pub fn radargram_raw(outcome: &Outcome, traces: &CleanedTraces) -> Result<Picture, FigureError> {
    let mut curves = surface_and_gate(outcome, traces);
    if let Some(surface) = &traces.surface {
        curves.push(FastTimeCurve {
            label: "surface echo as picked".to_owned(),
            fast_time_ns: surface
                .fast_time_s
                .iter()
                .map(|t| t.map_or(f64::NAN, |t| t * 1e9))
                .collect(),
            dashed: false,
        });
    }
    let title = if traces.shift_s == 0.0 {
        "Raw radargram"
    } else {
        "Raw radargram, zero-timed"
    };
    let words = [
        "Radargram as recorded: traces from left to right, fast time downwards, levels in decibels, with 2h/c, the gate \
         and the surface echo as picked",
        "Selected traces as recorded, fast time shifted to 2R/c: the surface echo should follow 2h/c.",
    ];
    draw(title, words, outcome, &traces.raw, -80.0, curves)
}

/// `radargram.png`: the traces that entered the image, with 2h/c and the gate.
///
/// # Errors
/// A picture too large to hold.
pub fn radargram_clean(outcome: &Outcome, traces: &CleanedTraces) -> Result<Picture, FigureError> {
    draw(
        &clean_title(outcome, traces),
        [
            "Radargram that entered the image: traces from left to right, fast time downwards, levels in decibels, with \
             2h/c and the gate",
            "The same traces as they entered the image; the title names the background that was subtracted.",
        ],
        outcome,
        &traces.clean,
        -50.0,
        surface_and_gate(outcome, traces),
    )
}

/// Processing of the traces that enter the image, in few words.
fn clean_title(outcome: &Outcome, traces: &CleanedTraces) -> String {
    let background = outcome.campaign.background() != Background::None;
    let title = match (background, traces.gate_s.is_some()) {
        (true, true) => "Radargram without background, gated",
        (true, false) => "Radargram without background",
        (false, true) => "Radargram, gated",
        (false, false) => "Radargram as it entered the image",
    };
    title.to_owned()
}

/// A radargram with its title, its content and how to read it in words.
fn draw(
    title: &str,
    [alt, caption]: [&str; 2],
    outcome: &Outcome,
    radargram: &Radargram,
    floor_db: f64,
    curves: Vec<FastTimeCurve>,
) -> Result<Picture, FigureError> {
    let moduli;
    let samples: &[f32] = match &radargram.samples {
        Samples::Real(values) => values,
        Samples::Complex(values) => {
            moduli = values.iter().map(|v| v.norm()).collect::<Vec<f32>>();
            &moduli
        }
    };
    let mut figure = RadargramFigure::new(
        title,
        samples,
        radargram.traces,
        radargram.samples_per_trace,
    )
    .fast_time(
        radargram.fast_time_start_s * 1e9,
        radargram.fast_time_step_s * 1e9,
    );
    figure.first_trace = outcome
        .prepared
        .aligned
        .traces
        .first()
        .copied()
        .unwrap_or(0);
    figure.unit = outcome.prepared.first().radar.unit.to_owned();
    figure.colours = RadargramColours::Decibel { floor_db };
    let track = outcome.prepared.first();
    let aligned = &outcome.prepared.aligned;
    let trajectory_s = || aligned.time_s.iter().map(|t| t + track.time_offset_s);
    // Numbers of traces are no times.
    let top: Vec<f64> = match track.is_untimed {
        true => along_lines_m(&aligned.path_m),
        false => trajectory_s().collect(),
    };
    figure.top = &top;
    if track.is_untimed {
        figure.top_title = "distance along the lines (m)".to_owned();
    } else if matches!(track.positions, Positions::Trajectory(_)) {
        // The clock of the trajectory's figures.
        figure.top_title = "trajectory time (s)".to_owned();
    }
    (figure.right, figure.right_title) = range_scale(outcome, radargram);
    figure.curves = curves;
    Picture::drawn(
        |width_px| {
            figure.width_px = width_px;
            figure.draw()
        },
        alt,
        caption,
    )
}

/// Distance of each trace from the first, of the path that each represents (m).
fn along_lines_m(path_m: &[f64]) -> Vec<f64> {
    let mut sum_m = 0.0;
    let middle_m = |path_m: &f64| {
        sum_m += path_m;
        sum_m - 0.5 * path_m
    };
    path_m.iter().map(middle_m).collect()
}

/// The scale at the right of a radargram: fast times (ns) and ranges in air, or with ground depths below the surface
/// for the median height of the flight (m), and its title.
fn range_scale(outcome: &Outcome, radargram: &Radargram) -> (Vec<[f64; 2]>, String) {
    let ns_per_m = 2e9 / outcome.campaign.image.light_speed_m_s;
    let last_ns = radargram.fast_time_end_s() * 1e9;
    let first_ns = radargram.fast_time_start_s * 1e9;
    let range = |ns: f64| [ns, ns / ns_per_m];
    let Some(ground) = &outcome.focused.underground else {
        return (
            vec![range(first_ns), range(last_ns)],
            "range (m)".to_owned(),
        );
    };
    let height_m = median_of(&outcome.prepared.aligned.height_m);
    let surface_ns = height_m * ns_per_m;
    let mut scale = vec![[surface_ns, 0.0]];
    if first_ns < surface_ns {
        scale.insert(0, [first_ns, first_ns / ns_per_m - height_m]);
    }
    let [mut at_ns, mut depth_m] = [surface_ns, 0.0];
    for layer in &ground.layers {
        let ns_per_m = ns_per_m * layer.soil.relative_permittivity.sqrt();
        let left_m = (last_ns - at_ns).max(0.0) / ns_per_m;
        let down_m = layer.thickness_m.min(left_m);
        at_ns += down_m * ns_per_m;
        depth_m += down_m;
        if down_m > 0.0 {
            scale.push([at_ns, depth_m]);
        }
    }
    let title = format!("depth (m), from {height_m:.2} m above the ground");
    (scale, title)
}

fn median_of(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

fn surface_and_gate(outcome: &Outcome, traces: &CleanedTraces) -> Vec<FastTimeCurve> {
    let c = outcome.campaign.image.light_speed_m_s;
    let surface_ns: Vec<f64> = outcome
        .prepared
        .aligned
        .height_m
        .iter()
        .map(|h| 2e9 * h / c)
        .collect();
    let shifted = |by_s: f64| surface_ns.iter().map(|t| t + by_s * 1e9).collect();
    let mut curves = vec![FastTimeCurve {
        label: "2h/c".to_owned(),
        fast_time_ns: shifted(0.0),
        dashed: false,
    }];
    for gate_s in traces.gate_s.into_iter().flatten() {
        curves.push(FastTimeCurve {
            label: "gate".to_owned(),
            fast_time_ns: shifted(gate_s),
            dashed: true,
        });
    }
    curves
}
