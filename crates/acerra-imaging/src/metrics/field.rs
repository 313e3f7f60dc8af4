//! Fields: anything that gives an amplitude at a point of the image plane.

/// An amplitude over the image plane.
///
/// Two types implement this trait: an image that is interpolated between its pixels
/// ([`InterpolatedImage`](super::InterpolatedImage)) and a point spread function that is evaluated exactly at
/// any place ([`PsfField`](crate::psf::PsfField)). Measured images and predictions are thus measured by the
/// same definitions.
pub trait Field: Sync {
    /// Amplitude |σ̃| at (x, y) in metres, or `None` outside the area that is known.
    fn amplitude(&self, x_m: f64, y_m: f64) -> Option<f64>;
}

/// Climbs to the maximum nearest to a starting point.
///
/// A pattern search with a parabola through three points in each direction; the pattern shrinks from `step_m`
/// to a thousandth of `step_m`. The search follows ridges oblique to the axes, since every round also tries
/// the diagonal of the last move. Returns the place (x, y) in metres and the amplitude there, or `None` if
/// the start is outside the field.
pub fn climb_to_peak(field: &dyn Field, start_m: [f64; 2], step_m: f64) -> Option<([f64; 2], f64)> {
    let mut here = start_m;
    let mut best = field.amplitude(here[0], here[1])?;
    let mut step = step_m;
    // Each round either moves uphill or halves the pattern, so that 400 rounds suffice.
    for _ in 0..400 {
        let before = here;
        for axis in [[1.0, 0.0], [0.0, 1.0]] {
            (here, best) = best_on_line(field, (here, best), axis, step);
        }
        let leap = [2.0 * here[0] - before[0], 2.0 * here[1] - before[1]];
        if leap != here
            && let Some(value) = field.amplitude(leap[0], leap[1]).filter(|v| *v > best)
        {
            here = leap;
            best = value;
        }
        let moved = (here[0] - before[0]).hypot(here[1] - before[1]);
        if moved < 0.5 * step {
            step *= 0.5;
        }
        if step < 1e-3 * step_m {
            break;
        }
    }
    Some((here, best))
}

/// The highest of three points on a line about `here`, a `step` apart, and of the vertex of the
/// parabola through them. `axis` is the line's unit vector.
pub(super) fn best_on_line(
    field: &dyn Field,
    here: ([f64; 2], f64),
    axis: [f64; 2],
    step: f64,
) -> ([f64; 2], f64) {
    let (place, value) = here;
    let at = |t: f64| {
        let p = [place[0] + t * axis[0], place[1] + t * axis[1]];
        (p, field.amplitude(p[0], p[1]).unwrap_or(f64::NEG_INFINITY))
    };
    let (minus, plus) = (at(-step), at(step));
    let mut best = here;
    for trial in [minus, plus] {
        if trial.1 > best.1 {
            best = trial;
        }
    }
    let curvature = minus.1 + plus.1 - 2.0 * value;
    if curvature < 0.0 && curvature.is_finite() {
        let vertex = at((0.5 * (minus.1 - plus.1) / curvature).clamp(-1.0, 1.0) * step);
        if vertex.1 > best.1 {
            best = vertex;
        }
    }
    best
}
