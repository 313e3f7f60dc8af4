//! Ways of echoes over level ground by rays that are tabulated over the straight distance.

use super::dispatch::dispatch;
use super::level::SimdLevel;
use super::profile::DELAYS;
use super::tabulated::Bins;

/// An antenna above level ground with its rays to a level plane: bins over the straight distance hold half the optical
/// length (m) and the weight of one way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AntennaRays<'a> {
    pub antenna_m: [f64; 3],
    pub bins: Bins<'a>,
}

/// Half of the optical length from the first antenna to a point and back to the second (m), and the product of both
/// weights, for points of the plane: `first_m` and those after it, `step_m` apart.
pub(crate) fn half_ways(
    level: SimdLevel,
    antennas: &[AntennaRays; 2],
    [first_m, step_m]: [[f64; 3]; 2],
) -> [[f64; DELAYS]; 2] {
    dispatch!(level, _s => sums(antennas, [first_m, step_m]))
}

#[inline(always)]
fn sums(antennas: &[AntennaRays; 2], [first_m, step_m]: [[f64; 3]; 2]) -> [[f64; DELAYS]; 2] {
    let mut half_m = [0.0; DELAYS];
    let mut weight = [1.0; DELAYS];
    for antenna in antennas {
        let from_m: [f64; 3] = std::array::from_fn(|axis| first_m[axis] - antenna.antenna_m[axis]);
        let mut ranges_m = [0.0; DELAYS];
        for (k, range) in ranges_m.iter_mut().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| from_m[axis] + k as f64 * step_m[axis]);
            *range = x * x + y * y + z * z;
        }
        for range in &mut ranges_m {
            *range = range.sqrt();
        }
        let found = antenna.bins.at(&ranges_m);
        for k in 0..DELAYS {
            half_m[k] += found.first[k];
            weight[k] *= found.second[k];
        }
    }
    [half_m, weight]
}
