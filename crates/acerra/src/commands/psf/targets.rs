//! Several targets: their file, and the table of where the image shows them (Table 5).

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use acerra_imaging::psf::Retrieved;
use anyhow::{Context, bail, ensure};
use serde::Serialize;

use crate::commands::values::number;

const MOST_TARGETS: usize = 1000;

/// Reads `x,y,z` a line; a first line of names, blank lines and lines that begin with # are passed
/// over.
pub(super) fn read(file: &Path) -> anyhow::Result<Vec<[f64; 3]>> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    parse(&text).with_context(|| file.display().to_string())
}

fn parse(text: &str) -> anyhow::Result<Vec<[f64; 3]>> {
    let mut found = vec![];
    let mut header_allowed = true;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim().trim_start_matches('\u{feff}');
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let values: Vec<f64> = cells.iter().map_while(|c| number(c).ok()).collect();
        if header_allowed && values.is_empty() && cells.len() == 3 {
            header_allowed = false;
            continue;
        }
        header_allowed = false;
        ensure!(
            values.len() == 3 && cells.len() == 3,
            "line {}: expected x,y,z in metres, found {line:?}",
            index + 1
        );
        ensure!(
            found.len() < MOST_TARGETS,
            "more than {MOST_TARGETS} targets"
        );
        found.push([values[0], values[1], values[2]]);
    }
    if found.is_empty() {
        bail!("no target in the file: expected lines of x,y,z in metres");
    }
    Ok(found)
}

#[derive(Serialize)]
pub(super) struct Answer {
    plane_z_m: f64,
    targets: Vec<Entry>,
}

#[derive(Serialize)]
struct Place {
    x_m: f64,
    y_m: f64,
}

#[derive(Serialize)]
struct Place3 {
    x_m: f64,
    y_m: f64,
    z_m: f64,
}

#[derive(Serialize)]
struct Entry {
    #[serde(rename = "true")]
    target: Place3,
    /// Where Eq. (14) puts it; null where the plane does not show it.
    expected: Option<Place>,
    /// Where the image shows it; null where it is absent.
    retrieved: Option<Place>,
    /// Level of the maximum in its part of the image, found or not.
    level_db: f64,
    /// Whether it appears twice, mirrored at the track.
    mirrored: bool,
    /// Distance of the retrieved place from Eq. (14)'s.
    error_m: Option<f64>,
}

impl Answer {
    pub fn of(plane_z_m: f64, found: &[Retrieved]) -> Self {
        let place = |p: [f64; 2]| Place {
            x_m: p[0],
            y_m: p[1],
        };
        let targets = found
            .iter()
            .map(|r| {
                let [x_m, y_m, z_m] = r.target_m;
                Entry {
                    target: Place3 { x_m, y_m, z_m },
                    expected: r.expected_m.map(place),
                    retrieved: r.detected.then(|| place(r.found_m)),
                    level_db: r.level_db,
                    mirrored: r.mirrored,
                    error_m: r
                        .expected_m
                        .filter(|_| r.detected)
                        .map(|e| (e[0] - r.found_m[0]).hypot(e[1] - r.found_m[1])),
                }
            })
            .collect();
        Self { plane_z_m, targets }
    }
}

/// Prints the table.
pub(super) fn answer(
    json: bool,
    plane_z_m: f64,
    found: &[Retrieved],
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    if json {
        serde_json::to_writer_pretty(&mut *out, &Answer::of(plane_z_m, found))?;
        writeln!(out)?;
        return Ok(());
    }
    writeln!(out, "image plane z = {plane_z_m} m")?;
    writeln!(
        out,
        "  true x, y, z (m)          Eq. (14) x, y (m)   found x, y (m)      level (dB)"
    )?;
    for r in found {
        let [x, y, z] = r.target_m;
        let sign = if r.mirrored { "±" } else { "" };
        let pair = |p: [f64; 2]| {
            format!(
                "({:.3}, {sign}{:.3})",
                p[0],
                if r.mirrored { p[1].abs() } else { p[1] }
            )
        };
        let expected = r.expected_m.map_or_else(|| "not seen".to_owned(), pair);
        let shown = if r.detected {
            pair(r.found_m)
        } else {
            "absent".to_owned()
        };
        writeln!(
            out,
            "  {:<26}{expected:<20}{shown:<20}{:>8.1}",
            format!("({x:.3}, {y:.3}, {z:.3})"),
            r.level_db
        )?;
    }
    Ok(())
}

/// The same as CSV.
pub(super) fn csv(found: &[Retrieved]) -> String {
    let mut text =
        "x_m,y_m,z_m,expected_x_m,expected_y_m,found_x_m,found_y_m,level_db,detected,mirrored\n"
            .to_owned();
    for r in found {
        let [x, y, z] = r.target_m;
        let expected = r
            .expected_m
            .map_or_else(|| ",".to_owned(), |e| format!("{:.4},{:.4}", e[0], e[1]));
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{x},{y},{z},{expected},{:.4},{:.4},{:.2},{},{}",
            r.found_m[0], r.found_m[1], r.level_db, r.detected, r.mirrored
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_or_refused_by_line() {
        let text = "# Table 5\nx_m,y_m,z_m\n-2,0,0\n\n0, 0, 0.2\r\n2,0,0.4\n";
        assert_eq!(
            parse(text).unwrap(),
            [[-2.0, 0.0, 0.0], [0.0, 0.0, 0.2], [2.0, 0.0, 0.4]]
        );
        let message = |text| parse(text).unwrap_err().to_string();
        assert!(message("1,2,3\n1,2\n").starts_with("line 2:"));
        assert!(message("1,2,3\nx,y,z\n").starts_with("line 2:"));
        assert!(message("1,2,nan\n").starts_with("line 1:"));
        assert!(message("x,y,z\n").starts_with("no target"));
    }
}
