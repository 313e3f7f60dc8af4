//! The fewest lines that show the whole area.

use super::polygon::{Point, Polygon};
use super::{Curve, PlanError};

/// Most lines of a plan.
const MOST_LINES: usize = 500;

/// Smallest distance at which a waypoint counts as reached (m): positions by RTK are as good.
const LEAST_ACCEPTANCE_M: f64 = 0.05;

/// One line, as it is flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Distance to the left of the frame's origin, seen along the heading (m).
    pub offset_m: f64,
    /// Where it begins along the heading (m).
    pub start_m: f64,
    /// Where it ends (m); before `start_m` when it is flown against the heading.
    pub end_m: f64,
    /// Corners, east and north of home (m); two for a straight line.
    pub waypoints_m: Vec<[f64; 2]>,
}

impl Line {
    /// Length of the path through its corners (m).
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.waypoints_m
            .windows(2)
            .map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]))
            .sum()
    }

    /// Least and greatest coordinate along the heading (m).
    #[must_use]
    pub fn span_m(&self) -> (f64, f64) {
        (self.start_m.min(self.end_m), self.start_m.max(self.end_m))
    }
}

/// All lines of a plan, in the order in which they are flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    /// Their direction, clockwise from north (rad).
    pub heading_rad: f64,
    /// Distance between neighbours (m); none for a single line.
    pub spacing_m: Option<f64>,
    /// The lines.
    pub lines: Vec<Line>,
}

/// Along and to the left of a heading, from east and north.
pub(super) fn line_from_enu(heading_rad: f64, [e, n]: Point) -> Point {
    let (s, c) = heading_rad.sin_cos();
    [e * s + n * c, n * s - e * c]
}

/// East and north, from along and to the left of a heading.
pub(super) fn enu_from_line(heading_rad: f64, [along, left]: Point) -> Point {
    let (s, c) = heading_rad.sin_cos();
    [along * s - left * c, along * c + left * s]
}

/// The direction of the side along which the area is narrowest across.
pub(super) fn longest_way(area: &Polygon) -> f64 {
    let mut best = (f64::INFINITY, 0.0);
    for (a, b) in area.edges() {
        let heading = (b[0] - a[0])
            .atan2(b[1] - a[1])
            .rem_euclid(std::f64::consts::PI);
        let (low, high) = area.map(|p| line_from_enu(heading, p)).bounds();
        if high[1] - low[1] < best.0 - 1e-6 {
            best = (high[1] - low[1], heading);
        }
    }
    best.1
}

/// Offsets of the fewest lines whose strips from `near` to `far` on both sides fill
/// [`low`, `high`].
pub(super) fn cover(low: f64, high: f64, near: f64, far: f64) -> Result<Vec<f64>, PlanError> {
    let width = high - low;
    for n in 1..=MOST_LINES {
        let offsets: Vec<f64> = if near <= 0.0 {
            (0..n)
                .map(|k| low + width * (2 * k + 1) as f64 / (2 * n) as f64)
                .collect()
        } else if n == 1 {
            vec![low - near]
        } else {
            // The outer lines lie outside the area by the width of their blind strip.
            let step = (width + 2.0 * near) / (n - 1) as f64;
            (0..n).map(|k| low - near + step * k as f64).collect()
        };
        if fills(&offsets, low, high, near, far) {
            return Ok(offsets);
        }
    }
    Err(PlanError::Impossible(format!(
        "an area {width:.0} m wide needs more than {MOST_LINES} lines, each showing from {near:.1} \
         to {far:.1} m from the line: divide the area or ask for less"
    )))
}

/// Whether the strips leave no hole.
fn fills(offsets: &[f64], low: f64, high: f64, near: f64, far: f64) -> bool {
    let mut strips: Vec<(f64, f64)> = offsets
        .iter()
        .flat_map(|u| [(u - far, u - near), (u + near, u + far)])
        .collect();
    strips.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut shown = low;
    for (from, to) in strips {
        if from > shown + 1e-9 {
            break;
        }
        shown = shown.max(to);
    }
    shown >= high - 1e-9
}

impl Lines {
    /// Lines over an area (east and north of home, m) whose strips from `near` to `far` fill it, each long
    /// enough that every place within `reach_m` of the line is seen under the whole view: `run_m` before and
    /// after.
    pub(super) fn over(
        area: &Polygon,
        heading_rad: f64,
        (near, far): (f64, f64),
        reach_m: f64,
        run_m: f64,
    ) -> Result<Self, PlanError> {
        let turned = area.map(|p| line_from_enu(heading_rad, p));
        let (low, high) = turned.bounds();
        let offsets = cover(low[1], high[1], near, far)?;
        let spacing_m = (offsets.len() > 1).then(|| offsets[1] - offsets[0]);
        let mut lines = Vec::new();
        for offset_m in offsets {
            let Some((from, to)) = turned.extent_between(offset_m - reach_m, offset_m + reach_m)
            else {
                continue;
            };
            let (mut start_m, mut end_m) = (from - run_m, to + run_m);
            // There and back, without ways between.
            if lines.len() % 2 == 1 {
                std::mem::swap(&mut start_m, &mut end_m);
            }
            let waypoints_m = [start_m, end_m]
                .map(|along| enu_from_line(heading_rad, [along, offset_m]))
                .to_vec();
            lines.push(Line {
                offset_m,
                start_m,
                end_m,
                waypoints_m,
            });
        }
        Ok(Self {
            heading_rad,
            spacing_m,
            lines,
        })
    }

