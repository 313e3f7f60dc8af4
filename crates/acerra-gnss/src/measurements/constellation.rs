//! The satellites of a run under dense indices, with their ephemerides.

use crate::observations::observation::ObservationData;
use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::{SPEED_OF_LIGHT_M_S, SignalCode};
use crate::options::PpkOptions;
use crate::orbits::broadcast::Broadcast;
use crate::orbits::navigation::{Ephemeris, Navigation};
use crate::orbits::products::{PreciseGap, PreciseProducts};
use acerra_geo::time::GpsTime;

/// A satellite with a predicted accuracy worse than this (m) is not used.
const LARGEST_ORBIT_ERROR_M: f64 = 300.0;
/// Standard deviation of precise orbits and clocks together (m), as of ultra-rapid products; errors of the
/// satellite antenna's phase centre, which is not modelled, are mostly absorbed by the clock.
const PRECISE_ERROR_M: f64 = 0.1;
/// Galileo data source: clock parameters for E5b and E1 (I/NAV).
const GALILEO_INAV_CLOCK: u32 = 1 << 9;

/// Satellites observed by rover or base, of the systems selected, in ascending order.
pub(crate) struct Constellation {
    ids: Vec<SatelliteId>,
    ephemerides: Vec<Vec<Broadcast>>,
    channels: Vec<Option<i8>>,
    /// Precise orbits and clocks, used exclusively for the satellites that they contain.
    precise: PreciseProducts,
    /// Whether message types of Galileo other than I/NAV, and ephemerides of the future, are accepted.
    any_galileo: bool,
}

/// A satellite at its transmission time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SatelliteState {
    pub position_ecef_m: [f64; 3],
    pub clock_s: f64,
    /// Variance of orbit and clock (m²).
    pub variance_m2: f64,
    /// Velocity and clock drift, where requested.
    pub rates: Option<([f64; 3], f64)>,
}

/// Reason for which a satellite has no state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unusable {
    NoPseudorange,
    NoEphemeris,
    /// The satellite's message flags it as unhealthy or too inaccurate.
    Excluded,
    /// The pseudorange disagrees with the receiver's position and the other pseudoranges.
    ImplausiblePseudorange,
}

