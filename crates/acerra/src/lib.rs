//! The application: campaign file, processing chain, products, report and command line.
//!
//! The way of the data is position → align → clean → focus → measure → deliver; `chain` holds
//! one module for each of these stages, and [`commands`] one for each command.

pub mod campaign;
pub mod chain;
pub mod cli;
pub mod commands;
pub mod demo;
pub mod describe;
pub mod figure;
pub mod plan;
pub mod positioning;
pub mod products;
pub mod report;
pub mod simulate;
