//! Additional figures of a run with autofocus: the image by the stated positions, the corrections.

use acerra_chain::autofocus::PathCorrection;
use acerra_figure::{Axis, FigureError, ImageDb, LinePlot, PixelValues, Series};

use crate::display::WINDOW;
use crate::outcome::Outcome;
use crate::report::Picture;

/// The image as the positions have it and the corrections, with the names of their files; none where
/// no correction is applied.
///
/// # Errors
/// Pictures too large to hold.
pub fn pictures(outcome: &Outcome) -> Result<Vec<(String, Picture)>, FigureError> {
    let (Some(correction), Some(before)) = (&outcome.prepared.correction, &outcome.uncorrected)
    else {
        return Ok(Vec::new());
    };
    let grid = &before.pixels.grid;
    let mut figure = ImageDb::new(
        format!("Image without autofocus {}", before.pixels.describe()),
        PixelValues::Complex(&before.image),
        grid.nx,
        grid.ny,
    )
    .at(grid.x0_m, grid.y0_m, grid.pixel_m);
    figure.window = WINDOW;
    let found = &correction.found;
    let image = Picture::drawn(
        |width_px| {
            figure.width_px = width_px;
            figure.draw()
        },
        "The image made with the positions as stated",
        format!(
            "The image by the stated positions. Points that were not used for the correction gain {:.2} ± \
             {:.2} dB by it.",
            found.gain_db, found.gain_sigma_db
        ),
    )?;
    Ok(vec![
        ("image-uncorrected.png".to_owned(), image),
        (
            "autofocus.png".to_owned(),
            corrections(correction, outcome)?,
        ),
    ])
}

/// Corrections along the flight with their deviations.
fn corrections(correction: &PathCorrection, outcome: &Outcome) -> Result<Picture, FigureError> {
    let found = &correction.found;
    let time_s = &outcome.prepared.aligned.time_s;
    let of = |values: &[[f64; 3]], axis: usize| -> Vec<f64> {
        values.iter().map(|v| 1e3 * v[axis]).collect()
    };
    let moved: Vec<Vec<f64>> = (0..3).map(|a| of(&found.correction_m, a)).collect();
    let sigma: Vec<Vec<f64>> = (0..3).map(|a| of(&found.sigma_m, a)).collect();
    let mut plot = LinePlot::new(
        "Corrections of the positions",
        Axis::new("radar time", "s"),
        Axis::new("correction", "mm"),
    );
    for (axis, name) in ["east", "north", "up"].into_iter().enumerate() {
        let series = Series::line(name, time_s, &moved[axis]).band(&sigma[axis]);
        plot = plot.with(series);
    }
    Picture::drawn(
        |width_px| {
            plot.width_px = width_px;
            plot.draw()
        },
        "Corrections of the positions east, north and up along the flight",
        format!(
            "Corrections by autofocus with bands of one posterior standard deviation; the correlation time \
             of the errors was taken as {:.2} s. trajectory-uncorrected.csv holds the stated positions.",
            correction.correlation_s
        ),
    )
}
