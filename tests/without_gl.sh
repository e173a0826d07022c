#!/usr/bin/env bash
# A class with one part for OpenGL and one for builds without has the same functions in both: else a
# build without it (-DKNEAD_GL=OFF) does not link.
# usage: tests/without_gl.sh LIBRARY      libknead_app, built with OpenGL
set -u
library=$(realpath "${1:?usage: tests/without_gl.sh LIBRARY}")
cd "$(dirname "$0")/.."
at=$(mktemp -d)
trap 'rm -rf "$at"' EXIT
compiler=${CXX:-c++}

# Functions of our classes that others may call, without those of a class's own Parts.
functions() {
    nm -C --defined-only "$1" |
        sed -nE '/::Parts::/d; s/^[0-9a-f]* T (knead::[A-Z][A-Za-z]*::.*)/\1/p' | sort -u
}
functions "$library" >"$at/all"

failed=0 count=0
for file in $(grep -rl 'KNEAD_HAS_GL' --include='*.cpp' host render | xargs grep -l '^#else'); do
    $compiler -std=c++20 -O0 -w -I. -isystem /usr/include/eigen3 -DXXH_INLINE_ALL -c "$file" \
        -o "$at/it.o" || exit 1
    functions "$at/it.o" >"$at/without"
    sed -E 's/^(knead::\w+::).*/^\1/' "$at/without" | sort -u >"$at/classes"
    [ -s "$at/classes" ] || continue
    grep -f "$at/classes" "$at/all" >"$at/with"
    if ! diff "$at/with" "$at/without"; then
        echo "$file does not define these (<) without OpenGL, or only (>) there" >&2
        failed=1
    fi
    count=$((count + $(wc -l <"$at/without")))
done
[ $count -gt 0 ] || { echo "no class with two parts" >&2; exit 1; }
[ $failed -eq 0 ] && echo "$count functions, with and without OpenGL"
exit $failed
