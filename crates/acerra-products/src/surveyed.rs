//! Surveyed points (`[measure] survey`), and the targets of the image nearest to them.

use std::path::{Path, PathBuf};

use acerra_chain::calibrate::{PointsError, SurveyedPoint, read_points};
use acerra_figure::SurveyMark;
use acerra_imaging::metrics::Target;
use serde::Serialize;

/// Reasons why surveyed points cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SurveyError {
    /// The operating system does not read the file.
    #[error("{}: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: std::io::Error,
    },
    /// The file holds something else.
    #[error("{}: {cause}", path.display())]
    Points {
        /// The file.
        path: PathBuf,
        /// The line, with the expected and the found content.
        cause: PointsError,
    },
}

/// A surveyed point, and the target nearest to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyRecord {
    /// Name of the point.
    pub name: String,
    /// East (m).
    pub x_m: f64,
    /// North (m).
    pub y_m: f64,
    /// Up (m).
    pub z_m: f64,
    /// The target nearest to it on the map.
    pub nearest: Option<NearestTarget>,
}

/// The target nearest to a surveyed point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NearestTarget {
    /// Number of the target, the strongest being 1.
    pub target: usize,
    /// Horizontal distance (m).
    pub distance_m: f64,
    /// Target less point: east and north (m).
    pub off_m: [f64; 2],
}

/// Reads the points of a file; none where no file is named.
///
/// # Errors
/// An unreadable file, or a line of it that holds no point.
pub fn read_survey(path: Option<&Path>) -> Result<Vec<SurveyedPoint>, SurveyError> {
    let Some(path) = path else {
        return Ok(Vec::new());
    };
    let text = std::fs::read_to_string(path).map_err(|cause| SurveyError::Read {
        path: path.to_owned(),
        cause,
    })?;
    read_points(&text).map_err(|cause| SurveyError::Points {
        path: path.to_owned(),
        cause,
    })
}

/// Every point with the target nearest to it.
#[must_use]
pub fn compared(points: &[SurveyedPoint], targets: &[Target]) -> Vec<SurveyRecord> {
    let record = |point: &SurveyedPoint| {
        let [x_m, y_m, z_m] = point.position_m;
        let nearest = |(k, t): (usize, &Target)| {
            let off_m = [t.x_m - x_m, t.y_m - y_m];
            NearestTarget {
                target: k + 1,
                distance_m: off_m[0].hypot(off_m[1]),
                off_m,
            }
        };
        SurveyRecord {
            name: point.name.clone(),
            x_m,
            y_m,
            z_m,
            nearest: targets
                .iter()
                .enumerate()
                .map(nearest)
                .min_by(|a, b| a.distance_m.total_cmp(&b.distance_m)),
        }
    };
    points.iter().map(record).collect()
}

impl SurveyRecord {
    /// Mark of the point over the image.
    #[must_use]
    pub fn mark(&self) -> SurveyMark {
        SurveyMark {
            x_m: self.x_m,
            y_m: self.y_m,
            label: self.name.clone(),
            target_distance_m: self.nearest.map(|nearest| nearest.distance_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_holds_no_points_is_named_with_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, "a,1,2,3\nb,1,2\n").unwrap();
        let message = read_survey(Some(&path)).unwrap_err().to_string();
        assert!(
            message.contains("points.csv: line 2: expected"),
            "{message}"
        );
        let absent = folder.path().join("none.csv");
        let message = read_survey(Some(&absent)).unwrap_err().to_string();
        assert!(message.contains("none.csv: "), "{message}");
        assert_eq!(read_survey(None).unwrap(), []);
    }
}
