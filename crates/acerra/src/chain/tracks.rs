//! Several flights into one image: a common frame, calibration, and all traces in one list.

use std::f64::consts::TAU;
use std::ops::Range;

use acerra_geo::trajectory::Frame;
use acerra_imaging::metrics::{ImageView, strongest_maxima};
use acerra_imaging::tracks::{Calibration, CalibrationOptions, Estimate, calibrate_on_target};
use acerra_imaging::{
    Complex32, Control, ImagingPlan, PlanOptions, PlaneGrid, PulseArrays, Pulses, Spreading,
    SurfaceGrid,
};
use acerra_radar::Spectrum;
use anyhow::{Context, bail};
use serde::Serialize;

use super::align::Aligned;
use super::clean::Cleaned;
use super::focus::weights;
use super::ground::Ground;
use super::position::Positions;
use super::read::RadarData;
use super::warnings::Warnings;
use crate::campaign::{CalibrationSource, Campaign, TrackSection};

/// One of the flights of an image.
#[derive(Clone, Debug)]
pub struct Track {
    /// What the campaign calls it, or its number.
    pub name: String,
    /// Its radar log.
    pub radar: RadarData,
    /// Its positions, in the first track's frame.
    pub positions: Positions,
    /// Its selected traces.
    pub aligned: Aligned,
    /// Their spectra, calibrated.
    pub cleaned: Cleaned,
    /// What was taken off.
    pub calibration: TrackCalibration,
}

/// Delay and phase taken off a track's spectra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TrackCalibration {
    /// Given by the campaign file, in nanoseconds and degrees.
    pub given_delay_ns: f64,
    /// Given by the campaign file.
    pub given_phase_deg: f64,
    /// Found beside that on a common target, against the first track.
    pub found: Option<FoundCalibration>,
}

/// What the common target told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FoundCalibration {
    /// Delay, in nanoseconds.
    pub delay_ns: f64,
    /// Its standard deviation.
    pub delay_sigma_ns: f64,
    /// Phase at the middle of the band, in degrees.
    pub phase_deg: f64,
    /// Its standard deviation.
    pub phase_sigma_deg: f64,
    /// Level of the target over the rest of its profile, in decibels.
    pub contrast_db: f64,
}

impl FoundCalibration {
    fn of(estimate: &Estimate, frequency_hz: &[f64]) -> Self {
        let middle_hz = 0.5 * (frequency_hz[0] + frequency_hz[frequency_hz.len() - 1]);
        let Calibration { delay_s, phase_rad } = estimate.calibration;
        let phase = phase_rad - TAU * middle_hz * delay_s;
        Self {
            delay_ns: delay_s * 1e9,
            delay_sigma_ns: estimate.delay_sigma_s * 1e9,
            phase_deg: (phase - TAU * (phase / TAU).round()).to_degrees(),
            phase_sigma_deg: estimate.phase_sigma_rad.to_degrees(),
            contrast_db: estimate.contrast_db,
        }
    }
}

/// The name of track `k`.
pub fn name_of_track(track: &TrackSection, k: usize) -> String {
    track.name.clone().unwrap_or_else(|| (k + 1).to_string())
}

/// Brings all trajectories into the frame of the first.
///
/// # Errors
/// Frames on the Earth beside frames of unknown place.
pub fn in_one_frame(positions: &mut [Positions]) -> anyhow::Result<()> {
    let mut first = None;
    for (k, p) in positions.iter_mut().enumerate() {
        let Positions::Trajectory(trajectory) = p else {
            continue;
        };
        let frame = *trajectory.frame();
        match (first, frame) {
            (None, frame) => first = Some(frame),
            (Some(Frame::Enu(target)), Frame::Enu(own)) => {
                if own != target {
                    **trajectory = trajectory.in_frame(target)?;
                }
            }
            (Some(Frame::Local), Frame::Local) => {}
            _ => bail!(
                "[[track]] {}: expected positions in the frame of the first track; one is on the \
                 Earth, the other at no known place",
                k + 1
            ),
        }
    }
    Ok(())
}

