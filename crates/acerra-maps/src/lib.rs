//! Files for map programs: rasters with their place on the Earth, overlays and points.
//!
//! ```text
//! EnuFrame + LocalGrid ──Placement::fit──► Placement ─┐
//! MapCrs (UTM, or any EPSG code)  ────────────────────┤
//! Raster (levels, powers or complex amplitudes) ──────┴─write_geotiff──► cloud-optimised GeoTIFF
//! Overlay (PNG, corners, track, points) ──write_kmz──► KMZ for Google Earth
//! points ──FeatureCollection──► GeoJSON
//! ```
//!
//! - [`crs`]: coordinate reference systems by EPSG code; a datum whose relation to WGS84 is not known
//!   is refused.
//! - [`placement`]: map coordinates of the pixels of a local east-north grid.
//! - [`geotiff`]: GeoTIFF with tiles and overviews laid out for reading in parts.
//! - [`world_file`]: the place of a picture in a frame without a place on the Earth.
//! - [`kmz`], [`geojson`]: overlays and points.
//!
//! An image of 400 × 300 pixels of 5 cm in its UTM zone:
//!
//! ```
//! use acerra_geo::geodesy::{EnuFrame, Geodetic};
//! use acerra_maps::crs::MapCrs;
//! use acerra_maps::geotiff::{Description, write_geotiff};
//! use acerra_maps::placement::{LocalGrid, Placement};
//! use acerra_maps::raster::Raster;
//!
//! let frame = EnuFrame::new(Geodetic::from_degrees(40.9596, 14.3696, 75.0));
//! let grid = LocalGrid { x0_m: 0.0, y0_m: -7.5, z_m: 0.0, pixel_m: 0.05, nx: 400, ny: 300 };
//! let crs = MapCrs::utm_about(frame.origin());
//! assert_eq!(crs.epsg(), 32633);
//!
//! let placement = Placement::fit(&frame, &grid, &crs)?;
//! let power = vec![1.0_f32; 400 * 300];
//! let raster = Raster::power(&power, grid.nx, grid.ny);
//! let mut file = std::io::Cursor::new(Vec::new());
//! write_geotiff(&mut file, &raster, &placement, Some(&crs), &Description::default())?;
//! assert!(file.get_ref().starts_with(b"II*\0"));
//! # Ok::<(), acerra_maps::MapError>(())
//! ```

mod cog;
pub mod crs;
mod error;
pub mod geojson;
pub mod geotiff;
pub mod kmz;
mod overview;
pub mod placement;
pub mod qgis_style;
pub mod raster;
mod tags;
pub mod world_file;

pub use error::MapError;
