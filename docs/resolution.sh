#!/bin/sh
# Draws the figures of resolution.md anew: docs/resolution.sh [path of acerra]
set -eu
cd "$(dirname "$0")"
acerra=${1:-../target/release/acerra}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
printf -- '-2,0,0\n0,0,0.2\n2,0,0.4\n' >"$work/targets.csv"

"$acerra" resolution --height 5 --offset 2 --light-speed 3e8 -o "$work/6" >/dev/null
cp "$work/6/resolution-map.png" images/figure-6.png

psf() { # figure, then options
    figure=$1
    shift
    "$acerra" psf --light-speed 3e8 --pixel-m 0.02 "$@" -o "$work/$figure" >/dev/null
    cp "$work/$figure/psf.png" "images/figure-$figure.png"
}
psf 7a --height 5 --offset 0
psf 7b --height 5 --offset 2
psf 7c --height 5 --offset 0 --track cosine:0.15:24
psf 7d --height 5 --offset 2 --track cosine:0.15:24
psf 7e --height 5 --offset 0 --track cosine:-0.15:24
psf 7f --height 5 --offset 2 --track cosine:-0.15:24
psf 8a --height 10 --offset 0 --track cosine:0.15:24
psf 8b --height 10 --offset 2 --track cosine:0.15:24
psf 14a --height 5 --targets "$work/targets.csv" --plane-z 0
psf 14b --height 5 --targets "$work/targets.csv" --plane-z 0.2
psf 14c --height 5 --targets "$work/targets.csv" --plane-z 0.4
