//! The surface of the ground from the radar's own first echo (`[ground] surface = "radar"`).
//!
//! The delay of the ground's first echo bounds the surface: no point of the surface lies within the ellipsoid
//! of the echo's path about transmitter and receiver (a sphere about one antenna), and one point lies on the
//! ellipsoid. Under a dense track the surface is therefore the lower envelope of these ellipsoids, whatever
//! its slope. Across a single track the shape of the ground is unknown: heights to the side of a track are
//! extrapolated from the nearest traces.

use acerra_imaging::{ImagingError, PlaneGrid, SurfaceGrid};
use acerra_radar::clean::{CleanError, SurfaceOptions, crests_near, track_surface};
use acerra_radar::{Radargram, RadargramError};

use crate::align::radar_height::median;
use crate::position::aligned::Aligned;
use crate::scene::Scene;

/// A surface found from the first echoes.
#[derive(Clone, Debug, PartialEq)]
pub struct RadarSurface {
    /// Heights of the surface under the image and the tracks.
    pub heights: SurfaceGrid,
    /// Share of the traces whose first echo was used.
    pub picked: f64,
    /// Standard deviation of first echoes about the echoes of neighbouring traces, as heights (m).
    pub scatter_m: f64,
    /// Share of the image's pixels that are farther from every trace than half the height of the flight.
    pub beyond: f64,
}

/// Reason for which the radar shows no surface.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RadarSurfaceError {
    /// The log holds spectra.
    #[error("[ground] surface = \"radar\": expected a radargram, found spectra")]
    Spectra,
    /// No echo can be followed.
    #[error("[ground] surface = \"radar\": no surface echo can be followed: {0}")]
    NoEcho(#[from] CleanError),
    /// Traces that the log does not contain.
    #[error(transparent)]
    Traces(#[from] RadargramError),
    /// The echo is missing in too many traces.
    #[error(
        "[ground] surface = \"radar\": the first echo of the ground is found in {percent:.0} % of the traces, expected \
         {needed:.0} % at least; state the surface (\"level\", \"terrain\")"
    )]
    Lost {
        /// Traces in which the echo is found (%).
        percent: f64,
        /// Traces in which the echo must be found (%).
        needed: f64,
    },
    /// Heights that are no valid surface.
    #[error(transparent)]
    Surface(#[from] ImagingError),
}

/// Largest relief that is followed, as a fraction of the flight's height.
const RELIEF_HEIGHTS: f64 = 0.25;
/// Distance from the crest of the whole trace at which a pick of its changing part belongs to another echo (s).
const SAME_ECHO_S: f64 = 1e-9;
/// Number of traces to either side with whose median a pick is compared.
const NEIGHBOURS: usize = 4;
/// Distance from the neighbours' median beyond which a pick is an outlier, in standard deviations.
const OUTLIER_SIGMAS: f64 = 4.0;
/// Least path difference of an outlier (m).
const LEAST_OUTLIER_M: f64 = 0.02;
/// Least share of the traces with an echo.
const LEAST_PICKED: f64 = 0.6;
/// Sine of the steepest slope that is followed.
const STEEPEST: f64 = 0.57;
/// Largest product of the numbers of nodes and traces.
const MOST_TERMS: f64 = 1e8;
/// Largest number of nodes.
const MOST_NODES: f64 = 1e5;

/// A track with positions of its traces.
#[derive(Clone, Copy, Debug)]
pub struct SeenTrack<'a> {
    /// The imaged traces, filtered along fast time and otherwise raw.
    pub radargram: &'a Radargram,
    /// Positions of the traces; heights above the level about which relief is searched.
    pub aligned: &'a Aligned,
    /// Stated fast time of zero range (s). Where none is stated, the median of the surface is at the level of
    /// `aligned`.
    pub delay_s: Option<f64>,
}

