//! KMZ (OGC KML 2.3 in a ZIP file): a picture laid over the ground, the track above it, and points.

use std::fmt::Write as _;
use std::io::{Cursor, Write};

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
use zip::write::{SimpleFileOptions, ZipWriter};

use crate::error::MapError;
use crate::geotiff::escaped;

/// A picture over the ground with its attributes.
#[derive(Clone, Debug)]
pub struct Overlay<'a> {
    /// Name.
    pub name: &'a str,
    /// What it shows, in words.
    pub description: &'a str,
    /// The picture, as PNG; transparent where there are no data.
    pub png: &'a [u8],
    /// Outer corners: south-west, south-east, north-east, north-west.
    pub corners: [Geodetic; 4],
    /// Lines flown, heights above the ellipsoid.
    pub tracks: Vec<Vec<Geodetic>>,
    /// Height reference of the tracks.
    pub heights: TrackHeights,
    /// Points with names and descriptions.
    pub points: Vec<OverlayPoint>,
    /// Legend of the colours, as PNG, in a corner of the screen.
    pub legend: Option<&'a [u8]>,
    /// First and last time of the flight in UTC, as ISO 8601 has it.
    pub time_span_utc: Option<[String; 2]>,
}

/// Height reference of lines. KML heights are above mean sea level (EGM96).
#[derive(Clone, Debug, Default, PartialEq)]
pub enum TrackHeights {
    /// By their height over the picture, as the ellipsoid's height above the sea is not known.
    #[default]
    OverPicture,
    /// Heights above the sea of every place of every line (m).
    AboveSea(Vec<Vec<f64>>),
}

/// A named point.
#[derive(Clone, Debug, PartialEq)]
pub struct OverlayPoint {
    /// Name.
    pub name: String,
    /// Description, in words.
    pub description: String,
    /// Place.
    pub place: Geodetic,
}

/// Writes an overlay.
///
/// The picture and the points lie on the ground.
///
/// # Errors
/// Errors of the writer.
pub fn write_kmz(mut out: impl Write, overlay: &Overlay<'_>) -> Result<(), MapError> {
    // In memory: `zip` prints the error of a writer that an unfinished archive is dropped with.
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().last_modified_time(zip::DateTime::default());
    let failed = |error: zip::result::ZipError| MapError::Io(error.into());
    zip.start_file("doc.kml", options).map_err(failed)?;
    zip.write_all(document(overlay).as_bytes())?;
    let stored = options.compression_method(zip::CompressionMethod::Stored);
    zip.start_file("image.png", stored).map_err(failed)?;
    zip.write_all(overlay.png)?;
    if let Some(legend) = overlay.legend {
        zip.start_file("legend.png", stored).map_err(failed)?;
        zip.write_all(legend)?;
    }
    out.write_all(&zip.finish().map_err(failed)?.into_inner())?;
    out.flush()?;
    Ok(())
}

fn document(overlay: &Overlay<'_>) -> String {
    let mut kml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
                   <kml xmlns=\"http://www.opengis.net/kml/2.2\" \
                   xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n"
        .to_owned();
    let name = escaped(overlay.name);
    let about = escaped(overlay.description);
    let [latitude_deg, longitude_deg] = middle_deg(&overlay.corners);
    let times = overlay.time_span_utc.as_ref().map(|span| {
        let [begin, end] = span.each_ref().map(|time| escaped(time));
        format!("<begin>{begin}</begin><end>{end}</end>")
    });
    // The time span of a view is one of Google's extensions.
    let [span, view_span] = ["TimeSpan", "gx:TimeSpan"].map(|tag| match &times {
        Some(times) => format!("<{tag}>{times}</{tag}>"),
        None => String::new(),
    });
    let _ = write!(
        kml,
        "<name>{name}</name>\n\
         <LookAt>{view_span}<longitude>{longitude_deg:.9}</longitude><latitude>{latitude_deg:.9}</latitude>\
         <altitude>0</altitude><heading>0</heading><tilt>0</tilt><range>{:.0}</range></LookAt>\n\
         <Style id=\"track\"><LineStyle><color>ffffffff</color><width>2</width></LineStyle></Style>\n\
         <GroundOverlay><name>{name}</name><description>{about}</description>\n\
         {span}<Icon><href>image.png</href></Icon>\n\
         <gx:LatLonQuad><coordinates>{}</coordinates></gx:LatLonQuad>\n\
         </GroundOverlay>\n",
        VIEW_DIAGONALS * diagonal_m(&overlay.corners),
        places(&overlay.corners, None)
    );
    if overlay.legend.is_some() {
        kml.push_str(
            "<ScreenOverlay><name>Legend</name><Icon><href>legend.png</href></Icon>\
             <overlayXY x=\"0\" y=\"1\" xunits=\"fraction\" yunits=\"fraction\"/>\
             <screenXY x=\"0.01\" y=\"0.98\" xunits=\"fraction\" yunits=\"fraction\"/>\
             <size x=\"0\" y=\"0.4\" xunits=\"fraction\" yunits=\"fraction\"/></ScreenOverlay>\n",
        );
    }
    let ground_m = overlay.corners.iter().map(|c| c.height_m).sum::<f64>() / 4.0;
    for (k, track) in overlay.tracks.iter().enumerate() {
        let over_picture = || {
            track
                .iter()
                .map(|place| place.height_m - ground_m)
                .collect()
        };
        let (mode, heights_m) = match &overlay.heights {
            TrackHeights::AboveSea(heights_m)
                if heights_m.get(k).is_some_and(|h| h.len() == track.len()) =>
            {
                ("absolute", heights_m[k].clone())
            }
            _ => ("relativeToGround", over_picture()),
        };
        let _ = write!(
            kml,
            "<Placemark><name>Track</name>{span}<styleUrl>#track</styleUrl>\n\
             <LineString><altitudeMode>{mode}</altitudeMode>\
             <coordinates>{}</coordinates></LineString></Placemark>\n",
            places(track, Some(&heights_m))
        );
    }
    for point in &overlay.points {
        let _ = write!(
            kml,
            "<Placemark><name>{}</name><description>{}</description>\n\
             <Point><coordinates>{}</coordinates></Point></Placemark>\n",
            escaped(&point.name),
            escaped(&point.description),
            places(&[point.place], None)
        );
    }
    kml.push_str("</Document>\n</kml>\n");
    kml
}

