//! Settings files in TOML, such as campaign, scene and plan files: parsing errors with line and column, and
//! tables of rules for the values.
//!
//! ```text
//! text ──parse──► T ──check(table, rules)──► a valid T
//!        SyntaxError      ValueError
//! ```
//!
//! ```
//! use acerra_settings::{check, parse, rules, within};
//!
//! #[derive(serde::Deserialize)]
//! #[serde(deny_unknown_fields)]
//! struct Radar {
//!     interval_s: f64,
//! }
//!
//! let radar: Radar = parse("interval_s = 0.07\n")?;
//! check("radar", &rules!(radar as "{}" { interval_s: within(1e-3..=100.0) => "0.001 to 100" }))?;
//!
//! let error = parse::<Radar>("interval = 0.07\n").err().unwrap();
//! assert!(error.to_string().starts_with("line 1, column 1: unknown field `interval`"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod edit;
mod rules;
mod syntax;

pub use edit::{Assignment, EditError, Step, Value, assign};
pub use rules::{Rule, ValueError, check, each, given, holds, within};
pub use syntax::{SyntaxError, parse};
