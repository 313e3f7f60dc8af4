//! RINEX observation and navigation files, versions 2, 3 and 4.
//!
//! Columns are taken strictly where the format puts them (a pseudo-type such as `X1` occupies its column like
//! any other); a defect drops the value, satellite or epoch concerned, and is counted in the
//! [report](crate::input::ReadReport).

mod epoch;
mod fields;
mod header;
mod navigation;
mod navigation_record;
mod observation;
mod types;

pub(crate) use fields::{calendar, column, real, text};
pub use header::ObservationHeader;
pub use navigation::read_navigation_lines;
pub(crate) use navigation_record::{
    accuracy_of_index_m, galileo_accuracy_of_index_m, moscow_time, nearest_week, utc_to_gps,
};
pub use observation::{ObservationRecord, RinexObservations};
