//! Main lobe and sidelobes in a cut through a peak.

/// Range of the search for sidelobes and of the sum of their energy, Rayleigh distances.
pub const SIDELOBE_REACH: f64 = 10.0;

/// A minimum ends the main lobe only where the cut has fallen by 3 dB; a shallower minimum is a ripple on the
/// lobe's top, since two lobes with a shallower dip between them count as one.
const LOBE_END_POWER: f64 = 0.501_187_233_627_272_2;
const POWER_3DB: f64 = 0.501_187_233_627_272_2;
const POWER_6DB: f64 = 0.251_188_643_150_958;

/// Features of one side of a cut, going outward from the peak. Powers are relative to the peak's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arm {
    /// Distance from the peak to the first minimum, m.
    pub rayleigh_m: Option<f64>,
    /// Distance from the peak at which power has fallen by 3 dB, m.
    pub half_width_3db_m: Option<f64>,
    /// Distance from the peak at which power has fallen by 6 dB, m.
    pub half_width_6db_m: Option<f64>,
    /// Highest power beyond the first minimum.
    pub side_peak: Option<f64>,
    /// Energy up to the first minimum (power × m).
    pub main_energy: f64,
    /// Energy beyond the first minimum.
    pub side_energy: f64,
}

/// Measures one side of a cut outward from a peak of amplitude `peak`, in steps of `step_m`.
///
/// `amplitude(s)` is the amplitude at distance s ≥ 0, `None` where the field ends. The main lobe is
/// followed up to `limit_m`; the sidelobes up to [`SIDELOBE_REACH`] Rayleigh distances, but no
/// further than `sidelobe_limit_m`. Crossings are interpolated linearly in power, the minimum by a
/// parabola.
pub fn measure_arm(
    amplitude: impl Fn(f64) -> Option<f64>,
    peak: f64,
    step_m: f64,
    limit_m: f64,
    sidelobe_limit_m: f64,
) -> Arm {
    let mut arm = Arm::default();
    let power = |k: usize| amplitude(k as f64 * step_m).map(|a| (a / peak).powi(2));
    let (mut before, mut here) = (1.0, 1.0);
    let mut k = 0;
    while (k as f64) * step_m < limit_m {
        let Some(next) = power(k + 1) else { return arm };
        let crossing = |level: f64| {
            (here > level && next <= level)
                .then(|| (k as f64 + (here - level) / (here - next)) * step_m)
        };
        arm.half_width_3db_m = arm.half_width_3db_m.or_else(|| crossing(POWER_3DB));
        arm.half_width_6db_m = arm.half_width_6db_m.or_else(|| crossing(POWER_6DB));
        if next > here && here <= before && here < LOBE_END_POWER {
            let curvature = before + next - 2.0 * here;
            let shift = if curvature > 0.0 {
                0.5 * (before - next) / curvature
            } else {
                0.0
            };
            arm.rayleigh_m = Some((k as f64 + shift) * step_m);
            break;
        }
        arm.main_energy += 0.5 * (here + next) * step_m;
        before = here;
        here = next;
        k += 1;
    }
    let Some(rayleigh_m) = arm.rayleigh_m else {
        return arm;
    };
    // A limit of whole steps is reached whatever its division is rounded to.
    let end = (SIDELOBE_REACH * rayleigh_m).min(sidelobe_limit_m) / step_m + 1e-6;
    while ((k + 1) as f64) <= end {
        let Some(next) = power(k + 1) else { break };
        arm.side_energy += 0.5 * (here + next) * step_m;
        arm.side_peak = Some(arm.side_peak.map_or(next, |p| p.max(next)));
        here = next;
        k += 1;
    }
    arm
}

/// Both sides of a cut put together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobe {
    /// The side towards smaller distances along the cut.
    pub minus: Arm,
    /// The other side.
    pub plus: Arm,
}

impl Lobe {
    /// Mean of both Rayleigh distances, m.
    pub fn rayleigh_m(&self) -> Option<f64> {
        Some(0.5 * (self.minus.rayleigh_m? + self.plus.rayleigh_m?))
    }

    /// Full width at −3 dB, m.
    pub fn width_3db_m(&self) -> Option<f64> {
        Some(self.minus.half_width_3db_m? + self.plus.half_width_3db_m?)
    }

    /// Full width at −6 dB, m.
    pub fn width_6db_m(&self) -> Option<f64> {
        Some(self.minus.half_width_6db_m? + self.plus.half_width_6db_m?)
    }

    /// Highest sidelobe's power relative to the peak.
    pub fn side_peak(&self) -> Option<f64> {
        match (self.minus.side_peak, self.plus.side_peak) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        }
    }

    /// Energy of the sidelobes over that of the main lobe; `None` unless both ends of the main
    /// lobe are known.
    pub fn side_to_main(&self) -> Option<f64> {
        self.rayleigh_m()?;
        let main = self.minus.main_energy + self.plus.main_energy;
        Some((self.minus.side_energy + self.plus.side_energy) / main)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn sinc(t: f64) -> f64 {
        if t == 0.0 {
            1.0
        } else {
            ((PI * t).sin() / (PI * t)).abs()
        }
    }

    #[test]
    fn a_sinc_has_its_textbook_figures() {
        let arm = measure_arm(|s| Some(3.0 * sinc(s / 0.4)), 3.0, 0.4 / 50.0, 5.0, 50.0);
        let lobe = Lobe {
            minus: arm,
            plus: arm,
        };
        assert!((lobe.rayleigh_m().unwrap() - 0.4).abs() < 3e-4);
        assert!((lobe.width_3db_m().unwrap() - 0.88449 * 0.4).abs() < 2e-4);
        assert!((lobe.width_6db_m().unwrap() - 1.20496 * 0.4).abs() < 2e-4);
        assert!((10.0 * lobe.side_peak().unwrap().log10() + 13.26).abs() < 0.02);
        // ∫sinc² is 0.90282 over (−1, 1) and 1 − 1/(10π²) over (−10, 10).
        let islr = 10.0 * lobe.side_to_main().unwrap().log10();
        assert!((islr + 10.16).abs() < 0.02, "{islr}");
    }

    #[test]
    fn ripples_on_top_do_not_end_the_lobe() {
        let shape = |s: f64| {
            Some((-(s * s)).exp() * (1.0 + 0.05 * (40.0 * s).cos()) + 0.01 * (3.0 * s).cos())
        };
        let arm = measure_arm(shape, shape(0.0).unwrap(), 0.002, 5.0, 5.0);
        assert!(arm.half_width_3db_m.is_some());
        assert!(
            arm.rayleigh_m
                .is_none_or(|r| r > arm.half_width_3db_m.unwrap())
        );
    }

    #[test]
    fn a_field_that_ends_leaves_the_rest_unknown() {
        let arm = measure_arm(|s| (s < 0.3).then(|| sinc(s / 0.4)), 1.0, 0.004, 5.0, 5.0);
        assert!(arm.half_width_3db_m.is_some() && arm.rayleigh_m.is_none());
        let lobe = Lobe {
            minus: arm,
            plus: Arm::default(),
        };
        assert!(lobe.rayleigh_m().is_none() && lobe.side_to_main().is_none());
    }
}
