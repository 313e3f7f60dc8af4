//! The spacing of traces along lines that the shapes of echoes agree on.

use acerra_imaging::ImagingError;

use super::leg::{depth_at, vertical};
use super::posterior::{CommonSigma, RADIUS_M, RADIUS_SIGMA_M, Residual, misfit};
use super::stretch::StretchedEcho;
use crate::focus::underground::Underground;
use crate::journal::finding::DOUBTFUL_SIGMAS;

/// Ratios of one factor of the spacing, and of the permittivities, to the one before.
const STRETCH_RATIO: f64 = 1.01;
const PERMITTIVITY_RATIO: f64 = 1.05;
/// Factors of the spacing that are compared, to either side of one: to a factor of seven, so that bounds lie beyond the
/// shapes that are compared.
const STRETCHES: i32 = 200;
/// Standard deviation of the logarithm of a stated permittivity: tables of soils span a factor of two.
const STATED_SIGMA: f64 = 0.35;

/// Spacing of the traces by the shapes of echoes: positions over true distances along the lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spacing {
    /// The likeliest factor.
    pub stretch: f64,
    /// Least and greatest factor within three standard deviations.
    pub bounds: [f64; 2],
    /// Distance of one from the likeliest factor, in standard deviations.
    pub sigmas: f64,
    /// Permittivity of the topmost layer by which the stated spacing would fit; none where no soil's does within three
    /// standard deviations.
    pub permittivity: Option<f64>,
    /// Echoes that the factor is from.
    pub echoes: usize,
}

/// The likeliest spacing, whatever the permittivities: those in force are as uncertain as stated ones are, or entirely where
/// they are found from the data. None without echoes.
///
/// An echo's hyperbola has the radius of curvature s² (h + q) in positions that are s times too far apart, with the antenna's
/// height h and q = Σ t/n: the same for another spacing and other permittivities.
///
/// # Errors
/// Invalid soils or layers.
pub(crate) fn spacing(
    underground: &Underground,
    frequency_hz: &[f64],
    echoes: &[StretchedEcho],
    common: CommonSigma,
) -> Result<Option<Spacing>, ImagingError> {
    if echoes.is_empty() {
        return Ok(None);
    }
    let in_force = underground.seen_at(frequency_hz)?;
    let shapes: Vec<Shape> = (echoes.iter())
        .map(|echo| Shape {
            echo: *echo,
            radius_m: echo.height_m
                + vertical(&in_force, depth_at(&in_force, echo.delay_m)).curvature_m,
        })
        .collect();
    let trials = (underground.factors(PERMITTIVITY_RATIO).into_iter())
        .map(|factor| Trial::of(underground, frequency_hz, &shapes, factor))
        .collect::<Result<Vec<Trial>, ImagingError>>()?;
    let fits: Vec<Fit> = (-STRETCHES..=STRETCHES)
        .filter_map(|k| Fit::of(&trials, &shapes, common, STRETCH_RATIO.powi(k)))
        .collect();
    // Echoes that scatter more than their deviations get less weight accordingly.
    let least = (fits.iter().map(|fit| fit.free)).fold(f64::INFINITY, f64::min);
    let freedom = echoes.len().saturating_sub(1).max(1) as f64;
    let excess = (least / freedom).max(1.0);
    let off = |fit: &Fit| fit.misfit / excess + fit.prior;
    let likeliest = fits.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    let stated = fits.iter().find(|fit| fit.stretch >= 1.0);
    let (Some(likeliest), Some(stated)) = (likeliest, stated) else {
        return Ok(None);
    };
    let most = DOUBTFUL_SIGMAS * DOUBTFUL_SIGMAS;
    let mut likely = fits.iter().filter(|fit| off(fit) - off(likeliest) <= most);
    let first = likely.next().unwrap_or(likeliest);
    let last = likely.next_back().unwrap_or(first);
    let top = (underground.layers.first()).map(|layer| layer.soil.relative_permittivity);
    let fits_stated = (stated.free - least) / excess <= most;
    Ok(Some(Spacing {
        stretch: likeliest.stretch,
        bounds: [first.stretch, last.stretch],
        sigmas: (off(stated) - off(likeliest)).max(0.0).sqrt(),
        permittivity: top
            .filter(|_| fits_stated)
            .map(|top| top * stated.free_factor),
        echoes: echoes.len(),
    }))
}

/// An echo with the radius of curvature of its hyperbola, by the permittivities in force and true distances (m).
struct Shape {
    echo: StretchedEcho,
    radius_m: f64,
}

/// Permittivities that are tried.
struct Trial {
    /// Factor by which the permittivities in force are multiplied.
    factor: f64,
    /// Square of its logarithm in units of its deviation.
    prior: f64,
    /// Distance q of the centre of each echo's object, and refractive index at the object.
    legs: Vec<[f64; 2]>,
}

impl Trial {
    fn of(
        underground: &Underground,
        frequency_hz: &[f64],
        shapes: &[Shape],
        factor: f64,
    ) -> Result<Self, ImagingError> {
        let ground = underground.scaled(factor).seen_at(frequency_hz)?;
        let leg = |shape: &Shape| {
            let depth_m = depth_at(&ground, shape.echo.delay_m);
            let index = vertical(&ground, depth_m).index;
            [vertical(&ground, depth_m + RADIUS_M).curvature_m, index]
        };
        Ok(Self {
            factor,
            prior: match underground.is_open {
                true => 0.0,
                false => (factor.ln() / STATED_SIGMA).powi(2),
            },
            legs: shapes.iter().map(leg).collect(),
        })
    }

