//! The sharpness cue: scores of images formed at chosen offsets, which the caller computes.

/// Sharpness over the offsets tried.
#[derive(Debug, Clone, PartialEq)]
pub struct SharpnessCue {
    /// Offset and score of each image, offsets rising: the mean over parts of ln(score).
    pub log_score: Vec<(f64, f64)>,
    /// Sharpest offset, s, interpolated between the offsets tried by a parabola.
    pub offset_s: f64,
    /// Standard deviation of the sharpest offset, s: the scatter of the parts' sharpest offsets, or, with a
    /// single part, half the width at which the score has fallen by 3 dB.
    pub sigma_s: f64,
    /// Number of parts that were scored separately.
    pub parts: usize,
}

/// Offsets at which to score, and the scores so far.
pub(super) struct Scored {
    /// Offset and one score for each part.
    pub scores: Vec<(f64, Vec<f64>)>,
}

impl Scored {
    /// The sharpest offset of one interval; `None` where the score peaks at an end of the interval (no peak),
    /// or scores are missing.
    pub fn cue(mut self) -> Option<SharpnessCue> {
        self.scores.sort_by(|a, b| a.0.total_cmp(&b.0));
        let parts = self.scores.first()?.1.len();
        let sound = parts > 0
            && self.scores.iter().all(|(_, s)| {
                s.len() == parts && s.iter().all(|score| *score > 0.0 && score.is_finite())
            });
        if !sound || self.scores.len() < 3 {
            return None;
        }
        let log_score: Vec<(f64, f64)> = self
            .scores
            .iter()
            .map(|(t, s)| (*t, s.iter().map(|x| x.ln()).sum::<f64>() / parts as f64))
            .collect();
        let (offset_s, width_s) = peak(&log_score)?;
        let each: Vec<f64> = (0..parts)
            .filter_map(|p| {
                let own: Vec<(f64, f64)> =
                    self.scores.iter().map(|(t, s)| (*t, s[p].ln())).collect();
                peak(&own).map(|(t, _)| t)
            })
            .collect();
        let sigma_s = match each.len() {
            0..=2 => width_s,
            n => {
                let mean = each.iter().sum::<f64>() / n as f64;
                let power = each.iter().map(|t| (t - mean).powi(2)).sum::<f64>();
                let scatter = (power / (n * (n - 1)) as f64).sqrt();
                // Few parts estimate their own scatter poorly (Student).
                scatter * ((n - 1) as f64 / (n as f64 - 2.0)).sqrt()
            }
        };
        let step_s = self.scores[1].0 - self.scores[0].0;
        Some(SharpnessCue {
            log_score,
            offset_s,
            sigma_s: sigma_s.max(0.05 * step_s),
            parts,
        })
    }
}

/// Vertex of the highest point inside a curve, and half its width 3 dB (in power) below.
fn peak(curve: &[(f64, f64)]) -> Option<(f64, f64)> {
    let k = (0..curve.len()).max_by(|&a, &b| curve[a].1.total_cmp(&curve[b].1))?;
    if k == 0 || k + 1 == curve.len() {
        return None;
    }
    let [(t0, y0), (t1, y1), (t2, y2)] = [curve[k - 1], curve[k], curve[k + 1]];
    // Vertex of the parabola through three unevenly spaced points.
    let (d0, d2) = ((y1 - y0) / (t1 - t0), (y2 - y1) / (t2 - t1));
    let curvature = (d2 - d0) / (0.5 * (t2 - t0));
    let offset_s = if curvature < 0.0 {
        (0.5 * (t0 + t1) - d0 / curvature).clamp(t0, t2)
    } else {
        t1
    };
    let floor = y1 - 0.5 * std::f64::consts::LN_2;
    let falls = |p: &&(f64, f64)| p.1 < floor;
    let left = curve[..k].iter().rev().find(falls).map(|p| t1 - p.0);
    let right = curve[k + 1..].iter().find(falls).map(|p| p.0 - t1);
    let width_s = match (left, right) {
        (Some(a), Some(b)) => 0.5 * (a + b),
        (Some(a), None) | (None, Some(a)) => a,
        (None, None) => curve[curve.len() - 1].0 - curve[0].0,
    };
    Some((offset_s, width_s))
}

/// Number of images to each side of an interval's centre within `sigmas` standard deviations.
fn images_aside(sigmas: f64, sigma_s: f64, step_s: f64) -> f64 {
    (sigmas * sigma_s / step_s).ceil().max(4.0)
}

/// Least number of images of an interval: two standard deviations to each side.
pub(super) fn least_images(sigma_s: f64, step_s: f64) -> usize {
    2 * images_aside(2.0, sigma_s, step_s) as usize + 1
}

/// Offsets at which one interval is scored: `step_s` apart, four standard deviations to each side as far as
/// `most` allow, and at least two.
pub(super) fn offsets_about(centre_s: f64, sigma_s: f64, step_s: f64, most: usize) -> Vec<f64> {
    let aside = |sigmas: f64| images_aside(sigmas, sigma_s, step_s);
    let half = aside(4.0).min((most as f64 / 2.0).floor().max(aside(2.0)));
    (0..=2 * half as usize)
        .map(|k| centre_s + (k as f64 - half) * step_s)
        .collect()
}
