//! Positions that came with the traces of a radar file.

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::trajectory::{Frame, TimeOrigin};

/// One position for each trace of a radar file.
#[derive(Clone, Debug)]
pub struct TracePositions {
    /// The positions, x east, y north, z up (m).
    pub position_m: Vec<[f64; 3]>,
    /// Transmitters and receivers in the same axes (m), where they are apart.
    pub antennas_m: Option<[Vec<[f64; 3]>; 2]>,
    /// Numbers of the traces at which a line begins, other than the first: between lines nothing was
    /// measured.
    pub line_starts: Vec<usize>,
    /// Whether the stated ends of lines place the traces, so that nothing measured their spacing.
    pub is_by_line_ends: bool,
    /// Frame of the axes.
    pub frame: Frame,
    /// The instant at which the traces' times are zero.
    pub time_origin: TimeOrigin,
}

impl From<Vec<[f64; 3]>> for TracePositions {
    /// Positions at unknown places, with their clock.
    fn from(position_m: Vec<[f64; 3]>) -> Self {
        Self {
            position_m,
            antennas_m: None,
            line_starts: Vec::new(),
            is_by_line_ends: false,
            frame: Frame::Local,
            time_origin: TimeOrigin::Relative,
        }
    }
}

impl TracePositions {
    /// These positions in another frame on the Earth; positions at no known place stay as they are.
    #[must_use]
    pub fn in_frame(mut self, target: EnuFrame) -> Self {
        if let Frame::Enu(own) = self.frame
            && own != target
        {
            let antennas = self.antennas_m.iter_mut().flatten().flatten();
            for position in self.position_m.iter_mut().chain(antennas) {
                *position = target.enu_from_ecef(own.ecef_from_enu(*position));
            }
            self.frame = Frame::Enu(target);
        }
        self
    }
}
