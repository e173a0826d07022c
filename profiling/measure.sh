#!/usr/bin/env bash
# Measures anew all that is kept of a card: its benchmarks in profiling/results/<card>/, and the
# tables of docs/engineering/kernels.md. With a folder of programs that were built elsewhere it
# needs nothing but a driver, CUPTI and Nsight Compute (the CUDA toolkit has both), Python 3, its
# package taichi for the peer and matplotlib for the drawings. Goes on after a failure; ends with 1
# then.
# usage: profiling/measure.sh [FOLDER_OF_PROGRAMS=build] [FOLDER_FOR_COUNTERS=out/measure]
#        [PARTS="bench kernels"]
set -u
cd "$(dirname "$0")/.."
programs=${1:-build}
work=${2:-out/measure}
parts=${3:-bench kernels}
card=$(nvidia-smi --query-gpu=name --format=csv,noheader | head -n 1 | tr '[:upper:]' '[:lower:]' |
    sed 's/[^a-z0-9][^a-z0-9]*/-/g; s/^-//; s/-$//')
[ -n "$card" ] || { echo "no GPU answers nvidia-smi" >&2; exit 4; }
for program in knead bench_substep bench_surface peer_plain; do
    [ -x "$programs/$program" ] || { echo "no $programs/$program: build it first" >&2; exit 2; }
done
results=profiling/results/$card
mkdir -p "$work" "$results" || exit 5

bench() {
    "$programs/knead" bench --peers --count --overwrite --out "$results" >"$work/bench.txt"
}

kernels() {
    profiling/nsight/collect.sh "$work/nsight" "$programs" &&
        profiling/nsight/summary.py "$work/nsight" --into docs/engineering/kernels.md
}

failed=0
for part in $parts; do
    case $part in
        bench | kernels) ;;
        *) echo "no part $part" >&2; exit 2 ;;
    esac
    start=$SECONDS
    if "$part"; then
        echo "$part: $((SECONDS - start)) s"
    else
        echo "$part: FAILED after $((SECONDS - start)) s" >&2
        failed=1
    fi
done
exit $failed
