//! Vectors of single-precision numbers, and of a few in double precision.

/// Largest number of lanes of a level.
pub(crate) const MAX_LANES: usize = 16;

/// Numbers of a vector in double precision, at every level.
pub(crate) const DOUBLES: usize = 8;

/// Adding this to |t| < 2²² rounds t to a whole number, which then is in the low mantissa bits.
pub(crate) const ROUNDING: f32 = 12_582_912.0; // 1.5 · 2²³

/// A vector of `N` single-precision numbers. A value of the implementing type is proof that the
/// processor has the instructions.
pub(crate) trait Lanes: Copy {
    /// The vector.
    type V: Copy;
    /// A vector of [`DOUBLES`] numbers in double precision.
    type Doubles: Copy;
    /// Number of values, at most [`MAX_LANES`].
    const N: usize;

    fn splat(self, x: f32) -> Self::V;
    /// # Safety
    /// `N` numbers must be readable at `p`.
    unsafe fn load(self, p: *const f32) -> Self::V;
    /// # Safety
    /// `N` numbers must be writable at `p`.
    unsafe fn store(self, p: *mut f32, v: Self::V);
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    /// 1/a, to two units in the last place.
    #[inline(always)]
    fn reciprocal(self, a: Self::V) -> Self::V {
        self.div(self.splat(1.0), a)
    }
    /// 1/√a for normal numbers above zero, to two units in the last place.
    #[inline(always)]
    fn inverse_sqrt(self, a: Self::V) -> Self::V {
        self.div(self.splat(1.0), self.sqrt(a))
    }
    fn max(self, a: Self::V, b: Self::V) -> Self::V;
    fn abs(self, a: Self::V) -> Self::V;
    fn floor(self, a: Self::V) -> Self::V;
    /// a·b + c
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a·b
    fn neg_mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// True if a ≤ b in every lane (false where one is NaN).
    fn all_le(self, a: Self::V, b: Self::V) -> bool;
    /// Lane l becomes `window[bits(i[l]) mod N]`, i made by adding [`ROUNDING`].
    fn pick(self, window: Self::V, i: Self::V) -> Self::V;
    /// Lane l becomes entry bits(i[l]) mod 2N of the two windows one after another, i made by adding
    /// [`ROUNDING`].
    fn pick2(self, windows: [Self::V; 2], i: Self::V) -> Self::V;
    /// The whole numbers that adding [`ROUNDING`] left in `i`, plus `plus`, stored as integers.
    ///
    /// # Safety
    /// `N` integers must be writable at `p`.
    unsafe fn store_rounded(self, p: *mut i32, i: Self::V, plus: i32);
    /// Lane l becomes the number at `p` + the whole number in `i[l]`.
    ///
    /// # Safety
    /// All those must be readable.
    unsafe fn gather(self, p: *const f32, i: Self::V) -> Self::V;
    /// Four vectors: lane l of vector k becomes the number at `p` + step·i[l] + k, where i holds
    /// whole numbers made by adding [`ROUNDING`].
    ///
    /// # Safety
    /// All those must be readable.
    unsafe fn gather4(self, p: *const f32, i: Self::V, step: usize) -> [Self::V; 4];
    /// The transpose of [`Lanes::gather4`]: lane l of vector k is added to the number at
    /// `p` + step·i[l] + k, lane after lane, so that lanes may meet in one place.
    ///
    /// # Safety
    /// All those must be writable.
    unsafe fn scatter_add4(self, p: *mut f32, i: Self::V, step: usize, v: [Self::V; 4]);
    /// As above for eight numbers a place, lanes in any order: lane l of vector k is added to the number at
    /// `p` + 8·i[l] + k.
    ///
    /// # Safety
    /// All those must be writable.
    unsafe fn scatter_add8(self, p: *mut f32, i: Self::V, v: [Self::V; 8]);
    /// −v in the lanes where i, made by adding [`ROUNDING`], holds an odd whole number, and v elsewhere.
    fn negate_odd(self, v: Self::V, i: Self::V) -> Self::V;
    /// One number in every place of a vector in double precision.
    fn splat_f64(self, x: f64) -> Self::Doubles;
    fn load_f64(self, x: [f64; DOUBLES]) -> Self::Doubles;
    fn store_f64(self, v: Self::Doubles) -> [f64; DOUBLES];
    /// a·b + c
    fn mul_add_f64(self, a: Self::Doubles, b: Self::Doubles, c: Self::Doubles) -> Self::Doubles;
    /// c − a·b
    fn neg_mul_add_f64(self, a: Self::Doubles, b: Self::Doubles, c: Self::Doubles)
    -> Self::Doubles;
    /// Runs `f` where the compiler may use this level's instructions.
    fn vectorize<R>(self, f: impl FnOnce(Self) -> R) -> R;
}