    /// Distance at which a waypoint counts as reached (m): as far as the drone may stray anyhow, yet
    /// no more than a quarter of the shortest leg, so that none is skipped, nor than the amplitude of
    /// the curve, so that its corners are not cut.
    pub(super) fn acceptance_m(&self, stray_m: f64, curve: Option<&Curve>) -> f64 {
        let legs = self
            .lines
            .iter()
            .flat_map(|line| line.waypoints_m.windows(2));
        let shortest_m = legs
            .map(|leg| (leg[1][0] - leg[0][0]).hypot(leg[1][1] - leg[0][1]))
            .fold(f64::INFINITY, f64::min);
        let amplitude_m = curve.map_or(f64::INFINITY, |curve| curve.amplitude_m);
        stray_m
            .min(0.25 * shortest_m)
            .min(amplitude_m)
            .max(LEAST_ACCEPTANCE_M)
    }

    /// The rectangle of all waypoints and home: west, south, east, north (m).
    pub(super) fn extent_m(&self) -> [f64; 4] {
        let places = self.lines.iter().flat_map(|line| &line.waypoints_m);
        places.fold([0.0; 4], |[west, south, east, north], [e, n]| {
            [west.min(*e), south.min(*n), east.max(*e), north.max(*n)]
        })
    }

    /// Bends the lines: their corners become the curve's waypoints.
    pub(super) fn bend(&mut self, curve: &Curve) {
        for line in &mut self.lines {
            line.waypoints_m = curve
                .waypoints_along_m(line.start_m, line.end_m)
                .into_iter()
                .map(|along| {
                    let left = line.offset_m + curve.left_m(along);
                    enu_from_line(self.heading_rad, [along, left])
                })
                .collect();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_turn_there_and_back() {
        let east = std::f64::consts::FRAC_PI_2;
        let [along, left] = line_from_enu(east, [3.0, 2.0]);
        assert!((along - 3.0).abs() < 1e-12 && (left - 2.0).abs() < 1e-12);
        let p = enu_from_line(0.7, line_from_enu(0.7, [5.0, -2.0]));
        assert!((p[0] - 5.0).abs() < 1e-12 && (p[1] + 2.0).abs() < 1e-12);
    }

    /// Every point of the width is between near and far from some line, and one line fewer leaves
    /// a hole.
    #[test]
    fn the_fewest_lines_leave_no_hole() {
        for (width, near, far) in [
            (5.0, 2.0, 8.0),
            (18.0, 2.0, 8.0),
            (40.0, 2.0, 8.0),
            (100.0, 3.0, 4.0),
            (30.0, 0.0, 5.0),
        ] {
            let offsets = cover(0.0, width, near, far).expect("possible");
            for i in 0..=1_000 {
                let u = width * f64::from(i) / 1_000.0;
                let shown = offsets.iter().any(|o| {
                    let d = (u - o).abs();
                    d >= near - 1e-6 && d <= far + 1e-6
                });
                assert!(shown, "{u} of {width}, {offsets:?}");
            }
            // No set of lines shows more than both its strips.
            assert!(offsets.len() as f64 >= width / (2.0 * (far - near)));
        }
        assert_eq!(cover(0.0, 5.0, 2.0, 8.0).expect("possible"), [-2.0]);
        assert_eq!(
            cover(0.0, 30.0, 0.0, 5.0).expect("possible"),
            [5.0, 15.0, 25.0]
        );
        assert!(cover(0.0, 1e5, 1.0, 2.0).is_err());
    }

    #[test]
    fn lines_reach_beyond_what_they_show() {
        let area = Polygon::new(vec![[0.0, 0.0], [30.0, 0.0], [30.0, 10.0], [0.0, 10.0]])
            .expect("an area");
        let heading = longest_way(&area);
        assert!((heading - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let lines = Lines::over(&area, heading, (2.0, 7.0), 7.0, 3.0).expect("possible");
        assert_eq!(lines.lines.len(), 2);
        assert!(lines.spacing_m.is_some_and(|m| (m - 14.0).abs() < 1e-9));
        let (first, second) = (&lines.lines[0], &lines.lines[1]);
        assert!((first.start_m + 3.0).abs() < 1e-9 && (first.end_m - 33.0).abs() < 1e-9);
        assert!((second.start_m - 33.0).abs() < 1e-9 && (second.end_m + 3.0).abs() < 1e-9);
        assert!((first.length_m() - 36.0).abs() < 1e-12);
        assert!((first.waypoints_m[0][1] + 2.0).abs() < 1e-9);
        assert!((lines.acceptance_m(0.3, None) - 0.3).abs() < 1e-12);
        assert!((lines.acceptance_m(50.0, None) - 9.0).abs() < 1e-12);
        assert!((lines.acceptance_m(0.0, None) - LEAST_ACCEPTANCE_M).abs() < 1e-12);
        let curve = Curve {
            amplitude_m: 0.2,
            period_m: 6.0,
            waypoints_per_period: 2,
            waypoint_tolerance_m: 0.05,
            ghost: Vec::new(),
        };
        assert!((lines.acceptance_m(0.3, Some(&curve)) - 0.2).abs() < 1e-12);
    }
}
