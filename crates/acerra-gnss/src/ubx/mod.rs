//! u-blox UBX raw logs.

pub mod frame;
