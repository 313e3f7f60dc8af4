//! The filter's state: position, optional velocity and acceleration, single-difference phase
//! biases, and what is remembered about each satellite's phase.

use super::constellation::Constellation;
use super::double_row::DoubleRow;
use crate::options::{GlonassAmbiguity, PpkOptions};
use crate::signal::{FREQUENCY_SLOTS, SignalCode};
use acerra_geo::time::GpsTime;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Standard deviation of the GLONASS inter-channel bias between receivers of unknown makes
/// (m per channel): Wanninger (2012) found up to 0.05.
const CHANNEL_SLOPE_SIGMA_M: f64 = 0.025;

/// What is remembered about one satellite's phase on one frequency.
#[derive(Debug, Clone, Default)]
pub(crate) struct Track {
    /// Epochs since the phase was last used.
    pub outage: u32,
    /// Epochs used since the last reset (RTKLIB), or since eligibility (demo5).
    pub lock: i32,
    /// This epoch's flags: bit 0 slip, bit 1 half cycle.
    pub flags: u8,
    /// Neither receiver has an unresolved half cycle now.
    pub half_cycle_known: bool,
    /// Last loss-of-lock bits of rover and base.
    pub stored_lli: [u8; 2],
    /// Slips counted up to the last observation of rover and base.
    pub last_slip_count: [Option<u32>; 2],
    /// Tag of the last phase of rover and base.
    pub phase_tag: [Option<GpsTime>; 2],
    /// Last phase of rover and base (cycles), for the Doppler test.
    pub last_phase_cycles: [f64; 2],
    /// Signal tracked last by rover and base.
    pub last_signal: [Option<SignalCode>; 2],
    /// Geometry-free combination against the first slot at the last epoch (m).
    pub geometry_free_m: Option<f64>,
    /// Took part in an accepted phase difference this epoch.
    pub valid: bool,
    /// Took part in this epoch's ambiguity resolution.
    pub in_fix: bool,
    /// Integer found with certainty, relative to those of its group.
    pub held: Option<f64>,
    /// Codes used since the bias was last initialised, those noisier than usual counting less.
    pub codes_used: f64,
    /// Number of the present bias: another after every slip.
    pub arc: u32,
    /// Innovations rejected since the last reset.
    pub rejections: u32,
    /// Inter-channel bias learnt during the hold (cycles).
    pub channel_bias_cycles: f64,
}

impl Track {
    pub(crate) const fn slipped(&self) -> bool {
        self.flags & 1 != 0
    }

    pub(crate) const fn half_cycle_flag(&self) -> bool {
        self.flags & 2 != 0
    }
}

/// A measurement equation with few non-zero coefficients.
#[derive(Debug, Clone)]
pub(crate) struct SparseRow {
    pub coefficients: Vec<(usize, f64)>,
    pub residual: f64,
}

/// State vector, covariance, and the tracks.
#[derive(Debug)]
pub(crate) struct FilterState {
    /// Position states: 3, or 9 with velocity and acceleration.
    pub position_states: usize,
    /// Position states and, where it is estimated, the GLONASS inter-channel bias.
    pub leading_states: usize,
    satellites: usize,
    pub x: Vec<f64>,
    /// Row-major covariance of all states.
    pub p: Vec<f64>,
    pub exists: Vec<bool>,
    pub tracks: Vec<Track>,
    initial_bias_variance: f64,
    /// Memory of the matrices of past updates.
    room: [Vec<f64>; 3],
}

impl Clone for FilterState {
    fn clone(&self) -> Self {
        Self {
            position_states: self.position_states,
            leading_states: self.leading_states,
            satellites: self.satellites,
            x: self.x.clone(),
            p: self.p.clone(),
            exists: self.exists.clone(),
            tracks: self.tracks.clone(),
            initial_bias_variance: self.initial_bias_variance,
            room: Default::default(),
        }
    }

