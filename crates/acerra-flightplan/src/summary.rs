//! The plan: all choices, and the expected image.

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_imaging::resolution::{across_track_m, along_track_m, range_m};
use serde::Serialize;

use super::polygon::Polygon;
use super::swath::View;
use super::{
    Curve, Flight, Ground, LIGHT_SPEED_M_S, Lines, PlanError, PlanFile, Radar, Swath, aliasing,
    flights, image_snr_db, lines,
};

/// Number of heights tried.
const HEIGHTS: usize = 55;

/// A plan that can be flown.
#[derive(Clone, Debug)]
pub struct FlightPlan {
    /// Request.
    pub file: PlanFile,
    /// East, north, up about home.
    pub frame: EnuFrame,
    /// What each line shows.
    pub swath: Swath,
    /// The lines, in order.
    pub lines: Lines,
    /// Their wave, if any.
    pub curve: Option<Curve>,
    /// Flights on one battery each.
    pub flights: Vec<Flight>,
    /// The figures.
    pub summary: Summary,
    /// The ground, where the plan names a terrain; level otherwise.
    pub ground: Option<Ground>,
    pub(super) area: Polygon,
    pub(super) view: View,
}

/// The figures of a plan, as `acerra plan --json` prints them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Height above ground (m).
    pub height_m: f64,
    /// Speed along the lines (m/s).
    pub speed_m_s: f64,
    /// Direction of the lines, clockwise from north (degrees).
    pub heading_deg: f64,
    /// Number of lines.
    pub lines: usize,
    /// Distance between them (m).
    pub track_spacing_m: Option<f64>,
    /// Length of the longest line (m).
    pub track_length_m: f64,
    /// Length of all lines (m).
    pub total_length_m: f64,
    /// Nearest and farthest distance from a line at which the requirements hold (m).
    pub swath_m: [f64; 2],
    /// Limit of the swath on its far side.
    pub swath_ends: &'static str,
    /// Half of the angle under which targets must be seen and processed (degrees).
    pub half_view_deg: f64,
    /// Distance between scans (m).
    pub step_m: f64,
    /// The longest without aliasing (m).
    pub longest_step_m: f64,
    /// Strongest alias along the track (dB) where the distance between scans is longer.
    pub alias_db: Option<f64>,
    /// Scans a second.
    pub scans_hz: f64,
    /// Expected along-track resolution (m), Eq. (6).
    pub along_m: f64,
    /// Expected range resolution (m), Eq. (8).
    pub range_m: f64,
    /// Expected across-track resolution (m), Eq. (9), at both ends of the swath.
    pub across_m: [f64; 2],
    /// Signal-to-noise ratio (dB) of the weakest wanted target at both ends of the swath.
    pub snr_db: [f64; 2],
    /// Distance at which a waypoint counts as reached (m).
    pub waypoint_acceptance_m: f64,
    /// The wave of the lines; none when straight, whose ghosts are as strong as their targets.
    pub curve: Option<Curve>,
    /// Random ranging error of each position (m, standard deviation) that costs 1 dB of the peak.
    pub position_error_for_1_db_m: f64,
    /// Area (m²).
    pub area_m2: f64,
    /// Time in the air (s).
    pub time_s: f64,
    /// Flights, one battery each.
    pub flights: Vec<Flight>,
    /// Remarks before flying it.
    pub warnings: Vec<String>,
}

