//! Plans of the double-precision engine.

use super::bins::choose_table;
use super::check::imaging::{compare_values, most_pixels};
use super::operator::{DoublePlan, margin};
use super::planner::next_share;
use super::report::DoubleChoice;
use super::request::Request;
use crate::engine::double::{DoubleTables, has_relief};
use crate::engine::level_ways::LevelWays;
use crate::engine::tables::fit_error::FitErrors;
use crate::engine::ways::WayTolerance;
use crate::error::ImagingError;
use acerra_control::Control;

/// Plans that are tried.
const ATTEMPTS: usize = 3;
/// Degree of the polynomials.
const DEGREE: usize = 3;
/// Share of the accuracy that the first tables may take.
const FIRST_SHARE: f64 = 0.5;

/// Tables of `request` that keep its accuracy and fit in memory together with `output_bytes` of the result;
/// `None` for uneven frequencies, for tables that do not fit, and for accuracies below the rounding of a
/// single-precision image.
///
/// # Errors
/// Cancellation.
pub(super) fn double_tables(
    request: &Request,
    power: &[f64],
    output_bytes: u128,
    control: Control,
) -> Result<Option<DoublePlan<DoubleTables>>, ImagingError> {
    let pulses = &request.echoes.pulses;
    let Some(errors) = FitErrors::new(pulses, power).filter(|_| request.echoes.is_even()) else {
        return Ok(None);
    };
    let allowed = margin(request) * request.options.accuracy;
    let ranges_m = request.optical_ranges_m();
    let highest_hz = pulses.frequency_hz().iter().copied().fold(0.0, f64::max);
    let shortest_wave_m = pulses.light_speed_m_s() / highest_hz;
    let mut accuracy = FIRST_SHARE * request.aim * allowed;
    for attempt in 1..=ATTEMPTS {
        let Some(spec) = choose_table(pulses, &errors, DEGREE, (accuracy, 0.0)) else {
            return Ok(None);
        };
        let table_bytes = DoubleTables::bytes_for(&spec, &ranges_m);
        let limit_bytes = request.options.memory_limit_bytes;
        let Some(ray_bytes) = limit_bytes.checked_sub(table_bytes + output_bytes) else {
            return Ok(None);
        };
        let bytes = table_bytes + LevelWays::bytes_for(&request.echoes, &request.grid, ray_bytes);
        let level = request.options.level;
        // Where crossings of uneven ground do not follow from others, every ray is searched for.
        let tolerance = if attempt == ATTEMPTS && has_relief(&request.echoes) {
            WayTolerance::EXACT
        } else {
            WayTolerance::new(accuracy, shortest_wave_m)
        };
        let engine = DoubleTables::build(pulses, level, (spec, tolerance), &ranges_m, control)?
            .with_ray_bytes(ray_bytes);
        let check = compare_values(request, &engine, most_pixels(request), control)?;
        if check.error_bound <= allowed {
            let choice = DoubleChoice {
                level,
                bin_m: spec.bin_m,
                bins_per_period: spec.period,
                degree: DEGREE,
            };
            return Ok(Some(DoublePlan {
                engine,
                choice,
                check,
                bytes,
            }));
        }
        accuracy *= next_share(allowed, check);
    }
    Ok(None)
}
