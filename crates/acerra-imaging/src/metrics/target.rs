//! Measured figures of a target: the entries of `targets.json`.

use serde::Serialize;

/// Width of a target's image along the track, m. `None` (JSON `null`) where the image ends before
/// the lobe does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AlongTrack {
    /// Distance from the peak to the first minimum, mean of both sides.
    pub rayleigh_m: Option<f64>,
    /// Full width at −3 dB.
    pub width_3db_m: Option<f64>,
    /// Full width at −6 dB.
    pub width_6db_m: Option<f64>,
}

/// Width of a target's image across the track, m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AcrossTrack {
    /// Mean of `inner_m` and `outer_m`.
    pub rayleigh_m: Option<f64>,
    /// Distance from the peak to the first minimum on the side towards the track. For a lobe that spans the
    /// track, the side to the right of the flight counts as this side.
    pub inner_m: Option<f64>,
    /// Distance from the peak to the first minimum on the side away from the track.
    pub outer_m: Option<f64>,
    /// Full width at −3 dB.
    pub width_3db_m: Option<f64>,
    /// Full width at −6 dB.
    pub width_6db_m: Option<f64>,
}

/// The partner that the left–right ambiguity puts on the other side of the track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ghost {
    /// Amplitude of the ghost over the amplitude of the target.
    pub level: f64,
    /// Place of its maximum, m.
    pub x_m: f64,
    /// Place of its maximum, m.
    pub y_m: f64,
}

/// Shape of the image of one target, from an image or a prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Widths along the track.
    pub along: AlongTrack,
    /// Widths across the track.
    pub across: AcrossTrack,
    /// Highest sidelobe of the two cuts below the peak, dB.
    pub pslr_db: Option<f64>,
    /// Energy of the sidelobes over that of the main lobe, added over the two cuts, dB.
    pub islr_db: Option<f64>,
}

/// One measured target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Sub-pixel place of the maximum, m.
    pub x_m: f64,
    /// Sub-pixel place of the maximum, m.
    pub y_m: f64,
    /// Height of the image plane, m.
    pub z_m: f64,
    /// Level below the strongest pixel or target, dB (0 for the strongest).
    pub level_db: f64,
    /// Widths along the track.
    pub along: AlongTrack,
    /// Widths across the track.
    pub across: AcrossTrack,
    /// Highest sidelobe of the two cuts below the peak, dB.
    pub pslr_db: Option<f64>,
    /// Energy of the sidelobes over that of the main lobe, added over the two cuts, dB.
    pub islr_db: Option<f64>,
    /// The mirrored partner; `None` where the target lies so close to the track that both are one,
    /// or where the mirrored place is outside the image.
    pub ghost: Option<Ghost>,
}
