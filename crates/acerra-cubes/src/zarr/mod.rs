//! Zarr version 3 in a directory: arrays in chunks, metadata of all of them in the group's.

mod chunks;
mod metadata;
mod stack;
mod tiled;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use crate::dataset::{Attribute, Dataset, StackShape, Variable, check_name};
use crate::error::CubeError;
use chunks::write_chunks;
use metadata::{ArrayMetadata, attributes_json, group_json};
pub use stack::StackWriter;
pub use tiled::TiledArray;

/// Name of the file that holds the metadata of a group or an array.
const METADATA: &str = "zarr.json";

/// Writes a dataset as a Zarr v3 group into the directory `folder`, which it makes.
///
/// # Errors
/// Names or lengths that do not fit, a directory that cannot be written.
pub fn write_zarr(folder: &Path, dataset: &Dataset<'_>) -> Result<(), CubeError> {
    let mut group = ZarrGroup::create(folder)?;
    group.dataset(dataset)?;
    group.finish(&dataset.attributes)
}

/// A group being written. The metadata of its arrays are included in the group's (consolidated), so that a
/// program needs no list of the directory.
#[derive(Debug)]
pub struct ZarrGroup {
    folder: PathBuf,
    arrays: Map<String, Value>,
}

impl ZarrGroup {
    /// Makes the directory of a group.
    ///
    /// # Errors
    /// A directory that cannot be made.
    pub fn create(folder: &Path) -> Result<Self, CubeError> {
        fs::create_dir_all(folder)?;
        Ok(Self {
            folder: folder.to_owned(),
            arrays: Map::new(),
        })
    }

    /// Writes every variable of a dataset.
    ///
    /// # Errors
    /// Names or lengths that do not fit, files that cannot be written.
    pub fn dataset(&mut self, dataset: &Dataset<'_>) -> Result<(), CubeError> {
        dataset.check()?;
        for variable in &dataset.variables {
            let shape = dataset.shape(variable)?;
            self.array(variable, &shape)?;
        }
        Ok(())
    }

    /// Begins an array of complex images, which are written one by one.
    ///
    /// # Errors
    /// A name that does not fit, files that cannot be written.
    pub fn stack(
        &mut self,
        variable: &Variable<'_>,
        shape: StackShape,
    ) -> Result<StackWriter, CubeError> {
        let metadata = ArrayMetadata::of(variable, &shape.lengths());
        let folder = self.begin(&variable.name, &metadata)?;
        Ok(StackWriter::new(
            &variable.name,
            folder,
            metadata.chunk,
            shape,
        ))
    }

    /// Begins a complex array that is cut along its first dimension into tiles of `per_tile`.
    ///
    /// # Errors
    /// A name that does not fit, files that cannot be written.
    pub fn tiled(
        &mut self,
        variable: &Variable<'_>,
        shape: &[usize],
        per_tile: usize,
    ) -> Result<TiledArray, CubeError> {
        let array = TiledArray::of(&self.folder, &variable.name, shape, per_tile);
        let metadata = ArrayMetadata::with_chunks(variable, shape, array.chunk(), None);
        self.begin(&variable.name, &metadata)?;
        Ok(array)
    }

    /// Writes the metadata of the group: the file is complete.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(self, attributes: &[(String, Attribute)]) -> Result<(), CubeError> {
        let text = group_json(attributes_json(attributes), self.arrays);
        Ok(fs::write(self.folder.join(METADATA), text)?)
    }

    fn array(&mut self, variable: &Variable<'_>, shape: &[usize]) -> Result<(), CubeError> {
        let metadata = ArrayMetadata::of(variable, shape);
        let folder = self.begin(&variable.name, &metadata)?;
        write_chunks(&folder, &variable.values, shape, &metadata.chunk)
    }

    /// Makes the directory of an array and writes its metadata.
    fn begin(&mut self, name: &str, metadata: &ArrayMetadata) -> Result<PathBuf, CubeError> {
        check_name(name)?;
        let folder = self.folder.join(name);
        fs::create_dir_all(&folder)?;
        let text = serde_json::to_string_pretty(&metadata.json).map_err(std::io::Error::from)?;
        fs::write(folder.join(METADATA), text + "\n")?;
        if self
            .arrays
            .insert(name.to_owned(), metadata.json.clone())
            .is_some()
        {
            return Err(CubeError::SameName {
                name: name.to_owned(),
            });
        }
        Ok(folder)
    }
}
