//! From the scene to scatterers, and from one pose to the echoes that they return.

use std::f64::consts::PI;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::model::{RadarModel, RadarScene};
use crate::flight::Pose;

/// Speed of light in vacuum (m/s).
pub const SPEED_OF_LIGHT_M_S: f64 = 299_792_458.0;

/// One echo of one pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// Two-way delay in the air (s).
    pub delay_s: f64,
    /// Root of the equivalent radar cross-section over R², antenna gains relative to their axis
    /// included (1/m).
    pub strength: f64,
    /// Phase on reflection (rad).
    pub phase_rad: f64,
}

#[derive(Clone, Copy, Debug)]
struct Scatterer {
    position_m: [f64; 3],
    /// √RCS (m), where it looks best.
    root_rcs_m: f64,
    phase_rad: f64,
    /// Direction of its strongest echo; none for an isotropic one.
    boresight: Option<[f64; 3]>,
}

/// The scene as scatterers; equal seeds give equal speckle.
#[derive(Debug)]
pub struct Scattering {
    scatterers: Vec<Scatterer>,
    surface_reflection: Option<f64>,
    beam_exponent: f64,
}

/// Half-power half-width of a trihedral's pattern (rad).
const CORNER_HALF_WIDTH_RAD: f64 = 20.0 * PI / 180.0;

impl Scattering {
    /// Lays out `scene` about the ground track `track_m` (east, north).
    #[must_use]
    pub fn new(scene: &RadarScene, radar: &RadarModel, track_m: &[[f64; 2]], seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let carrier_hz = 0.5e9 * (radar.band_ghz[0] + radar.band_ghz[1]);
        let wavelength_m = SPEED_OF_LIGHT_M_S / carrier_hz;
        let mut scatterers = Vec::new();
        for p in &scene.point {
            scatterers.push(Scatterer {
                position_m: p.position_m,
                root_rcs_m: p.rcs_m2.sqrt(),
                phase_rad: 0.0,
                boresight: None,
            });
        }
        for c in &scene.corner {
            let (sa, ca) = c.azimuth_deg.to_radians().sin_cos();
            let (se, ce) = c.elevation_deg.to_radians().sin_cos();
            scatterers.push(Scatterer {
                position_m: c.position_m,
                root_rcs_m: corner_rcs_m2(c.edge_m, wavelength_m).sqrt(),
                phase_rad: 0.0,
                boresight: Some([sa * ce, ca * ce, se]),
            });
        }
        for c in &scene.clutter {
            #[expect(clippy::cast_precision_loss, reason = "a count")]
            let each = (c.rcs_m2 / c.scatterers as f64).sqrt();
            for _ in 0..c.scatterers {
                scatterers.push(Scatterer {
                    position_m: [0, 1, 2]
                        .map(|i| c.from_m[i] + rng.random::<f64>() * (c.to_m[i] - c.from_m[i])),
                    // Exponential cross-sections: fully developed speckle.
                    root_rcs_m: each * (-(1.0 - rng.random::<f64>()).ln()).sqrt(),
                    phase_rad: rng.random::<f64>() * 2.0 * PI,
                    boresight: None,
                });
            }
        }
        if let Some(ground) = &scene.ground {
            facets(ground, track_m, &mut rng, &mut scatterers);
        }
        // One-way power is one half at half the beamwidth; the amplitude of two antennas is the one-way
        // power.
        let beam_exponent =
            0.5_f64.ln() / (0.5 * radar.antenna_beamwidth_deg).to_radians().cos().ln();
        Self {
            scatterers,
            surface_reflection: scene.ground.as_ref().map(|g| g.reflection),
            beam_exponent,
        }
    }

