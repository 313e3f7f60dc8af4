//! Colours by role, and the colour maps of images.

use colorous::Gradient;

/// A colour, by its role in the figure or by value.
///
/// Roles become CSS variables in SVG (`--fig-ink`, `--fig-muted`, `--fig-grid`, `--fig-paper`,
/// `--fig-1` … `--fig-8`) with the light theme's value as fallback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Text and axis lines.
    Ink,
    /// Secondary text and tick marks.
    Muted,
    /// Grid lines.
    Grid,
    /// The ground of the figure.
    Paper,
    /// The n-th colour of data series, from 0, cyclic; the Okabe–Ito set, safe for colour-blind
    /// readers.
    Series(usize),
    /// A fixed sRGB value.
    Rgb(u8, u8, u8),
}

/// Okabe & Ito's colour-blind-safe palette, ordered by contrast on white, yellow darkened.
const SERIES: [[u8; 3]; 8] = [
    [0x00, 0x72, 0xB2],
    [0xD5, 0x5E, 0x00],
    [0x00, 0x9E, 0x73],
    [0xCC, 0x79, 0xA7],
    [0xB5, 0x89, 0x00],
    [0x56, 0xB4, 0xE9],
    [0x8A, 0x5A, 0x44],
    [0x6B, 0x6B, 0x6B],
];

impl Colour {
    /// The sRGB value on a light ground.
    #[must_use]
    pub fn rgb(self) -> [u8; 3] {
        match self {
            Self::Ink => [0x22, 0x26, 0x2B],
            Self::Muted => [0x5F, 0x68, 0x72],
            Self::Grid => [0xE3, 0xE7, 0xEB],
            Self::Paper => [0xFF, 0xFF, 0xFF],
            Self::Series(index) => SERIES[index % SERIES.len()],
            Self::Rgb(r, g, b) => [r, g, b],
        }
    }

    /// The CSS value: a variable with fallback for roles, a literal for fixed colours.
    pub(super) fn css(self) -> String {
        let [r, g, b] = self.rgb();
        let literal = format!("#{r:02x}{g:02x}{b:02x}");
        let role = match self {
            Self::Ink => "ink".to_owned(),
            Self::Muted => "muted".to_owned(),
            Self::Grid => "grid".to_owned(),
            Self::Paper => "paper".to_owned(),
            Self::Series(index) => (index % SERIES.len() + 1).to_string(),
            Self::Rgb(..) => return literal,
        };
        format!("var(--fig-{role},{literal})")
    }
}

/// A perceptually ordered colour map for values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Palette {
    /// Black through red and orange to pale yellow: highest contrast for images in decibels.
    #[default]
    Inferno,
    /// Violet through green to yellow.
    Viridis,
    /// Blue to yellow, made for colour-blind readers.
    Cividis,
    /// White to black.
    Greys,
    /// Blue through white to red, for values of both signs about zero.
    BlueRed,
}

impl Palette {
    fn gradient(self) -> Gradient {
        match self {
            Self::Inferno => colorous::INFERNO,
            Self::Viridis => colorous::VIRIDIS,
            Self::Cividis => colorous::CIVIDIS,
            Self::Greys => colorous::GREYS,
            Self::BlueRed => colorous::RED_BLUE,
        }
    }

    /// The colour at `fraction` of the map, clamped to `[0, 1]`; grey for NaN.
    #[must_use]
    pub fn at(self, fraction: f64) -> [u8; 3] {
        if fraction.is_nan() {
            return NO_VALUE;
        }
        let fraction = fraction.clamp(0.0, 1.0);
        let fraction = if self == Self::BlueRed {
            1.0 - fraction
        } else {
            fraction
        };
        let colour = self.gradient().eval_continuous(fraction);
        [colour.r, colour.g, colour.b]
    }

    /// The map at 1024 even steps, for quick look-up.
    pub(super) fn table(self) -> Vec<[u8; 3]> {
        (0..TABLE)
            .map(|i| self.at(i as f64 / (TABLE - 1) as f64))
            .collect()
    }
}

const TABLE: usize = 1024;

/// Pixels without a value.
pub(super) const NO_VALUE: [u8; 3] = [0x9A, 0x9F, 0xA5];

/// Looks `fraction` up in a palette's [`table`](Palette::table).
pub(super) fn look_up(table: &[[u8; 3]], fraction: f64) -> [u8; 3] {
    if fraction.is_nan() {
        return NO_VALUE;
    }
    let last = table.len() - 1;
    table[((fraction.clamp(0.0, 1.0) * last as f64).round() as usize).min(last)]
}
