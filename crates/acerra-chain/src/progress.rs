//! Progress of a run, told to whoever shows it.

/// Hears how far a long step has come. Calls come from several threads.
pub trait Progress: Sync {
    /// A step of `total` units begins.
    fn start(&self, name: &str, total: u64);
    /// So many of them are done.
    fn at(&self, done: u64);
    /// The step is over.
    fn finish(&self);
}

/// Shows nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _: &str, _: u64) {}
    fn at(&self, _: u64) {}
    fn finish(&self) {}
}
