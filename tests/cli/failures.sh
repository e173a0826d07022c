#!/usr/bin/env bash
# Every command, again and again: in the n-th round the n-th call fails that opens, reads, writes,
# flushes, closes, renames or makes a file, until a round ends in which none did. Each time it must
# end with a word of the file and the reason, or have lost nothing; what is there must be whole.
# usage: tests/cli/failures.sh PROGRAM LIBRARY
set -u
library=$(realpath "${2:?usage: $0 PROGRAM LIBRARY}")
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=1
folder=$(pwd -P)
rounds=0

cat >small.json <<'SCENE'
{"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90,
 "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
              "material": {"preset": "clay", "young": 1e5}}]}
SCENE
run=(run small.json --device cpu --threads 1 -q)
answers 0 "${run[@]}" --frames 3 --particles --out one
answers 0 record squeeze hands.hands --seconds 0.2 -q
# A run that was ended, with its checkpoint.
for limit in 0.001 0.002 0.004 0.008 0.016 0.03 0.06 0.12 0.25; do
    answers 0 "${run[@]}" --frames 20 --out ended --overwrite --time-limit $limit
    [ ! -e ended/checkpoint.knead ] || break
done
[ -e ended/checkpoint.knead ] || wrong "no checkpoint to go on from"
cp one/mesh.glb one/particles.ply .

# What does not depend on how long it took.
sums() {
    find "$1" -type f ! -name 'report.*' ! -name frames.csv ! -name 'verify.*' \
        ! -name checkpoint.knead -exec md5sum {} + | sed "s|  $1/|  |" | sort
}

# fails_at_each NAME OLD ARGUMENT...: in a folder `at` that begins as a copy of OLD ("" for none),
# the command writes below it.
fails_at_each() {
    local name=$1 old=$2 n=0 code call path whole
    shift 2
    fresh() { rm -rf at; mkdir at; if [ -n "$old" ]; then cp -r "$old"/. at; fi; }
    fresh
    local before
    before=$(sums at)
    answers 0 "$@"
    whole=$(sums at)
    while :; do
        n=$((n + 1))
        fresh
        rm -f log
        FAIL_UNDER=$folder/at FAIL_AT=$n FAIL_LOG=$folder/log LD_PRELOAD=$library \
            timeout 100 "$program" "$@" >said 2>complained </dev/null
        code=$?
        [ -e log ] || break
        read -r call path <log
        rounds=$((rounds + 1))
        local here="$name, call $n ($call ${path#"$folder"/})"
        local after
        after=$(sums at)
        find at -name '*.partial-*' | grep -q . && wrong "$here: left $(ls -A at)"
        case $code in
            0) [ "$after" = "$whole" ] || wrong "$here: ends well without all of its files" ;;
            3 | 5)
                [ $code -eq 5 ] || [[ $call = open || $call = *read ]] || wrong "$here: exit 3"
                grep -q 'No space left on device' complained || wrong "$here: no reason"
                grep -q 'at\b' complained || wrong "$here: names no file"
                # Every file is an old one or a new one.
                while read -r line; do
                    [ -z "$line" ] || grep -qxF -- "$line" <<<"$before
$whole" || wrong "$here: half a file: $line"
                done <<<"$after"
                ;;
            *) wrong "$here: exit $code" ;;
        esac
        [ $n -lt 400 ] || { wrong "$name: no end"; break; }
    done
    [ $code -eq 0 ] || wrong "$name: exit $code where nothing failed"
    [ $n -gt 3 ] || wrong "$name: only $n calls"
    echo "$name: $((n - 1)) calls"
}

fails_at_each run "" "${run[@]}" --frames 2 --particles --out at --checkpoint 1e-9
fails_at_each "run --overwrite" one "${run[@]}" --frames 2 --particles --out at --overwrite
fails_at_each "run --resume" ended run --resume at -q --threads 1
mkdir -p old
for file in mesh.obj copy.ply copy.stl hands.hands hands.jsonl; do echo old >old/$file; done
fails_at_each record old record squeeze at/hands.hands --seconds 0.2 --overwrite -q
fails_at_each "convert mesh" old convert mesh.glb at/mesh.obj --overwrite -q
fails_at_each "convert to STL" old convert mesh.glb at/copy.stl --overwrite -q
fails_at_each "convert particles" old convert particles.ply at/copy.ply --overwrite -q
fails_at_each "convert hands" old convert hands.hands at/hands.jsonl --overwrite -q
mkdir -p given
cp mesh.glb hands.hands particles.ply small.json given
for file in mesh.glb hands.hands particles.ply small.json; do
    fails_at_each "info $file" given info at/$file
done
row='\0\0\200\77\0\0\0\100\0\0\100\100\0\0\200\77\0\0\200\77\0\0\200\77\377\0\200\377'
mkdir -p splats
printf "$row\\377\\200\\200\\200" >splats/a.splat
fails_at_each render splats render at/a.splat --out at/drawn.png --size 16x16 --device cpu -q
fails_at_each "convert splats" splats convert at/a.splat at/b.spz -q
fails_at_each "run of sequences" "" "${run[@]}" --frames 2 --out at --mesh-every 1 \
    --particles-every 1
fails_at_each "run of pictures" "" "${run[@]}" --frames 2 --out at --pictures 1 \
    --set pictures.width=32 --set pictures.height=32
fails_at_each new "" new at/fresh.json
fails_at_each "help of all" "" help --pages at
cp one/report.json given
fails_at_each compare given compare at/report.json one/report.json
fails_at_each "compare particles" given compare at/particles.ply particles.ply
fails_at_each verify "" verify convergence --only patch --device cpu -q --out at/verified
echo "$rounds calls failed"
concluded