/// Finds the surface under the image of `scene` and under the tracks.
///
/// # Errors
/// An echo that cannot be followed.
pub fn radar_surface(
    tracks: &[SeenTrack<'_>],
    scene: &Scene,
) -> Result<RadarSurface, RadarSurfaceError> {
    let mut shells = Vec::new();
    let mut deviations_m = Vec::new();
    let mut traces = 0;
    for track in tracks {
        traces += track.aligned.traces.len();
        let first = track.first_echoes(scene.light_speed_m_s)?;
        let kept = kept_paths(&first);
        deviations_m.extend(kept.iter().map(|kept| 0.5 * kept.deviation_m));
        shells.extend(kept.iter().map(|kept| {
            let [transmitter_m, receiver_m] = track.aligned.antennas_at_m(kept.trace);
            Shell::new(transmitter_m, receiver_m, kept.path_m)
        }));
    }
    let picked = shells.len() as f64 / traces.max(1) as f64;
    if picked < LEAST_PICKED {
        return Err(RadarSurfaceError::Lost {
            percent: 100.0 * picked,
            needed: 100.0 * LEAST_PICKED,
        });
    }
    let under: Vec<[f64; 3]> = shells
        .iter()
        .map(|shell| {
            let [x_m, y_m, _] = shell.centre_m;
            let bottoms = shells.iter().filter_map(|s| s.bottom_m([x_m, y_m]));
            [x_m, y_m, bottoms.fold(f64::INFINITY, f64::min)]
        })
        .collect();
    let height_m = median(&shells.iter().map(|s| s.across_m).collect::<Vec<_>>());
    let image = &scene.pixels.grid;
    let spacing_m = spacing_m(&under);
    let lattice = lattice(image, &under, spacing_m)?;
    let heights = SurfaceGrid::in_parallel(lattice, |x_m, y_m| {
        Ok::<_, ImagingError>(beside_m(&under, [x_m, y_m], spacing_m))
    })?;
    let square = deviations_m.iter().map(|d| d * d).sum::<f64>();
    Ok(RadarSurface {
        beyond: beyond(image, &under, 0.5 * height_m),
        heights,
        picked,
        scatter_m: (square / deviations_m.len().max(1) as f64).sqrt(),
    })
}

impl SeenTrack<'_> {
    /// Path of the first echo of each trace, and the path over level ground (m).
    fn first_echoes(
        &self,
        light_speed_m_s: f64,
    ) -> Result<Vec<Option<[f64; 2]>>, RadarSurfaceError> {
        let raw = self.radargram;
        let height_m = &self.aligned.height_m;
        let typical_m = median(height_m).max(0.0);
        let relief_s = 2.0 * RELIEF_HEIGHTS * typical_m / light_speed_m_s;
        let mut options = SurfaceOptions::default();
        options.follow_s = options.follow_s.max(relief_s);
        if let Some(delay_s) = self.delay_s {
            options = options.with_approximate_delay_s(delay_s);
            // Direct coupling comes before half of the surface's path.
            options.search_s = options.search_s.min(typical_m / light_speed_m_s);
        }
        let track = track_surface(raw, height_m, &options)?;
        let delay_s = self.delay_s.unwrap_or(track.delay_s);
        let crests = crests_near(raw, &track, SAME_ECHO_S);
        let paths = crests.iter().zip(height_m).enumerate();
        Ok(paths
            .map(|(k, (crest, height_m))| {
                let [a, b] = self.aligned.antennas_at_m(k);
                let apart_m = (a[0] - b[0]).hypot(a[1] - b[1]);
                let path_m = light_speed_m_s * (crest.as_ref()?.fast_time_s - delay_s);
                (path_m > apart_m).then(|| [path_m, apart_m.hypot(2.0 * height_m)])
            })
            .collect())
    }
}

/// A first echo that is used.
struct Kept {
    trace: usize,
    path_m: f64,
    /// Deviation from the median of the neighbours, after removal of the path over level ground (m).
    deviation_m: f64,
}

/// The paths that agree with the paths of neighbouring traces.
fn kept_paths(first: &[Option<[f64; 2]>]) -> Vec<Kept> {
    let residual = |k: usize| first[k].map(|[path_m, level_m]| path_m - level_m);
    let all: Vec<Kept> = (0..first.len())
        .filter_map(|trace| {
            let near = trace.saturating_sub(NEIGHBOURS)..(trace + NEIGHBOURS + 1).min(first.len());
            let typical_m = median(&near.filter_map(residual).collect::<Vec<_>>());
            Some(Kept {
                trace,
                path_m: first[trace]?[0],
                deviation_m: residual(trace)? - typical_m,
            })
        })
        .collect();
    let sizes: Vec<f64> = all.iter().map(|kept| kept.deviation_m.abs()).collect();
    let most_m = (OUTLIER_SIGMAS * 1.4826 * median(&sizes)).max(LEAST_OUTLIER_M);
    all.into_iter()
        .filter(|kept| kept.deviation_m.abs() <= most_m)
        .collect()
}

