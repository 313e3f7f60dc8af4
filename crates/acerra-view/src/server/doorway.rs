//! Access: an address on the loopback interface that begins with a random token.

use std::net::{Ipv4Addr, TcpListener};
use std::time::Duration;

use axum::Router;
use axum::extract::{ConnectInfo, Request, State};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use rand::TryRngCore;
use rand::rngs::OsRng;

use crate::error::ViewError;
use crate::server::connections::{Caller, Connections};

/// Interval at which a server checks whether it is to stop.
const LOOK: Duration = Duration::from_millis(100);

/// A port that is listened to, and the token that gives access.
#[derive(Debug)]
pub struct Doorway {
    listener: TcpListener,
    /// The port.
    pub port: u16,
    /// The token, 128 random bits in hexadecimal digits.
    pub token: String,
}

impl Doorway {
    /// Takes a port; 0 for any free one.
    ///
    /// # Errors
    /// A port that cannot be had, a system without random numbers.
    pub fn open(port: u16) -> Result<Self, ViewError> {
        let bind = |cause| ViewError::Bind { port, cause };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(bind)?;
        listener.set_nonblocking(true).map_err(bind)?;
        let port = listener.local_addr().map_err(bind)?.port();
        let token = token()?;
        Ok(Self {
            listener,
            port,
            token,
        })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Answers requests until `stop` returns true. Of connections without the token a few are open at a time.
    ///
    /// # Errors
    /// A failure of the system.
    pub fn serve(
        self,
        router: Router,
        stop: impl Fn() -> bool + Send + 'static,
    ) -> Result<(), ViewError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(ViewError::Serve)?;
        let listener = self.listener;
        let inside = format!("/{}/", self.token);
        let router = router.layer(from_fn_with_state(inside, note_token));
        let router = router.into_make_service_with_connect_info::<Caller>();
        let served = runtime.block_on(async move {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            axum::serve(Connections::new(listener), router)
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

/// Notes which connections have shown the token.
async fn note_token(State(inside): State<String>, request: Request, next: Next) -> Response {
    if request.uri().path().starts_with(&inside)
        && let Some(ConnectInfo(caller)) = request.extensions().get::<ConnectInfo<Caller>>()
    {
        caller.is_known();
    }
    next.run(request).await
}

/// 128 random bits in hexadecimal digits.
fn token() -> Result<String, ViewError> {
    let mut bytes = [0_u8; 16];
    OsRng
        .try_fill_bytes(&mut bytes)
        .map_err(|error| ViewError::Random(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