impl FlightPlan {
    /// Plans a flight.
    ///
    /// # Errors
    /// [`PlanError`] with the reason why there is no such flight.
    ///
    /// ```
    /// use acerra_flightplan::{FlightPlan, PlanFile};
    /// let plan = FlightPlan::make(PlanFile::parse(
    ///     "[area]\ncorners_deg = [[40.9, 14.2], [40.9, 14.2003], [40.9001, 14.2003], [40.9001, 14.2]]\n\
    ///      [want]\nalong_m = 0.06\nacross_m = 0.5\nrcs_dbsm = 10\n",
    /// )?)?;
    /// assert!(plan.summary.across_m.iter().all(|m| *m <= 0.5 + 1e-9));
    /// assert!(plan.summary.step_m <= plan.summary.longest_step_m);
    /// # Ok::<(), acerra_flightplan::PlanError>(())
    /// ```
    pub fn make(file: PlanFile) -> Result<Self, PlanError> {
        file.check()?;
        let [lat, lon] = file.area.home_deg.unwrap_or(file.area.corners_deg[0]);
        let frame = EnuFrame::new(Geodetic::from_degrees(lat, lon, 0.0));
        let corners = file.area.corners_deg.iter().map(|[lat, lon]| {
            let [e, n, _] = frame.enu_from_geodetic(&Geodetic::from_degrees(*lat, *lon, 0.0));
            [e, n]
        });
        let area = Polygon::new(corners.collect())?;
        let heading_rad = match file.area.heading_deg {
            Some(heading) => heading.to_radians(),
            None => lines::longest_way(&area),
        };
        let view = View::of(&file)?;
        let speed_m_s = speed(&file, &view)?;
        let step_m = speed_m_s / file.radar.scans_hz;

        let (swath, mut lines, mut flights) =
            best_height(&file, &area, heading_rad, &view, speed_m_s)?;
        let curve = Curve::choose(&file, &view, &swath, lines.spacing_m, speed_m_s)?;
        if let Some(curve) = &curve {
            lines.bend(curve);
            flights = flights::divide(&file.drone, &lines.lines, swath.height_m, speed_m_s)?;
        }
        let alias_db = alias_db(&file, &view, &swath, speed_m_s)?;
        let mut warnings = warnings(&swath, curve.as_ref());
        warnings.extend(sampling_warning(&file.radar, &view, speed_m_s, alias_db)?);
        let ends = [swath.near_m, swath.far_m];
        let theory = |e: acerra_imaging::ImagingError| PlanError::Impossible(e.to_string());
        let resolution_m = range_m(file.radar.bandwidth_hz(), LIGHT_SPEED_M_S).map_err(theory)?;
        let across = |d: f64| across_track_m(resolution_m, swath.height_m, d).map_err(theory);
        let snr = |d: f64| {
            let range_m = swath.height_m.hypot(d);
            image_snr_db(
                &file.radar,
                range_m,
                file.want.rcs_dbsm,
                view.half_rad,
                step_m,
            )
        };
        let lengths = || lines.lines.iter().map(super::Line::length_m);
        let centre_hz = file.radar.centre_hz();
        let summary = Summary {
            height_m: swath.height_m,
            speed_m_s,
            heading_deg: heading_rad.to_degrees().rem_euclid(360.0),
            lines: lines.lines.len(),
            track_spacing_m: lines.spacing_m,
            track_length_m: lengths().fold(0.0, f64::max),
            total_length_m: lengths().sum(),
            swath_m: ends,
            swath_ends: swath.far_limit.reason(),
            half_view_deg: view.half_rad.to_degrees(),
            step_m,
            longest_step_m: view.longest_step_m,
            alias_db,
            scans_hz: file.radar.scans_hz,
            along_m: along_track_m(centre_hz, view.half_rad, LIGHT_SPEED_M_S).map_err(theory)?,
            range_m: resolution_m,
            across_m: [across(ends[0])?, across(ends[1])?],
            snr_db: ends.map(snr),
            waypoint_acceptance_m: lines.acceptance_m(file.drone.stray_m, curve.as_ref()),
            curve: curve.clone(),
            // exp(−(4πσ/λ)²) of the power is left of a peak under random ranging errors.
            position_error_for_1_db_m: (0.1 * std::f64::consts::LN_10).sqrt() * LIGHT_SPEED_M_S
                / (4.0 * std::f64::consts::PI * centre_hz),
            area_m2: area.area_m2(),
            time_s: flights.iter().map(|f| f.time_s).sum(),
            flights: flights.clone(),
            warnings,
        };
        let ground = match &file.area.terrain {
            Some(path) => Some(Ground::read(
                path,
                file.area.terrain_crs.as_deref(),
                &frame,
                lines.extent_m(),
                file.drone.stray_m,
            )?),
            None => None,
        };
        Ok(Self {
            ground,
            file,
            frame,
            swath,
            lines,
            curve,
            flights,
            summary,
            area,
            view,
        })
    }

