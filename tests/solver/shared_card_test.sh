#!/usr/bin/env bash
# Programs that share a GPU take turns on it, and are stopped between any two instructions. Kernels
# that start early then meet each other in states that they never see when alone. A deterministic
# run is to end in the same bits beside others as by itself; others are to end well.
# usage: tests/solver/shared_card_test.sh PROGRAM
set -u
program=$(realpath "${1:?usage: tests/solver/shared_card_test.sh PROGRAM}")
cd "$(dirname "$0")/../.." || exit 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# The run $1 of two hands at hand scale, whose frames are long, with the options after it. Leaves
# the state that it ended in, or nothing where it failed.
run() {
    if "$program" run scenes/squeeze.json --device cuda --frames 60 --audit 60 \
        --mesh none --pictures 0 --quiet --json --out "$folder/$1" \
        --set domain.edge=0.2 --set walls.min=[0.009375,0.009375,0.009375] \
        --set walls.max=[0.1875,0.1875,0.1875] --set objects.0.diameter=0.1 \
        --set objects.0.centre=[0.1,0.059375,0.1] --set hands.zoom=1 \
        --set hands.at=[0.1,0.059375,0.1] "${@:2}" \
        </dev/null >"$folder/$1.json" 2>"$folder/$1.said"; then
        sed -n 's/.*"state_hash": "\([0-9a-f]*\)".*/\1/p' "$folder/$1.json"
    fi >"$folder/$1.hash"
}

run alone --deterministic
if grep -q "no CUDA device" "$folder/alone.said"; then
    cat "$folder/alone.said"
    exit 77
fi
alone=$(<"$folder/alone.hash")
[ -n "$alone" ] || { cat "$folder/alone.said"; exit 1; }
for k in 1 2 3; do run "$k" --deterministic & done
wait
for k in 4 5 6; do run "$k" & done
wait
failed=0
for k in 1 2 3 4 5 6; do
    hash=$(<"$folder/$k.hash")
    [ "$hash" = "$alone" ] && continue
    [ "$k" -gt 3 ] && [ -n "$hash" ] && continue
    failed=1
    echo "run $k, of three at once: state '$hash'; the deterministic one by itself: $alone"
    cat "$folder/$k.said"
done
[ $failed = 0 ] && echo "three at once, each $alone as by itself; three that are not deterministic"
exit $failed