    /// As `clone`, in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        let Self {
            position_states,
            leading_states,
            satellites,
            x,
            p,
            exists,
            tracks,
            initial_bias_variance,
            room: _,
        } = source;
        self.position_states = *position_states;
        self.leading_states = *leading_states;
        self.satellites = *satellites;
        self.x.clone_from(x);
        self.p.clone_from(p);
        self.exists.clone_from(exists);
        self.tracks.clone_from(tracks);
        self.initial_bias_variance = *initial_bias_variance;
    }
}

impl FilterState {
    pub(crate) fn new(constellation: &Constellation, options: &PpkOptions) -> Self {
        let position_states = if options.dynamics.is_some() { 9 } else { 3 };
        let satellites = constellation.len();
        let slots = options.frequencies.clamp(1, FREQUENCY_SLOTS);
        let estimates_slope = options.glonass_ambiguity == GlonassAmbiguity::Auto;
        let leading_states = position_states + usize::from(estimates_slope);
        let n = leading_states + slots * satellites;
        let mut state = Self {
            position_states,
            leading_states,
            satellites,
            x: vec![0.0; n],
            p: vec![0.0; n * n],
            exists: vec![false; n],
            tracks: vec![Track::default(); slots * satellites],
            initial_bias_variance: options.initial_bias_cycles * options.initial_bias_cycles,
            room: Default::default(),
        };
        if let Some(index) = state.channel_slope_index() {
            state.initialise(index, 0.0, CHANNEL_SLOPE_SIGMA_M.powi(2));
        }
        state
    }

    /// Index of the GLONASS inter-channel bias (m per channel), where it is estimated.
    pub(crate) fn channel_slope_index(&self) -> Option<usize> {
        (self.leading_states > self.position_states).then_some(self.position_states)
    }

    /// GLONASS inter-channel bias (m per channel) and its standard deviation; 0 where it is not
    /// estimated.
    pub(crate) fn channel_slope_m(&self) -> [f64; 2] {
        self.channel_slope_index().map_or([0.0; 2], |k| {
            [self.x[k], self.covariance(k, k).max(0.0).sqrt()]
        })
    }

    pub(crate) fn len(&self) -> usize {
        self.x.len()
    }

    pub(crate) fn bias_index(&self, satellite: usize, slot: usize) -> usize {
        self.leading_states + slot * self.satellites + satellite
    }

    /// The single-difference bias (cycles), if estimated.
    pub(crate) fn bias(&self, satellite: usize, slot: usize) -> Option<f64> {
        let index = self.bias_index(satellite, slot);
        self.exists[index].then(|| self.x[index])
    }

    pub(crate) fn track(&self, satellite: usize, slot: usize) -> &Track {
        &self.tracks[slot * self.satellites + satellite]
    }

    pub(crate) fn track_mut(&mut self, satellite: usize, slot: usize) -> &mut Track {
        &mut self.tracks[slot * self.satellites + satellite]
    }

    /// Whether the bias was initialised and not updated since.
    pub(crate) fn has_initial_variance(&self, satellite: usize, slot: usize) -> bool {
        let index = self.bias_index(satellite, slot);
        self.exists[index] && self.covariance(index, index) == self.initial_bias_variance
    }

    pub(crate) fn covariance(&self, i: usize, j: usize) -> f64 {
        self.p[i * self.x.len() + j]
    }

    pub(crate) fn covariance_mut(&mut self, i: usize, j: usize) -> &mut f64 {
        let n = self.x.len();
        &mut self.p[i * n + j]
    }

    /// Starts a phase bias (cycles) anew.
    pub(crate) fn initialise_bias(&mut self, satellite: usize, slot: usize, cycles: f64) {
        let index = self.bias_index(satellite, slot);
        self.initialise(index, cycles, self.initial_bias_variance);
        let track = self.track_mut(satellite, slot);
        track.codes_used = 0.0;
        track.arc += 1;
        track.held = None;
    }

    /// Sets a state with this variance, uncorrelated with all others.
    pub(crate) fn initialise(&mut self, index: usize, value: f64, variance: f64) {
        let n = self.x.len();
        self.x[index] = value;
        for k in 0..n {
            self.p[index * n + k] = 0.0;
            self.p[k * n + index] = 0.0;
        }
        self.p[index * n + index] = variance;
        self.exists[index] = true;
    }