    /// Corners of the area, in order.
    #[must_use]
    pub fn area_corners(&self) -> Vec<Geodetic> {
        self.area
            .corners()
            .iter()
            .map(|p| self.place(*p, 0.0))
            .collect()
    }

    /// Height of home above the sea (m): the terrain's, or that stated in the plan.
    #[must_use]
    pub fn home_above_sea_m(&self) -> f64 {
        match &self.ground {
            Some(ground) => ground.home_m(),
            None => self.file.area.home_height_m,
        }
    }

    /// The place of a point east and north of home, with a height above ground.
    #[must_use]
    pub fn place(&self, [e, n]: [f64; 2], height_m: f64) -> Geodetic {
        let mut place = self.frame.geodetic_from_enu([e, n, 0.0]);
        // Heights are above home's; the Earth's curve is not flown.
        place.height_m = height_m;
        place
    }
}

/// The stated speed, or the largest without aliasing, less a tenth.
fn speed(file: &PlanFile, view: &View) -> Result<f64, PlanError> {
    let (drone, scans_hz) = (&file.drone, file.radar.scans_hz);
    if let Some(speed) = drone.speed_m_s {
        return Ok(speed);
    }
    let limit = view.longest_step_m * scans_hz;
    let speed = (0.9 * limit).min(drone.max_speed_m_s);
    if speed < drone.min_speed_m_s {
        return Err(PlanError::Impossible(format!(
            "{scans_hz} scans a second sample ±{:.1}° without aliasing only up to {limit:.2} m/s, \
             slower than the drone's {} m/s: take {:.0} scans a second, ask for less along the \
             track, or state drone.speed_m_s to have the aliases at that speed computed",
            view.half_rad.to_degrees(),
            drone.min_speed_m_s,
            (drone.min_speed_m_s / (0.9 * view.longest_step_m)).ceil(),
        )));
    }
    Ok(speed)
}

/// The strongest alias in decibels where scans lie further apart than the wanted view allows.
fn alias_db(
    file: &PlanFile,
    view: &View,
    swath: &Swath,
    speed_m_s: f64,
) -> Result<Option<f64>, PlanError> {
    let scans_hz = file.radar.scans_hz;
    let step_m = speed_m_s / scans_hz;
    if step_m <= view.longest_step_m {
        return Ok(None);
    }
    let level = aliasing::level(file, view, swath, step_m)?;
    let level_db = 20.0 * level.log10();
    if level > aliasing::TOLERATED {
        return Err(PlanError::Impossible(format!(
            "at {speed_m_s} m/s and {scans_hz} scans a second the scans are {step_m:.3} m apart; a \
             view of ±{:.1}° aliases beyond {:.3} m, here with {level_db:.0} dB, more than the \
             {:.0} dB of an aperture's sidelobes: fly at {:.2} m/s or take {:.0} scans a second to \
             have none, or ask for less along the track",
            view.half_rad.to_degrees(),
            view.longest_step_m,
            20.0 * aliasing::TOLERATED.log10(),
            view.longest_step_m * scans_hz,
            (speed_m_s / view.longest_step_m).ceil(),
        )));
    }
    Ok(Some(level_db))
}