/// The ellipsoid of a path about transmitter and receiver.
struct Shell {
    centre_m: [f64; 3],
    /// Horizontal direction from one antenna to the other.
    axis: [f64; 2],
    /// Half axis along `axis` (m).
    along_m: f64,
    /// Half axis across `axis` (m).
    across_m: f64,
}

impl Shell {
    fn new(transmitter_m: [f64; 3], receiver_m: [f64; 3], path_m: f64) -> Self {
        let apart = [0, 1].map(|k| receiver_m[k] - transmitter_m[k]);
        let apart_m = apart[0].hypot(apart[1]);
        let along_m = 0.5 * path_m;
        Self {
            centre_m: std::array::from_fn(|k| 0.5 * (transmitter_m[k] + receiver_m[k])),
            axis: match apart_m {
                0.0 => [1.0, 0.0],
                _ => apart.map(|v| v / apart_m),
            },
            along_m,
            across_m: (along_m * along_m - 0.25 * apart_m * apart_m)
                .max(0.0)
                .sqrt(),
        }
    }

    /// Height of the shell's lower side at `[x, y]` (m); `None` where the shell is steeper than [`STEEPEST`].
    fn bottom_m(&self, [x_m, y_m]: [f64; 2]) -> Option<f64> {
        let [dx, dy] = [x_m - self.centre_m[0], y_m - self.centre_m[1]];
        let along = (dx * self.axis[0] + dy * self.axis[1]) / self.along_m;
        let across = (dy * self.axis[0] - dx * self.axis[1]) / self.across_m;
        let square = along * along + across * across;
        (square <= STEEPEST * STEEPEST)
            .then(|| self.centre_m[2] - self.across_m * (1.0 - square).sqrt())
    }
}

/// Typical distance of neighbouring traces (m).
fn spacing_m(under: &[[f64; 3]]) -> f64 {
    let steps = under.windows(2).map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        (a[0] - b[0]).hypot(a[1] - b[1])
    });
    median(&steps.collect::<Vec<_>>()).max(1e-3)
}

/// Height to the side of the tracks: mean of the heights under the traces, with weights that fall with the
/// fourth power of the distance beyond the spacing of the traces.
fn beside_m(under: &[[f64; 3]], [x_m, y_m]: [f64; 2], spacing_m: f64) -> f64 {
    let mut sums = [0.0; 2];
    for [x, y, z] in under {
        let square = (x - x_m).powi(2) + (y - y_m).powi(2) + 0.25 * spacing_m * spacing_m;
        let weight = 1.0 / (square * square);
        sums[0] += weight * z;
        sums[1] += weight;
    }
    sums[0] / sums[1]
}

/// The lattice of heights: under the image and the traces.
fn lattice(
    image: &PlaneGrid,
    under: &[[f64; 3]],
    spacing_m: f64,
) -> Result<PlaneGrid, ImagingError> {
    let mut sides = [
        [image.x0_m, image.x_m(image.nx.saturating_sub(1))],
        [image.y0_m, image.y_m(image.ny.saturating_sub(1))],
    ];
    for place_m in under {
        for axis in 0..2 {
            sides[axis][0] = sides[axis][0].min(place_m[axis] - spacing_m);
            sides[axis][1] = sides[axis][1].max(place_m[axis] + spacing_m);
        }
    }
    let lengths_m = sides.map(|[from, to]| to - from);
    let nodes = (MOST_TERMS / under.len().max(1) as f64).clamp(1.0, MOST_NODES);
    let step_m = (lengths_m[0] * lengths_m[1] / nodes)
        .sqrt()
        .max(lengths_m[0].max(lengths_m[1]) / nodes)
        .max(0.5 * spacing_m);
    PlaneGrid::from_ranges(sides[0], sides[1], image.z_m, step_m)
}

