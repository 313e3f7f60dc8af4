//! Integer ambiguities: search, acceptance, and the evidence of phases for one set of integers.

pub(crate) mod attempt;
pub(crate) mod evidence;
pub(crate) mod fixed_integers;
pub(crate) mod group;
pub(crate) mod lambda;
