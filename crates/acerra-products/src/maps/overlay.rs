//! `image.kmz`: the image laid over the ground, the track above it, the targets.

use std::fs::File;
use std::io::BufWriter;

use acerra_figure::{ImageDb, LevelWindow, PixelValues};
use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::GpsTime;
use acerra_maps::kmz::{Overlay, OverlayPoint, TrackHeights, write_kmz};
use anyhow::Context;

use super::frame::OnEarth;
use crate::display::Shown;
use crate::outcome::Outcome;
use crate::provenance::time_span;
use crate::staging::Staging;

const NAME: &str = "image.kmz";
/// Side of the picture at most; graphics processors take no larger ones.
const MOST_SIDE: usize = 4096;
/// Places of a track at most.
const MOST_PLACES: usize = 2000;

pub(super) fn write(
    outcome: &Outcome,
    shown: &Shown,
    earth: OnEarth<'_>,
    staging: &Staging,
) -> anyhow::Result<()> {
    let grid = &outcome.focused.pixels.grid;
    let values = PixelValues::Complex(&outcome.focused.image);
    let mut image = ImageDb::new("", values, grid.nx, grid.ny);
    image = image.at(grid.x0_m, grid.y0_m, grid.pixel_m);
    let floor_db = shown.levels.floor_db;
    image.gain.clone_from(&shown.gain);
    image.window = LevelWindow::Fixed { floor_db };
    let image = image.with_levels(shown.levels);
    let png = image.overlay_png(MOST_SIDE).context(NAME)?;
    let legend = image.legend().to_png().context(NAME)?;
    let description = format!(
        "Radar image {}; levels from {:.0} dB to 0 dB below the maximum. Acerra {}.",
        outcome.focused.pixels.describe(),
        floor_db,
        env!("CARGO_PKG_VERSION")
    );
    let points = outcome.measured.targets.iter().enumerate();
    let points = points.map(|(k, target)| OverlayPoint {
        name: format!("{}", k + 1),
        description: format!("{:.1} dB", target.level_db),
        place: earth
            .frame
            .geodetic_from_enu([target.x_m, target.y_m, target.z_m]),
    });
    let tracks: Vec<Vec<Geodetic>> = (outcome.prepared.tracks.iter())
        .flat_map(|track| earth.lines(outcome, track, MOST_PLACES))
        .collect();
    let overlay = Overlay {
        name: &outcome.name,
        description: &description,
        png: &png,
        corners: earth.corners(),
        heights: above_sea(outcome, &tracks),
        tracks,
        points: points.collect(),
        legend: Some(&legend),
        time_span_utc: time_span(outcome).map(|span| span.map(iso_8601)),
    };
    let file = File::create(staging.path(NAME)).with_context(|| format!("{NAME}: cannot write"))?;
    write_kmz(BufWriter::new(file), &overlay).context(NAME)
}

/// A time in UTC to the second, in KML's form.
fn iso_8601(time: GpsTime) -> String {
    time.format_utc(0).replace('/', "-").replacen(' ', "T", 1) + "Z"
}

/// Heights of the tracks above the sea, where the geoid is known all along.
fn above_sea(outcome: &Outcome, tracks: &[Vec<Geodetic>]) -> TrackHeights {
    let of_track = |places: &Vec<Geodetic>| -> Option<Vec<f64>> {
        places.iter().map(|p| outcome.above_sea_m(p)).collect()
    };
    let heights: Option<Vec<Vec<f64>>> = tracks.iter().map(of_track).collect();
    heights.map_or(TrackHeights::OverPicture, TrackHeights::AboveSea)
}
