//! Polylines with no more points than a figure can show.

/// The stretches of indices below `len` for which `usable` holds.
pub(super) fn runs(len: usize, usable: impl Fn(usize) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut out = Vec::new();
    let mut start = 0;
    for i in 0..=len {
        if i == len || !usable(i) {
            if start < i {
                out.push(start..i);
            }
            start = i + 1;
        }
    }
    out
}

/// The parts of `run` between which `x` steps by more than `longest_step`.
pub(super) fn without_gaps(
    run: std::ops::Range<usize>,
    x: &[f64],
    longest_step: f64,
) -> Vec<std::ops::Range<usize>> {
    let gaps = run
        .clone()
        .skip(1)
        .filter(|&i| (x[i] - x[i - 1]).abs() > longest_step);
    let mut starts = vec![run.start];
    starts.extend(gaps);
    let ends = starts.iter().skip(1).copied().chain([run.end]);
    starts
        .iter()
        .zip(ends)
        .map(|(&from, to)| from..to)
        .collect()
}

/// Reduces consecutive points in one pixel column to the first, lowest, highest and last of them:
/// a line of a million points draws as before, from a few thousand.
pub(super) fn column_extremes(points: Vec<(f32, f32)>) -> Vec<(f32, f32)> {
    let mut kept = Vec::with_capacity(points.len().min(4096));
    let mut rest = points.as_slice();
    while let Some(first) = rest.first() {
        let column = (first.0 * 2.0).floor();
        let count = rest
            .iter()
            .take_while(|p| (p.0 * 2.0).floor() == column)
            .count();
        let (group, after) = rest.split_at(count);
        rest = after;
        if count <= 4 {
            kept.extend_from_slice(group);
            continue;
        }
        let by_height = |a: &&(f32, f32), b: &&(f32, f32)| a.1.total_cmp(&b.1);
        kept.push(group[0]);
        kept.extend(group.iter().min_by(by_height));
        kept.extend(group.iter().max_by(by_height));
        kept.push(group[count - 1]);
    }
    thin(kept)
}

/// Drops points that lie within a third of a pixel of the last one kept.
pub(super) fn thin(points: Vec<(f32, f32)>) -> Vec<(f32, f32)> {
    let mut kept: Vec<(f32, f32)> = Vec::with_capacity(points.len().min(4096));
    for point in points {
        match kept.last() {
            Some(last) if (last.0 - point.0).hypot(last.1 - point.1) < 0.34 => {}
            _ => kept.push(point),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_steps_part_a_run() {
        let x = [0.0, 1.0, 2.0, 9.0, 10.0, 30.0];
        let parts = |run, longest| -> Vec<(usize, usize)> {
            let parts = without_gaps(run, &x, longest);
            parts
                .into_iter()
                .map(|part| (part.start, part.end))
                .collect()
        };
        assert_eq!(parts(0..6, 2.5), [(0, 3), (3, 5), (5, 6)]);
        assert_eq!(parts(1..5, f64::INFINITY), [(1, 5)]);
        assert_eq!(parts(3..4, 0.1), [(3, 4)]);
    }
}
