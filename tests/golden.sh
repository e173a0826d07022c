#!/usr/bin/env bash
# Checks the hashes of scenes/golden.csv with the program of a verify build, or measures them anew.
# A change of the table is explained in the commit that makes it.
# usage: tests/golden.sh [--update] [--make] BUILD [cpu|cuda]
#   --make    configures BUILD with KNEAD_VERIFY where it is not, and builds the program
set -u
update=no make=no
while [[ ${1:-} == --* ]]; do
    case $1 in
        --update) update=yes ;;
        --make) make=yes ;;
        *) echo "unknown option $1" >&2; exit 2 ;;
    esac
    shift
done
build=${1:?usage: tests/golden.sh [--update] [--make] BUILD [cpu|cuda]} device=${2:-cpu}
[[ $device = cpu || $device = cuda ]] || { echo "not a device: $device" >&2; exit 2; }
cd "$(dirname "$0")/.." || exit 2

if [ $make = yes ]; then
    cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DKNEAD_VERIFY=ON >/dev/null &&
        cmake --build "$build" --target knead --parallel || exit 2
fi
grep -qs '^KNEAD_VERIFY:[A-Z]*=ON' "$build/CMakeCache.txt" ||
    { echo "$build is no build with -DKNEAD_VERIFY=ON" >&2; exit 2; }

table=scenes/golden.csv
new=$(mktemp)
trap 'rm -f "$new"' EXIT
# The state that a run of the row ends in, on $device; further arguments go to the program.
hash_of() {
    local scene=$1 hands=$2 frames=$4 options=() setting
    for setting in $3; do options+=(--set "$setting"); done
    [ -n "$hands" ] && options+=(--hands "scenes/$hands")
    [ "$device" = cuda ] && options+=(--deterministic)
    "$build/knead" run "scenes/$scene.json" --device "$device" --frames "$frames" --pictures 0 \
        --audit "$frames" --quiet --json "${options[@]}" "${@:5}" </dev/null |
        sed -n 's/.*"state_hash": "\([0-9a-f]*\)".*/\1/p'
}

changed=0
read -r heading <$table
echo "$heading" >"$new"
while IFS=, read -r scene hands settings frames cpu gpu; do
    found=$(hash_of "$scene" "$hands" "$settings" "$frames")
    [ -n "$found" ] || { echo "$scene: the run failed" >&2; exit 1; }
    if [ $device = cpu ]; then
        was=$cpu cpu=$found
        one=$(hash_of "$scene" "$hands" "$settings" "$frames" --threads 1)
        [ "$one" = "$found" ] || { echo "$scene: $found, and $one on one thread" >&2; exit 1; }
    else
        was=$gpu gpu=$found
    fi
    [ "$was" = "$found" ] || { echo "$scene $settings: $found, was ${was:-empty}"; changed=1; }
    echo "$scene,$hands,$settings,$frames,$cpu,$gpu" >>"$new"
done < <(tail -n +2 $table)

if [ $update = yes ]; then
    cp "$new" $table
    [ $changed = 0 ] && echo "nothing has changed" || echo "$table is new: say in the commit why"
elif [ $changed = 1 ]; then
    echo "other states than those of $table; if that is meant: tests/golden.sh --update" \
        "$build $device, and say in the commit why"
    exit 1
else
    echo "the states are those of $table"
fi
