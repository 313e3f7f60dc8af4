//! Treatment of contradictions, and the products to write.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[checks] contradictions`: treatment of a run whose evidence contradicts its settings.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Contradictions {
    /// It fails, and writes no products.
    #[default]
    Refuse,
    /// It goes on; every contradiction becomes a warning.
    Warn,
}

/// `[products] formats`: files for other programs, in addition to those of every run.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProductFormat {
    /// `image-db.tif`: levels in dB below the maximum as a cloud-optimised GeoTIFF, with the style `image-db.qml` for QGIS.
    /// Pixels that no trace reaches and those below the floor of `image.png` have no data.
    Geotiff,
    /// `image-absolute-db.tif`: levels in dB of |σ̃|² itself, likewise, without a floor.
    GeotiffAbsolute,
    /// `image-power.tif`: linear powers, likewise.
    GeotiffPower,
    /// `image-complex.tif`: the complex image, likewise.
    GeotiffComplex,
    /// `image.kmz`: the image, the track and the targets for Google Earth.
    Kmz,
    /// `targets.geojson`: targets with their uncertainty; `flight.geojson`: the track, the outline of the image.
    Geojson,
    /// `data.zarr`: image, cleaned radargram, spectra, trajectory and targets as a Zarr v3 group, with
    /// named coordinates and units.
    Zarr,
    /// `data.h5`: the same as NetCDF-4 (HDF5), complex arrays as real and imaginary part.
    Hdf5,
    /// `image.vti`, `volume.vti`: the image and the volume for ParaView.
    Vtk,
    /// `spectra.cphd`: the cleaned spectra with their positions, as phase history data (CPHD) for other
    /// programs; left out where the positions have no place on the Earth.
    Cphd,
}
