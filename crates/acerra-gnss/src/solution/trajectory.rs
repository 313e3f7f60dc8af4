//! Conversion of a solution to a trajectory, the input of the further processing.

use super::epoch::Solution;
use super::quality::Quality;
use super::summary::PpkSolution;
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Fix, Frame, SolutionStatus, TimeOrigin, Trajectory, TrajectoryError};

impl PpkSolution {
    /// The solution as a trajectory: east, north, up about the base (in single-point mode, about the first
    /// position), in GPS seconds of the first position's week, as from the reader of `.pos` files. Epochs
    /// positioned by codes alone are left out, unless there are no others.
    ///
    /// # Errors
    /// [`TrajectoryError::Empty`] when no epoch has a position.
    pub fn trajectory(&self) -> Result<Trajectory, TrajectoryError> {
        let first = self.epochs.first().ok_or(TrajectoryError::Empty)?;
        let frame = EnuFrame::from_ecef(self.base_position_ecef_m.unwrap_or(first.position_ecef_m));
        let origin = GpsTime::from_week_tow(first.time.week(), 0.0);
        let mut fixes: Vec<Fix> = Vec::with_capacity(self.epochs.len());
        // Positions from codes are metres off: they are used only where no others exist.
        let from_phases = |q: Quality| matches!(q, Quality::Fixed | Quality::Float);
        let any_from_phases = self.epochs.iter().any(|e| from_phases(e.quality));
        let usable = |e: &&Solution| !any_from_phases || from_phases(e.quality);
        for epoch in self.epochs.iter().filter(usable) {
            let time_s = epoch.time - origin;
            if fixes.last().is_some_and(|last| time_s <= last.time_s) {
                continue;
            }
            let mut fix = Fix::new(time_s, frame.enu_from_ecef(epoch.position_ecef_m));
            fix.covariance_m2 = Some(frame.enu_covariance_from_ecef(&epoch.covariance_ecef_m2));
            fix.velocity_m_s = epoch
                .velocity_ecef_m_s
                .map(|v| frame.enu_vector_from_ecef(v));
            fix.status = SolutionStatus::from_rtklib_q(u32::from(epoch.quality.number()));
            fix.satellites = u16::try_from(epoch.satellites).ok();
            fix.age_s = Some(epoch.age_s);
            fix.ratio = Some(epoch.ratio);
            fixes.push(fix);
        }
        Trajectory::new(Frame::Enu(frame), TimeOrigin::Gps(origin), fixes)
    }
}