/// Distance of the first view from the ground, in diagonals of the picture: the whole picture is visible,
/// with its surroundings.
const VIEW_DIAGONALS: f64 = 1.5;

/// Latitude and longitude of the middle, degrees. Longitudes on both sides of 180° count from the first corner's.
fn middle_deg(corners: &[Geodetic; 4]) -> [f64; 2] {
    let first_deg = corners[0].longitude_deg();
    let east_deg =
        |corner: &Geodetic| (corner.longitude_deg() - first_deg + 540.0).rem_euclid(360.0) - 180.0;
    let mean = |of: &dyn Fn(&Geodetic) -> f64| corners.iter().map(of).sum::<f64>() / 4.0;
    let longitude_deg = first_deg + mean(&east_deg);
    [
        mean(&|corner| corner.latitude_deg()),
        (longitude_deg + 540.0).rem_euclid(360.0) - 180.0,
    ]
}

fn diagonal_m(corners: &[Geodetic; 4]) -> f64 {
    let [a, b] = [&corners[0], &corners[2]].map(ecef_from_geodetic);
    let square: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
    square.sqrt()
}

/// Longitude, latitude and, where given, height of each place.
fn places(places: &[Geodetic], heights_m: Option<&Vec<f64>>) -> String {
    let texts: Vec<String> = places
        .iter()
        .enumerate()
        .map(|(k, place)| {
            let (longitude, latitude) = (place.longitude_deg(), place.latitude_deg());
            match heights_m {
                Some(heights_m) => format!("{longitude:.9},{latitude:.9},{:.3}", heights_m[k]),
                None => format!("{longitude:.9},{latitude:.9}"),
            }
        })
        .collect();
    texts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Read};

    #[test]
    fn an_archive_holds_document_and_picture() {
        let at = |lat, lon| Geodetic::from_degrees(lat, lon, 80.0);
        let overlay = Overlay {
            name: "<flight> & \"log\"",
            description: "levels in dB",
            png: b"picture",
            corners: [
                at(41.0, 14.0),
                at(41.0, 14.1),
                at(41.1, 14.1),
                at(41.1, 14.0),
            ],
            tracks: vec![vec![Geodetic::from_degrees(41.05, 14.05, 90.0)]],
            heights: TrackHeights::OverPicture,
            points: vec![OverlayPoint {
                name: "1".to_owned(),
                description: "0.0 dB".to_owned(),
                place: at(41.02, 14.03),
            }],
            legend: Some(b"bar"),
            time_span_utc: Some(
                ["2019-10-15T09:31:18Z", "2019-10-15T09:31:39Z"].map(str::to_owned),
            ),
        };
        let mut bytes = Cursor::new(Vec::new());
        write_kmz(&mut bytes, &overlay).unwrap();
        let mut zip = zip::ZipArchive::new(bytes).unwrap();
        let mut kml = String::new();
        zip.by_name("doc.kml")
            .unwrap()
            .read_to_string(&mut kml)
            .unwrap();
        for text in [
            "<name>&lt;flight&gt; &amp; &quot;log&quot;</name>",
            "14.000000000,41.000000000 14.100000000,41.000000000 14.100000000,41.100000000",
            "14.050000000,41.050000000,10.000",
            "14.030000000,41.020000000</coordinates>",
            "<longitude>14.050000000</longitude><latitude>41.050000000</latitude>",
            "<TimeSpan><begin>2019-10-15T09:31:18Z</begin><end>2019-10-15T09:31:39Z</end></TimeSpan><Icon>",
            "<ScreenOverlay><name>Legend</name><Icon><href>legend.png</href></Icon>",
        ] {
            assert!(kml.contains(text), "{text}\n{kml}");
        }
        assert!(kml.contains("relativeToGround"));
        let above = Overlay {
            heights: TrackHeights::AboveSea(vec![vec![41.25]]),
            ..overlay.clone()
        };
        let kml_above = document(&above);
        assert!(kml_above.contains("<altitudeMode>absolute</altitudeMode>"));
        assert!(kml_above.contains("14.050000000,41.050000000,41.250"));
        let mut png = Vec::new();
        zip.by_name("image.png")
            .unwrap()
            .read_to_end(&mut png)
            .unwrap();
        assert_eq!(png, b"picture");
        assert_eq!(zip.by_name("legend.png").unwrap().size(), 3);
        // 11.1 km by 8.4 km, seen from one and a half times its diagonal.
        let range = kml
            .split("<range>")
            .nth(1)
            .unwrap()
            .split('<')
            .next()
            .unwrap();
        assert!(
            (range.parse::<f64>().unwrap() - 1.5 * 13_910.0).abs() < 50.0,
            "{range}"
        );
        // About the 180th meridian as elsewhere.
        let [_, east] = middle_deg(&[
            at(0.0, 179.9),
            at(0.0, -179.9),
            at(0.1, -179.9),
            at(0.1, 179.9),
        ]);
        assert!((east.abs() - 180.0).abs() < 1e-9, "{east}");
    }
}
