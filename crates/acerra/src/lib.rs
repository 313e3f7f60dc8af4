//! The `acerra` command: arguments, one module for each command, the demonstration, and what any
//! supported file holds. The work itself is done by the libraries below it.

pub mod cli;
pub mod commands;
pub mod demo;
pub mod describe;
pub mod final_image;
pub mod init;
pub mod interrupt;
pub mod progress;
pub mod settings_files;
pub mod simulated;
pub mod terminal;
