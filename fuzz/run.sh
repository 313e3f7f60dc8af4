#!/usr/bin/env bash
# Runs every fuzz target for SECONDS each (default 20), starting from the committed seeds.
# usage: fuzz/run.sh [SECONDS] [TARGET…]
# FUZZ_SEED=N repeats a run; by default every run draws anew.
# Needs no nightly toolchain; with the address sanitizer where this toolchain has one.
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-20}
shift || true
command -v cargo-fuzz >/dev/null || cargo install --locked --quiet cargo-fuzz
export RUSTC_BOOTSTRAP=1
if [ $# -gt 0 ]; then targets=("$@"); else mapfile -t targets < <(cargo fuzz list); fi
for target in "${targets[@]}"; do
    mkdir -p "corpus/$target"
    seeds=()
    [ -d "seeds/$target" ] && seeds=("seeds/$target")
    echo "== $target, $seconds s"
    cargo fuzz run --sanitizer "${SANITIZER:-address}" "$target" "corpus/$target" "${seeds[@]}" -- \
        -max_total_time="$seconds" -seed="${FUZZ_SEED:-0}" -rss_limit_mb=2048 -timeout=10 -verbosity=0 -print_final_stats=1
done
