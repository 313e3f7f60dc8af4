//! The expected image under Gaussian position errors, in closed form.

use serde::Serialize;

use super::criteria::{
    CUT_CELLS, CUT_POINTS, FOCUSED_COHERENCE, FOCUSED_POWER, SHIFT_COHERENCE, half_power_width,
};
use super::geometry::{View, dot};
use super::model::ErrorModel;
use super::nodes::Nodes;
use crate::error::ImagingError;
use crate::psf::spread::PointSpread;

/// Expected blur of a point's image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Blur {
    /// Loss of power at the target's true place, dB. Exact for any size of error.
    pub loss_at_target_db: f64,
    /// Coherent power of the shifted peak over the power of the speckle that the errors spread, dB.
    pub coherence_db: f64,
    /// Whether the peak is clear, by the criterion of the [module](super); the figures below require a clear
    /// peak.
    pub focused: bool,
    /// Loss of power at the peak, wherever it has shifted to, dB.
    pub peak_loss_db: Option<f64>,
    /// Standard deviation of the peak's shift along the track, m; `None` below a coherence of 3 dB, where the
    /// first-order approximation fails.
    pub shift_along_m: Option<f64>,
    /// Standard deviation of the peak's shift across the track, m; `None` also for a target under
    /// the track, where range does not change across.
    pub shift_across_m: Option<f64>,
    /// −3 dB width along the track of the mean power about the shifted place, over the width of the ideal
    /// image.
    pub widening_along: Option<f64>,
    /// The widening across the track.
    pub widening_across: Option<f64>,
}

/// Predicts the effect of `model` on the image of a point at `target_m` (on the plane of the point).
///
/// Range errors ε shift the phase of each contribution by kε, k = 4πf/c. With Gaussian errors the expected
/// power is the double sum over pulses and frequencies of exp(−Var(kε − k′ε′)/2), for errors of any size.
/// Slow errors mostly shift the peak: the shift that fits the errors best is found by least squares, and the
/// remaining errors blur the peak. The motion of a peak in its own speckle is added to the shift, to first
/// order.
///
/// # Errors
/// A model for another number of pulses, a target that is not below the flight, no bandwidth.
///
/// ```
/// use acerra_imaging::psf::{PointSpread, TrackShape, synthetic_track};
/// use acerra_imaging::sensitivity::{ErrorModel, predict};
/// let track = synthetic_track(TrackShape::Straight, 3.0, 0.03, 5.0)?;
/// let model = ErrorModel::white(0.005, track.len())?;
/// let frequency_hz = (0..171).map(|n| 3.1e9 + 1e7 * f64::from(n)).collect();
/// let spread = PointSpread::new(track, None, frequency_hz, 3e8)?;
/// let blur = predict(&spread, [0.0, 2.0, 0.0], &model)?;
/// // 5 mm are 0.83 rad at 3.95 GHz: 10 log₁₀ exp(−0.83²) ≈ −3 dB.
/// assert!((blur.peak_loss_db.unwrap() + 3.0).abs() < 0.3);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub fn predict(
    spread: &PointSpread,
    target_m: [f64; 3],
    model: &ErrorModel,
) -> Result<Blur, ImagingError> {
    let view = View::of(spread, target_m, model)?;
    let covariance = view.covariance_m2(model);
    let map = view.shift_map();
    let residual = view.residual_m2(&covariance, &map);
    let nodes = Nodes::of(&view);

    let at_target = nodes.sums(&covariance, None, &[]).power;
    let coherent = nodes.coherent_power(&residual);
    let cuts = cut_excess_m(spread, &view, target_m);
    let functional = nodes.shift_functional(&residual);
    let sums = nodes.sums(&residual, functional.as_ref(), &cuts);
    let coherence = coherent / (sums.power - coherent).max(1e-12 * coherent);
    let floor = view.speckle_scale * dot(&view.share, &view.share);
    let focused = sums.power >= FOCUSED_POWER * floor && coherence >= FOCUSED_COHERENCE;
    let first_order = focused && coherence >= SHIFT_COHERENCE;

    let linear = quadratic(&covariance, &map);
    let mut shift_m = None;
    let mut regained = 0.0;
    if let Some(functional) = functional.as_ref().filter(|_| focused) {
        let cross = nodes.cross(&covariance, &residual, &map, &linear, functional);
        let total = |i: usize| linear[i][i] + sums.shift[i][i] + 2.0 * cross[i];
        shift_m = Some([0, 1].map(|i| total(i).max(0.0).sqrt()));
        // Climbing from the fitted place to the maximum of the speckle regains half of curvature times
        // variance.
        for i in 0..2 {
            for j in 0..2 {
                regained += 0.5 * functional.curvature[i][j] * sums.shift[i][j];
            }
        }
    }
    let ideal = nodes.ideal_cut(&cuts);
    let widening = |axis: usize| -> Option<f64> {
        let range = axis * CUT_POINTS..(axis + 1) * CUT_POINTS;
        Some(half_power_width(&sums.cut[range.clone()])? / half_power_width(&ideal[range])?)
    };
    let across = focused && view.across_known;
    Ok(Blur {
        loss_at_target_db: 10.0 * at_target.log10(),
        coherence_db: 10.0 * coherence.log10(),
        focused,
        peak_loss_db: focused.then(|| 10.0 * (sums.power + regained).log10()),
        shift_along_m: shift_m.map(|s| s[0]).filter(|_| first_order),
        shift_across_m: shift_m.map(|s| s[1]).filter(|_| across && first_order),
        widening_along: widening(0).filter(|_| focused),
        widening_across: widening(1).filter(|_| across),
    })
}

/// H C Hᵀ.
fn quadratic(c: &[f64], h: &[Vec<f64>; 2]) -> [[f64; 2]; 2] {
    let ch: Vec<[f64; 2]> = c
        .chunks(h[0].len())
        .map(|row| [dot(row, &h[0]), dot(row, &h[1])])
        .collect();
    [0, 1].map(|i| [0, 1].map(|j| h[i].iter().zip(&ch).map(|(w, v)| w * v[j]).sum()))
}

/// Excess range of every kept pulse at the points of both cuts: `[2 · CUT_POINTS][pulses]`, m.
fn cut_excess_m(spread: &PointSpread, view: &View, target_m: [f64; 3]) -> Vec<Vec<f64>> {
    let range = crate::vector::range_m;
    let cuts = [
        (view.track.tangent, view.cell.along_m),
        (view.track.left(), view.cell.across_m),
    ];
    let mut excess = Vec::with_capacity(2 * CUT_POINTS);
    for (direction, cell_m) in cuts {
        for k in 0..CUT_POINTS {
            let s = CUT_CELLS * cell_m * (2.0 * k as f64 / (CUT_POINTS - 1) as f64 - 1.0);
            let at = [
                target_m[0] + s * direction[0],
                target_m[1] + s * direction[1],
                target_m[2],
            ];
            let of = |m: &usize| {
                let p = spread.position_m()[*m];
                range(p, at) - range(p, target_m)
            };
            excess.push(view.pulse.iter().map(of).collect());
        }
    }
    excess
}
