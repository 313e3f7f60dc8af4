#!/usr/bin/env bash
# Runs every fuzz target for SECONDS each (default 20), starting from the committed seeds.
# usage: fuzz/run.sh [SECONDS] [TARGET…]
# FUZZ_SEED=N repeats a run; by default every run draws anew.
# Needs no nightly toolchain; with the address sanitizer where this toolchain has one.
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-20}
shift || true
# Not optimised, so that it compiles sooner: it only starts the targets.
command -v cargo-fuzz >/dev/null ||
    CARGO_PROFILE_RELEASE_OPT_LEVEL=0 CARGO_PROFILE_RELEASE_LTO=off cargo install --locked --quiet cargo-fuzz
export RUSTC_BOOTSTRAP=1
if [ $# -gt 0 ]; then targets=("$@"); else mapfile -t targets < <(cargo fuzz list); fi
sanitizer=${SANITIZER:-address}
# All at once, or one by one as they run: the first uses every processor.
if [ ${#targets[@]} -gt 1 ]; then cargo fuzz build --dev --sanitizer "$sanitizer"; fi

fuzz() {
    mkdir -p "corpus/$1"
    local seeds=() said
    [ -d "seeds/$1" ] && seeds=("seeds/$1")
    said=$(mktemp)
    local failed=0
    cargo fuzz run --dev --sanitizer "$sanitizer" "$1" "corpus/$1" "${seeds[@]}" -- \
        -max_total_time="$seconds" -seed="${FUZZ_SEED:-0}" -rss_limit_mb=2048 -timeout=10 -verbosity=0 -print_final_stats=1 \
        >"$said" 2>&1 || failed=1
    { echo "== $1, $seconds s"; cat "$said"; } # whole, since others run beside it
    rm "$said"
    return $failed
}
export -f fuzz
export sanitizer seconds
# A target uses one processor; the first failure ends the rest.
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc 2>/dev/null || echo 2)" -I{} bash -euo pipefail -c 'fuzz {} || exit 255'
