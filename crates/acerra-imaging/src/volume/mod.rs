//! Volumes: horizontal slices imaged or modelled one after another, in the memory of one slice.

mod forward;
mod imaging;

pub use forward::ForwardVolume;
pub use imaging::{VolumeRun, image_volume, image_volume_planned_once};
