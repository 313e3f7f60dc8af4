//! The server: its address, access rules, and answers.

mod answer;
mod assets;
mod basemap;
mod connections;
mod cursor;
mod doorway;
mod guard;
mod interactive;
mod live;
mod live_message;
mod live_socket;
mod map_tiles;
mod products;
mod state;
mod volume;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::Router;
use axum::routing::get;

use crate::error::ViewError;
use crate::run::Run;
use basemap::Basemap;
use doorway::Doorway;
use guard::Guard;
use state::Shared;

pub use live::{FinalView, LiveServer};

/// Data to serve, and address.
#[derive(Clone, Debug, Default)]
pub struct ServerOptions {
    /// The directories of runs.
    pub directories: Vec<PathBuf>,
    /// The port; any free one by default.
    pub port: u16,
    /// Map tiles as the user gives them: an address with `{z}`, `{x}` and `{y}`, or a directory.
    pub basemap: Option<String>,
}

/// A server that listens and does not answer yet.
#[derive(Debug)]
pub struct Server {
    doorway: Doorway,
    address: String,
    router: Router,
}

impl Server {
    /// Reads the runs and takes an address on the loopback interface.
    ///
    /// # Errors
    /// A directory that holds no run, an address that cannot be had.
    pub fn open(options: &ServerOptions) -> Result<Self, ViewError> {
        if options.directories.is_empty() {
            return Err(ViewError::NoRun);
        }
        let basemap = options.basemap.as_deref().map(Basemap::find).transpose()?;
        let runs = options.directories.iter().map(|folder| Run::open(folder));
        let runs = runs.collect::<Result<Vec<Run>, ViewError>>()?;
        let doorway = Doorway::open(options.port)?;
        let guard = Guard::new(doorway.port, basemap.as_ref());
        let shared = Arc::new(Shared::new(runs, basemap));
        let router = guard.around(runs_at(&format!("/{}", doorway.token), shared));
        Ok(Self {
            address: doorway.address(),
            doorway,
            router,
        })
    }

    /// The address of the page, with the token that gives access.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Answers requests until `stop` returns true.
    ///
    /// # Errors
    /// A failure of the system.
    pub fn run(self, stop: impl Fn() -> bool + Send + 'static) -> Result<(), ViewError> {
        self.doorway.serve(self.router, stop)
    }
}

/// The pages of runs, under a path.
fn runs_at(path: &str, shared: Arc<Shared>) -> Router {
    let pages = Router::new()
        .merge(assets::routes())
        .merge(products::palettes())
        .merge(products::routes())
        .merge(map_tiles::routes())
        .merge(cursor::routes())
        .merge(volume::routes())
        .merge(interactive::routes())
        .with_state(shared);
    Router::new()
        .nest(path, pages)
        .route(&format!("{path}/"), get(assets::page))
}

/// The pages of the run in a directory, under a path.
fn run_at(path: &str, directory: &Path) -> Result<Router, ViewError> {
    let run = Run::open(directory)?;
    Ok(runs_at(path, Arc::new(Shared::new(vec![run], None))))
}