    /// Squares of the differences between the logarithms of the radii of curvature and those of this trial, in units of their
    /// deviations.
    fn misfit(&self, shapes: &[Shape], common: CommonSigma, stretch: f64) -> f64 {
        let compared = shapes.iter().zip(&self.legs);
        let residuals: Vec<Residual> = compared
            .map(|(shape, [curvature_m, index])| {
                let (along, across) = (shape.echo.along, shape.echo.across);
                let own = 2.0 * along.sigma / along.value;
                let object_sigma_m = RADIUS_SIGMA_M / index * 0.5_f64.sqrt();
                let ratio_to = |radius_m: f64| {
                    ((along.value / stretch).powi(2) * shape.radius_m / radius_m).ln()
                };
                // Across the lines the spacing is right, and the shape is that of the same object in the same soil, but for
                // unequal radii of the object.
                if let Some(across) = across {
                    let radius_m = across.value.powi(2) * shape.radius_m;
                    let of_across = 2.0 * across.sigma / across.value;
                    return Residual {
                        value: ratio_to(radius_m),
                        own_sigma: own.hypot(of_across).hypot(2.0 * object_sigma_m / radius_m),
                        common: [0.0; 3],
                    };
                }
                let radius_m = shape.echo.height_m + curvature_m;
                Residual {
                    value: ratio_to(radius_m),
                    own_sigma: own.hypot(object_sigma_m / radius_m),
                    common: [
                        object_sigma_m / radius_m,
                        common.height_m / radius_m,
                        common.delay_m / (index * index) / radius_m,
                    ],
                }
            })
            .collect();
        misfit(&residuals)
    }
}

/// The permittivities that fit best with a factor of the spacing.
struct Fit {
    stretch: f64,
    /// Misfit of the likeliest permittivities, given the stated ones, and the square of their distance from these in units of
    /// the prior's deviation.
    misfit: f64,
    prior: f64,
    /// Least misfit of all permittivities, and the factor of the permittivities that has it.
    free: f64,
    free_factor: f64,
}

impl Fit {
    fn of(trials: &[Trial], shapes: &[Shape], common: CommonSigma, stretch: f64) -> Option<Self> {
        let misfits: Vec<(f64, &Trial)> = (trials.iter())
            .map(|trial| (trial.misfit(shapes, common, stretch), trial))
            .collect();
        let total = |fit: &(f64, &Trial)| fit.0 + fit.1.prior;
        let best = misfits
            .iter()
            .min_by(|a, b| total(a).total_cmp(&total(b)))?;
        let free = misfits.iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self {
            stretch,
            misfit: best.0,
            prior: best.1.prior,
            free: free.0,
            free_factor: free.1.factor,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::stretch::Factor;
    use super::*;

    /// Points below a soil of 6 whose positions are too far apart by a factor, as a ground of `in_force` shows them.
    fn echoes(stretch: f64, in_force: f64, is_grid: bool) -> Vec<StretchedEcho> {
        let factor = |value: f64| Factor {
            value,
            sigma: 0.02 * value,
        };
        let echo = |depth_m: f64| {
            let delay_m = 6.0_f64.sqrt() * (depth_m - RADIUS_M);
            let height_m = 0.05;
            let true_radius_m = height_m + depth_m / 6.0_f64.sqrt();
            let ratio = (true_radius_m / (height_m + delay_m / in_force)).sqrt();
            StretchedEcho {
                along: factor(stretch * ratio),
                across: is_grid.then(|| factor(ratio)),
                delay_m,
                height_m,
            }
        };
        [0.15, 0.25].map(echo).to_vec()
    }

    fn found(stretch: f64, in_force: f64, is_grid: bool) -> Spacing {
        let ground = Underground::of_soil(in_force);
        let echoes = echoes(stretch, in_force, is_grid);
        let found = spacing(&ground, &[1.5e9], &echoes, CommonSigma::default());
        found.unwrap().unwrap()
    }

    #[test]
    fn the_factor_is_found_where_the_permittivity_is_right() {
        for stretch in [0.4, 1.0, 2.5] {
            let found = found(stretch, 6.0, false);
            assert!((found.stretch / stretch - 1.0).abs() < 0.03, "{found:?}");
            assert_eq!(found.sigmas > 3.0, stretch != 1.0, "{found:?}");
        }
    }

    #[test]
    fn a_line_leaves_the_permittivity_open_and_a_grid_does_not() {
        let line = found(1.5, 6.0, false);
        assert!(
            line.permittivity.is_some_and(|value| value < 4.0),
            "{line:?}"
        );
        let grid = found(1.5, 20.0, true);
        assert!((grid.stretch / 1.5 - 1.0).abs() < 0.03, "{grid:?}");
        assert_eq!(grid.permittivity, None);
        assert!(found(1.0, 20.0, true).sigmas < 1.0);
    }

    #[test]
    fn no_soil_explains_a_hyperbola_that_is_too_wide() {
        assert_eq!(found(4.0, 6.0, false).permittivity, None);
    }
}
