//! Factors on the variances of an epoch's codes, for unusual noise and for outliers.
//!
//! The noise measured over a whole log is too small for a minute under trees or next to a wall, where
//! reflected signals are metres late. The codes of one epoch show this: the robust scale of their residuals
//! about the epoch's position by codes reduces the weight of all codes, and single outliers are reduced
//! further, by Huber's estimator (Huber 1964, "Robust estimation of a location parameter"; Yang, He and Xu
//! 2001, "Adaptively robust filtering for kinematic geodetic positioning", J. Geodesy 75).

use crate::linear::double_row::DoubleRow;
use crate::linear::outliers::median;
use crate::observations::signal::FREQUENCY_SLOTS;
use nalgebra::{Matrix3, Vector3};

/// Standardised residual from which Huber's weights fall: 95 % efficient on normal errors.
const HUBER: f64 = 1.345;
const ITERATIONS: usize = 5;
/// Weight of the noise measured over the log, in degrees of freedom of the epoch.
const PRIOR_FREEDOM: f64 = 6.0;
/// Least degrees of freedom from which an epoch's residuals are used.
const LEAST_FREEDOM: usize = 3;
/// 1.4826 median absolute deviations of normal errors are a standard deviation.
const SIGMA_PER_MAD: f64 = 1.482_6;

/// Factor on each code's variance at this epoch, by common satellite and slot; never below one.
pub(crate) type Inflation = Vec<[f64; FREQUENCY_SLOTS]>;

/// One satellite's code, relative to its block's reference.
struct Member {
    common: usize,
    slot: usize,
    block: usize,
    difference_m: f64,
    design: Vector3<f64>,
    sigma_m: f64,
    weight: f64,
}

/// Inflation of the codes among `rows`, which are formed at a position near the rover.
pub(crate) fn inflation(rows: &[DoubleRow], satellites: usize) -> Inflation {
    let mut inflation = vec![[1.0; FREQUENCY_SLOTS]; satellites];
    let mut members = members(rows);
    let blocks = members.chunk_by(|a, b| a.block == b.block).count();
    let Some(freedom) = members.len().checked_sub(3 + blocks) else {
        return inflation;
    };
    if freedom < LEAST_FREEDOM {
        return inflation;
    }
    let mut variance_factor = 1.0;
    for _ in 0..ITERATIONS {
        let Some(residuals) = standardised_residuals(&members) else {
            return inflation;
        };
        let sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        // The residuals lack the part absorbed by the position and the offsets.
        let took = members.len() as f64 / freedom as f64;
        let own = (SIGMA_PER_MAD * median(sizes)).powi(2) * took;
        let freedom = freedom as f64;
        variance_factor = (own * freedom + PRIOR_FREEDOM) / (freedom + PRIOR_FREEDOM);
        variance_factor = variance_factor.max(1.0);
        let scale = variance_factor.sqrt();
        let mut changed = false;
        for (member, residual) in members.iter_mut().zip(residuals) {
            let weight = (HUBER * scale / residual.abs()).min(1.0);
            changed |= weight != member.weight;
            member.weight = weight;
        }
        // Equal weights give equal residuals.
        if !changed {
            break;
        }
    }
    for member in members {
        inflation[member.common][member.slot] = variance_factor / member.weight;
    }
    inflation
}

fn members(rows: &[DoubleRow]) -> Vec<Member> {
    let codes: Vec<&DoubleRow> = rows.iter().filter(|r| r.is_code).collect();
    let mut members = Vec::with_capacity(codes.len() + 8);
    for block in codes.chunk_by(|a, b| a.block == b.block) {
        let first = block[0];
        members.push(Member {
            common: first.reference,
            slot: first.slot,
            block: first.block,
            difference_m: 0.0,
            design: Vector3::zeros(),
            sigma_m: first.variance_reference_m2.sqrt(),
            weight: 1.0,
        });
        members.extend(block.iter().map(|r| Member {
            common: r.other,
            slot: r.slot,
            block: r.block,
            difference_m: -r.residual_m,
            design: -Vector3::from(r.position),
            sigma_m: r.variance_other_m2.sqrt(),
            weight: 1.0,
        }));
    }
    members
}

/// Residuals over standard deviations about the weighted best position and an offset per block;
/// `None` where the geometry is singular.
fn standardised_residuals(members: &[Member]) -> Option<Vec<f64>> {
    let blocks = || members.chunk_by(|a, b| a.block == b.block);
    let weight = |m: &Member| m.weight / (m.sigma_m * m.sigma_m);
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    let mut means = Vec::new();
    for block in blocks() {
        let total: f64 = block.iter().map(weight).sum();
        let design: Vector3<f64> = block.iter().map(|m| m.design * weight(m)).sum();
        let difference_m: f64 = block.iter().map(|m| m.difference_m * weight(m)).sum();
        let (design, difference_m) = (design / total, difference_m / total);
        for m in block {
            let row = m.design - design;
            normal += row * row.transpose() * weight(m);
            right += row * ((m.difference_m - difference_m) * weight(m));
        }
        means.push((design, difference_m));
    }
    let step = normal.cholesky()?.solve(&right);
    let mut residuals = Vec::with_capacity(members.len());
    for (block, (design, difference_m)) in blocks().zip(means) {
        residuals.extend(block.iter().map(|m| {
            let residual_m = m.difference_m - difference_m - (m.design - design).dot(&step);
            residual_m / m.sigma_m
        }));
    }
    Some(residuals)
}
