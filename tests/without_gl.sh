#!/usr/bin/env bash
# A file that has one part with OpenGL and one without defines the same functions in both: else a
# build without it (-DKNEAD_GL=OFF) does not link.
# usage: tests/without_gl.sh
set -u
cd "$(dirname "$0")/.."
at=$(mktemp -d)
trap 'rm -rf "$at"' EXIT
compiler=${CXX:-c++}

if ! echo '#include <EGL/egl.h>' | $compiler -E -x c++ - >/dev/null 2>&1; then
    echo "the headers of EGL are not here"
    exit 77
fi

# Functions of ours that the file defines for others, without those of its own Parts; further
# arguments go to the compiler.
functions() {
    $compiler -std=c++20 -O0 -w -I. -isystem /usr/include/eigen3 -DXXH_INLINE_ALL "${@:2}" -c "$1" \
        -o "$at/it.o" && nm -C --defined-only "$at/it.o" |
        sed -n '/::Parts::/d; s/^[0-9a-f]* T //p' | sort -u
}

failed=0 count=0
for file in $(grep -rl 'KNEAD_HAS_GL' --include='*.cpp' host render xr | xargs grep -l '^#else'); do
    functions "$file" -DKNEAD_HAS_GL=1 >"$at/with" || exit 1
    functions "$file" >"$at/without" || exit 1
    if ! diff "$at/with" "$at/without"; then
        echo "$file does not define these (<) without OpenGL, or only (>) there" >&2
        failed=1
    fi
    count=$((count + $(wc -l <"$at/with")))
done
[ $count -gt 0 ] || { echo "no file with two parts" >&2; exit 1; }
[ $failed -eq 0 ] && echo "$count functions, with and without OpenGL"
exit $failed
