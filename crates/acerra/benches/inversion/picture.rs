//! The images of all methods side by side.

use acerra_figure::{Drawing, GhostMark, ImageDb, LevelWindow, PixelValues, TargetMark, sheet};

use crate::measure::{crop, mirrored_m};
use crate::scene::Scene;
use crate::solve::Run;

/// Height of the plot of a panel (CSS pixels).
const PLOT_PX: f32 = 250.0;
/// Level at which colours end, dB.
const FLOOR_DB: f64 = -40.0;
/// What is shown about a target: to both sides along x, and beyond target and ghost across (m).
const NEAR_M: f64 = 2.5;
/// Ghosts nearer to their target than this are one spot with it (m).
const GHOST_APART_M: f64 = 1.4;

/// The part of the pixels that a row shows.
#[derive(Clone, Copy)]
pub enum View {
    Whole,
    /// All pixels, with rings about targets and places of ghosts.
    Marked,
    /// The surroundings of the first target and of its ghost.
    FirstTarget,
}

/// A row of panels for each scene, a column for each method, as PNG.
pub fn picture<'a>(rows: impl Iterator<Item = (&'a Scene, &'a [Run], View)>) -> Vec<u8> {
    let panels = rows.map(|(scene, runs, view)| {
        let last = runs.len() - 1;
        let panel = |(k, run)| panel(scene, run, view, k == last);
        runs.iter().enumerate().map(panel).collect()
    });
    sheet(panels.collect()).to_png().unwrap()
}

fn panel(scene: &Scene, run: &Run, view: View, has_colour_bar: bool) -> Drawing {
    let [x_m, y_m] = bounds_m(scene, view);
    let (values, grid) = crop(&run.focused.image, scene.pixels.grid, x_m, y_m);
    let position_m = scene.aligned.position_m.iter();
    let track_m: Vec<[f64; 2]> = position_m.map(|p| [p[0], p[1]]).collect();
    let mut image = ImageDb::new(
        format!("{}: {}", scene.name, run.method.name()),
        PixelValues::Complex(&values),
        grid.nx,
        grid.ny,
    )
    .at(grid.x0_m, grid.y0_m, grid.pixel_m);
    image.window = LevelWindow::Fixed { floor_db: FLOOR_DB };
    image.track_m = &track_m;
    image.legend = false;
    image.colour_bar = has_colour_bar;
    image.plot_height_px = PLOT_PX;
    if matches!(view, View::Marked) {
        mark_targets(&mut image, scene);
    }
    image.draw().unwrap()
}

fn mark_targets(image: &mut ImageDb<'_>, scene: &Scene) {
    for (k, target) in scene.targets.iter().enumerate() {
        let [x_m, y_m, _] = target.place_m;
        let label = String::new();
        image.targets.push(TargetMark { x_m, y_m, label });
        let [x_m, ghost_y_m] = mirrored_m(scene, k);
        if (ghost_y_m - y_m).abs() > GHOST_APART_M {
            image.ghosts.push(GhostMark {
                x_m,
                y_m: ghost_y_m,
                label: String::new(),
            });
        }
    }
}

/// Coordinates between which a view lies, along x and y.
fn bounds_m(scene: &Scene, view: View) -> [[f64; 2]; 2] {
    match view {
        View::Whole | View::Marked => [[f64::NEG_INFINITY, f64::INFINITY]; 2],
        View::FirstTarget => {
            let (place_m, ghost_m) = (scene.targets[0].place_m, mirrored_m(scene, 0));
            let middle_m = 0.5 * (place_m[1] + ghost_m[1]);
            let half_m = 0.5 * (place_m[1] - ghost_m[1]).abs() + NEAR_M;
            let about = |v: f64| [v - half_m, v + half_m];
            [about(place_m[0]), about(middle_m)]
        }
    }
}
