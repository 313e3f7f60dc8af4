//! Working memory of the updates of a filter's state.

use super::sparse_row::SparseRow;

/// Memory of past updates.
#[derive(Debug, Default)]
pub(crate) struct Room {
    /// Noise, then the innovations' covariance, then its factor.
    pub noise: Vec<f64>,
    /// Covariance of the active states, row by row.
    pub covariance: Vec<f64>,
    /// The equations, with places among the active states for states.
    pub placed: Vec<SparseRow>,
    /// One column per equation: (P Hᵀ) restricted to the active states; then PHᵀL⁻ᵀ.
    pub pht: Vec<f64>,
    /// One column per active state: L⁻¹HP.
    pub whitened: Vec<f64>,
    pub residuals: Vec<f64>,
    /// States that exist.
    pub active: Vec<usize>,
    /// Index of each state among the active states.
    pub place: Vec<usize>,
}

impl Room {
    /// Stores which states exist.
    pub(crate) fn note_active(&mut self, exists: &[bool]) {
        self.active.clear();
        self.place.clear();
        for (index, exists) in exists.iter().enumerate() {
            self.place.push(if *exists {
                self.active.len()
            } else {
                usize::MAX
            });
            if *exists {
                self.active.push(index);
            }
        }
    }

    /// Takes the active states' part of the covariance `p` of `n` states, and of the equations.
    pub(crate) fn gather(&mut self, p: &[f64], n: usize, rows: &[SparseRow]) {
        self.covariance.clear();
        for &a in &self.active {
            let own = &p[a * n..(a + 1) * n];
            self.covariance.extend(self.active.iter().map(|&b| own[b]));
        }
        self.placed.clear();
        let place = &self.place;
        self.placed.extend(rows.iter().map(|row| {
            // A state that does not exist has neither variance nor covariance.
            let mut placed = SparseRow::new(&[], row.residual);
            for &(index, coefficient) in row.coefficients() {
                if place[index] != usize::MAX {
                    placed.push(place[index], coefficient);
                }
            }
            placed
        }));
    }
}

/// Fills `to` with the rows of a matrix whose columns are `count` long, one after the other.
pub(crate) fn transpose(columns: &[f64], count: usize, to: &mut Vec<f64>) {
    to.resize(columns.len(), 0.0);
    let rows = columns.len() / count.max(1);
    for (j, column) in columns.chunks_exact(count.max(1)).enumerate() {
        for (own, value) in to.chunks_exact_mut(rows).zip(column) {
            own[j] = *value;
        }
    }
}

/// Zeros in the given memory.
pub(crate) fn zeros_in(mut memory: Vec<f64>, count: usize) -> Vec<f64> {
    memory.clear();
    memory.resize(count, 0.0);
    memory
}