/// Takes delay and phase off every track: what the campaign gives, and what a common target tells.
///
/// # Errors
/// Tracks that see no common target.
pub fn calibrate(
    campaign: &Campaign,
    tracks: &mut [Track],
    ground: &Ground,
    warnings: &mut Warnings,
) -> anyhow::Result<()> {
    for (track, section) in tracks.iter_mut().zip(&campaign.track) {
        track.calibration.given_delay_ns = section.delay_ns;
        track.calibration.given_phase_deg = section.phase_deg;
        let given = Calibration {
            delay_s: section.delay_ns * 1e-9,
            phase_rad: section.phase_deg.to_radians(),
        };
        remove(given, &mut track.cleaned.spectrum)?;
    }
    if campaign.tracks.calibration == CalibrationSource::Given {
        return Ok(());
    }
    let weight: Vec<Vec<f64>> = tracks
        .iter()
        .map(|t| weights(campaign, &t.aligned))
        .collect();
    let pulses: Vec<Pulses<'_>> = tracks
        .iter()
        .zip(&weight)
        .map(|(track, weight)| {
            let spectrum = &track.cleaned.spectrum;
            Pulses::new(PulseArrays {
                position_m: &track.aligned.position_m,
                frequency_hz: &spectrum.frequency_hz,
                spectrum: &spectrum.values,
                weight,
                light_speed_m_s: campaign.image.light_speed_m_s,
            })
            .with_context(|| format!("[[track]] {}", track.name))
        })
        .collect::<anyhow::Result<_>>()?;
    let (candidates, stated_z_m) = match campaign.tracks.target_m {
        Some(target) => (vec![target], Some(target[2])),
        None => (candidates(&pulses[0], ground)?, None),
    };
    let window_s = campaign.tracks.window_ns * 1e-9;
    let height = |x: f64, y: f64| stated_z_m.unwrap_or_else(|| ground.below_m(x, y));
    let options = CalibrationOptions {
        window_s,
        spreading: Spreading::InverseSquare,
    };
    let found = calibrate_on_target(&pulses, &candidates, options, &height, Control::default())
        .context("[tracks] calibration")?;
    drop(pulses);
    for (track, estimate) in tracks.iter_mut().zip(&found.estimates) {
        let spectrum = &mut track.cleaned.spectrum;
        let told = FoundCalibration::of(estimate, &spectrum.frequency_hz);
        if told.contrast_db < 10.0 || told.delay_ns.abs() > 0.98 * campaign.tracks.window_ns {
            warnings.add(format!(
                "[[track]] {}: its calibration is uncertain: the common target at x = {:.2} m, \
                 y = {:.2} m stands {:.1} dB above the rest, {:+.2} ns from the first track's; \
                 state [tracks] target_m, or delay_ns and phase_deg",
                track.name,
                found.position_m[0],
                found.position_m[1],
                told.contrast_db,
                told.delay_ns
            ));
        }
        track.calibration.found = Some(told);
        remove(estimate.calibration, spectrum)?;
    }
    Ok(())
}

fn remove(calibration: Calibration, spectrum: &mut Spectrum) -> anyhow::Result<()> {
    if calibration != Calibration::default() {
        calibration.remove(&spectrum.frequency_hz, &mut spectrum.values)?;
    }
    Ok(())
}

/// Maxima of a track's image, on few enough pixels to be had at once.
fn candidates(pulses: &Pulses<'_>, ground: &Ground) -> anyhow::Result<Vec<[f64; 3]>> {
    /// Pixels that are imaged to find them.
    const PIXELS: f64 = 1e6;
    /// How far below the greatest maximum another may lie, and how many are tried.
    const FLOOR_DB: f64 = -10.0;
    const MOST: usize = 32;
    let fine = ground.grid;
    let sides = [fine.nx, fine.ny].map(|n| {
        #[expect(clippy::cast_precision_loss, reason = "a count of pixels")]
        let n = n as f64;
        n * fine.pixel_m
    });
    let grid = PlaneGrid::from_ranges(
        [fine.x0_m, fine.x_m(fine.nx - 1)],
        [fine.y0_m, fine.y_m(fine.ny - 1)],
        ground.below_m(fine.x0_m, fine.y0_m),
        fine.pixel_m.max((sides[0] * sides[1] / PIXELS).sqrt()),
    )?;
    let surface = match &ground.surface {
        Some(_) => Some(SurfaceGrid::from_fn(grid, |x, y| {
            anyhow::Ok(ground.below_m(x, y))
        })?),
        None => None,
    };
    let options = PlanOptions::default()
        .with_accuracy(1e-2)
        .with_check_pixels(16);
    let plan = match &surface {
        Some(surface) => ImagingPlan::new(*pulses, surface, &options),
        None => ImagingPlan::new(*pulses, grid, &options),
    }?;
    let mut image = vec![Complex32::default(); grid.len()];
    plan.run(&mut image, Control::default())?;
    let view = ImageView::new(&image, grid)?;
    let maxima = strongest_maxima(&view, FLOOR_DB, MOST);
    if maxima.is_empty() {
        bail!("[tracks] calibration: the first track's image is empty");
    }
    Ok(maxima
        .into_iter()
        .map(|[x, y]| [x, y, ground.below_m(x, y)])
        .collect())
}

