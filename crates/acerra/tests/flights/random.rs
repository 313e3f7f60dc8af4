//! Numbers and smooth motions from a seed.

/// Numbers from a seed (SplitMix64).
pub struct Random(u64);

impl Random {
    /// The numbers of a seed; neighbouring seeds have nothing in common.
    pub fn of(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly distributed.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "53 bits are held exactly")]
        let share = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        low + share * (high - low)
    }

    /// Whether something of this probability happens.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// One of so many.
    pub fn one_of(&mut self, count: u64) -> u64 {
        self.next() % count
    }

    /// Normally distributed (Box and Muller).
    pub fn normal(&mut self, sigma: f64) -> f64 {
        let radius = (-2.0 * (1.0 - self.between(0.0, 1.0)).ln()).sqrt();
        sigma * radius * (std::f64::consts::TAU * self.between(0.0, 1.0)).cos()
    }
}

/// Sines of random phase: a smooth motion of a standard deviation.
pub struct Sway(Vec<[f64; 3]>);

/// Sines of each.
const SINES: usize = 8;

impl Sway {
    /// A motion whose periods lie between these (s).
    pub fn of(sigma: f64, period_s: [f64; 2], random: &mut Random) -> Self {
        let amplitude = sigma * (2.0 / SINES as f64).sqrt();
        let sine = |_| {
            let logs = period_s.map(f64::ln);
            let rate = std::f64::consts::TAU / random.between(logs[0], logs[1]).exp();
            [amplitude, rate, random.between(0.0, std::f64::consts::TAU)]
        };
        Self((0..SINES).map(sine).collect())
    }

    /// Its value at a time (s).
    pub fn at(&self, time_s: f64) -> f64 {
        self.0
            .iter()
            .map(|[a, w, p]| a * (w * time_s + p).sin())
            .sum()
    }
}
