//! GeoTIFF (OGC 19-008), cloud optimised: tiles of 256 pixels, overviews down to one tile, laid out so
//! that a part can be read without the rest.

use std::fmt::Write as _;
use std::io::Write;

use crate::cog;
use crate::crs::MapCrs;
use crate::error::MapError;
use crate::overview::pyramid;
use crate::placement::Placement;
use crate::raster::{Raster, Values};
use crate::tags::{Directory, Value};

/// Metadata of a file, in addition to its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// Meaning of the pixels, in words.
    pub title: String,
    /// The program that wrote it.
    pub software: String,
    /// Unit of the values, such as `"dB"`.
    pub unit: String,
    /// Names and values of further metadata, as GDAL shows them.
    pub items: Vec<(String, String)>,
}

/// Writes an image with its place on the map; without a coordinate reference system its place is in the local
/// frame.
///
/// # Errors
/// Values that do not fill the pixels, and errors of the writer.
pub fn write_geotiff(
    out: impl Write,
    raster: &Raster<'_>,
    placement: &Placement,
    crs: Option<&MapCrs>,
    description: &Description,
) -> Result<(), MapError> {
    raster.check()?;
    let mut directory = Directory::default();
    let mut text = |tag: u16, text: &str| {
        if !text.is_empty() {
            // ASCII alone, as TIFF 6.0 has it; the metadata are UTF-8 by GDAL's convention.
            let plain = text.chars().map(|c| if c.is_ascii() { c } else { '?' });
            directory.set(tag, Value::Ascii(plain.collect()));
        }
    };
    text(270, &description.title);
    text(305, &description.software);
    directory.set(42112, Value::Ascii(gdal_metadata(raster, description)));
    directory.set(34264, Value::Double(model_transformation(placement)));
    if let Some(crs) = crs {
        let (keys, names) = geo_keys(crs);
        directory.set(34735, Value::Short(keys));
        directory.set(34737, Value::Ascii(names));
    }
    cog::write(out, &pyramid(raster), &directory)
}

/// The matrix that takes column and row, counted from the north-western pixel's outer corner, to map
/// coordinates.
fn model_transformation(placement: &Placement) -> Vec<f64> {
    let corner = placement.at(-0.5, -0.5);
    let (column, row) = (placement.column, placement.row);
    #[rustfmt::skip]
    let matrix = vec![
        column[0], row[0], 0.0, corner[0],
        column[1], row[1], 0.0, corner[1],
        0.0,       0.0,    0.0, 0.0,
        0.0,       0.0,    0.0, 1.0,
    ];
    matrix
}

/// The GeoKey directory (keys sorted by number) and its texts.
fn geo_keys(crs: &MapCrs) -> (Vec<u16>, String) {
    let name = format!("EPSG:{}|", crs.epsg());
    let (model, code_key) = if crs.is_geographic() {
        (2, 2048) // GeodeticCRSGeoKey
    } else {
        (1, 3072) // ProjectedCRSGeoKey
    };
    #[rustfmt::skip]
    let keys = vec![
        1, 1, 1, 4,
        1024, 0, 1, model,
        1025, 0, 1, 1, // pixels are areas
        1026, 34737, name.len() as u16, 0,
        code_key, 0, 1, crs.epsg(),
    ];
    (keys, name)
}

/// GDAL's metadata: items of the file, unit and description of the band.
fn gdal_metadata(raster: &Raster<'_>, description: &Description) -> String {
    let band = match raster.values {
        Values::Power(_) => "power",
        Values::Level(..) => "level",
        Values::Complex(_) => "complex amplitude",
    };
    let mut xml = "<GDALMetadata>".to_owned();
    let mut item = |attributes: &str, value: &str| {
        let _ = write!(xml, "<Item {attributes}>{}</Item>", escaped(value));
    };
    for (name, value) in &description.items {
        item(&format!("name=\"{}\"", escaped(name)), value);
    }
    item(
        "name=\"DESCRIPTION\" sample=\"0\" role=\"description\"",
        band,
    );
    if !description.unit.is_empty() {
        let unit = "name=\"UNITTYPE\" sample=\"0\" role=\"unittype\"";
        item(unit, &description.unit);
    }
    xml.push_str("</GDALMetadata>");
    xml
}

/// Text within XML; control characters, which XML may not hold, become spaces.
pub(crate) fn escaped(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '&' => "&amp;".to_owned(),
            '<' => "&lt;".to_owned(),
            '>' => "&gt;".to_owned(),
            '"' => "&quot;".to_owned(),
            c if c.is_control() => " ".to_owned(),
            c => c.to_string(),
        })
        .collect()
}
