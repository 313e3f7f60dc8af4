//! One method on one scene.

use std::sync::Mutex;
use std::time::Instant;

use acerra_chain::focus::inversion::Method;
use acerra_chain::focus::plan::ImageError;
use acerra_chain::{Control, Focused};

use crate::cost::{Cost, measured};
use crate::scene::Scene;

/// An image and what it took.
pub struct Run {
    pub method: Method,
    pub focused: Focused,
    pub cost: Cost,
    /// Median time from one iteration to the next.
    pub iteration_s: Option<f64>,
}

impl Run {
    /// Iterations done; of `clean` major cycles.
    pub fn iterations(&self) -> Option<usize> {
        let record = self.focused.inversion.as_ref()?;
        Some(record.iterations.last().map_or(0, |last| last.number))
    }

    /// Whether the solver ended before its iterations were spent.
    pub fn is_settled(&self) -> Option<bool> {
        let record = self.focused.inversion.as_ref()?;
        Some(record.stop.is_converged())
    }

    /// What the stop rule looked at last: relative change, duality gap, or residual peak.
    pub fn change(&self) -> Option<f64> {
        Some(self.focused.inversion.as_ref()?.iterations.last()?.change)
    }
}

/// Images `scene` by `method`.
pub fn run(
    scene: &Scene,
    method: Method,
    max_iterations: Option<usize>,
) -> Result<Run, ImageError> {
    let steps = Steps::default();
    let control = Control::default().reporting_to(&steps);
    let (focused, cost) = measured(|| scene.image(method, max_iterations, &control))?;
    Ok(Run {
        method,
        focused,
        cost,
        iteration_s: (method != Method::Adjoint)
            .then(|| steps.median_s())
            .flatten(),
    })
}

/// When each iteration ended.
#[derive(Default)]
struct Steps(Mutex<Vec<Instant>>);

impl acerra_chain::Progress for Steps {
    fn start(&self, _name: &str, _total: u64) {}

    fn at(&self, _done: u64) {
        self.0.lock().unwrap().push(Instant::now());
    }

    fn finish(&self) {}
}

impl Steps {
    fn median_s(&self) -> Option<f64> {
        let ends = self.0.lock().unwrap();
        let gap_s = |pair: &[Instant]| (pair[1] - pair[0]).as_secs_f64();
        let mut gaps_s: Vec<f64> = ends.windows(2).map(gap_s).collect();
        gaps_s.sort_by(f64::total_cmp);
        gaps_s.get(gaps_s.len() / 2).copied()
    }
}
