//! Instruction sets.

use crate::error::ImagingError;
use serde::{Serialize, Serializer};
use std::fmt;

/// An instruction set for which the kernels are compiled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SimdLevel {
    /// Eight-lane arrays that the compiler turns into the instructions of every processor of the target (SSE2
    /// on x86-64, NEON on 64-bit Arm).
    Portable,
    /// AVX2 and FMA, 8 lanes.
    Avx2,
    /// AVX-512 F, 16 lanes.
    Avx512,
}

impl SimdLevel {
    /// The best level of this processor.
    #[must_use]
    pub fn detect() -> Self {
        *Self::available().last().unwrap_or(&Self::Portable)
    }

    /// All levels of this processor, slowest first.
    #[must_use]
    pub fn available() -> &'static [Self] {
        const ALL: [SimdLevel; 3] = [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512];
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if avx2 && is_x86_feature_detected!("avx512f") {
                return &ALL;
            }
            if avx2 {
                return &ALL[..2];
            }
        }
        &ALL[..1]
    }

    /// This level, if the processor has it.
    ///
    /// # Errors
    /// [`ImagingError::NoSuchLevel`] where the processor lacks the level.
    pub fn checked(self) -> Result<Self, ImagingError> {
        if Self::available().contains(&self) {
            Ok(self)
        } else {
            Err(ImagingError::NoSuchLevel { level: self.name() })
        }
    }

    /// Short name, as printed in explanations.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "AVX2+FMA",
            Self::Avx512 => "AVX-512",
        }
    }

    /// Numbers in one vector.
    #[must_use]
    pub fn lanes(self) -> usize {
        match self {
            Self::Portable | Self::Avx2 => 8,
            Self::Avx512 => 16,
        }
    }
}

impl Serialize for SimdLevel {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_levels_are_errors() {
        for level in [SimdLevel::Portable, SimdLevel::Avx2, SimdLevel::Avx512] {
            assert_eq!(
                level.checked().is_ok(),
                SimdLevel::available().contains(&level)
            );
        }
        assert!(SimdLevel::Portable.checked().is_ok());
        assert!(SimdLevel::detect().checked().is_ok());
    }
}
