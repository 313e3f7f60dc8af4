//! Surveyed points: places of reflectors in a text file.

/// Most points that a file may hold.
const MOST_POINTS: usize = 10_000;

/// A surveyed point.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyedPoint {
    /// Name of the point; its number where the file gives no name.
    pub name: String,
    /// East, north, up (m).
    pub position_m: [f64; 3],
}

/// Reason why points cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PointsError {
    /// A line that is no point.
    #[error(
        "line {line}: expected x_m,y_m,z_m or name,x_m,y_m,z_m, three finite numbers in metres, \
         found {found:?}"
    )]
    Line {
        /// Number, from 1.
        line: usize,
        /// Content.
        found: String,
    },
    /// No point at all.
    #[error("expected at least one point, as x_m,y_m,z_m, one point a line")]
    Empty,
    /// Too many points.
    #[error("line {line}: expected at most {limit} points")]
    TooMany {
        /// The line at which the limit is passed.
        line: usize,
        /// The limit.
        limit: usize,
    },
}

/// Reads points from text: one a line as `x,y,z` or `name,x,y,z` in metres. A header, empty lines and
/// those that start with `#` are passed over.
///
/// # Errors
/// A line that holds no point, with its number; a file without a point.
///
/// ```
/// let points = acerra_chain::calibrate::read_points("name,x_m,y_m,z_m\nwest,4.0,-1.5,0.12\n")?;
/// assert_eq!((points[0].name.as_str(), points[0].position_m), ("west", [4.0, -1.5, 0.12]));
/// # Ok::<(), acerra_chain::calibrate::PointsError>(())
/// ```
pub fn read_points(text: &str) -> Result<Vec<SurveyedPoint>, PointsError> {
    let mut points = Vec::new();
    let mut header_may_come = true;
    for (number, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line_number = number + 1;
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let is_header = header_may_come && line.split(',').any(|cell| cell.trim() == "x_m");
        header_may_come = false;
        if is_header {
            continue;
        }
        let point = point(line, points.len() + 1).ok_or_else(|| PointsError::Line {
            line: line_number,
            found: line.chars().take(60).collect(),
        })?;
        if points.len() == MOST_POINTS {
            return Err(PointsError::TooMany {
                line: line_number,
                limit: MOST_POINTS,
            });
        }
        points.push(point);
    }
    if points.is_empty() {
        return Err(PointsError::Empty);
    }
    Ok(points)
}

fn point(line: &str, number: usize) -> Option<SurveyedPoint> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let (name, numbers) = match cells.as_slice() {
        numbers if numbers.len() == 3 => (number.to_string(), numbers),
        [name, numbers @ ..] if numbers.len() == 3 => ((*name).to_owned(), numbers),
        _ => return None,
    };
    let mut position_m = [0.0; 3];
    for (value, cell) in position_m.iter_mut().zip(numbers) {
        *value = cell.parse().ok().filter(|v: &f64| v.is_finite())?;
    }
    Some(SurveyedPoint { name, position_m })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn points_with_and_without_names_are_read_and_others_placed() {
        let points = read_points("# corners\r\n1,2,3\r\n\r\n b , 4, 5 ,6e-1\r\n").unwrap();
        assert_eq!(points[0].name, "1");
        assert_eq!(points[1].position_m, [4.0, 5.0, 0.6]);
        assert_eq!(points[1].name, "b");
        for text in [
            "1,2\n",
            "a,b,c,d,e\n",
            "1,2,nan\n",
            "x_m,y_m,z_m\nx_m,y_m,z_m\n",
        ] {
            let message = read_points(text).unwrap_err().to_string();
            assert!(message.starts_with("line "), "{message}");
        }
        assert_eq!(read_points("# none\n"), Err(PointsError::Empty));
        let many = "0,0,0\n".repeat(MOST_POINTS + 1);
        assert!(matches!(
            read_points(&many),
            Err(PointsError::TooMany { .. })
        ));
    }
}
