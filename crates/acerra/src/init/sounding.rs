//! Content of a radar file that decides whether the image lies below its antennas.

use acerra_formats::{Axis, Channel, Positions, Recording};

/// Relative permittivities between that of air and that of water, which a header may state.
const PERMITTIVITIES: std::ops::RangeInclusive<f64> = 1.5..=81.0;

/// Content of a radargram for an image below the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sounding {
    /// Two-way time that the record covers (s).
    pub(super) window_s: f64,
    /// Relative permittivity of the soil by the header.
    pub(super) permittivity: Option<f64>,
    /// Heights of the traces.
    pub(super) heights: Heights,
    /// Whether the file places transmitter and receiver.
    pub(super) has_antennas: bool,
}

/// Heights of traces in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Heights {
    /// None: traces have no places, or all heights are zero, or equal on the Earth, where the height of the first trace
    /// is the zero of heights.
    None,
    /// In the file's own axes.
    Local,
    /// Of places on the Earth.
    OnEarth,
}

impl Sounding {
    /// That of a radargram.
    pub(super) fn of(recording: &Recording, channel: &Channel) -> Option<Self> {
        let Axis::FastTime {
            step_s, samples, ..
        } = channel.axis
        else {
            return None;
        };
        let heights = match &channel.positions {
            Some(Positions::Local(places)) if places.iter().any(|p| p[2] != 0.0) => Heights::Local,
            Some(Positions::Geodetic(places)) if places.iter().any(|p| p[2] != places[0][2]) => {
                Heights::OnEarth
            }
            _ => Heights::None,
        };
        let stated = (recording.header.iter())
            .find(|(name, _)| name == "relative_permittivity")
            .and_then(|(_, value)| value.parse().ok());
        Some(Self {
            window_s: step_s * samples as f64,
            permittivity: stated.filter(|found| PERMITTIVITIES.contains(found)),
            heights,
            has_antennas: channel.antennas_m.is_some(),
        })
    }
}