/// The height with the shortest time in the air.
fn best_height(
    file: &PlanFile,
    area: &Polygon,
    heading_rad: f64,
    view: &View,
    speed_m_s: f64,
) -> Result<(Swath, Lines, Vec<Flight>), PlanError> {
    let (low, high) = (file.drone.min_height_m, file.drone.max_height_m);
    let step_m = speed_m_s / file.radar.scans_hz;
    let mut best: Option<(f64, Swath, Lines, Vec<Flight>)> = None;
    let mut refused: Vec<PlanError> = Vec::new();
    for i in 0..HEIGHTS {
        let height_m = low + (high - low) * i as f64 / (HEIGHTS - 1) as f64;
        let attempt = Swath::at(file, view, height_m, step_m).and_then(|swath| {
            let sure = swath.sure(file.drone.stray_m);
            let run_m = height_m.hypot(swath.far_m) * view.half_rad.tan();
            let lines = Lines::over(area, heading_rad, sure, swath.far_m, run_m)?;
            let flights = flights::divide(&file.drone, &lines.lines, height_m, speed_m_s)?;
            Ok((swath, lines, flights))
        });
        match attempt {
            Ok((swath, lines, flights)) => {
                let time_s = flights.iter().map(|f| f.time_s).sum();
                if best.as_ref().is_none_or(|(t, ..)| time_s < *t - 1e-9) {
                    best = Some((time_s, swath, lines, flights));
                }
            }
            Err(error) => refused.push(error),
        }
        if high <= low {
            break;
        }
    }
    best.map(|(_, swath, lines, flights)| (swath, lines, flights))
        .ok_or_else(|| {
            let mut reasons: Vec<String> = Vec::new();
            for error in [
                refused.first(),
                refused.get(refused.len() / 2),
                refused.last(),
            ] {
                let reason = error.map(ToString::to_string).unwrap_or_default();
                if !reasons.contains(&reason) {
                    reasons.push(reason);
                }
            }
            PlanError::Impossible(format!(
                "no height from {low} to {high} m will do: {}",
                reasons.join("; ")
            ))
        })
}

/// Remarks by the limits of the sampling along the track.
fn sampling_warning(
    radar: &Radar,
    view: &View,
    speed_m_s: f64,
    alias_db: Option<f64>,
) -> Result<Option<String>, PlanError> {
    let step_m = speed_m_s / radar.scans_hz;
    let whole_beam_m = aliasing::beam_step_m(radar)?;
    let remedy = format!(
        "{:.2} m/s or {:.0} scans a second sample the whole beam of {}°",
        whole_beam_m * radar.scans_hz,
        (speed_m_s / whole_beam_m).ceil(),
        radar.beam_deg
    );
    Ok(match alias_db {
        Some(level_db) => Some(format!(
            "scans {:.0} mm apart alias within the view of ±{:.1}°: {level_db:.0} dB along the track, \
             spread by the band; {remedy}",
            1e3 * step_m,
            view.half_rad.to_degrees(),
        )),
        None if step_m > whole_beam_m => {
            // λ/(4 sin θ) turned round.
            let sampled_rad = (whole_beam_m * radar.half_beam_rad().sin() / step_m).asin();
            Some(format!(
                "scans {:.0} mm apart sample ±{:.1}° without aliasing: echoes from further ahead or \
                 behind add faint aliases along the track; {remedy}",
                1e3 * step_m,
                sampled_rad.to_degrees(),
            ))
        }
        None => None,
    })
}

fn warnings(swath: &Swath, curve: Option<&Curve>) -> Vec<String> {
    let mut warnings = Vec::new();
    if swath.near_m > 0.0 {
        warnings.push(format!(
            "less than {:.1} m from a line the ground is resolved more coarsely than wanted; \
             neighbouring lines show it",
            swath.near_m
        ));
    }
    match curve {
        None => warnings.push(
            "straight lines: each target has a ghost of equal strength on the other side of the \
             track (set want.ghost to curve them)"
                .to_owned(),
        ),
        Some(curve) if curve.amplitude_m < 1.0 => warnings.push(format!(
            "waves of {:.2} m need a drone positioned by RTK; without RTK the drone's wander has the same \
             effect, unplanned",
            curve.amplitude_m
        )),
        Some(_) => {}
    }
    warnings
}
