//! The product `trajectory.csv`, column by column.

use acerra_geo::time::{Calendar, GpsTime};
use anyhow::{Context, ensure};

/// A table with a line of names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads comma-separated values whose first line names the columns.
    ///
    /// # Errors
    /// A line with more or fewer cells than the first.
    pub fn parse(text: &str) -> anyhow::Result<Self> {
        let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines();
        let names = cells(
            lines
                .next()
                .context("line 1: expected names of columns, found none")?,
        );
        let mut rows = Vec::new();
        for (k, line) in lines.enumerate() {
            let row = cells(line);
            ensure!(
                row.len() == names.len(),
                "line {}: expected {} cells, found {}",
                k + 2,
                names.len(),
                row.len()
            );
            rows.push(row);
        }
        Ok(Self { names, rows })
    }

    /// Number of lines below the first.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no line below the first.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The cells of a column.
    #[must_use]
    pub fn texts(&self, name: &str) -> Option<impl Iterator<Item = &str>> {
        let column = self.names.iter().position(|n| n == name)?;
        Some(self.rows.iter().map(move |row| row[column].as_str()))
    }

    /// The numbers of a column, NaN where a cell is empty; none where the column is absent or empty
    /// altogether.
    ///
    /// # Errors
    /// A cell that is no number.
    pub fn numbers(&self, name: &str) -> anyhow::Result<Option<Vec<f64>>> {
        let Some(cells) = self.texts(name) else {
            return Ok(None);
        };
        let number = |(k, cell): (usize, &str)| match cell {
            "" => Ok(f64::NAN),
            cell => cell.parse().ok().with_context(|| {
                format!("line {}, {name}: expected a number, found {cell:?}", k + 2)
            }),
        };
        let values = cells
            .enumerate()
            .map(number)
            .collect::<anyhow::Result<Vec<f64>>>()?;
        Ok(values.iter().any(|v| !v.is_nan()).then_some(values))
    }

    /// First and last instant of traces that have a position, where the table holds them.
    #[must_use]
    pub fn time_span(&self) -> Option<[&str; 2]> {
        let instants: Vec<&str> = self
            .texts("gpst")?
            .zip(self.texts("flag")?)
            .filter_map(|(gpst, flag)| (flag == "ok").then_some(gpst))
            .collect();
        Some([instants.first()?, instants.last()?])
    }

    /// GPS time at second zero of the column `time_s`, where the table holds it.
    #[must_use]
    pub fn time_zero(&self) -> Option<GpsTime> {
        let gpst = instant(self.texts("gpst")?.next()?)?;
        let first_s: f64 = self.texts("time_s")?.next()?.parse().ok()?;
        Some(gpst + -first_s)
    }
}

/// The instant of a reading `yyyy/mm/dd hh:mm:ss.sss` in GPS time.
fn instant(text: &str) -> Option<GpsTime> {
    let (date, clock) = text.split_once(' ')?;
    let mut date = date.splitn(3, '/');
    let mut clock = clock.splitn(3, ':');
    let calendar = Calendar::new(
        date.next()?.parse().ok()?,
        date.next()?.parse().ok()?,
        date.next()?.parse().ok()?,
        clock.next()?.parse().ok()?,
        clock.next()?.parse().ok()?,
        clock.next()?.parse().ok()?,
    );
    calendar
        .ok()
        .map(|calendar| GpsTime::from_calendar(&calendar))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_numbers_or_texts() {
        let text = "time_s,x_m,sd_x_m,status,gpst\n\
                    10.5,1.25,,fixed,2020/04/05 00:00:10.500000\n\
                    11.5,,,float,2020/04/05 00:00:11.500000\n";
        let table = Table::parse(text).unwrap();
        assert_eq!(table.len(), 2);
        let x = table.numbers("x_m").unwrap().unwrap();
        assert!((x[0] - 1.25).abs() < 1e-12 && x[1].is_nan());
        assert_eq!(table.numbers("sd_x_m").unwrap(), None);
        assert_eq!(table.numbers("y_m").unwrap(), None);
        assert!(
            table
                .numbers("status")
                .unwrap_err()
                .to_string()
                .contains("line 2, status")
        );
        assert_eq!(table.time_zero(), Some(GpsTime::from_week_tow(2100, 0.0)));
        let short = Table::parse("a,b\n1\n").unwrap_err().to_string();
        assert_eq!(short, "line 2: expected 2 cells, found 1");
        assert!(Table::parse("").is_err());
    }
}
