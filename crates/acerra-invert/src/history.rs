//! Report of a solver on its iterations.

use serde::Serialize;

/// Reason why a solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Stop {
    /// The solution changes by less than the tolerance.
    Converged,
    /// The residual has come down to the level of the noise.
    Noise,
    /// The data hold no further information: the Krylov space is exhausted.
    Exhausted,
    /// The iterations allowed are spent.
    Iterations,
    /// The residual no longer falls.
    Stalled,
}

impl Stop {
    /// Whether the solution is the one that the method defines, rather than an intermediate one.
    #[must_use]
    pub fn is_converged(self) -> bool {
        matches!(self, Self::Converged | Self::Noise | Self::Exhausted)
    }
}

/// One recorded iteration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Iteration {
    /// Number of the iteration, from 1.
    pub number: usize,
    /// ‖d − Lσ‖ / ‖d‖.
    pub residual: f64,
    /// Relative change of the solution since the iteration recorded before; of the sparse solver the
    /// relative duality gap.
    pub change: f64,
}

/// The iterations of a solver and how they ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct History {
    /// Recorded iterations, in their order.
    pub iterations: Vec<Iteration>,
    /// Reason why the solver stopped.
    pub stop: Stop,
}

impl History {
    /// ‖d − Lσ‖ / ‖d‖ of the solution; 1 without an iteration.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.iterations.last().map_or(1.0, |last| last.residual)
    }

    /// Iterations done.
    #[must_use]
    pub fn count(&self) -> usize {
        self.iterations.last().map_or(0, |last| last.number)
    }
}
