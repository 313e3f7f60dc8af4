//! Radar imaging by the adjoint of the scattering operator: reference, fast kernels, resolution, metrics.
