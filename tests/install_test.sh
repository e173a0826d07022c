#!/usr/bin/env bash
# What is installed is enough: from a build folder into a temporary prefix, and examples/ built
# against that as a project of its own, and run. What the installed headers include is there.
# usage: tests/install_test.sh BUILD_FOLDER
set -eu
shopt -s globstar
build=$(realpath "${1:?usage: tests/install_test.sh BUILD_FOLDER}")
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
prefix=$folder/prefix
cmake --install "$build" --prefix "$prefix" >/dev/null
"$prefix"/bin/knead --version

# Its scenes and figures are found from a folder that has none, and not in a tree.
mkdir "$folder"/empty
(
    cd "$folder"/empty
    "$prefix"/bin/knead info scenes/squeeze.json >/dev/null
    "$prefix"/bin/knead run squeeze --device cpu --frames 1 --set domain.cells=32 --quiet
    code=0
    "$prefix"/bin/knead bench targets --device cpu --quick --max-memory 1 --out bench \
        >said 2>&1 || code=$?
    # Too little memory for any case: but the scene was read, and targets.json.
    if [ $code -ne 4 ] || grep 'no file' said; then
        echo "the installed program lacks its files: bench ended with $code"
        exit 1
    fi
    "$prefix"/bin/knead verify accuracy --only shear --device cpu >said 2>&1
    if grep 'no file' said; then
        echo "the installed program lacks known.json"
        exit 1
    fi
)

missing=$(cd "$prefix"/include/knead &&
    grep -rhoE '^ *# *include +"[^"]+"' . | grep -oE '[^"]+/[^"]+' | sort -u |
    while read -r header; do [ -e "$header" ] || echo "$header"; done)
if [ -n "$missing" ]; then
    printf 'included by an installed header, and not installed: %s\n' $missing
    exit 1
fi
if grep -rlF "$PWD" "$prefix"/lib*/**/cmake; then
    echo "the package's files name the folder that it was built in"
    exit 1
fi

# The program's user has settings of his own, none of which is ours.
unset CMAKE_CXX_COMPILER_LAUNCHER CMAKE_CUDA_COMPILER_LAUNCHER CXXFLAGS
cp -r examples "$folder"/examples
cmake -S "$folder"/examples -B "$folder"/build -G Ninja -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror" >/dev/null
cmake --build "$folder"/build >"$folder"/log || { cat "$folder"/log; exit 1; }
"$folder"/build/press "$folder"/press.obj

# The sphere went 4 cm down into the ball: its top is not whole any more.
awk '$1 == "v" { if ($3 > top) top = $3 } END {
    printf "the ball of 10 cm on a floor at 3 cm now ends at %.1f cm\n", 100 * top
    exit !(top > 0.05 && top < 0.125)  # no mesh: 0
}' "$folder"/press.obj
