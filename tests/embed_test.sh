#!/usr/bin/env bash
# A project that takes Knead in by FetchContent or add_subdirectory keeps its flags and its
# launchers: the outer project's own file is compiled with nothing of ours but where the headers
# are, and nothing but the two libraries is made for it.
# usage: tests/embed_test.sh BUILD_FOLDER        (whose compilers are used)
set -eu
build=$(realpath "${1:?usage: tests/embed_test.sh BUILD_FOLDER}")
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
unset CMAKE_CXX_COMPILER_LAUNCHER CMAKE_CUDA_COMPILER_LAUNCHER CXXFLAGS
cached() { sed -n "s/^$1:[A-Z]*=//p" "$build"/CMakeCache.txt; }
cmake -S tests/embed -B "$folder" -G "$(cached CMAKE_GENERATOR)" -DKNEAD="$PWD" \
    -DCMAKE_BUILD_TYPE=Debug -DKNEAD_CUDA="$(cached KNEAD_CUDA)" \
    -DCMAKE_CXX_COMPILER="$(cached CMAKE_CXX_COMPILER)" >"$folder"/log 2>&1 ||
    { cat "$folder"/log; exit 1; }

command=$(grep -A3 "\"directory\": \"$folder\"" "$folder"/compile_commands.json |
    sed -n 's/^ *"command": "\(.*outside\.cpp\)".*/\1/p')
echo "compiled by: $command"
read -ra words <<<"$command"
[ "${words[0]}" = "$(cached CMAKE_CXX_COMPILER)" ] || { echo "a launcher: ${words[0]}"; exit 1; }
for word in "${words[@]:1}"; do
    case $word in
        -I* | -isystem | -g | -std=*++20 | -DKNEAD_HAS_CUDA=1 | -o | -c) ;;
        -*) echo "a flag that the outer project did not ask for: $word"; exit 1 ;;
    esac
done
(cd "$folder" && eval "$command")

if grep -n keep_ptxas -r "$folder" --include=build.ninja --include=build.make; then
    echo "the compiler is launched by a script of ours"
    exit 1
fi
targets=$(cmake --build "$folder" --target help)
for ours in knead_solver knead_app; do
    grep -qw "$ours" <<<"$targets" || { echo "no target $ours"; exit 1; }
done
if grep -E '^(\.\.\. )?(knead|knead_tests|docs|bench_substep)(:|$)' <<<"$targets"; then
    echo "is made for the outer project, too"
    exit 1
fi
echo "the outer project keeps its flags"
