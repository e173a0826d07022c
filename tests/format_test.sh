#!/usr/bin/env bash
# Checks the layout of the whole tree by .clang-format. Only clang-format 14 counts, because other
# versions lay some code out differently; without it the test is skipped. Prints every place that
# differs; fails if there is any.
# usage: tests/format_test.sh            (checks)
#        tests/format_test.sh --write    (formats the files in place)
set -u
cd "$(dirname "$0")/.."
shopt -s nullglob globstar

arguments=(--dry-run --Werror)
case "$#:${1-}" in
    0:) ;;
    1:--write) arguments=(-i) ;;
    *) echo "usage: tests/format_test.sh [--write]"; exit 2 ;;
esac

for program in clang-format-14 clang-format ""; do
    [[ -n $program && $("$program" --version 2>/dev/null) == *"version 14."* ]] && break
done
if [ -z "$program" ]; then
    echo "no clang-format 14 here (Debian: apt-get install clang-format-14): layout not checked"
    exit 77
fi

files=({cuda,host,render,xr,tests,profiling,examples}/**/*.{h,cuh,cpp,cu})
[ ${#files[@]} -gt 0 ] || { echo "no source found"; exit 1; }

if ! "$program" "${arguments[@]}" "${files[@]}"; then
    echo "the layout differs from .clang-format: tests/format_test.sh --write mends it"
    exit 1
fi
echo "${#files[@]} files have the layout of .clang-format"
