//! GNSS: logs of two receivers, one flying and one on the ground.
//!
//! [`simulate`] follows the physics forward: satellites on their broadcast orbits, light that takes
//! its time while the Earth turns, clocks that wander, an ionosphere and a troposphere, noise and
//! multipath that grow towards the horizon, whole and half cycles, slips, blockages and outages.
//! The logs are written as RINEX 2.11 ([`ReceiverLog::to_rinex`], [`navigation_to_rinex`]) and as
//! the UBX messages of a u-blox LEA-6T ([`ReceiverLog::to_ubx`]). Equal input gives equal bytes.
//!
//! Every random process has a separate stream of numbers, so that changing one receiver, or the noise of one,
//! has no effect on the others.
//!
//! ```
//! use acerra_simulate::gnss::{GnssModel, Setting, constellation, simulate};
//! use acerra_geo::geodesy::{EnuFrame, Geodetic};
//! use acerra_geo::time::{Calendar, GpsTime};
//!
//! let start = GpsTime::from_calendar(&Calendar::new(2018, 7, 9, 9, 30, 0.0)?);
//! let logs = simulate(&GnssModel::default(), &Setting {
//!     frame: EnuFrame::new(Geodetic::from_degrees(40.95, 14.35, 60.0)),
//!     start,
//!     duration_s: 10.0,
//!     rover_m: &|time_s| [1.5 * time_s, 0.0, 10.0],
//!     base_m: [-20.0, 5.0, 1.5],
//!     navigation: &constellation(start, 10.0, 1),
//!     seed: 1,
//! })?;
//! assert!(logs.rover.to_rinex("ROVER").starts_with("     2.11           OBSERVATION DATA"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod clock;
mod constellation;
mod link;
mod lnav;
mod model;
mod receiver;
mod rinex;
mod setting;
#[cfg(test)]
mod tests;
mod ubx;

pub use constellation::constellation;
pub use model::{GnssError, GnssModel, ReceiverModel};
pub use receiver::{Observed, ObservedEpoch, ReceiverLog};
pub use rinex::navigation_to_rinex;
pub use setting::Setting;

/// Logs of the receivers.
#[derive(Clone, Debug)]
pub struct GnssLogs {
    /// The flying receiver.
    pub rover: ReceiverLog,
    /// The receiver on the ground.
    pub base: ReceiverLog,
}

/// Simulates both receivers.
///
/// # Errors
/// [`GnssError`] for a model that no receiver can have, a duration that is not between a moment and
/// a day, or a sky without at least four satellites.
pub fn simulate(model: &GnssModel, setting: &Setting<'_>) -> Result<GnssLogs, GnssError> {
    model.check()?;
    model::require(
        (1.0..=86_400.0).contains(&setting.duration_s),
        "duration_s",
        "1 to 86400 s",
        setting.duration_s,
    )?;
    let satellites = link::satellites(setting);
    let sky = link::Sky {
        model,
        satellites: &satellites,
        klobuchar: setting.navigation.klobuchar,
    };
    let still = |_: f64| setting.base_m;
    let rover = receiver::log(
        &sky,
        setting,
        &model.rover,
        setting.rover_m,
        receiver::ROVER,
    );
    let base = receiver::log(&sky, setting, &model.base, &still, receiver::BASE);
    for log in [&rover, &base] {
        let most = log
            .epochs
            .iter()
            .map(|epoch| epoch.observed.len())
            .max()
            .unwrap_or(0);
        if most < 4 {
            return Err(GnssError::EmptySky { most });
        }
    }
    Ok(GnssLogs { rover, base })
}
