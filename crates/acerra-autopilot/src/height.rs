//! Heights above the ellipsoid and above the sea, kept apart.

use acerra_geo::geodesy::Geodetic;
use acerra_geo::geoid::GeoidGrid;

use crate::error::LogError;
use crate::report::LogWarning;
use crate::sample::{HeightDatum, Place, PositionSample};

/// The samples whose heights count from one surface, the ellipsoid where any does, and the number of others.
pub fn of_one_datum(samples: &[PositionSample]) -> (Vec<PositionSample>, usize) {
    let is_above_ellipsoid =
        |s: &PositionSample| matches!(s.place, Place::Geodetic(_, HeightDatum::Ellipsoid));
    let is_above_sea =
        |s: &PositionSample| matches!(s.place, Place::Geodetic(_, HeightDatum::SeaLevel));
    if !samples.iter().any(is_above_ellipsoid) {
        return (samples.to_vec(), 0);
    }
    let kept: Vec<PositionSample> = samples
        .iter()
        .filter(|s| !is_above_sea(s))
        .copied()
        .collect();
    let left_out = samples.len() - kept.len();
    (kept, left_out)
}

/// Raises heights above the sea by the geoid's, where a grid gives it.
#[derive(Debug)]
pub struct Heights<'a> {
    geoid: Option<&'a GeoidGrid>,
    datum: Option<HeightDatum>,
    first_geoid_m: Option<f64>,
}

impl<'a> Heights<'a> {
    /// With a grid of the geoid, or without.
    pub const fn new(geoid: Option<&'a GeoidGrid>) -> Self {
        Self {
            geoid,
            datum: None,
            first_geoid_m: None,
        }
    }

    /// The place, with its height above the ellipsoid if known.
    ///
    /// # Errors
    /// A place that the grid does not cover.
    pub fn ellipsoidal(&mut self, place: Place) -> Result<Place, LogError> {
        let Place::Geodetic(place, mut datum) = place else {
            return Ok(place);
        };
        let mut height_m = place.height_m;
        if let (HeightDatum::SeaLevel, Some(grid)) = (datum, self.geoid) {
            let (latitude_deg, longitude_deg) = (place.latitude_deg(), place.longitude_deg());
            let geoid_m = grid.height_m(latitude_deg, longitude_deg);
            let geoid_m = geoid_m.ok_or(LogError::OutsideGeoid {
                latitude_deg,
                longitude_deg,
            })?;
            self.first_geoid_m.get_or_insert(geoid_m);
            height_m += geoid_m;
            datum = HeightDatum::Ellipsoid;
        }
        self.datum = Some(datum);
        Ok(Place::Geodetic(Geodetic { height_m, ..place }, datum))
    }

    /// Datum of the heights now; none for positions in the robot's local axes.
    pub const fn datum(&self) -> Option<HeightDatum> {
        self.datum
    }

    /// Remarks on them.
    pub fn remark(&self, source: &str) -> Option<LogWarning> {
        if let Some(geoid_m) = self.first_geoid_m {
            return Some(LogWarning::RaisedByGeoid { geoid_m });
        }
        (self.datum == Some(HeightDatum::SeaLevel)).then(|| LogWarning::SeaLevelHeights {
            source: source.to_owned(),
        })
    }
}