    /// Number of scatterers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.scatterers.len()
    }

    /// Whether the scene is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.scatterers.is_empty() && self.surface_reflection.is_none()
    }

    /// The echoes at one pose, with the phase centre at `antenna_m`.
    pub fn echoes(&self, pose: &Pose, antenna_m: [f64; 3], echoes: &mut Vec<Echo>) {
        echoes.clear();
        let axis = pose.attitude.rotate([0.0, 0.0, -1.0]);
        for s in &self.scatterers {
            let d = [0, 1, 2].map(|i| s.position_m[i] - antenna_m[i]);
            let range_m = norm(d).max(0.05);
            let beam = self.beam(dot(d, axis) / range_m);
            let pattern = s
                .boresight
                .map_or(1.0, |b| corner_pattern(-dot(d, b) / range_m));
            let strength = s.root_rcs_m * beam * pattern / (range_m * range_m);
            if strength > 0.0 {
                let delay_s = 2.0 * range_m / SPEED_OF_LIGHT_M_S;
                echoes.push(Echo {
                    delay_s,
                    strength,
                    phase_rad: s.phase_rad,
                });
            }
        }
        if let Some(reflection) = self.surface_reflection {
            let height_m = antenna_m[2].max(0.05);
            // A mirror image at 2h: power ∝ Γ²λ²/(4π·2h)², written as a cross-section over R⁴.
            let strength =
                (4.0 * PI).sqrt() * reflection.abs() / (2.0 * height_m) * self.beam(-axis[2]);
            echoes.push(Echo {
                delay_s: 2.0 * height_m / SPEED_OF_LIGHT_M_S,
                strength,
                // A denser medium turns the sign.
                phase_rad: if reflection < 0.0 { 0.0 } else { PI },
            });
        }
    }

    /// Amplitude of the two antennas together at `cosine` of the angle off their axis.
    fn beam(&self, cosine: f64) -> f64 {
        if cosine > 0.0 {
            cosine.powf(self.beam_exponent)
        } else {
            0.0
        }
    }
}

/// Largest radar cross-section of a triangular trihedral: 4πa⁴/(3λ²).
#[must_use]
pub fn corner_rcs_m2(edge_m: f64, wavelength_m: f64) -> f64 {
    4.0 * PI * edge_m.powi(4) / (3.0 * wavelength_m * wavelength_m)
}

/// Amplitude of a trihedral at `cosine` of the angle off its axis: a bell, half power at 20°.
fn corner_pattern(cosine: f64) -> f64 {
    if cosine <= 0.0 {
        return 0.0;
    }
    let off = cosine.min(1.0).acos() / CORNER_HALF_WIDTH_RAD;
    (-0.5 * std::f64::consts::LN_2 * off * off).exp()
}

fn facets(
    ground: &super::model::Ground,
    track_m: &[[f64; 2]],
    rng: &mut ChaCha8Rng,
    scatterers: &mut Vec<Scatterer>,
) {
    if ground.facets_per_m2 == 0.0 || track_m.is_empty() {
        return;
    }
    let bound = |i: usize, sign: f64| {
        track_m
            .iter()
            .map(|p| sign * p[i])
            .fold(f64::NEG_INFINITY, f64::max)
            + ground.extent_m
    };
    let (low, high) = (
        [-bound(0, -1.0), -bound(1, -1.0)],
        [bound(0, 1.0), bound(1, 1.0)],
    );
    let area_m2 = (high[0] - low[0]) * (high[1] - low[1]);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bounded by the checks of the scene"
    )]
    let count = (area_m2 * ground.facets_per_m2).min(1e6) as usize;
    let rcs_m2 = 10.0_f64.powf(0.1 * ground.backscatter_db) / ground.facets_per_m2;
    for _ in 0..count {
        scatterers.push(Scatterer {
            position_m: [
                low[0] + rng.random::<f64>() * (high[0] - low[0]),
                low[1] + rng.random::<f64>() * (high[1] - low[1]),
                0.0,
            ],
            root_rcs_m: (-rcs_m2 * (1.0 - rng.random::<f64>()).ln()).sqrt(),
            phase_rad: rng.random::<f64>() * 2.0 * PI,
            boresight: None,
        });
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
