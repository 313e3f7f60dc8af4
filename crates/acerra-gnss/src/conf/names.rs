//! Options that are chosen by name, on a command line or in a file.

use crate::options::{AmbiguityMode, FilterDirection, GlonassAmbiguity, PositioningMode, RuleSet};
use crate::pos::{PosFrame, PosTime, PosTimeScale};
use std::fmt;
use std::str::FromStr;

/// A name that is none of an option's values.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected {expected}, found {found:?}")]
pub struct UnknownNameError {
    /// The valid names.
    pub expected: String,
    /// The name given.
    pub found: String,
}

/// Implements `Display` and `FromStr` by one table of names, and lists the values in its order.
macro_rules! named {
    ($type:ty { $($value:ident = $name:literal),+ $(,)? }) => {
        impl $type {
            /// Every value, in the order of RTKLIB's numbers where these exist.
            pub const ALL: &'static [Self] = &[$(Self::$value),+];

            /// The name on the command line.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name),+
                }
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }

        impl FromStr for $type {
            type Err = UnknownNameError;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                let value = Self::ALL.iter().find(|value| value.name() == text);
                value.copied().ok_or_else(|| UnknownNameError {
                    expected: [$($name),+].join(", "),
                    found: text.to_owned(),
                })
            }
        }
    };
}

named!(PositioningMode {
    Single = "single",
    Dgps = "dgps",
    Kinematic = "kinematic",
    Static = "static",
    MovingBase = "moving-base",
});

named!(FilterDirection {
    Forward = "forward",
    Backward = "backward",
    Combined = "combined",
    CombinedWithoutReset = "combined-no-reset",
});

named!(AmbiguityMode {
    Off = "off",
    Continuous = "continuous",
    Instantaneous = "instantaneous",
    FixAndHold = "fix-and-hold",
});

named!(GlonassAmbiguity {
    Off = "off",
    On = "on",
    Auto = "auto",
    FixAndHold = "fix-and-hold",
});

named!(RuleSet {
    Rtklib = "rtklib",
    Demo5 = "demo5",
});

named!(PosFrame {
    Geodetic = "llh",
    Ecef = "xyz",
    EnuBaseline = "enu",
});

named!(PosTime {
    WeekTow = "week",
    Calendar = "calendar",
});

named!(PosTimeScale {
    Gps = "gpst",
    Utc = "utc",
    Jst = "jst",
});

#[cfg(test)]
mod tests {
    use super::*;

    fn every_name_is_read_back<T>(all: &[T])
    where
        T: Copy + fmt::Display + FromStr<Err = UnknownNameError> + PartialEq + fmt::Debug,
    {
        for value in all {
            assert_eq!(value.to_string().parse(), Ok(*value));
        }
    }

    #[test]
    fn names_are_read_as_written() {
        every_name_is_read_back(PositioningMode::ALL);
        every_name_is_read_back(FilterDirection::ALL);
        every_name_is_read_back(AmbiguityMode::ALL);
        every_name_is_read_back(GlonassAmbiguity::ALL);
        every_name_is_read_back(RuleSet::ALL);
        every_name_is_read_back(PosFrame::ALL);
        every_name_is_read_back(PosTime::ALL);
        every_name_is_read_back(PosTimeScale::ALL);
        let error = "hold".parse::<AmbiguityMode>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected off, continuous, instantaneous, fix-and-hold, found \"hold\""
        );
    }
}
