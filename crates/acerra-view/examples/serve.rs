//! Serves runs without the command: `cargo run -p acerra-view --example serve -- DIRECTORY…`
#![allow(clippy::print_stdout)]

fn main() -> Result<(), acerra_view::ViewError> {
    let directories = std::env::args().skip(1).map(Into::into).collect();
    let server = acerra_view::Server::open(&acerra_view::ServerOptions {
        directories,
        ..Default::default()
    })?;
    println!("{}", server.address());
    server.run(|| false)
}
