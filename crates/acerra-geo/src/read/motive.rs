//! OptiTrack Motive's CSV export, format 1.2x.
//!
//! The rows of types, names and identities above the data may lack their labels or be blank altogether
//! (format 1.22); [`motive_header`](super::motive_header) describes these rows.
//!
//! Motive's world has Y up. It becomes x = X, y = −Z, z = Y, which keeps it right-handed and
//! unmirrored; a quaternion (w; X, Y, Z) becomes (w; X, −Z, Y), so that a body aligned with the
//! world when it was defined has its forward axis along x, left along y.

use std::io::BufRead;

use super::assemble::{Assembler, Axes, Record, Stamp};
use super::csv_columns::Separator;
use super::error::quoted;
use super::lines::Lines;
use super::motive_header::{BodyColumns, Header};
use super::{ReadError, ReadOptions, ReadReport, ReadWarning, SkipReason, TrajectoryFormat};
use crate::trajectory::{Attitude, Fix, Frame, TimeOrigin, Trajectory};

const COMMA: Separator = Separator::Char(',');

pub(super) fn read<R: BufRead>(
    lines: &mut Lines<R>,
    options: &ReadOptions,
) -> Result<(Trajectory, ReadReport), ReadError> {
    let mut all = Assembler::new(options, ReadReport::new(TrajectoryFormat::Motive));
    let (header, columns, unit_m) = read_header(lines, options, &mut all.report)?;
    let furthest = columns
        .position
        .into_iter()
        .chain(columns.rotation.into_iter().flatten())
        .chain([columns.time])
        .max()
        .unwrap_or(0);

    let mut rows = 0u64;
    while let Some(line) = lines.next()? {
        if line.text.trim().is_empty() {
            continue;
        }
        let cells = COMMA.split(&line.text);
        if cells.len() <= furthest {
            let expected = format!("{} columns or more", furthest + 1);
            return Err(line.malformed(
                expected,
                format!("{} in {}", cells.len(), quoted(&line.text)),
            ));
        }
        rows += 1;
        let time_s = line.number_in("time", cells[columns.time], -1e9..=1e9, "within 1e9 s")?;
        let [x, y, z] = columns.position.map(|i| cells[i]);
        if x.is_empty() && y.is_empty() && z.is_empty() {
            all.skip(SkipReason::EmptyPosition, line.number);
            continue;
        }
        let x = line.metres("X", x)? * unit_m;
        let y = line.metres("Y", y)? * unit_m;
        let z = line.metres("Z", z)? * unit_m;
        let mut fix = Fix::new(0.0, [x, -z, y]);
        if let Some(rotation) = columns.rotation
            && rotation.iter().any(|&i| !cells[i].is_empty())
        {
            let mut q = [0.0; 4];
            for (q, i) in q.iter_mut().zip(rotation) {
                *q = line.number("rotation", cells[i])?;
            }
            let [x, y, z, w] = q;
            fix.attitude = Attitude::from_quaternion(w, x, -z, y);
        }
        let record = Record {
            line: line.number,
            stamp: Stamp::Seconds(time_s),
            fix,
        };
        all.push(record, line.read_bytes)?;
    }

    if let Some(promised) = header
        .entry("Total Exported Frames")
        .and_then(|n| n.parse().ok())
        && promised > rows
    {
        all.report.warnings.push(ReadWarning::RowsMissing {
            promised,
            found: rows,
        });
    }
    all.finish(
        &Axes::Local(Frame::Local),
        TimeOrigin::Relative,
        lines.count(),
    )
}

fn read_header<R: BufRead>(
    lines: &mut Lines<R>,
    options: &ReadOptions,
    report: &mut ReadReport,
) -> Result<(Header, BodyColumns, f64), ReadError> {
    let mut header = Header::default();
    let mut first = true;
    while let Some(line) = lines.next()? {
        let text = line.text.trim();
        if text.is_empty() {
            continue;
        }
        let cells = COMMA.split(text);
        if first {
            first = false;
            let pairs = cells.chunks_exact(2);
            header.entries = pairs.map(|p| (p[0].to_owned(), p[1].to_owned())).collect();
            continue;
        }
        if cells
            .first()
            .is_some_and(|c| c.eq_ignore_ascii_case("Frame"))
        {
            if let Some(columns) = header.infer_bodies(&cells) {
                report.warnings.push(ReadWarning::UnnamedBody { columns });
            }
            let (name, kind) = header.choose(options.rigid_body.as_deref())?;
            let columns = header.columns(line.number, &cells, &name, kind)?;
            let unit_m = length_unit(&header)?;
            describe(&header, &name, columns.rotation.is_some(), report);
            return Ok((header, columns, unit_m));
        }
        header.add_row(&cells);
        if line.number > 20 {
            break;
        }
    }
    Err(ReadError::Header {
        line: lines.count(),
        problem: "no row of column axes, which begins with Frame,Time".to_owned(),
    })
}

