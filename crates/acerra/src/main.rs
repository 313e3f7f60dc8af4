//! The `acerra` command.

fn main() {}
