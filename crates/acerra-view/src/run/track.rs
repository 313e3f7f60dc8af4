//! `trajectory.csv`: where the phase centre was at every trace.

use std::path::Path;

use acerra_products::data::Table;
use serde::Serialize;

use crate::error::ViewError;

/// The traces of all tracks with their places.
#[derive(Debug, Default, Serialize)]
pub struct TrackTable {
    /// Number of each trace in its log.
    pub trace: Vec<f64>,
    /// Trajectory time (s).
    pub time_s: Vec<f64>,
    /// East, north and up of the phase centre (m); not finite where there is no position.
    pub position_m: Vec<[f64; 3]>,
    /// Standard deviations (m); not finite where the trajectory states none.
    pub sigma_m: Vec<[f64; 3]>,
    /// Solution status.
    pub status: Vec<String>,
    /// `ok`, or why there is no position.
    pub flag: Vec<String>,
    /// GPS time, where it is known.
    pub gpst: Vec<String>,
    /// Rows with which a line or a track begins, other than the first: between lines nothing was measured.
    pub line_starts: Vec<usize>,
}

/// Geometry of a place as seen from a trace.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Seen {
    /// Number of the trace in its log.
    pub trace: f64,
    /// Range (m).
    pub range_m: f64,
    /// Angle of incidence on level ground, from the vertical (degrees).
    pub incidence_deg: f64,
}

impl TrackTable {
    /// Reads `trajectory.csv`.
    ///
    /// # Errors
    /// A file that is absent, or a line that is no row of the table.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        std::fs::read_to_string(path)
            .map_err(anyhow::Error::from)
            .and_then(|text| Self::of(&Table::parse(&text)?))
            .map_err(|cause| ViewError::Product {
                path: path.to_owned(),
                cause,
            })
    }

    fn of(table: &Table) -> anyhow::Result<Self> {
        let n = table.len();
        let numbers = |name: &str| -> anyhow::Result<Vec<f64>> {
            Ok(table.numbers(name)?.unwrap_or_else(|| vec![f64::NAN; n]))
        };
        let three = |names: [&str; 3]| -> anyhow::Result<Vec<[f64; 3]>> {
            let [x, y, z] = [numbers(names[0])?, numbers(names[1])?, numbers(names[2])?];
            Ok((0..n).map(|k| [x[k], y[k], z[k]]).collect())
        };
        let texts = |name: &str| -> Vec<String> {
            match table.texts(name) {
                Some(cells) => cells.map(str::to_owned).collect(),
                None => vec![String::new(); n],
            }
        };
        Ok(Self {
            trace: numbers("trace")?,
            time_s: numbers("time_s")?,
            position_m: three(["x_m", "y_m", "z_m"])?,
            sigma_m: three(["sd_x_m", "sd_y_m", "sd_z_m"])?,
            status: texts("status"),
            flag: texts("flag"),
            gpst: texts("gpst"),
            line_starts: Vec::new(),
        })
    }

    /// The positions there are.
    #[must_use]
    pub fn placed_m(&self) -> Vec<[f64; 3]> {
        let is_placed = |p: &&[f64; 3]| p.iter().all(|v| v.is_finite());
        self.position_m.iter().filter(is_placed).copied().collect()
    }

    /// A place as seen from the trace nearest to it.
    #[must_use]
    pub fn nearest(&self, place_m: [f64; 3]) -> Option<Seen> {
        let traces = self.position_m.iter().zip(&self.trace);
        let seen = traces.map(|(position_m, trace)| Seen::from(*position_m, *trace, place_m));
        seen.filter(|seen| seen.range_m.is_finite())
            .min_by(|a, b| a.range_m.total_cmp(&b.range_m))
    }
}

impl Seen {
    /// A place as a trace at `position_m` sees it.
    #[must_use]
    pub fn from(position_m: [f64; 3], trace: f64, place_m: [f64; 3]) -> Self {
        let [range_m, incidence_deg] = range_and_incidence(position_m, place_m);
        Self {
            trace,
            range_m,
            incidence_deg,
        }
    }
}

/// Range (m) and angle of incidence from the vertical (degrees) of a place on level ground.
#[must_use]
pub fn range_and_incidence(position_m: [f64; 3], place_m: [f64; 3]) -> [f64; 2] {
    let [dx, dy, dz] = [0, 1, 2].map(|i| position_m[i] - place_m[i]);
    let across_m = dx.hypot(dy);
    [across_m.hypot(dz), across_m.atan2(dz).to_degrees()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_trace_has_range_and_incidence() {
        let text = "trace,time_s,x_m,y_m,z_m,flag\n4,0,0,0,3,ok\n5,1,4,0,3,ok\n6,2,,,,in-gap\n";
        let table = TrackTable::of(&Table::parse(text).unwrap()).unwrap();
        let pulse = table.nearest([4.0, 4.0, 0.0]).unwrap();
        assert_eq!(pulse.trace, 5.0);
        assert!((pulse.range_m - 5.0).abs() < 1e-12);
        assert!((pulse.incidence_deg - (4.0_f64 / 3.0).atan().to_degrees()).abs() < 1e-12);
        assert_eq!(table.placed_m().len(), 2);
        assert!(TrackTable::default().nearest([0.0; 3]).is_none());
    }
}
