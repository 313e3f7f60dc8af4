//! A simulated flight with its processed result, and the errors of the result relative to the truth.

use acerra_geo::trajectory::SolutionStatus;
use acerra_imaging::metrics::{LocalTrack, Target};
use acerra_imaging::resolution::displacement_m;
use acerra_radar::Radargram;
use acerra_radar::clean::envelope;

use acerra_products::Outcome;
use acerra_simulate::scene::Scene;
use acerra_simulate::write::Simulated;

/// A simulated flight and its processed result.
#[derive(Debug)]
pub struct Flown {
    /// The flight and the ground below.
    pub scene: Scene,
    /// What was logged.
    pub simulated: Simulated,
    /// Result of the chain for the logs.
    pub outcome: Outcome,
    /// Where the radar's phase centre truly was at each imaged trace (m).
    pub truth_m: Vec<[f64; 3]>,
}

/// A reflector: where it is, and where the image shows it.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Its number, from 1.
    pub number: usize,
    /// Where it is (m).
    pub true_m: [f64; 3],
    /// The target nearest to it.
    pub target: Target,
    /// Displacement of this flight's image across the track by the height error, by Eq. (14) (m).
    pub across_bound_m: f64,
}

impl Found {
    /// Off along x and y (m).
    #[must_use]
    pub fn off_m(&self) -> [f64; 2] {
        [
            self.target.x_m - self.true_m[0],
            self.target.y_m - self.true_m[1],
        ]
    }
}

impl Flown {
    pub(super) fn new(
        scene: Scene,
        simulated: Simulated,
        outcome: Outcome,
    ) -> anyhow::Result<Self> {
        let flight = scene.fly()?;
        let start_s = scene.start()?.tow_s();
        let arm = scene.radar.lever_arm_m;
        let truth_m = outcome
            .prepared
            .aligned
            .time_s
            .iter()
            .map(|t| t + simulated.time_offset_s - start_s)
            .map(|t| flight.pose_at(t).point_m(arm))
            .collect();
        Ok(Self {
            scene,
            simulated,
            outcome,
            truth_m,
        })
    }

    /// Position errors at the imaged traces: as positioned less the truth (m).
    #[must_use]
    pub fn error_m(&self) -> Vec<[f64; 3]> {
        let pairs = self
            .outcome
            .prepared
            .aligned
            .position_m
            .iter()
            .zip(&self.truth_m);
        pairs
            .map(|(found, truth)| [0, 1, 2].map(|i| found[i] - truth[i]))
            .collect()
    }

    /// Error of ranges by zero-timing (m), positive for ranges that are too long.
    #[must_use]
    pub fn range_error_m(&self) -> f64 {
        let shift_s = self.outcome.prepared.cleaned().map_or(0.0, |t| t.shift_s);
        let half_c = 0.5 * self.outcome.campaign.image.light_speed_m_s;
        half_c * (shift_s + 1e-9 * self.scene.radar.delay_ns)
    }

    /// Number of imaged traces at fixed positions.
    #[must_use]
    pub fn fixed(&self) -> usize {
        let status = &self.outcome.prepared.aligned.status;
        status
            .iter()
            .filter(|s: &&SolutionStatus| s.is_fixed())
            .count()
    }

    /// The estimated offset between the clocks less the true one, and its standard deviation (s); none where
    /// the campaign states the offset.
    #[must_use]
    pub fn offset_error_s(&self) -> Option<[f64; 2]> {
        let track = self.outcome.prepared.first();
        let search = track.search.as_ref()?;
        let off_s = track.time_offset_s - self.simulated.time_offset_s;
        Some([off_s, search.estimate.sigma_s])
    }

    /// The target nearest to each reflector of the scene.
    #[must_use]
    pub fn found(&self) -> Vec<Found> {
        let targets = &self.outcome.measured.targets;
        let mut found = Vec::new();
        for (k, corner) in self.scene.corner.iter().enumerate() {
            let true_m = corner.position_m;
            let distance = |t: &Target| (t.x_m - true_m[0]).hypot(t.y_m - true_m[1]);
            let nearest = targets
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            if let Some(target) = nearest {
                found.push(Found {
                    number: k + 1,
                    true_m,
                    target: *target,
                    across_bound_m: self.across_bound_m(true_m),
                });
            }
        }
        found
    }

    /// Eq. (14) for the largest height error at the traces that see a point within 45°: outward displacement
    /// of the image by an image plane that is too high by this error.
    fn across_bound_m(&self, point_m: [f64; 3]) -> f64 {
        let Some(track) = LocalTrack::at(&self.truth_m, point_m) else {
            return 0.0;
        };
        let range_error_m = self.range_error_m();
        let height_error_m = self
            .truth_m
            .iter()
            .zip(self.error_m())
            .filter(|(p, _)| (p[0] - point_m[0]).hypot(p[1] - point_m[1]) <= p[2] - point_m[2])
            .map(|(_, error)| (error[2] - range_error_m).abs())
            .fold(0.0, f64::max);
        displacement_m(track.height_m, track.offset_m.abs(), height_error_m)
            .ok()
            .flatten()
            .unwrap_or(0.0)
    }

    /// Distance of the first two reflectors in the image (m).
    #[must_use]
    pub fn distance_m(&self) -> Option<f64> {
        match self.found().as_slice() {
            [a, b, ..] => Some((a.target.x_m - b.target.x_m).hypot(a.target.y_m - b.target.y_m)),
            _ => None,
        }
    }

    /// Largest of the standard deviations that the positioning states, on each axis (m).
    #[must_use]
    pub fn largest_sigma_m(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| {
            let sigma_m = self.outcome.prepared.aligned.sigma_m.iter();
            sigma_m.map(|s| s[i]).fold(0.0, f64::max)
        })
    }
}

/// Largest envelope over all traces within an interval of fast time (s).
#[must_use]
pub fn largest_envelope(radargram: &Radargram, [from_s, to_s]: [f64; 2]) -> f64 {
    let n = radargram.samples_per_trace;
    envelope(radargram)
        .iter()
        .enumerate()
        .filter(|(k, _)| (from_s..to_s).contains(&radargram.fast_time_s(k % n)))
        .fold(0.0, |most, (_, level)| most.max(*level))
}

/// Root mean square of vectors, axis by axis (m).
#[must_use]
pub fn rms_m(vectors_m: &[[f64; 3]]) -> [f64; 3] {
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let count = vectors_m.len().max(1) as f64;
    [0, 1, 2].map(|i| (vectors_m.iter().map(|v| v[i] * v[i]).sum::<f64>() / count).sqrt())
}
