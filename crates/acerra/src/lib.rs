//! The application: campaign file, processing chain, products, report and command line.
