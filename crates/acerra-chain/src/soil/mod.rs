//! Permittivity of the ground by the echoes of buried points.
//!
//! The permittivity ε relates two measures of an echo from below the surface: the delay below the surface
//! straight under the antenna, τ = Σ n t over the layers (as one-way optical length), and the curvature of
//! the hyperbola, which is that of a point at the distance h + q from an antenna at height h, with q = Σ t/n.
//! Below one soil q = τ/ε. Delays are counted from the echo of the surface itself, so that an error of the
//! zero of fast time and the length of the pulse fall out (`zero`); the curvature is that at which the traces
//! of a point add up to the greatest power ([`echo`]), with a deviation by the clutter of the same image. A
//! buried object is no point: the echo comes from the object's near side and has the curvature of the
//! object's centre, so that the radius enters the comparison, with its deviation ([`posterior`]).

pub mod echo;
pub(crate) mod evidence;
pub(crate) mod leg;
mod phases;
pub(crate) mod points;
pub mod posterior;
mod search;
pub(crate) mod spacing;
mod stretch;
pub(crate) mod zero;
