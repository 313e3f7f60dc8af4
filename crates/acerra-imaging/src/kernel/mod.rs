//! SIMD kernels: the inner loops of the engines at every instruction set.
//!
//! A kernel is written once over [`lanes::Lanes`]. The token of a level exists only where the
//! processor has its instructions, and [`dispatch`] compiles the kernel for each level inside a
//! function that enables them. This module and its children are the only place of the crate where
//! `unsafe` is allowed.
#![allow(unsafe_code)]

pub(crate) mod aligned;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub(crate) mod cosine_power;
pub(crate) mod delay_sums;
pub(crate) mod direct;
pub(crate) mod dispatch;
#[cfg(target_arch = "x86_64")]
mod instructions;
pub(crate) mod lanes;
pub(crate) mod level;
pub(crate) mod level_ways;
pub(crate) mod merge;
mod peak;
pub(crate) mod phase;
pub(crate) mod phasor;
pub(crate) mod point_spread;
mod portable;
pub(crate) mod profile;
pub(crate) mod split;
pub(crate) mod spread;
pub(crate) mod spread_expansion;
pub(crate) mod spread_groups;
pub(crate) mod spread_squares;
pub(crate) mod tabulated;
mod two_ways;
