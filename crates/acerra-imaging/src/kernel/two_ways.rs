//! Bistatic paths: the range is the mean of the ranges from the transmitter and from the receiver.

use super::lanes::Lanes;

/// Mean of both ranges.
#[inline(always)]
pub(super) fn mean<S: Lanes>(s: S, sent: S::V, received: S::V) -> S::V {
    s.mul(s.splat(0.5), s.add(sent, received))
}

/// Half of a + b, or of a − b where the `sign` of b is −1.
#[inline(always)]
pub(super) fn half_sum<S: Lanes>(s: S, sign: S::V, a: S::V, b: S::V) -> S::V {
    s.mul(s.splat(0.5), s.mul_add(sign, b, a))
}

/// A struct of vectors with the [`half_sum`] of every field of two, the last list being fields of pairs.
macro_rules! half_sums {
    (($s:expr, $sign:expr, $a:expr, $b:expr), [$($field:ident),+ $(,)?], [$($pair:ident),+]) => {
        Self {
            $($field: half_sum($s, $sign, $a.$field, $b.$field),)+
            $($pair: [
                half_sum($s, $sign, $a.$pair[0], $b.$pair[0]),
                half_sum($s, $sign, $a.$pair[1], $b.$pair[1]),
            ],)+
        }
    };
}
pub(super) use half_sums;

/// The lesser of both numbers in every lane.
#[inline(always)]
pub(super) fn lesser<S: Lanes>(s: S, a: S::V, b: S::V) -> S::V {
    let zero = s.splat(0.0);
    s.sub(zero, s.max(s.sub(zero, a), s.sub(zero, b)))
}

/// Ratio of the bistatic spreading to the spreading at the mean range: S²/(R_t R_r) for the ranges R_t and
/// R_r with mean S.
#[inline(always)]
pub(super) fn spreading<S: Lanes>(s: S, sent: S::V, received: S::V) -> S::V {
    let mean = mean(s, sent, received);
    s.div(s.mul(mean, mean), s.mul(sent, received))
}
