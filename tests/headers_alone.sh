#!/usr/bin/env bash
# Every stage header stands alone: each header under cuda/ is compiled by itself, without a CUDA
# compiler and without warnings, by every C++ compiler that is there. An include that only works
# after another one, or CUDA that has crept into the maths, fails here.
# usage: tests/headers_alone.sh
set -u
shopt -s globstar
cd "$(dirname "$0")/.."

compilers=()
for compiler in g++ clang++; do
    if command -v $compiler >/dev/null; then
        compilers+=($compiler)
    else
        echo "$compiler is not here: left out"
    fi
done
if [ ${#compilers[@]} -eq 0 ]; then
    echo "neither g++ nor clang++ is here" >&2
    exit 1
fi

failed=0
count=0
for header in cuda/**/*.h; do
    for compiler in "${compilers[@]}"; do
        count=$((count + 1))
        if ! $compiler -std=c++20 -I. -fsyntax-only -Wall -Wextra -Wshadow -Werror -x c++ \
            -include "$header" /dev/null; then
            echo "$header does not stand alone under $compiler" >&2
            failed=$((failed + 1))
        fi
    done
done
echo "$count compilations of the headers of cuda/, $failed failed"
[ $count -gt 0 ] && [ $failed -eq 0 ]
