//! Solution statuses: their colours and when each held.

use super::numbers::{fixed, quantile};
use acerra_figure::{Colour, TimelineRow};
use acerra_geo::trajectory::SolutionStatus;

/// The colour by which a status is shown.
pub(super) fn colour(status: SolutionStatus) -> Colour {
    match status {
        SolutionStatus::Fixed | SolutionStatus::External => Colour::Series(2),
        SolutionStatus::Float => Colour::Series(4),
        SolutionStatus::Ppp => Colour::Series(0),
        SolutionStatus::Dgps | SolutionStatus::Sbas => Colour::Series(3),
        SolutionStatus::Single => Colour::Series(1),
        _ => Colour::Series(7),
    }
}

/// Steps in time longer than this are gaps: three usual ones.
pub(super) fn longest_step_s(time_s: &[f64]) -> f64 {
    3.0 * usual_step_s(time_s)
}

fn usual_step_s(time_s: &[f64]) -> f64 {
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
    quantile(steps, 0.5)
        .filter(|step| *step > 0.0)
        .unwrap_or(1.0)
}

/// One row per status that occurs, best first, named with its share of the positions. A position counts until
/// the next one, but at most three usual intervals, so that gaps remain.
pub(super) fn rows(time_s: &[f64], status: &[SolutionStatus]) -> Vec<TimelineRow> {
    let usual = usual_step_s(time_s);
    let n = time_s.len();
    let mut rows = Vec::new();
    for wanted in SolutionStatus::ALL {
        let mut stretches: Vec<[f64; 2]> = Vec::new();
        let mut count = 0;
        for i in (0..n).filter(|i| status[*i] == wanted) {
            count += 1;
            let from = time_s[i];
            let next = time_s.get(i + 1).copied().unwrap_or(from + usual);
            let to = if next - from <= 3.0 * usual {
                next
            } else {
                from + usual
            };
            match stretches.last_mut() {
                Some(last) if last[1] >= from => last[1] = to,
                _ => stretches.push([from, to]),
            }
        }
        if count > 0 {
            let share = fixed(100.0 * f64::from(count) / n as f64, 1);
            rows.push(TimelineRow {
                label: format!("{} {share} %", wanted.name()),
                colour: colour(wanted),
                stretches,
            });
        }
    }
    rows
}
