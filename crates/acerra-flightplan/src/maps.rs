//! Expected quality over the area: resolution, ghosts and looks.

use acerra_imaging::resolution::{across_track_m, along_track_m, range_m};

use super::lines::line_from_enu;
use super::{FlightPlan, LIGHT_SPEED_M_S};

/// Cells along the longer side of the area.
const CELLS: f64 = 160.0;

/// Values over the area, row-major, row 0 the southernmost; NaN outside it.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedMaps {
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from south to north.
    pub rows: usize,
    /// Centre of the first cell, east of home, and the step (m).
    pub east_m: [f64; 2],
    /// Centre of the first cell, north of home, and the step (m).
    pub north_m: [f64; 2],
    /// Best across-track resolution of all lines that show the cell (m), Eq. (9).
    pub across_m: Vec<f64>,
    /// Along-track resolution from that line (m), Eq. (6) with the view it has of the cell.
    pub along_m: Vec<f64>,
    /// Ghost of a target in the cell as that line shows it, relative to the target.
    pub ghost: Vec<f64>,
    /// Number of lines that image the cell as required.
    pub looks: Vec<f64>,
}

/// The maps of a plan.
#[must_use]
pub fn expected_maps(plan: &FlightPlan) -> ExpectedMaps {
    let (low, high) = plan.area.bounds();
    let step = (high[0] - low[0]).max(high[1] - low[1]) / CELLS;
    let cells = |axis: usize| ((high[axis] - low[axis]) / step).ceil().max(1.0) as usize;
    let (columns, rows) = (cells(0), cells(1));
    let first = |axis: usize| low[axis] + 0.5 * step;
    let mut maps = ExpectedMaps {
        columns,
        rows,
        east_m: [first(0), step],
        north_m: [first(1), step],
        across_m: Vec::with_capacity(columns * rows),
        along_m: Vec::with_capacity(columns * rows),
        ghost: Vec::with_capacity(columns * rows),
        looks: Vec::with_capacity(columns * rows),
    };
    for row in 0..rows {
        for column in 0..columns {
            let point = [
                first(0) + step * column as f64,
                first(1) + step * row as f64,
            ];
            let cell = plan
                .area
                .contains(point)
                .then(|| expected_at(plan, point))
                .flatten();
            let [across, along, ghost, looks] = cell.unwrap_or([f64::NAN; 4]);
            maps.across_m.push(across);
            maps.along_m.push(along);
            maps.ghost.push(ghost);
            maps.looks.push(looks);
        }
    }
    maps
}

/// Across, along, ghost, looks at a point east and north of home; none where no line shows it.
pub(super) fn expected_at(plan: &FlightPlan, point: [f64; 2]) -> Option<[f64; 4]> {
    let [along, left] = line_from_enu(plan.lines.heading_rad, point);
    let radar = &plan.file.radar;
    let resolution_m = range_m(radar.bandwidth_hz(), LIGHT_SPEED_M_S).ok()?;
    let (swath, height_m) = (&plan.swath, plan.swath.height_m);
    let mut looks = 0.0;
    let mut best: Option<[f64; 3]> = None;
    for line in &plan.lines.lines {
        let distance_m = (left - line.offset_m).abs();
        let (from, to) = line.span_m();
        if distance_m > swath.far_m || along <= from || along >= to {
            continue;
        }
        let range_m = height_m.hypot(distance_m);
        // Half of the angle between the views of both ends, at most the processed one.
        let view = |reach_m: f64| reach_m.atan2(range_m).min(plan.view.half_rad);
        let half_view = 0.5 * (view(along - from) + view(to - along));
        let Ok(across) = across_track_m(resolution_m, height_m, distance_m) else {
            continue;
        };
        let Ok(fine) = along_track_m(radar.centre_hz(), half_view, LIGHT_SPEED_M_S) else {
            continue;
        };
        if distance_m >= swath.near_m {
            looks += 1.0;
        }
        if best.is_none_or(|[a, ..]| across < a) {
            let ghost = plan.curve.as_ref().map_or(1.0, |c| c.ghost_at(distance_m));
            best = Some([across, fine, ghost]);
        }
    }
    best.map(|[across, fine, ghost]| [across, fine, ghost, looks])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlanFile;

    #[test]
    fn everywhere_in_the_area_is_as_fine_as_asked_for() {
        let text = "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2004], [40.9002, 14.2005], \
                    [40.90015, 14.2]]\n[want]\nalong_m = 0.06\nacross_m = 0.4\nrcs_dbsm = 10\n\
                    [drone]\nstray_m = 0.5\n";
        let plan = FlightPlan::make(PlanFile::parse(text).expect("a file")).expect("a plan");
        let maps = expected_maps(&plan);
        assert_eq!(maps.across_m.len(), maps.rows * maps.columns);
        let inside: Vec<usize> = (0..maps.across_m.len())
            .filter(|i| maps.looks[*i] >= 0.0)
            .collect();
        // The area fills a good part of its bounds.
        assert!(inside.len() > maps.across_m.len() / 3);
        for i in inside {
            assert!(maps.across_m[i] <= 0.4 + 1e-9 && maps.looks[i] >= 1.0);
            assert!(maps.along_m[i] <= 0.06 + 1e-9);
            assert_eq!(maps.ghost[i], 1.0);
        }
    }
}
