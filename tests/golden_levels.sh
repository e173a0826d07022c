#!/bin/sh
# The golden states of scenes/golden.csv, on every level of x86-64 that this processor knows: by a
# verify build of their test alone.
# usage: tests/golden_levels.sh BUILD      builds in BUILD/verify
set -eu
cd "$(dirname "$0")/.."
build=$1/verify
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DKNEAD_VERIFY=ON -DKNEAD_CUDA=OFF \
    -DKNEAD_GL=OFF -DKNEAD_TESTS=golden >"$1/verify.log"
if ! cmake --build "$build" --target knead_tests >>"$1/verify.log"; then
    tail -n 20 "$1/verify.log"
    exit 1
fi
exec "$build/knead_tests" --gtest_brief=1