/// All tracks' traces and spectra in one list, and which are whose.
///
/// # Errors
/// Tracks of different frequencies.
pub fn merge(tracks: &[Track]) -> anyhow::Result<(Aligned, Spectrum, Vec<Range<usize>>)> {
    let Some(first) = tracks.first() else {
        bail!("[[track]]: expected at least one");
    };
    let mut aligned = first.aligned.clone();
    let mut spectrum = first.cleaned.spectrum.clone();
    let mut parts: Vec<_> = std::iter::once(0..aligned.traces.len()).collect();
    for track in &tracks[1..] {
        let (own, values) = (&track.aligned, &track.cleaned.spectrum);
        if values.frequency_hz != spectrum.frequency_hz {
            bail!(
                "[[track]] {}: expected the {} frequencies of the first track, from {} Hz, found \
                 {} from {} Hz",
                track.name,
                spectrum.frequency_hz.len(),
                spectrum.frequency_hz[0],
                values.frequency_hz.len(),
                values.frequency_hz[0]
            );
        }
        spectrum.values.extend_from_slice(&values.values);
        spectrum.time_s.extend_from_slice(&values.time_s);
        let start = aligned.traces.len();
        // Deviations are told for all traces or for none.
        if own.sigma_m.is_empty() || aligned.sigma_m.is_empty() {
            aligned.sigma_m.clear();
        } else {
            aligned.sigma_m.extend_from_slice(&own.sigma_m);
        }
        aligned.traces.extend_from_slice(&own.traces);
        aligned.time_s.extend_from_slice(&own.time_s);
        aligned.position_m.extend_from_slice(&own.position_m);
        aligned.status.extend_from_slice(&own.status);
        aligned.height_m.extend_from_slice(&own.height_m);
        aligned.path_m.extend_from_slice(&own.path_m);
        aligned.all.extend_from_slice(&own.all);
        parts.push(start..aligned.traces.len());
    }
    Ok((aligned, spectrum, parts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::geodesy::{EnuFrame, Geodetic};
    use acerra_geo::trajectory::{Fix, SolutionStatus, TimeOrigin, Trajectory};

    fn at(frame: Frame, position_m: [f64; 3]) -> Positions {
        let fix = Fix {
            time_s: 0.0,
            position_m,
            covariance_m2: None,
            velocity_m_s: None,
            attitude: None,
            status: SolutionStatus::Fixed,
            satellites: None,
            age_s: None,
            ratio: None,
        };
        let trajectory = Trajectory::new(frame, TimeOrigin::Relative, vec![fix]).unwrap();
        Positions::Trajectory(Box::new(trajectory))
    }

    #[test]
    fn tracks_about_different_origins_meet_in_the_frame_of_the_first() {
        // The second origin stands 111 m north of the first and 3 m above it.
        let first = EnuFrame::new(Geodetic::from_degrees(41.0, 14.2, 60.0));
        let second = EnuFrame::new(Geodetic::from_degrees(41.001, 14.2, 63.0));
        let place = [5.0, 120.0, 7.0];
        let seen = second.enu_from_ecef(first.ecef_from_enu(place));
        assert!((place[1] - seen[1]).abs() > 100.0);
        let mut positions = [
            at(Frame::Enu(first), [0.0; 3]),
            at(Frame::Enu(second), seen),
            Positions::PerTrace(vec![[1.0; 3]]),
        ];
        in_one_frame(&mut positions).unwrap();
        let Positions::Trajectory(moved) = &positions[1] else {
            panic!("a trajectory");
        };
        for (found, expected) in moved.fixes()[0].position_m.iter().zip(place) {
            assert!((found - expected).abs() < 1e-6);
        }
        let mut apart = [at(Frame::Enu(first), [0.0; 3]), at(Frame::Local, [0.0; 3])];
        let message = in_one_frame(&mut apart).unwrap_err().to_string();
        assert!(message.contains("[[track]] 2"), "{message}");
    }
}
