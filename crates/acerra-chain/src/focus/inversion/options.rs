//! `[image] method` and `[image.inversion]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[image] method`: method of imaging the echoes.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The adjoint, the sum of Eq. (3).
    #[default]
    Adjoint,
    /// Truncated singular value decomposition: narrower, with higher sidelobes.
    Tsvd,
    /// Damped least squares, the damping found from the noise.
    Cgls,
    /// The sparsest scene that explains the echoes up to the noise.
    Sparse,
    /// Points subtracted one after another, and restored without sidelobes.
    Clean,
}

impl Method {
    /// Name of the method in a campaign.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Adjoint => "adjoint",
            Self::Tsvd => "tsvd",
            Self::Cgls => "cgls",
            Self::Sparse => "sparse",
            Self::Clean => "clean",
        }
    }
}

/// `[image.inversion]`: parameters of `method`, each found from the data or by theory unless stated.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct InversionSection {
    /// Of `"tsvd"`: singular values further than this below the greatest are left out, in decibels.
    pub threshold_db: f64,
    /// Of `"cgls"`: the damping μ over the greatest singular value. By default the one whose residual
    /// equals the noise, else the corner of the L-curve.
    pub damping: Option<f64>,
    /// Of `"sparse"`: the weight λ of the scene's modulus over the smallest weight whose scene is empty. By
    /// default the level that noise exceeds nowhere in the image, but at least 0.03.
    pub sparsity: Option<f64>,
    /// Of `"clean"`: points weaker than this against the strongest are left, in decibels. By default
    /// those that noise reaches, but at least −30 dB.
    pub clean_threshold_db: Option<f64>,
    /// Of `"clean"`: the share of a point that is taken off at a time.
    pub clean_gain: f64,
    /// Most iterations (of `"clean"` major cycles); by default 120, of `"sparse"` 200, of `"clean"` 60.
    pub max_iterations: Option<usize>,
    /// Number of strongest targets at which the method is applied to the echoes of a single point, so that
    /// its resolution can be compared with the adjoint's. Each takes about as long as the image.
    pub resolution_points: usize,
}

impl Default for InversionSection {
    fn default() -> Self {
        Self {
            threshold_db: -20.0,
            damping: None,
            sparsity: None,
            clean_threshold_db: None,
            clean_gain: 0.2,
            max_iterations: None,
            resolution_points: 1,
        }
    }
}

/// Method and parameters of an inversion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InversionOptions {
    /// The method.
    pub method: Method,
    /// Parameters of the method.
    pub parameters: InversionSection,
}

impl InversionOptions {
    /// Largest number of iterations.
    #[must_use]
    pub fn max_iterations(&self) -> usize {
        self.parameters.max_iterations.unwrap_or(match self.method {
            Method::Adjoint | Method::Tsvd | Method::Cgls => 120,
            Method::Sparse => 200,
            Method::Clean => 60,
        })
    }
}
