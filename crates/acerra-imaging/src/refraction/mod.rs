//! Rays from an antenna into the ground: travel times and amplitudes.
//!
//! A ray obeys Fermat's principle: its optical length Σ n ℓ is stationary. Below level ground, of one soil
//! or of level layers, Snell's law leaves one unknown, the slope of the ray in air ([`crossing`]); below
//! uneven ground the crossing point is searched on the surface ([`relief`]). Amplitudes hold Fresnel's
//! transmission and the spreading of the refracted tube of rays; absorption and dispersion follow from the
//! lengths within each soil and its complex refractive index ([`soil`]).
//!
//! ```
//! use acerra_imaging::refraction::{Ground, Layer, Soil, Surface};
//! let sand = Soil { relative_permittivity: 4.0, conductivity_s_m: 0.0 };
//! let ground = Ground::new(Surface::Level { z_m: 0.0 }, &[Layer::below_all(sand)], 1e9)?;
//! // Straight below the antenna: 1 m of air and 0.2 m of soil with a refractive index of 2.
//! let ray = ground.ray([0.0, 0.0, 1.0], [0.0, 0.0, -0.2]);
//! assert!((ray.optical_m - 1.4).abs() < 1e-12);
//! # Ok::<(), acerra_imaging::ImagingError>(())
//! ```

pub mod crossing;
pub mod fresnel;
pub mod ground;
pub mod ray;
pub mod relief;
pub mod soil;

pub use ground::{Ground, Layer, Surface};
pub use ray::{MAX_LAYERS, Ray};
pub use relief::Relief;
pub use soil::Soil;