    /// Forgets a state.
    pub(crate) fn remove(&mut self, index: usize) {
        self.initialise(index, 0.0, 0.0);
        self.exists[index] = false;
        if let Some(track) = index.checked_sub(self.leading_states) {
            self.tracks[track].held = None;
        }
    }

    pub(crate) fn position(&self) -> [f64; 3] {
        [self.x[0], self.x[1], self.x[2]]
    }

    /// Equation of a double difference.
    pub(crate) fn sparse(&self, row: &DoubleRow, satellites: [usize; 2]) -> SparseRow {
        let mut coefficients = Vec::with_capacity(5);
        coefficients.extend(row.position.iter().copied().enumerate());
        if !row.is_code {
            coefficients.push((
                self.bias_index(satellites[0], row.slot),
                row.wavelengths_m[0],
            ));
            coefficients.push((
                self.bias_index(satellites[1], row.slot),
                -row.wavelengths_m[1],
            ));
            if let (Some(index), true) = (self.channel_slope_index(), row.channels_apart != 0.0) {
                coefficients.push((index, row.channels_apart));
            }
        }
        SparseRow {
            coefficients,
            residual: row.residual_m,
        }
    }

    /// A matrix of zeros for the noise of an [update](Self::update), in memory of a past one.
    pub(crate) fn blank(&mut self, size: usize) -> DMatrix<f64> {
        zeros_in(&mut self.room[0], size, size)
    }

    /// Kalman measurement update with noise covariance `r` (m × m).
    ///
    /// Returns false, leaving the state as it was, when the innovation covariance is not
    /// positive definite.
    pub(crate) fn update(&mut self, rows: &[SparseRow], r: DMatrix<f64>) -> bool {
        let n = self.x.len();
        let active: Vec<usize> = (0..n).filter(|&i| self.exists[i]).collect();
        let m = rows.len();
        // One column per equation: (P Hᵀ) restricted to the active states.
        let mut pht = zeros_in(&mut self.room[1], active.len(), m);
        for (column, row) in rows.iter().enumerate() {
            let mut out = pht.column_mut(column);
            for &(index, coefficient) in &row.coefficients {
                let source = &self.p[index * n..(index + 1) * n];
                for (o, &a) in out.iter_mut().zip(&active) {
                    *o += coefficient * source[a];
                }
            }
        }
        let mut place = vec![usize::MAX; n];
        for (k, &a) in active.iter().enumerate() {
            place[a] = k;
        }
        let mut s = r;
        // The factorisation reads the lower triangle only.
        for j in 0..m {
            let column = pht.column(j);
            for (i, row) in rows.iter().enumerate().skip(j) {
                let products = row.coefficients.iter();
                s[(i, j)] += products
                    .map(|&(index, c)| c * column[place[index]])
                    .sum::<f64>();
            }
        }
        let Some(cholesky) = Cholesky::new(s) else {
            return false;
        };
        let residuals = DVector::from_iterator(m, rows.iter().map(|r| r.residual));
        let mut w = zeros_in(&mut self.room[2], m, active.len());
        pht.transpose_to(&mut w);
        cholesky.l_dirty().solve_lower_triangular_mut(&mut w);
        let mut whitened = residuals;
        cholesky.l_dirty().solve_lower_triangular_mut(&mut whitened);
        let dx = w.tr_mul(&whitened);
        for (i, &a) in active.iter().enumerate() {
            self.x[a] += dx[i];
            let own = w.column(i);
            for (j, &b) in active.iter().enumerate().take(i + 1) {
                let reduction = own.dot(&w.column(j));
                self.p[a * n + b] -= reduction;
                if i != j {
                    self.p[b * n + a] -= reduction;
                }
            }
        }
        self.room = [cholesky.unpack_dirty(), pht, w].map(|matrix| matrix.data.into());
        true
    }
}

/// A matrix of zeros in this memory.
fn zeros_in(memory: &mut Vec<f64>, rows: usize, columns: usize) -> DMatrix<f64> {
    let mut values = std::mem::take(memory);
    values.clear();
    values.resize(rows * columns, 0.0);
    DMatrix::from_vec(rows, columns, values)
}
