//! The filter's state: position, optional velocity and acceleration, single-difference phase biases, and the
//! history of each satellite's phase.

use crate::linear::dense::{dot, dot_pair, factorise, solve_lower, solve_lower_rows};
use crate::linear::double_row::DoubleRow;
use crate::linear::sparse_row::SparseRow;
use crate::linear::update_room::{Room, transpose, zeros_in};
use crate::measurements::constellation::Constellation;
use crate::observations::signal::{FREQUENCY_SLOTS, SignalCode};
use crate::options::{GlonassAmbiguity, PositioningMode, PpkOptions};
use acerra_geo::time::GpsTime;

/// Standard deviation of the GLONASS inter-channel bias between receivers of unknown makes
/// (m per channel): Wanninger (2012) found up to 0.05.
const CHANNEL_SLOPE_SIGMA_M: f64 = 0.025;

/// History of one satellite's phase on one frequency.
#[derive(Debug, Clone, Default)]
pub(crate) struct Track {
    /// Epochs since the phase was last used.
    pub outage: u32,
    /// Epochs used since the last reset (RTKLIB), or since eligibility (demo5).
    pub lock: i32,
    /// This epoch's flags: bit 0 slip, bit 1 half cycle.
    pub flags: u8,
    /// Whether neither receiver has an unresolved half cycle at this epoch.
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
    /// Whether the phase was part of an accepted phase difference at this epoch.
    pub valid: bool,
    /// Whether the phase was part of this epoch's ambiguity resolution.
    pub in_fix: bool,
    /// Held integer, relative to the integers of the group.
    pub held: Option<f64>,
    /// Number of codes used since the bias (or, where the position outlasts biases, the position) was last
    /// initialised; noisier codes count less.
    pub codes_used: f64,
    /// Number of the present bias, which changes at every slip.
    pub arc: u32,
    /// Number of slips so far, flagged or not, whether the bias was kept or not.
    pub slips: u32,
    /// Time at which the present bias began.
    pub began: Option<GpsTime>,
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
    /// Whether the position by codes outlasts the biases, so that its errors persist after a slip.
    codes_outlast_biases: bool,
    room: Room,
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
            codes_outlast_biases: self.codes_outlast_biases,
            room: Default::default(),
        }
    }

    /// As `clone`, in the present memory.
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
            codes_outlast_biases,
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
        self.codes_outlast_biases = *codes_outlast_biases;
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
            codes_outlast_biases: options.mode == PositioningMode::Static,
            room: Default::default(),
        };
        if let Some(index) = state.channel_slope_index() {
            state.initialise(index, 0.0, CHANNEL_SLOPE_SIGMA_M.powi(2));
        }
        state
    }

    /// A copy, in spare memory where given.
    pub(crate) fn copied_into(&self, memory: Option<Self>) -> Self {
        match memory {
            Some(mut copy) => {
                copy.clone_from(self);
                copy
            }
            None => self.clone(),
        }
    }

    /// Index of the GLONASS inter-channel bias (m per channel), where it is estimated.
    pub(crate) fn channel_slope_index(&self) -> Option<usize> {
        (self.leading_states > self.position_states).then_some(self.position_states)
    }

    /// GLONASS inter-channel bias (m per channel) and its standard deviation; 0 where the bias is not
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

    /// Restarts a phase bias (cycles).
    pub(crate) fn initialise_bias(&mut self, satellite: usize, slot: usize, cycles: f64) {
        let index = self.bias_index(satellite, slot);
        self.initialise(index, cycles, self.initial_bias_variance);
        let codes_outlast_biases = self.codes_outlast_biases;
        let track = self.track_mut(satellite, slot);
        if !codes_outlast_biases {
            track.codes_used = 0.0;
        }
        track.arc += 1;
        track.held = None;
    }

    /// Sets a state with the variance `variance`, uncorrelated with all others.
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
        let [x, y, z] = row.position;
        let mut equation = SparseRow::new(&[(0, x), (1, y), (2, z)], row.residual_m);
        if !row.is_code {
            let [reference, other] = satellites.map(|of| self.bias_index(of, row.slot));
            equation.push(reference, row.wavelengths_m[0]);
            equation.push(other, -row.wavelengths_m[1]);
            if let (Some(index), true) = (self.channel_slope_index(), row.channels_apart != 0.0) {
                equation.push(index, row.channels_apart);
            }
        }
        equation
    }

    /// A matrix of zeros for the noise of an [update](Self::update), in memory of a past one.
    pub(crate) fn blank(&mut self, size: usize) -> Vec<f64> {
        zeros_in(std::mem::take(&mut self.room.noise), size * size)
    }

    /// As [`blank`](Self::blank), with `variance` on the diagonal.
    pub(crate) fn white_noise(&mut self, size: usize, variance: f64) -> Vec<f64> {
        let mut noise = self.blank(size);
        noise
            .iter_mut()
            .step_by(size + 1)
            .for_each(|r| *r = variance);
        noise
    }

    /// Kalman measurement update with a noise covariance, of which the lower triangle is read (by
    /// columns).
    ///
    /// Returns false, leaving the state as it was, when the innovation covariance is not
    /// positive definite.
    pub(crate) fn update(&mut self, rows: &[SparseRow], noise: Vec<f64>) -> bool {
        let (n, m) = (self.x.len(), rows.len());
        let mut room = std::mem::take(&mut self.room);
        room.note_active(&self.exists);
        room.gather(&self.p, n, rows);
        let count = room.active.len();
        room.pht = zeros_in(room.pht, count * m);
        for (out, row) in (room.pht.chunks_exact_mut(count.max(1))).zip(&room.placed) {
            for &(place, coefficient) in row.coefficients() {
                let source = &room.covariance[place * count..(place + 1) * count];
                for (o, value) in out.iter_mut().zip(source) {
                    *o += coefficient * value;
                }
            }
        }
        let mut factor = noise;
        for (j, column) in room.pht.chunks_exact(count.max(1)).enumerate() {
            let below = factor[j * m + j..(j + 1) * m].iter_mut();
            for (element, row) in below.zip(&room.placed[j..]) {
                let products = row.coefficients().iter();
                *element += products.map(|&(place, c)| c * column[place]).sum::<f64>();
            }
        }
        let regular = factorise(&mut factor, m);
        if regular {
            solve_lower_rows(&factor, &mut room.pht, count);
            transpose(&room.pht, count, &mut room.whitened);
            room.residuals.clear();
            room.residuals.extend(rows.iter().map(|r| r.residual));
            solve_lower(&factor, &mut room.residuals);
            self.apply(&room, m);
        }
        room.noise = factor;
        self.room = room;
        regular
    }

    /// Moves the state by the whitened residuals, and reduces its covariance accordingly.
    fn apply(&mut self, room: &Room, m: usize) {
        let n = self.x.len();
        let whitened = |i: usize| &room.whitened[i * m..(i + 1) * m];
        for (i, &a) in room.active.iter().enumerate() {
            let own = whitened(i);
            self.x[a] += dot(own, &room.residuals);
            let mut reduce = |b: usize, reduction: f64| {
                self.p[a * n + b] -= reduction;
                if a != b {
                    self.p[b * n + a] -= reduction;
                }
            };
            let mut k = 0;
            while k < i {
                let both = dot_pair(own, whitened(k), whitened(k + 1));
                reduce(room.active[k], both[0]);
                reduce(room.active[k + 1], both[1]);
                k += 2;
            }
            if k == i {
                reduce(a, dot(own, own));
            }
        }
    }
}
