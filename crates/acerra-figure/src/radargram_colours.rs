//! How the samples of a radargram become colours.

use super::colour::Palette;
use super::colour_bar::ColourBar;

/// How sample values become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RadargramColours {
    /// Signed amplitudes, blue through white to red, symmetric about zero. The end of the scale is
    /// `limit` where given, else the 99.5th percentile of the moduli.
    Signed {
        /// Amplitude at the ends of the scale.
        limit: Option<f64>,
    },
    /// Moduli in decibels below the largest, down to `floor_db` (negative).
    Decibel {
        /// The lowest level shown, in dB.
        floor_db: f64,
    },
}

/// The colours of one radargram: the scale and its unit.
pub(super) struct Colouring {
    pub bar: ColourBar,
    /// The modulus at 0 dB, or at the ends of a signed scale.
    unit: f64,
}

impl Colouring {
    pub fn new(colours: RadargramColours, samples: &[f32], unit_name: &str) -> Self {
        let mut moduli: Vec<f32> = samples
            .iter()
            .map(|v| v.abs())
            .filter(|v| v.is_finite())
            .collect();
        match colours {
            RadargramColours::Signed { limit } => {
                let unit = limit
                    .filter(|limit| *limit > 0.0 && limit.is_finite())
                    .or_else(|| percentile(&mut moduli, 0.995))
                    .unwrap_or(1.0);
                let title = if unit_name.is_empty() {
                    "amplitude".to_owned()
                } else {
                    format!("amplitude ({unit_name})")
                };
                let bar = ColourBar {
                    title,
                    palette: Palette::BlueRed,
                    range: [-unit, unit],
                    log: false,
                };
                Self { bar, unit }
            }
            RadargramColours::Decibel { floor_db } => {
                let floor = if floor_db < 0.0 && floor_db.is_finite() {
                    floor_db
                } else {
                    -60.0
                };
                let unit = f64::from(moduli.iter().copied().fold(0.0, f32::max));
                let bar = ColourBar {
                    title: "level relative to the maximum (dB)".to_owned(),
                    palette: Palette::Inferno,
                    range: [floor, 0.0],
                    log: false,
                };
                Self { bar, unit }
            }
        }
    }

    /// The place of a sample value on the colour scale, 0 to 1; NaN where it has none.
    pub fn fraction(&self, value: f64) -> f64 {
        if !value.is_finite() {
            return f64::NAN;
        }
        if self.bar.range[1] > 0.0 {
            return 0.5 + 0.5 * value / self.unit;
        }
        if value == 0.0 {
            return 0.0;
        }
        1.0 - 20.0 * (value.abs() / self.unit).log10() / self.bar.range[0]
    }
}

/// The value below which `share` of the values lie, where that is positive; else the largest where
/// that is.
fn percentile(values: &mut [f32], share: f64) -> Option<f64> {
    let index = ((values.len().checked_sub(1)?) as f64 * share).round() as usize;
    let (_, at, above) = values.select_nth_unstable_by(index, f32::total_cmp);
    let largest = above.iter().copied().fold(*at, f32::max);
    let chosen = if *at > 0.0 { *at } else { largest };
    (chosen > 0.0).then_some(f64::from(chosen))
}
