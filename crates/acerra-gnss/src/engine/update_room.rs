//! Memory that the updates of a filter's state work in.

/// Memory of past updates.
#[derive(Debug, Default)]
pub(super) struct Room {
    /// Noise, then the innovations' covariance, then its factor.
    pub noise: Vec<f64>,
    /// One column per equation: (P Hᵀ) restricted to the active states; then PHᵀL⁻ᵀ.
    pub pht: Vec<f64>,
    /// One column per active state: L⁻¹HP.
    pub whitened: Vec<f64>,
    pub residuals: Vec<f64>,
    /// States that exist.
    pub active: Vec<usize>,
    /// Where among them each state is.
    pub place: Vec<usize>,
}

impl Room {
    /// Notes which states exist.
    pub(super) fn note_active(&mut self, exists: &[bool]) {
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
}

/// Fills `to` with the rows of a matrix whose columns are `count` long, one after the other.
pub(super) fn transpose(columns: &[f64], count: usize, to: &mut Vec<f64>) {
    to.resize(columns.len(), 0.0);
    let rows = columns.len() / count.max(1);
    for (j, column) in columns.chunks_exact(count.max(1)).enumerate() {
        for (own, value) in to.chunks_exact_mut(rows).zip(column) {
            own[j] = *value;
        }
    }
}

/// Zeros in this memory.
pub(super) fn zeros_in(mut memory: Vec<f64>, count: usize) -> Vec<f64> {
    memory.clear();
    memory.resize(count, 0.0);
    memory
}
