#!/bin/sh
# Writes the validation book anew: every table and picture of docs/validation.
set -eu
cd "$(dirname "$0")/.."
ACERRA_DOCS="$PWD/docs/validation" cargo test --release --locked -p acerra -p acerra-gnss \
    -- --ignored validation_book validation_ppk
