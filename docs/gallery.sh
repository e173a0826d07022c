#!/usr/bin/env bash
# Makes the pictures of splats in the README from a committed scene. Needs ffmpeg.
# usage: docs/gallery.sh [PROGRAM]
set -eu
cd "$(dirname "$0")/.."
program=${1:-build/demo/knead} out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$program" run scenes/pot.json --set domain.cells=28 --frames 270 --pictures 30 --mesh none \
    --splats none --out "$out"
picture() { printf '%s/pictures/frame_%05d.png' "$out" "$1"; }
shrunk='crop=840:650:20:30,scale=420:-1:flags=lanczos'
ffmpeg -loglevel error -y -i "$(picture 30)" -i "$(picture 120)" -i "$(picture 270)" \
    -filter_complex "[0]$shrunk[a];[1]$shrunk[b];[2]$shrunk[c];[a][b][c]hstack=3" \
    -compression_level 9 docs/pot.png