/// Share of some pixels of the image that are farther than `reach_m` from every trace.
fn beyond(image: &PlaneGrid, under: &[[f64; 3]], reach_m: f64) -> f64 {
    const A_SIDE: usize = 24;
    let places = |n: usize| (0..A_SIDE).map(move |k| k * n.saturating_sub(1) / (A_SIDE - 1));
    let far = |x_m: f64, y_m: f64| {
        let near = |p: &[f64; 3]| (p[0] - x_m).hypot(p[1] - y_m) <= reach_m;
        !under.iter().any(near)
    };
    let count = places(image.ny)
        .flat_map(|j| places(image.nx).map(move |i| (i, j)))
        .filter(|(i, j)| far(image.x_m(*i), image.y_m(*j)))
        .count();
    count as f64 / (A_SIDE * A_SIDE) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_radar::Samples;

    const C_M_S: f64 = 299_792_458.0;

    fn ground_m(x_m: f64) -> f64 {
        0.02 * (4.0 * x_m).sin() + 0.01 * (9.0 * x_m).cos()
    }

    /// Echoes of the nearest point of uneven ground along a line, and coupling that is ten times as strong.
    fn line(delay_s: f64) -> (Radargram, Aligned) {
        let position_m: Vec<[f64; 3]> = (0..80)
            .map(|k| {
                let x_m = 0.025 * f64::from(k);
                [x_m, 0.0, 0.9 + 0.03 * (0.3 * f64::from(k)).sin()]
            })
            .collect();
        let step_s = 20e-12;
        let samples: Vec<f32> = (position_m.iter())
            .flat_map(|p| {
                let nearest_m = (0..2000)
                    .map(|k| p[0] - 1.0 + 0.001 * f64::from(k))
                    .map(|x| (x - p[0]).hypot(ground_m(x) - p[2]))
                    .fold(f64::INFINITY, f64::min);
                let echo_s = delay_s + 2.0 * nearest_m / C_M_S;
                let pulse = |t_s: f64| {
                    let u = t_s / 0.4e-9;
                    (-u * u).exp() * (std::f64::consts::TAU * 1.5e9 * t_s).cos()
                };
                (0..600).map(move |k| {
                    let t_s = step_s * f64::from(k);
                    (pulse(t_s - echo_s) + 10.0 * pulse(t_s - delay_s)) as f32
                })
            })
            .collect();
        let time_s = (0..80).map(|k| 0.05 * f64::from(k)).collect();
        let aligned = Aligned {
            traces: (0..80).collect(),
            height_m: position_m.iter().map(|p| p[2]).collect(),
            position_m,
            ..Aligned::default()
        };
        let radargram = Radargram::new(time_s, 0.0, step_s, Samples::Real(samples)).unwrap();
        (radargram, aligned)
    }

    #[test]
    fn uneven_ground_is_found_below_a_line() {
        let (radargram, aligned) = line(1e-9);
        let grid = PlaneGrid::from_ranges([0.2, 1.8], [0.0, 0.0], -0.3, 0.01).unwrap();
        let scene = Scene::plane(grid).on_level(0.0);
        let seen = SeenTrack {
            radargram: &radargram,
            aligned: &aligned,
            delay_s: Some(1e-9),
        };
        let found = radar_surface(&[seen], &scene).unwrap();
        assert!(found.picked > 0.95 && found.beyond == 0.0, "{found:?}");
        let errors_m: Vec<f64> = (0..160)
            .map(|k| 0.2 + 0.01 * f64::from(k))
            .map(|x_m| found.heights.height_m(x_m, 0.0) - ground_m(x_m))
            .collect();
        let rms_m = (errors_m.iter().map(|e| e * e).sum::<f64>() / 160.0).sqrt();
        assert!(rms_m < 3e-3, "{rms_m}");
    }

    #[test]
    fn noise_has_no_surface() {
        let (radargram, aligned) = line(1e-9);
        let noise = (0..80 * 600_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 16) as f32);
        let noisy = Radargram::new(
            radargram.time_s.clone(),
            0.0,
            radargram.fast_time_step_s,
            Samples::Real(noise.collect()),
        );
        let grid = PlaneGrid::from_ranges([0.2, 1.8], [0.0, 0.0], -0.3, 0.01).unwrap();
        let seen = SeenTrack {
            radargram: &noisy.unwrap(),
            aligned: &aligned,
            delay_s: Some(1e-9),
        };
        let refused = radar_surface(&[seen], &Scene::plane(grid));
        assert!(
            matches!(
                refused,
                Err(RadarSurfaceError::NoEcho(_) | RadarSurfaceError::Lost { .. })
            ),
            "{refused:?}"
        );
    }
}
