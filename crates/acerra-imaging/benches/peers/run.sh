#!/usr/bin/env bash
# Times this library and what else images the common scene, in one run: benches/peers/run.sh [VENV]
# Python packages go into a virtual environment (./peers-venv by default); torchbp is timed where it
# is installed there already.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
venv=${1:-peers-venv}
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -c 'import numba' 2>/dev/null || "$venv/bin/pip" install --quiet numpy numba
scene=$(mktemp -d)
trap 'rm -rf "$scene"' EXIT
bench() { cargo bench --quiet --manifest-path "$here/../../Cargo.toml" --bench common_scene -- "$@"; }
bench "dump=$scene"
"$venv/bin/python" "$here/peers.py" "$scene"
bench table 2e-3 1e-3 3.2e-4
