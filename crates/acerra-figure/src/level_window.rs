//! Which levels an image shows.

/// The levels that an image's colours span, in dB relative to its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelWindow {
    /// From `floor_db` to 0 dB.
    Fixed {
        /// The lowest level shown, in dB (negative); lower levels take its colour.
        floor_db: f64,
    },
    /// From a percentile of the image's own levels to 0 dB, so that a scene of little contrast is not black
    /// and a scene of much contrast is not washed out. The floor stays within [−80, −25] dB, and is the next
    /// whole decibel below the percentile.
    Percentile {
        /// Share of the pixels that lie below the floor, 0 to 1.
        share: f64,
    },
}

/// Lowest and highest floor taken from statistics, in dB.
const FLOOR_BOUNDS_DB: [f64; 2] = [-80.0, -25.0];
/// Floor where none can be had.
const USUAL_FLOOR_DB: f64 = -40.0;

impl LevelWindow {
    /// The floor for pixels of `levels_db` (any order; those that are not finite do not count),
    /// shown below `reference_db`.
    pub(super) fn floor_db(self, levels_db: &mut Vec<f64>, reference_db: f64) -> f64 {
        match self {
            Self::Fixed { floor_db } if floor_db < 0.0 && floor_db.is_finite() => floor_db,
            Self::Fixed { .. } => USUAL_FLOOR_DB,
            Self::Percentile { share } => {
                levels_db.retain(|level| level.is_finite());
                let Some(last) = levels_db.len().checked_sub(1) else {
                    return USUAL_FLOOR_DB;
                };
                let rank = (share.clamp(0.0, 1.0) * last as f64).round() as usize;
                let (_, level, _) = levels_db.select_nth_unstable_by(rank, f64::total_cmp);
                let floor_db = (*level - reference_db).floor();
                floor_db.clamp(FLOOR_BOUNDS_DB[0], FLOOR_BOUNDS_DB[1])
            }
        }
    }

    /// Text of the colour bar on the floor; empty for a fixed floor.
    pub(super) fn note(self) -> String {
        match self {
            Self::Fixed { .. } => String::new(),
            Self::Percentile { share } => {
                format!("; floor: percentile {:.0}", 100.0 * share)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_follows_the_levels_within_its_bounds() {
        let window = LevelWindow::Percentile { share: 0.25 };
        let floor = |levels: Vec<f64>| window.floor_db(&mut levels.clone(), 0.0);
        let even = |from: f64, to: f64| {
            (0..=100)
                .map(|i| from + (to - from) * f64::from(i) / 100.0)
                .collect::<Vec<f64>>()
        };
        assert_eq!(floor(even(-60.0, -20.0)), -50.0);
        assert_eq!(floor(even(-300.0, -100.0)), -80.0);
        assert_eq!(floor(even(-3.0, 0.0)), -25.0);
        assert_eq!(floor(vec![f64::NEG_INFINITY, f64::NAN]), -40.0);
    }
}
