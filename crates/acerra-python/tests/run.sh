#!/usr/bin/env bash
# Types, stubs, doctests and tests of the installed package.
# usage: tests/run.sh PYTHON
set -euo pipefail
cd "$(dirname "$0")/.."
python=$1
"$python" -m mypy
# The stubs against the module that is installed, away from the sources.
(cd tests && "$python" -m mypy.stubtest acerra._native)
"$python" -m pytest --durations=12 --doctest-modules --pyargs acerra tests
