#!/usr/bin/env bash
# Includes only go downwards from room to room, in one spelling: from the top of the tree. Names
# every line that breaks this. docs/rooms.md draws the rooms.
# usage: tests/includes_test.sh
set -u
cd "$(dirname "$0")/.."
shopt -s globstar nullglob

# Every room, and the rooms it may include besides itself.
declare -A may=(
    [cuda/math]=""
    [cuda/device]="cuda/math"
    [cuda/contact]="cuda/math"
    [cuda/mpm]="cuda/contact cuda/math cuda/device"
    [cuda/surface]="cuda/mpm cuda/contact cuda/math cuda/device"
    [cuda/splats]="cuda/mpm cuda/contact cuda/math cuda/device"
    [cuda/history]="cuda/math"
)
stages="cuda/math cuda/device cuda/contact cuda/mpm cuda/surface cuda/splats cuda/history"
may[host/base]="cuda/math"
may[host/solver]="host/base $stages"
may[host/splats]="host/solver ${may[host/solver]}"
may[host/surface]="host/solver ${may[host/solver]}"
may[host/share]="host/surface host/splats ${may[host/surface]}"
may[host/hands]="host/solver ${may[host/solver]}"
may[host/scene]="host/surface host/splats host/hands ${may[host/surface]}"
may[host/files]="host/scene ${may[host/scene]}"
may[host/assets]="host/files ${may[host/files]}"
may[render]="host/share ${may[host/share]} host/hands host/files/image.h ${may[host/surface]}"
may[render/view]="render ${may[render]}"
may[xr]="host/hands ${may[host/hands]}"
may[host/document]="host/assets ${may[host/assets]}"
may[host/paging]="host/document ${may[host/document]}"
may[host/session]="host/paging ${may[host/paging]}"
may[host/run]="host/session ${may[host/session]}"
may[host/live]="host/session ${may[host/session]} host/share render xr"
may[host/picture]="host/live ${may[host/live]}"
may[host/ui]="host/run host/picture ${may[host/picture]}"
may[host/vr]="host/ui ${may[host/ui]}"
may[host/desktop]="host/ui ${may[host/ui]} render/view"
may[host/bench]="host/run host/live ${may[host/live]}"
may[host/verify]="host/run host/live ${may[host/live]}"
may[host/cli]="host/bench host/verify host/vr host/desktop ${may[host/desktop]}"

# The room of a path: cuda and host have rooms of their own, and so has render/view; the others are
# one each.
room() {
    case $1 in
        cuda/*/* | host/*/* | render/view/*) local below=${1#*/}; echo "${1%%/*}/${below%%/*}" ;;
        *) echo "${1%%/*}" ;;
    esac
}

wrong=0
count=0
while IFS=: read -r file line text; do
    count=$((count + 1))
    target=${text#*\"}
    target=${target%%\"*}
    from=$(room "$file")
    to=$(room "$target")
    if [ "$target" = knead_commit.h ]; then continue; fi  # made by the build
    if [ ! -e "$target" ]; then
        why="is not a path from the top of the tree"
    elif [ -z "${may[$from]+known}" ]; then
        why="is in $from, which is not among the rooms of tests/includes_test.sh"
    elif [[ $from = "$to" || " ${may[$from]} " = *" $to "* || " ${may[$from]} " = *" $target "* ]]
    then
        continue
    else
        why="includes upwards: $from may include ${may[$from]:-nothing}"
    fi
    echo "$file:$line: \"$target\" $why"
    wrong=$((wrong + 1))
done < <(grep -nE '^ *# *include +"' cuda/**/*.{h,cuh,cu} host/**/*.{h,cuh,cpp,cu} \
    render/*.{h,cpp} render/view/*.{h,cpp} xr/*.{h,cpp})

# Where files are compiled together (KNEAD_UNITED), one may live on what another includes.
for needs in 'fmt:: <fmt/' 'nlohmann:: <nlohmann/' 'std::filesystem <filesystem>' \
    'std::chrono <chrono>'; do
    read -r name header <<<"$needs"
    for file in $(grep -lF "$name" host/**/*.{h,cpp} render/**/*.{h,cpp} xr/*.{h,cpp}); do
        own=${file%.cpp}.h
        [ -e "$own" ] || own=
        grep -qF "#include $header" "$file" $own && continue
        echo "$file: uses $name and does not include $header"
        wrong=$((wrong + 1))
    done
done

echo "$count includes, $wrong wrong"
[ $count -gt 0 ] && [ $wrong -eq 0 ]