impl Constellation {
    pub(crate) fn new(
        rover: &ObservationData,
        base: Option<&ObservationData>,
        navigation: &Navigation,
        options: &PpkOptions,
    ) -> Self {
        let mut ids: Vec<SatelliteId> = std::iter::once(rover)
            .chain(base)
            .flat_map(|data| &data.epochs)
            .flat_map(|epoch| epoch.satellites.iter().map(|s| s.satellite))
            .filter(|id| options.systems.contains(id.system()))
            .filter(|id| !options.excluded_satellites.contains(id))
            .collect();
        ids.sort_unstable();
        ids.dedup();
        let mut ephemerides: Vec<Vec<Broadcast>> = ids.iter().map(|_| Vec::new()).collect();
        for e in &navigation.ephemerides {
            if let Ok(index) = ids.binary_search(&e.satellite()) {
                ephemerides[index].push(Broadcast::from(*e));
            }
        }
        let from_logs = |number: u8| {
            std::iter::once(rover)
                .chain(base)
                .find_map(|data| data.glonass_channels.get(&number).copied())
        };
        let channels = ids
            .iter()
            .zip(&ephemerides)
            .map(|(id, list)| {
                let broadcast = list.iter().find_map(|e| match &e.ephemeris {
                    Ephemeris::Glonass(e) => Some(e.channel),
                    _ => None,
                });
                (id.system() == System::Glonass)
                    .then(|| broadcast.or_else(|| from_logs(id.number())))
                    .flatten()
            })
            .collect();
        Self {
            ids,
            ephemerides,
            channels,
            precise: navigation.precise.clone(),
            any_galileo: options.policy().takes_any_galileo(),
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.ids.len()
    }

    pub(crate) fn id(&self, index: usize) -> SatelliteId {
        self.ids[index]
    }

    pub(crate) fn index(&self, id: SatelliteId) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    pub(crate) fn has_ephemerides(&self, index: usize) -> bool {
        !self.ephemerides[index].is_empty() || self.precise.holds(self.ids[index])
    }

    pub(crate) fn channel(&self, index: usize) -> Option<i8> {
        self.channels[index]
    }

    /// Carrier frequency of a signal (Hz); 0 when unknown.
    pub(crate) fn frequency_hz(&self, index: usize, code: SignalCode) -> f64 {
        code.carrier_frequency_hz(self.ids[index].system(), self.channels[index])
            .unwrap_or(0.0)
    }

    /// Group delay of a first-slot signal (m), from the first record of the satellite.
    pub(crate) fn group_delay_m(&self, index: usize, code: SignalCode) -> f64 {
        let first = self.ephemerides[index].first();
        let Some(Ephemeris::Kepler(e)) = first.map(|e| &e.ephemeris) else {
            return 0.0;
        };
        let delay_s = match e.satellite.system() {
            System::Gps | System::Qzss => e.group_delay_s[0],
            System::Galileo => e.group_delay_s[1],
            System::Beidou if code.band == 2 => e.group_delay_s[0],
            _ => 0.0,
        };
        SPEED_OF_LIGHT_M_S * delay_s
    }

    /// The record whose reference time is nearest to `t`, the later one in the list on ties.
    fn select(&self, index: usize, t: GpsTime) -> Option<&Broadcast> {
        let mut best: Option<(f64, &Broadcast)> = None;
        for broadcast in &self.ephemerides[index] {
            let e = &broadcast.ephemeris;
            let ahead_s = e.toe().seconds_since(t);
            let limit_s = match e.satellite().system() {
                System::Gps | System::Qzss | System::Navic => 7_201.0,
                System::Galileo => 14_400.0,
                System::Beidou => 21_601.0,
                System::Glonass => 1_800.0,
                System::Sbas => 360.0,
            };
            if let (Ephemeris::Kepler(k), System::Galileo, false) =
                (e, e.satellite().system(), self.any_galileo)
                && (k.data_source & GALILEO_INAV_CLOCK == 0 || ahead_s >= 0.0)
            {
                continue;
            }
            let distance_s = ahead_s.abs();
            if distance_s <= limit_s && best.is_none_or(|(least, _)| distance_s <= least) {
                best = Some((distance_s, broadcast));
            }
        }
        best.map(|(_, e)| e)
    }

    /// The satellite's state at the transmission of the signal received at `tag` with this pseudorange (m; 0
    /// = none). `selection_time` chooses among its ephemerides.
    pub(crate) fn state(
        &self,
        index: usize,
        selection_time: GpsTime,
        tag: GpsTime,
        pseudorange_m: f64,
        with_rates: bool,
    ) -> Result<SatelliteState, Unusable> {
        if pseudorange_m == 0.0 {
            return Err(Unusable::NoPseudorange);
        }
        if self.precise.holds(self.ids[index]) {
            return self
                .precise_state(self.ids[index], tag, pseudorange_m, with_rates)
                .map_err(|_| Unusable::NoEphemeris);
        }
        let broadcast = self
            .select(index, selection_time)
            .ok_or(Unusable::NoEphemeris)?;
        let e = &broadcast.ephemeris;
        if !e.is_healthy() || !(0.0..=LARGEST_ORBIT_ERROR_M).contains(&e.accuracy_m()) {
            return Err(Unusable::Excluded);
        }
        let sent = tag - pseudorange_m / SPEED_OF_LIGHT_M_S;
        let sent = sent - e.clock_without_relativity_s(sent);
        let (orbit, rates) = broadcast.state_at(sent, with_rates);
        Ok(SatelliteState {
            position_ecef_m: orbit.position_ecef_m,
            clock_s: orbit.clock_s,
            variance_m2: e.accuracy_m() * e.accuracy_m(),
            rates: rates.map(|rates| (rates.velocity_ecef_m_s, rates.clock_rate)),
        })
    }

    /// As [`Self::state`], from the precise products.
    fn precise_state(
        &self,
        satellite: SatelliteId,
        tag: GpsTime,
        pseudorange_m: f64,
        with_rates: bool,
    ) -> Result<SatelliteState, PreciseGap> {
        let sent = tag - pseudorange_m / SPEED_OF_LIGHT_M_S;
        let sent = sent - self.precise.clock_at(satellite, sent)?;
        let orbit = self.precise.state_at(satellite, sent)?;
        let rates = if with_rates {
            let rates = self.precise.rates_at(satellite, sent)?;
            Some((rates.velocity_ecef_m_s, rates.clock_rate))
        } else {
            None
        };
        Ok(SatelliteState {
            position_ecef_m: orbit.position_ecef_m,
            clock_s: orbit.clock_s,
            variance_m2: PRECISE_ERROR_M * PRECISE_ERROR_M,
            rates,
        })
    }
}
