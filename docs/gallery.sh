#!/usr/bin/env bash
# Makes the pictures of the README and of docs/: from committed scenes clay and a pot of splats
# before, in and after the hands, every material, and a loop, with ffmpeg; from the committed report
# of an H200 error against run time and how the cases of the stability map ended. Look at what it
# has made.
# usage: docs/gallery.sh [PROGRAM=build/demo/knead] [PARTS="clay pot presets verify"]
set -eu
cd "$(dirname "$0")/.."
program=${1:-build/demo/knead} parts=${2:-clay pot presets verify} out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# simulate SCENE EVERY OPTION...: pictures of a run, without its other results.
simulate() {
    "$program" run "scenes/$1.json" --out "$out/$1" --pictures "$2" --audit 1000 --mesh none \
        --splats none "${@:3}"
}
picture() { printf '%s/%s/pictures/frame_%05d.png' "$out" "$1" "$2"; }
# side_by_side SCENE FRAME FRAME FRAME FILTER TO: each as the filter leaves it.
side_by_side() {
    ffmpeg -loglevel error -y -i "$(picture "$1" "$2")" -i "$(picture "$1" "$3")" \
        -i "$(picture "$1" "$4")" -filter_complex "[0]$5[a];[1]$5[b];[2]$5[c];[a][b][c]hstack=3" \
        -compression_level 9 "$6"
}

clay() {
    simulate pinch 4 --set domain.cells=40 --set surface.nodes=96 --set pictures.width=512 \
        --set pictures.height=384 --set 'camera.eye=[0.38,1.0,1.01]' \
        --set 'camera.target=[0.55,0.225,0.5]'
    side_by_side pinch 32 84 144 'scale=420:-1:flags=lanczos' docs/clay.png
    # 60 frames a second, of which one in four is drawn.
    ffmpeg -loglevel error -y -framerate 15 -pattern_type glob \
        -i "$out/pinch/pictures/frame_*.png" -loop 0 -filter_complex \
        'scale=320:-1:flags=lanczos,split[a][b];[a]palettegen=max_colors=96[p];[b][p]paletteuse=dither=none:diff_mode=rectangle' \
        docs/loop.gif
}

pot() {
    simulate pot 30 --set domain.cells=28 --frames 270
    side_by_side pot 30 120 270 'crop=840:650:20:30,scale=420:-1:flags=lanczos' docs/pot.png
}

presets() {
    simulate presets 36
    ffmpeg -loglevel error -y -i "$(picture presets 36)" -vf 'scale=1080:-1:flags=lanczos' \
        -compression_level 9 docs/presets.png
}

verify() { cp profiling/results/nvidia-h200/verify/{workprecision,stability}.png docs; }

for part in $parts; do
    case $part in
        clay | pot | presets | verify) "$part" ;;
        *) echo "no part $part" >&2; exit 2 ;;
    esac
done
