//! Numbers that begin with a line of the cache.

/// An array that begins with a line of the cache: vectors that begin at a multiple of their length then
/// never cross one, which would cost a load about twice as much and a store several times.
#[repr(align(64))]
pub(crate) struct Aligned<const COUNT: usize>(pub [f32; COUNT]);
