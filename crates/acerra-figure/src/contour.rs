//! Contour lines of a regular grid, by marching squares.

use std::collections::BTreeMap;

/// A point in grid units: (column, row), fractional.
pub(super) type GridPoint = (f64, f64);

/// An edge of the grid: (row, column, whether it runs along a row).
type Edge = (usize, usize, bool);

/// The lines on which a row-major `columns × rows` grid takes `level`, each as a run of points.
/// Cells with a corner that is not finite carry no line; saddles are joined by the cell's mean.
pub(super) fn lines(
    values: &[f64],
    columns: usize,
    rows: usize,
    level: f64,
) -> Vec<Vec<GridPoint>> {
    let mut segments: Vec<(Edge, Edge)> = Vec::new();
    for row in 0..rows.saturating_sub(1) {
        for column in 0..columns.saturating_sub(1) {
            let at = |dr: usize, dc: usize| values[(row + dr) * columns + column + dc];
            let corners = [at(0, 0), at(0, 1), at(1, 1), at(1, 0)];
            if corners.iter().any(|v| !v.is_finite()) {
                continue;
            }
            let edges: [Edge; 4] = [
                (row, column, true),
                (row, column + 1, false),
                (row + 1, column, true),
                (row, column, false),
            ];
            let above = corners.map(|v| v >= level);
            let crossed: Vec<usize> = (0..4).filter(|i| above[*i] != above[(i + 1) % 4]).collect();
            match crossed[..] {
                [a, b] => segments.push((edges[a], edges[b])),
                [_, _, _, _] => {
                    let mean = corners.iter().sum::<f64>() / 4.0;
                    // Cut off the corners that differ from the middle.
                    if (mean >= level) == above[0] {
                        segments.push((edges[0], edges[1]));
                        segments.push((edges[2], edges[3]));
                    } else {
                        segments.push((edges[3], edges[0]));
                        segments.push((edges[1], edges[2]));
                    }
                }
                _ => {}
            }
        }
    }
    let point = |&(row, column, along): &Edge| {
        let a = values[row * columns + column];
        let (next_row, next_column) = if along {
            (row, column + 1)
        } else {
            (row + 1, column)
        };
        let b = values[next_row * columns + next_column];
        let fraction = (level - a) / (b - a);
        if along {
            (column as f64 + fraction, row as f64)
        } else {
            (column as f64, row as f64 + fraction)
        }
    };
    join(&segments)
        .into_iter()
        .map(|chain| chain.iter().map(point).collect())
        .collect()
}

/// Joins segments that share an end into chains, open ones first.
fn join(segments: &[(Edge, Edge)]) -> Vec<Vec<Edge>> {
    let mut at: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
    for (index, (a, b)) in segments.iter().enumerate() {
        at.entry(*a).or_default().push(index);
        at.entry(*b).or_default().push(index);
    }
    let mut used = vec![false; segments.len()];
    let mut chains = Vec::new();
    let ends = at
        .iter()
        .filter(|(_, list)| list.len() == 1)
        .map(|(edge, _)| *edge);
    let anywhere = segments.iter().map(|segment| segment.0);
    for start in ends.chain(anywhere) {
        let mut chain = vec![start];
        let mut here = start;
        while let Some(&next) = at[&here].iter().find(|index| !used[**index]) {
            used[next] = true;
            let (a, b) = segments[next];
            here = if a == here { b } else { a };
            chain.push(here);
        }
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contour_of_a_cone_is_one_closed_circle() {
        let n = 41;
        let values: Vec<f64> = (0..n * n)
            .map(|i| ((i % n) as f64 - 20.0).hypot((i / n) as f64 - 20.0))
            .collect();
        let found = lines(&values, n, n, 12.5);
        assert_eq!(found.len(), 1);
        let circle = &found[0];
        assert_eq!(circle.first(), circle.last());
        for (x, y) in circle {
            assert!(((x - 20.0).hypot(y - 20.0) - 12.5).abs() < 0.02);
        }
    }

    #[test]
    fn a_saddle_gives_two_open_lines_and_nan_cells_none() {
        assert_eq!(lines(&[1.0, 0.0, 0.0, 1.0], 2, 2, 0.5).len(), 2);
        assert!(lines(&[1.0, 0.0, f64::NAN, 1.0], 2, 2, 0.5).is_empty());
        assert!(lines(&[1.0], 1, 1, 0.5).is_empty());
    }
}
