#!/usr/bin/env bash
# Some inputs of every format, the same on every run.
# usage: tests/fuzz/some.sh KNEAD_FUZZ INPUTS
set -eu
export OMP_NUM_THREADS=1
fuzz=$(realpath "${1:?usage: $0 KNEAD_FUZZ INPUTS}")
cd "$(dirname "$0")/../.."
"$fuzz" --inputs "$2"
