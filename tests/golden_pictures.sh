#!/usr/bin/env bash
# Renews the pictures of tests/golden/ by the program of the tests, on software's OpenGL. Look at
# them, and say in the commit why they have changed.
# usage: tests/golden_pictures.sh [PROGRAM_OF_TESTS=build/knead_tests]
set -eu
program=$(realpath "${1:-$(dirname "$0")/../build/knead_tests}")
cd "$(dirname "$0")/.."
KNEAD_RENEW_PICTURES=1 LIBGL_ALWAYS_SOFTWARE=1 "$program" --gtest_brief=1 \
    --gtest_filter='GoldenPictures.*:GoldenSplats.*'
du -cb tests/golden/*.png | tail -n 1
git status --short tests/golden
