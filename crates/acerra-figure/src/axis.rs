//! Axes: quantity, unit and range.

/// Scale of the values along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisScale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; values at or below zero are left out.
    Log,
}

/// An axis: quantity, unit and range.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Unit; may be empty for pure numbers.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: AxisScale,
    /// Lowest and highest value shown; taken from the data where not given.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis over the range of its data.
    #[must_use]
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            scale: AxisScale::Linear,
            range: None,
        }
    }

    /// This axis, logarithmic.
    #[must_use]
    pub fn log(self) -> Self {
        Self {
            scale: AxisScale::Log,
            ..self
        }
    }

    /// This axis, over `[low, high]`.
    #[must_use]
    pub fn range(self, low: f64, high: f64) -> Self {
        Self {
            range: Some([low, high]),
            ..self
        }
    }

    pub(super) fn title(&self) -> String {
        if self.unit.is_empty() {
            self.label.clone()
        } else {
            format!("{} ({})", self.label, self.unit)
        }
    }

    /// The range to show: as stated, else that of `values`, widened by the share `pad`; never empty.
    pub(super) fn resolve(&self, values: impl Iterator<Item = f64>, pad: f64) -> [f64; 2] {
        let log = self.scale == AxisScale::Log;
        let usable = |v: f64| v.is_finite() && (!log || v > 0.0);
        if let Some([low, high]) = self.range
            && usable(low)
            && usable(high)
            && low != high
        {
            return [low.min(high), low.max(high)];
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| usable(*v)) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            return if log { [0.1, 10.0] } else { [0.0, 1.0] };
        }
        if log {
            let ratio = (high / low)
                .powf(pad)
                .max(if high > low { 1.0 } else { 2.0 });
            return [low / ratio, high * ratio];
        }
        // A constant is shown in the middle of a range wide enough to be labelled.
        let room = if high - low > 1e-12 * high.abs().max(low.abs()) {
            pad * (high - low)
        } else {
            (0.1 * high.abs()).max(0.5)
        };
        [low - room, high + room]
    }
}
