//! Positions of images: the events of a camera's shutter, with the images' names.

use std::io::{self, Write};

use acerra_geo::geodesy::EnuFrame;

use crate::solution::{EventPosition, PpkSolution};
use acerra_geo::geoid::GeoidGrid;

/// Reason for which images have no positions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Different numbers of images and events, which are assigned by their order only.
    #[error("expected as many images as events: {events} events, found {images} images")]
    Counts {
        /// Events in the rover's log.
        events: usize,
        /// Images given.
        images: usize,
    },
}

/// An image with its event.
#[derive(Debug, Clone, PartialEq)]
pub struct ImagePosition {
    /// Name of the image.
    pub image: String,
    /// Time and position of the event.
    pub event: EventPosition,
}

/// Pairs images with events: the first image, in the order given, with the first event, and so on.
///
/// # Errors
/// [`ImageError::Counts`] where the numbers differ. Nothing is guessed: one missed shutter pulse would
/// displace every later image.
pub fn position_images(
    images: &[String],
    solution: &PpkSolution,
) -> Result<Vec<ImagePosition>, ImageError> {
    if images.len() != solution.events.len() {
        return Err(ImageError::Counts {
            events: solution.events.len(),
            images: images.len(),
        });
    }
    let pairs = images.iter().zip(&solution.events);
    Ok(pairs
        .map(|(image, event)| ImagePosition {
            image: image.clone(),
            event: event.clone(),
        })
        .collect())
}

/// Writes images with their positions as CSV.
///
/// Columns: `image`, `time_gpst`, `latitude_deg`, `longitude_deg`, `height_m` (above the geoid of
/// `geoid`, else above the ellipsoid), `sd_north_m`, `sd_east_m`, `sd_up_m`, `quality` (RTKLIB's
/// number). Images outside the solution, or outside the geoid's grid, have empty columns. Names
/// with commas or quotes are quoted.
///
/// # Errors
/// Errors of the writer.
pub fn write_images(
    mut out: impl Write,
    images: &[ImagePosition],
    geoid: Option<&GeoidGrid>,
) -> io::Result<()> {
    writeln!(
        out,
        "image,time_gpst,latitude_deg,longitude_deg,height_m,sd_north_m,sd_east_m,sd_up_m,quality"
    )?;
    for ImagePosition { image, event } in images {
        let time = event.time.format_calendar(6);
        write!(out, "{},{time},", quoted(image))?;
        match position(event, geoid) {
            Some(columns) => writeln!(out, "{columns}")?,
            None => writeln!(out, ",,,,,,")?,
        }
    }
    Ok(())
}

fn position(event: &EventPosition, geoid: Option<&GeoidGrid>) -> Option<String> {
    let frame = EnuFrame::from_ecef(event.position_ecef_m?);
    let place = frame.origin();
    let (latitude, longitude) = (place.latitude_deg(), place.longitude_deg());
    let separation_m = match geoid {
        Some(grid) => grid.height_m(latitude, longitude)?,
        None => 0.0,
    };
    let c = frame.enu_covariance_from_ecef(&event.covariance_ecef_m2);
    let [east, north, up] = [0, 1, 2].map(|k| c[k][k].max(0.0).sqrt());
    let quality = event.quality.map_or(0, crate::solution::Quality::number);
    Some(format!(
        "{latitude:.10},{longitude:.10},{:.4},{north:.4},{east:.4},{up:.4},{quality}",
        place.height_m - separation_m
    ))
}

fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
