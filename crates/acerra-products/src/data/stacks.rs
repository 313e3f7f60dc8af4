//! Volumes and looks of a run: from their NPZ files, image by image.

use std::fs::File;
use std::io::{BufReader, Seek, Write};
use std::path::{Path, PathBuf};

use acerra_cubes::{
    CubeError, Dataset, Hdf5File, Hdf5Stack, StackShape, Values, Variable, ZarrGroup,
};
use acerra_npz::{NpyError, NpzReader};
use anyhow::{Context, ensure};
use num_complex::Complex32;

/// The volume and the looks in a run's directory, where they are there.
pub(super) struct Stacks {
    volume: Option<Stack>,
    looks: Option<Stack>,
}

/// A file of images.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    path: PathBuf,
    array: &'static str,
}

impl Stacks {
    /// The stacks in `folder`.
    pub fn of(folder: &Path) -> Self {
        let stack = |array: &'static str| {
            let path = folder.join(format!("{array}.npz"));
            path.is_file().then(|| Stack::new(&path, array))
        };
        Self {
            volume: stack("volume"),
            looks: stack("looks"),
        }
    }

    /// The volume, if any.
    pub fn volume(&self) -> Option<&Stack> {
        self.volume.as_ref()
    }

    /// Adds the dimensions and coordinates of the stacks to the dataset of their run.
    pub fn describe(&self, data: &mut Dataset<'_>) -> anyhow::Result<()> {
        if let Some(volume) = &self.volume {
            let z_m = volume.heights_m()?;
            data.dimension("z", z_m.len());
            let z = Variable::new("z", &["z"], z_m.into());
            let z = z
                .with("long_name", "up of the volume's slices")
                .with("units", "m");
            data.variable(z.with("axis", "Z").with("positive", "up"));
        }
        Ok(())
    }

    /// Writes the stacks as arrays of the group.
    pub fn write_zarr(&self, group: &mut ZarrGroup) -> anyhow::Result<()> {
        for (stack, variable) in self.variables() {
            let mut array = group.stack(&variable, stack.shape()?)?;
            stack.each(|image| array.slice(image))?;
            array.finish()?;
        }
        Ok(())
    }

    /// Writes the stacks as arrays of the file.
    pub fn write_hdf5(&self, file: &mut Hdf5File<impl Write + Seek>) -> anyhow::Result<()> {
        for (stack, variable) in self.variables() {
            let mut array = Hdf5Stack::begin(file, &variable, stack.shape()?)?;
            stack.each(|image| array.slice(image))?;
            array.finish()?;
        }
        Ok(())
    }

    /// The stacks of the run, with names and meanings of their arrays.
    fn variables(&self) -> impl Iterator<Item = (&Stack, Variable<'static>)> {
        let kinds = [
            (
                &self.volume,
                ["z", "y", "x"],
                "complex reflectivity of the volume",
            ),
            (
                &self.looks,
                ["look", "y", "x"],
                "complex reflectivity by parts of the track",
            ),
        ];
        kinds
            .into_iter()
            .filter_map(|(stack, dimensions, meaning)| {
                let stack = stack.as_ref()?;
                let values = Values::from(Vec::<Complex32>::new());
                let variable = Variable::new(stack.array, &dimensions, values);
                let variable = variable.with("long_name", meaning).with("units", "1");
                Some((stack, variable))
            })
    }
}

impl Stack {
    /// The images of an array in a file.
    pub fn new(path: &Path, array: &'static str) -> Self {
        Self {
            path: path.to_owned(),
            array,
        }
    }

    pub fn open(&self) -> anyhow::Result<NpzReader<BufReader<File>>> {
        let file = File::open(&self.path).with_context(|| self.name())?;
        NpzReader::new(BufReader::new(file)).with_context(|| self.name())
    }

    pub fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Images, rows and columns.
    pub fn shape(&self) -> anyhow::Result<StackShape> {
        let shape = self
            .open()?
            .shape(self.array)
            .with_context(|| self.name())?;
        let [images, rows, columns] = shape[..] else {
            anyhow::bail!(
                "{}: {}: expected three dimensions, found {}",
                self.name(),
                self.array,
                shape.len()
            );
        };
        let as_length = |n: u64| usize::try_from(n).with_context(|| self.name());
        Ok(StackShape {
            images: as_length(images)?,
            rows: as_length(rows)?,
            columns: as_length(columns)?,
        })
    }

    /// Heights of the slices (m).
    pub fn heights_m(&self) -> anyhow::Result<Vec<f64>> {
        self.coordinates_m("z_m", self.shape()?.images)
    }

    /// Coordinates along an axis (m), `count` of them.
    pub fn coordinates_m(&self, name: &'static str, count: usize) -> anyhow::Result<Vec<f64>> {
        let (shape, values) = self
            .open()?
            .values(name, count.saturating_add(1))
            .with_context(|| self.name())?;
        ensure!(
            shape == [count as u64],
            "{}: {name}: expected {count} coordinates, found shape {shape:?}",
            self.name()
        );
        Ok(values.into_iter().map(|(v, _)| v).collect())
    }

    /// Hands the images to `take`, one after the other.
    pub fn each(
        &self,
        mut take: impl FnMut(&[Complex32]) -> Result<(), CubeError>,
    ) -> anyhow::Result<()> {
        let StackShape { rows, columns, .. } = self.shape()?;
        let length = rows.saturating_mul(columns);
        let mut image = Vec::new();
        let mut taken = Ok(());
        let read = self
            .open()?
            .with(self.array, |header, mut reader| -> Result<(), NpyError> {
                header.read_values(&mut reader, usize::MAX, |re, im| {
                    image.push(Complex32::new(re as f32, im as f32));
                    if image.len() == length {
                        if taken.is_ok() {
                            taken = take(&image);
                        }
                        image.clear();
                    }
                })
            });
        read.with_context(|| self.name())?;
        Ok(taken?)
    }
}