fn length_unit(header: &Header) -> Result<f64, ReadError> {
    match header.entry("Length Units") {
        None | Some("Meters") => Ok(1.0),
        Some("Centimeters") => Ok(1e-2),
        Some("Millimeters") => Ok(1e-3),
        Some("Inches") => Ok(0.0254),
        Some("Feet") => Ok(0.3048),
        Some(other) => Err(ReadError::Header {
            line: 1,
            problem: format!("length unit {} is not known", quoted(other)),
        }),
    }
}

fn describe(header: &Header, body: &str, has_rotation: bool, report: &mut ReadReport) {
    report.about("rigid body", body);
    for key in [
        "Take Name",
        "Capture Start Time",
        "Export Frame Rate",
        "Format Version",
    ] {
        if let Some(value) = header.entry(key) {
            report.about(&key.to_lowercase(), value);
        }
    }
    if let Some(kind) = header.entry("Rotation Type")
        && !kind.eq_ignore_ascii_case("Quaternion")
        && !has_rotation
    {
        report.warnings.push(ReadWarning::RotationIgnored {
            kind: kind.to_owned(),
        });
    }
    if header
        .entry("Coordinate Space")
        .is_some_and(|s| !s.eq_ignore_ascii_case("Global"))
    {
        report.warnings.push(ReadWarning::LocalSpace);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::read_trajectory;

    /// Two bodies and a marker, in an order of columns that no export has.
    fn take(unit: &str, rows: &str) -> String {
        format!(
            "Format Version,1.23,Take Name,Made,Total Exported Frames,3,Rotation Type,Quaternion,\
             Length Units,{unit},Coordinate Space,Global\r\n\r\n\
             ,Type,Marker,Marker,Marker,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,\
             Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\r\n\
             ,Name,M 1,M 1,M 1,Drone,Drone,Drone,Drone,Drone,Drone,Drone,Drone,Wand,Wand,Wand\r\n\
             ,ID,a,a,a,b,b,b,b,b,b,b,b,c,c,c\r\n\
             ,,Position,Position,Position,Position,Position,Position,Mean Marker Error,Rotation,\
             Rotation,Rotation,Rotation,Position,Position,Position\r\n\
             Frame,Time (Seconds),X,Y,Z,Z,Y,X,,W,X,Y,Z,X,Y,Z\r\n{rows}"
        )
    }

    fn drone(text: &str) -> Result<(Trajectory, ReadReport), ReadError> {
        read_trajectory(
            text.as_bytes(),
            &ReadOptions::default().with_rigid_body("Drone"),
        )
    }

    #[test]
    fn columns_are_found_by_name_and_axes_turned() -> Result<(), ReadError> {
        // A quarter turn about Y (up): forward X goes to −Z, which is our +y.
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let rows = format!(
            "0,0.0,9,9,9,3,2,1,0.001,{h},0,{h},0,7,8,9\r\n1,0.5,9,9,9,,,,,,,,,7,8,9\r\n\
             2,1.0,9,9,9,3,2,1,0.001,,,,,7,8,9\r\n"
        );
        for (unit, size) in [
            ("Meters", 1.0),
            ("Millimeters", 1e-3),
            ("Centimeters", 1e-2),
        ] {
            let (track, report) = drone(&take(unit, &rows))?;
            assert_eq!(track.fixes().len(), 2);
            assert_eq!(track.fixes()[0].position_m, [size, -3.0 * size, 2.0 * size]);
            let forward = track.fixes()[0]
                .attitude
                .expect("attitude")
                .rotate([1.0, 0.0, 0.0]);
            assert!(crate::matrix::distance(forward, [0.0, 1.0, 0.0]) < 1e-12);
            assert_eq!(track.fixes()[1].attitude, None);
            assert_eq!(report.skipped_for(SkipReason::EmptyPosition), 1);
            assert_eq!(report.skipped[0].first_line, 9);
            assert!(report.warnings.is_empty());
        }
        let options = ReadOptions::default().with_rigid_body("M 1");
        let (marker, _) = read_trajectory(take("Meters", &rows).as_bytes(), &options)?;
        assert_eq!(marker.fixes()[0].position_m, [9.0, -9.0, 9.0]);
        Ok(())
    }

    /// As Motive writes format 1.22: the label cells of the type, name and property rows are blank.
    #[test]
    fn rows_without_labels_are_told_by_their_content() -> Result<(), ReadError> {
        let row = "0,0.0,9,9,9,3,2,1,0.001,1,0,0,0,7,8,9\r\n";
        let text = take("Meters", row).replace("Format Version,1.23", "Format Version,1.22");
        let unlabelled = text
            .replace("\r\n,Type,", "\r\n,,")
            .replace("\r\n,Name,", "\r\n,,")
            .replace("\r\n,ID,", "\r\n,,");
        let without_ids = unlabelled.replace(",,a,a,a,b,b,b,b,b,b,b,b,c,c,c\r\n", "");
        assert_ne!(without_ids, unlabelled);
        let (want, _) = drone(&text)?;
        for text in [&unlabelled, &without_ids, &unlabelled.replace("\r\n", "\r")] {
            let (track, report) = drone(text)?;
            assert_eq!(track, want);
            assert_eq!(report.warnings.len(), 1); // rows missing, as ever
        }
        Ok(())
    }

    #[test]
    fn bodies_without_names_are_told_by_their_axes() -> Result<(), ReadError> {
        let text = |rows: &str, axes: &str| {
            format!(
                "Format Version,1.22,Take Name,Made,Rotation Type,Quaternion,Length Units,Meters\n\n\
                 {rows}Frame,Time (Seconds),{axes}\n0,0.0,0,0,0,1,1,2,3,4,5,6\n"
            )
        };
        let blank = ",,,,,,,,,,,\n";
        let properties = ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,,,\n";
        for rows in [String::new(), blank.repeat(3), blank.repeat(2) + properties] {
            let text = text(&rows, "X,Y,Z,W,X,Y,Z,,,");
            let (track, report) = read_trajectory(text.as_bytes(), &ReadOptions::default())?;
            assert_eq!(track.fixes()[0].position_m, [1.0, -3.0, 2.0], "{rows}");
            assert!(track.fixes()[0].attitude.is_some());
            assert_eq!(
                report.warnings,
                [ReadWarning::UnnamedBody { columns: [3, 9] }]
            );
        }
        // Two bodies cannot be separated; positions alone may be a marker's.
        let two = "X,Y,Z,W,X,Y,Z,X,Y,Z,W,X,Y,Z";
        let read = |axes| read_trajectory(text("", axes).as_bytes(), &ReadOptions::default());
        assert!(matches!(read(two), Err(ReadError::SeveralBodies { names }) if names.len() == 2));
        assert!(matches!(read("X,Y,Z"), Err(ReadError::NoSuchBody { .. })));
        Ok(())
    }

    #[test]
    fn faults() {
        let row = "0,0.0,9,9,9,3,2,1,0.001,1,0,0,0,7,8,9\r\n";
        let text = take("Meters", row);
        let plain = read_trajectory(text.as_bytes(), &ReadOptions::default());
        assert_eq!(
            plain.expect_err("two bodies").to_string(),
            "several rigid bodies, choose one by name: Drone, Wand"
        );
        let options = ReadOptions::default().with_rigid_body("Kite");
        let kite = read_trajectory(text.as_bytes(), &options)
            .expect_err("no kite")
            .to_string();
        assert_eq!(
            kite,
            "no rigid body or marker named 'Kite'; there are: Drone, Wand"
        );
        let (_, report) = drone(&text).expect("readable");
        assert_eq!(
            report.warnings,
            [ReadWarning::RowsMissing {
                promised: 3,
                found: 1
            }]
        );
        assert!(drone(&take("Furlongs", row)).is_err());
        assert!(matches!(
            drone(&take("Meters", "0,0.0,9,9")),
            Err(ReadError::CutOff { line: 8, .. })
        ));
        assert!(matches!(
            drone(&take("Meters", "")),
            Err(ReadError::NoPositions { .. })
        ));
        assert!(matches!(drone(&text[..300]), Err(ReadError::Header { .. })));
        let nan = row.replace(",3,2,1,", ",3,nan,1,");
        assert!(matches!(
            drone(&take("Meters", &nan)),
            Err(ReadError::NotFinite { line: 8, .. })
        ));
    }
}
