//! NAV-PVT and NAV-HPPOSLLH put together, epoch by epoch.

use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::SolutionStatus;
use acerra_gnss::ubx::frame::Frame;
use acerra_gnss::ubx::{FinePosition, ReceiverSolution, fine_position, receiver_solution};

/// A position of the receiver, by whatever message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Position {
    /// When.
    pub time: GpsTime,
    /// Position.
    pub place: Geodetic,
    /// Standard deviations east, north, up (m), where they are stated.
    pub sigma_m: Option<[f64; 3]>,
    /// Kind of the solution.
    pub status: SolutionStatus,
}

/// Puts the two messages of an epoch together. A receiver that has once sent the finer one is waited for.
#[derive(Debug, Default)]
pub(crate) struct Solutions {
    coarse: Option<ReceiverSolution>,
    fine: Option<FinePosition>,
    has_fine: bool,
    /// Whether the latest solution had no fix.
    pub is_without_fix: bool,
}

impl Solutions {
    /// Takes a message; returns the positions that are complete by now.
    pub fn take(&mut self, frame: &Frame<'_>) -> [Option<Position>; 2] {
        if let Some(solution) = receiver_solution(frame) {
            self.is_without_fix = solution.status.is_none();
            // The fine position of the one before never came.
            let left = self
                .coarse
                .replace(solution)
                .and_then(|s| position(&s, None));
            return [left, self.complete()];
        }
        if let Some(fine) = fine_position(frame) {
            self.has_fine = true;
            self.fine = Some(fine);
            return [None, self.complete()];
        }
        [None, None]
    }

    fn complete(&mut self) -> Option<Position> {
        let coarse = self.coarse?;
        let fine = self.fine.filter(|fine| fine.tow_ms == coarse.tow_ms);
        if fine.is_none() && self.has_fine && coarse.status.is_some() {
            return None;
        }
        self.coarse = None;
        position(&coarse, fine)
    }
}

fn position(coarse: &ReceiverSolution, fine: Option<FinePosition>) -> Option<Position> {
    let (time, status) = (coarse.time?, coarse.status?);
    Some(Position {
        time,
        place: fine.map_or(coarse.place, |fine| fine.place),
        sigma_m: Some(fine.map_or(coarse.sigma_m, |fine| fine.sigma_m)),
        status,
    })
}
