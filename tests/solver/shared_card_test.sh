#!/usr/bin/env bash
# Programs that share a GPU take turns on it, and are stopped between any two instructions. Kernels
# that start early then meet each other in states that they never see when alone: a deterministic
# run is to end in the same bits beside others as by itself.
# usage: tests/solver/shared_card_test.sh PROGRAM
set -u
program=$(realpath "${1:?usage: tests/solver/shared_card_test.sh PROGRAM}")
cd "$(dirname "$0")/../.." || exit 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# A run of two hands at hand scale, whose frames are long. Its state goes to the file $1.
run() {
    "$program" run scenes/squeeze.json --device cuda --deterministic --frames 60 --audit 60 \
        --mesh none --pictures 0 --quiet --json --out "$folder/$1" \
        --set domain.edge=0.2 --set walls.min=[0.009375,0.009375,0.009375] \
        --set walls.max=[0.1875,0.1875,0.1875] --set objects.0.diameter=0.1 \
        --set objects.0.centre=[0.1,0.059375,0.1] --set hands.zoom=1 \
        --set hands.at=[0.1,0.059375,0.1] </dev/null 2>"$folder/$1.said" |
        sed -n 's/.*"state_hash": "\([0-9a-f]*\)".*/\1/p' >"$folder/$1.hash"
}

run alone
if grep -q "no CUDA device\|without CUDA" "$folder/alone.said"; then
    cat "$folder/alone.said"
    exit 77
fi
alone=$(<"$folder/alone.hash")
[ -n "$alone" ] || { cat "$folder/alone.said"; exit 1; }
failed=0
for k in 1 2 3; do run "$k" & done
wait
for k in 1 2 3; do
    [ "$(<"$folder/$k.hash")" = "$alone" ] && continue
    failed=1
    echo "run $k of three at once: state $(<"$folder/$k.hash"), by itself $alone"
    cat "$folder/$k.said"
done
[ $failed = 0 ] && echo "three at once, each $alone as by itself"
exit $failed
