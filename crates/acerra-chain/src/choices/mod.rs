//! Choices of each stage, as a settings file writes them: a word, a number, a list or a table.

mod ground;
mod image;
mod outcome;
mod parse;
mod position;
mod timing;
mod traces;

pub use ground::{GroundSurface, Permittivity};
pub use image::{AntennaAxis, CalibrationSource, Heights, LookTaper, Sum, Values, Weight};
pub use outcome::{Contradictions, ProductFormat};
pub(crate) use parse::{FARTHEST_M, LONGEST_NS, LONGEST_S};
pub use position::{HeightDatum, HeightSource, Unfixed};
pub use timing::{Delay, TimeOffset, ZeroTiming};
pub use traces::{Background, Gate, Select};

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize)]
    struct One<T> {
        key: T,
    }

    fn parse<T: serde::de::DeserializeOwned>(value: &str) -> Result<T, toml::de::Error> {
        toml::from_str::<One<T>>(&format!("key = {value}")).map(|one| one.key)
    }

    #[test]
    fn every_form_of_the_contract_is_read() {
        assert_eq!(parse::<Select>("\"moving\"").unwrap(), Select::Moving);
        assert_eq!(parse::<Select>("[3, 9]").unwrap(), Select::Range([3, 9]));
        assert_eq!(parse::<TimeOffset>("\"auto\"").unwrap(), TimeOffset::Auto);
        assert_eq!(
            parse::<TimeOffset>("-2").unwrap(),
            TimeOffset::Seconds(-2.0)
        );
        assert_eq!(
            parse::<ZeroTiming>("\"first-trace\"").unwrap(),
            ZeroTiming::FirstTrace
        );
        assert_eq!(
            parse::<ZeroTiming>("\"direct-wave\"").unwrap(),
            ZeroTiming::DirectWave
        );
        assert_eq!(
            parse::<ZeroTiming>("{ shift_ns = 1.5 }").unwrap(),
            ZeroTiming::Shift { shift_ns: 1.5 }
        );
        assert_eq!(
            parse::<Background>("{ window = 51 }").unwrap(),
            Background::Window { window: 51 }
        );
        assert_eq!(
            parse::<Background>("{ components = 2 }").unwrap(),
            Background::Components { components: 2 }
        );
        assert_eq!(
            parse::<Gate>("[-6, 24.0]").unwrap(),
            Gate::About([-6.0, 24.0])
        );
        assert_eq!(parse::<Gate>("\"none\"").unwrap(), Gate::None);
        assert_eq!(parse::<Gate>("\"auto\"").unwrap(), Gate::Auto);
        assert_eq!(parse::<Select>("\"auto\"").unwrap(), Select::Auto);
        assert_eq!(parse::<Delay>("\"auto\"").unwrap(), Delay::Auto);
        assert_eq!(parse::<Delay>("12").unwrap(), Delay::Nanoseconds(12.0));
        assert_eq!(parse::<Heights>("-1").unwrap(), Heights::Plane(-1.0));
        assert_eq!(
            parse::<Heights>("[0, 1.5]").unwrap(),
            Heights::Range([0.0, 1.5])
        );
    }

    #[test]
    fn everything_else_is_refused_with_what_was_expected() {
        for wrong in ["\"some\"", "[3]", "[9, 3]", "[-1, 3]", "[0.5, 2]", "true"] {
            let message = parse::<Select>(wrong).unwrap_err().to_string();
            assert!(message.contains("[first, last]"), "{message}");
        }
        assert!(parse::<TimeOffset>("nan").is_err());
        assert!(parse::<Delay>("nan").is_err());
        assert!(parse::<Delay>("'automatic'").is_err());
        for wrong in ["inf", "[0]", "[1, 0]", "[0, 1, 2]", "'low'"] {
            let message = parse::<Heights>(wrong).unwrap_err().to_string();
            assert!(message.contains("[from, to]"), "{message}");
        }
        assert!(parse::<ZeroTiming>("{ shift_ns = inf }").is_err());
        assert!(parse::<ZeroTiming>("{ shift_ns = 1, more = 2 }").is_err());
        assert!(parse::<Background>("{ window = 0 }").is_err());
        assert!(parse::<Background>("{ window = -5 }").is_err());
        assert!(parse::<Gate>("[24, -6]").is_err());
        assert!(parse::<Gate>("[-6, 24, 30]").is_err());
    }
}
