//! The measurement update of an epoch, repeated without measurements that contradict the rest.

use super::residuals::Update;
use super::{EpochView, Filter};
use crate::linear::double_row::DoubleRow;
use crate::linear::outliers::{Worst, misfit, worst};
use crate::solution::NotFixedReason;

/// Share of the codes' past misfit that counts at the next epoch.
const MISFIT_KEPT: f64 = 0.98;

/// Reason for which an epoch could not be updated.
pub(super) struct UpdateFailure {
    pub reason: NotFixedReason,
    /// The update whose measurements contradict each other, if any.
    pub contradicting: Option<Update>,
}

impl Filter<'_> {
    /// Updates the state; measurements beyond the residual limits are added to `excluded` and the
    /// update repeated without them, until a third of the satellites is left out.
    pub(super) fn checked_update(
        &mut self,
        epoch: &EpochView<'_>,
        excluded: &mut Vec<(usize, usize)>,
    ) -> Result<Update, UpdateFailure> {
        let options = self.options;
        let checks_residuals =
            options.max_phase_residual_sigma.is_some() || options.max_code_residual_sigma.is_some();
        if !checks_residuals {
            return self.update(epoch, excluded);
        }
        let mut prior = self.room.take().unwrap_or_else(|| self.state.clone());
        prior.clone_from(&self.state);
        loop {
            let update = self.update(epoch, excluded)?;
            let Some(outlier) = self.outlier(&update.differences.rows) else {
                self.room = Some(prior);
                return Ok(update);
            };
            if 3 * (excluded.len() + 1) > epoch.common.len() {
                // More contradictions than agreement: the integers held must be wrong.
                self.forget_biases();
                return Err(UpdateFailure {
                    reason: NotFixedReason::PhasesInconsistent {
                        normalised: outlier.normalised,
                    },
                    contradicting: Some(update),
                });
            }
            excluded.push((outlier.common, outlier.slot));
            self.state.clone_from(&prior);
        }
    }

    pub(super) fn update(
        &mut self,
        epoch: &EpochView<'_>,
        excluded: &[(usize, usize)],
    ) -> Result<Update, UpdateFailure> {
        let least = self.options.policy().least_rows();
        let iterations = self.options.iterations.max(1);
        let prior = (iterations > 1).then(|| self.state.clone());
        for k in 0..iterations {
            let zero = self.rover_zero(epoch.rover);
            let rows = self.differences(epoch, &zero, &self.state, excluded).rows;
            // Measurements count once: every iteration starts from the state before the epoch.
            let again = prior.as_ref().filter(|_| k > 0);
            let done = rows.len() >= least
                && match again {
                    Some(prior) => self.update_again(prior, &rows, &epoch.common),
                    None => self.measurement_update(&rows, &epoch.common),
                };
            if !done {
                let common = self.count_valid(&rows, &epoch.common);
                return Err(UpdateFailure {
                    reason: NotFixedReason::TooFewCommonSatellites { common },
                    contradicting: None,
                });
            }
        }
        let zero = self.rover_zero(epoch.rover);
        let differences = self.differences(epoch, &zero, &self.state, excluded);
        Ok(Update { zero, differences })
    }

    /// The code, else the phase, that is furthest beyond its limit.
    fn outlier(&self, rows: &[DoubleRow]) -> Option<Worst> {
        let beyond = |limit: Option<f64>, is_code: bool| {
            let limit = limit?;
            worst(rows, is_code, |_, _| true).filter(|w| w.normalised > limit)
        };
        beyond(self.options.max_code_residual_sigma, true)
            .or_else(|| beyond(self.options.max_phase_residual_sigma, false))
    }

    /// Adds the codes' residuals to their fading sums.
    pub(super) fn note_misfit(&mut self, rows: &[DoubleRow]) {
        let (squares, freedom) = misfit(rows, true, |_, _| true);
        self.misfit = [
            MISFIT_KEPT * self.misfit[0] + squares,
            MISFIT_KEPT * self.misfit[1] + freedom as f64,
        ];
    }
}
