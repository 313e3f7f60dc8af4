//! The server: its address, who may ask, and what it answers.

mod answer;
mod assets;
mod basemap;
mod cursor;
mod guard;
mod interactive;
mod map_tiles;
mod products;
mod state;
mod volume;

use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::routing::get;
use rand::TryRngCore;
use rand::rngs::OsRng;

use crate::error::ViewError;
use crate::run::Run;
use basemap::Basemap;
use guard::Guard;
use state::Shared;

/// What is served, and where.
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
    listener: std::net::TcpListener,
    address: String,
    router: Router,
}

/// How often a server looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(100);

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
        let bind = |cause| ViewError::Bind {
            port: options.port,
            cause,
        };
        let listener =
            std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, options.port)).map_err(bind)?;
        listener.set_nonblocking(true).map_err(bind)?;
        let port = listener.local_addr().map_err(bind)?.port();
        let token = token()?;
        let guard = Guard::new(port, basemap.as_ref());
        let shared = Arc::new(Shared::new(runs, basemap));
        let pages = Router::new()
            .merge(assets::routes())
            .merge(products::routes())
            .merge(map_tiles::routes())
            .merge(cursor::routes())
            .merge(volume::routes())
            .merge(interactive::routes())
            .with_state(shared);
        let router = Router::new()
            .nest(&format!("/{token}"), pages)
            .route(&format!("/{token}/"), get(assets::page));
        let router = guard.around(router);
        Ok(Self {
            listener,
            address: format!("http://127.0.0.1:{port}/{token}/"),
            router,
        })
    }

    /// The address of the page, with the token that gives access.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Answers requests until `stop` says so.
    ///
    /// # Errors
    /// A failure of the system.
    pub fn run(self, stop: impl Fn() -> bool + Send + 'static) -> Result<(), ViewError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(ViewError::Serve)?;
        let (listener, router) = (self.listener, self.router);
        let served = runtime.block_on(async move {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            axum::serve(listener, router)
                .with_graceful_shutdown(async move {
                    while !stop() {
                        tokio::time::sleep(LOOK).await;
                    }
                })
                .await
        });
        // Work in progress is not waited for.
        runtime.shutdown_background();
        served.map_err(ViewError::Serve)
    }
}

/// 128 random bits in hexadecimal digits.
fn token() -> Result<String, ViewError> {
    let mut bytes = [0_u8; 16];
    OsRng
        .try_fill_bytes(&mut bytes)
        .map_err(|error| ViewError::Random(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
