#!/usr/bin/env bash
# From a fresh clone to clay pressed by a hand: pictures, a mesh and a report under out/demo; and to
# an object of splats in the same hands, under out/demo-pot.
set -eu -o pipefail
cd "$(dirname "$0")"
. .ci/setup.sh

install "${build_packages[@]}"

# "[17/130]" of Ninja, on one line of a terminal, else a line a quarter.
progress() {
    local line done all shown=0
    while IFS= read -r line; do
        [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]] || continue
        done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
        if [ -t 1 ]; then
            printf '\r    %d of %d steps, %d s' "$done" "$all" $SECONDS
        elif [ $((4 * done / all)) -gt $shown ]; then
            shown=$((4 * done / all))
            echo "    $done of $all steps, $SECONDS s"
        fi
    done
    [ ! -t 1 ] || echo
}

cuda=OFF
gpu_present && cuda=ON  # without a card its half of the build would only cost minutes
say "Building (release, for this machine's processor): about two minutes on two cores"
began=$SECONDS
mkdir -p build
build() {  # settings
    { cmake -S . -B build/demo -G Ninja -DCMAKE_BUILD_TYPE=Release -DKNEAD_NATIVE=ON \
        -DKNEAD_CUDA=$cuda "$@" && cmake --build build/demo --target knead; } 2>&1 |
        tee build/demo.log | progress
}
# A compiler that we do not know may refuse files compiled together, and take them one by one.
if ! build -DKNEAD_UNITED=ON && ! build -DKNEAD_UNITED=OFF; then
    grep -E 'rror' build/demo.log | head -n 20 >&2
    echo "The build failed: see build/demo.log" >&2
    exit 1
fi
grep -o 'knead: .*' build/demo.log | head -n 1
echo "built in $((SECONDS - began)) s on $(nproc) processors"

say "Running: knead run scenes/demo.json, a little coarsely, --out out/demo: some fifteen seconds"
began=$SECONDS
./build/demo/knead run scenes/demo.json --out out/demo --overwrite --pictures 39 \
    --set domain.cells=40 --set surface.nodes=80 "$@"
echo "ran for $((SECONDS - began)) s"

say "Running: knead run scenes/pot.json, coarsely, --out out/demo-pot: some ten seconds"
began=$SECONDS
./build/demo/knead run scenes/pot.json --out out/demo-pot --overwrite --quiet --mesh none \
    --set domain.cells=16 --set objects.0.material.young=1e5 --frames 120 --pictures 60
echo "ran for $((SECONDS - began)) s"

say "What there is to see"
first=$(find out/demo/pictures -name '*.png' 2>/dev/null | sort | head -n 1)
last=$(find out/demo/pictures -name '*.png' 2>/dev/null | sort | tail -n 1)
if [ -n "$first" ]; then
    echo "pictures      out/demo/pictures, from ${first##*/} to ${last##*/}"
else
    echo "pictures      none: see \"left out\" above"
fi
echo "a pot         out/demo-pot/pictures: a pot of Gaussian splats, squeezed; its splats as they"
echo "              are now in out/demo-pot/splats.ply, for any viewer of Gaussian splats"
echo "mesh          out/demo/mesh.glb, for any viewer of glTF"
echo "report        out/demo/report.json and, frame by frame, out/demo/frames.csv"
echo "              (docs/guide/first-hour.md, section 4, says how to read them)"
echo "next          ./build/demo/knead run scenes/imprint.json --out out/imprint"
