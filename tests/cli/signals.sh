#!/usr/bin/env bash
# INT, TERM and HUP at every stage of a run: in the n-th round the signal comes with the n-th call
# that opens, writes, flushes, closes, renames or makes a file of the run's folder, from before the
# first frame until after the last file. Nothing is left half written; a run that had begun keeps
# its results and goes on to the end that it would have had; one that was over is whole.
# usage: tests/cli/signals.sh PROGRAM LIBRARY
set -u
library=$(realpath "${2:?usage: $0 PROGRAM LIBRARY}")
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=1
folder=$(pwd -P)

cat >small.json <<'SCENE'
{"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90,
 "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
              "material": {"preset": "clay", "young": 1e5}}]}
SCENE
run=(run small.json --device cpu --threads 1 -q --frames 3 --particles --checkpoint 1e-9)
answers 0 "${run[@]}" --out whole
same_as_whole() {
    local file
    for file in mesh.glb particles.ply; do
        cmp -s whole/$file "$1/$file" || wrong "$here: another $file"
    done
    [ "$(ls "$1" | tr '\n' ' ')" = "frames.csv mesh.glb particles.ply report.json " ] ||
        wrong "$here: there is $(ls -m "$1")"
}

# The end by SIGNAL at call n: what it may be, and what it must leave.
ended_by() {
    local code=$1 number=$2
    find at -name '*.partial-*' 2>/dev/null | grep -q . && wrong "$here: left $(ls -A at)"
    if [ "$code" -eq 0 ]; then
        same_as_whole at
        whole_ends=$((whole_ends + 1))
    elif [ "$code" -ne $((128 + number)) ]; then
        wrong "$here: exit $code"
    elif [ -e at/report.json ]; then
        grep -q '"end": "interrupted"' at/report.json || wrong "$here: a report of another end"
        early_ends=$((early_ends + 1))
        [ -e at/checkpoint.knead ] || return
        answers 0 run --resume at --threads 1 -q
        same_as_whole at
    else
        sooner=$((sooner + 1))
    fi
}

for signal in INT:2 TERM:15 HUP:1; do
    n=0 whole_ends=0 early_ends=0 sooner=0
    while :; do
        n=$((n + 1))
        here="${signal%:*} with call $n"
        rm -rf at log
        mkdir at
        # Job control: what a script starts in the background would ignore INT.
        set -m
        FAIL_UNDER=$folder/at FAIL_AT=$n FAIL_LOG=$folder/log FAIL_SIGNAL=${signal#*:} \
            LD_PRELOAD=$library timeout --foreground 100 "$program" "${run[@]}" --out at \
            >said 2>complained </dev/null &
        wait $!
        code=$?
        set +m
        [ -e log ] || break
        ended_by $code "${signal#*:}"
        [ $n -lt 400 ] || { wrong "no end"; break; }
    done
    [ $code -eq 0 ] || wrong "exit $code where no signal came"
    echo "${signal%:*}: $((n - 1)) moments: $sooner before the first frame, $early_ends with" \
        "partial results, $whole_ends after the last frame"
    [ $early_ends -gt 0 ] && [ $whole_ends -gt 0 ] || wrong "${signal%:*}: not at every stage"
done

# While a huge picture is drawn or written: it is given up, and nothing of it is left.
row='\0\0\200\77\0\0\0\100\0\0\100\100\0\0\200\77\0\0\200\77\0\0\200\77\377\0\200\377'
printf "$row\\377\\200\\200\\200" >one.splat
# sent SIGNAL CODES SECONDS ARGUMENT...: the signal comes so long after the program's first word, or
# start where it says none; it ends with one of the codes, and `took` says after how long.
sent() {
    local signal=$1 expected=$2 seconds=$3
    shift 3
    here="$signal after $seconds s: knead $1"
    rm -f said complained  # words of the program before this one are none of its own
    set -m
    "$program" "$@" >said 2>complained </dev/null &
    local process=$!
    if [ "$1" != render ] && [ "$1" != convert ]; then
        for _ in $(seq 600); do [ -s said ] || [ -s complained ] && break || sleep 0.05; done
    fi
    sleep "$seconds"
    local begin=$EPOCHREALTIME
    kill -s "$signal" $process 2>/dev/null
    wait $process
    code=$?
    set +m
    took=$(awk -v a="$begin" -v b="$EPOCHREALTIME" 'BEGIN { print b - a }')
    case " $expected " in
        *" $code "*) ;;
        *) wrong "$here: exit $code instead of $expected" ;;
    esac
    find . -name '*.partial-*' | grep -q . && wrong "$here: left $(find . -name '*.partial-*')"
}
# ends_soon SIGNAL CODES SECONDS ARGUMENT...: the same, within 0.2 s. Other programs may hold it up,
# so it has three tries.
ends_soon() {
    local try
    for try in 1 2 3; do
        sent "$@"
        echo "$4: $took s after $1 at $3 s"
        awk -v t="$took" 'BEGIN { exit !(t < 0.2) }' && return
    done
    wrong "$here: it ended after $took s"
}

signals=(INT TERM HUP) codes=(130 143 129) n=0
for seconds in 0.03 0.06 0.1 0.15 0.2 0.25 0.3 0.5 0.8 1.1; do
    ends_soon ${signals[n % 3]} ${codes[n % 3]} $seconds \
        render one.splat --out huge.png --size 8192x4096 --device cpu -q
    [ ! -e huge.png ] || wrong "$here: a picture is there"
    n=$((n + 1))
done

# While many splats are read, written as other ones, and drawn small.
cp one.splat many.splat
for _ in $(seq 21); do
    cat many.splat many.splat >more.splat
    mv more.splat many.splat
done
# at_all_times FILE ARGUMENT...: ends soon at one moment after the other, and leaves FILE whole or
# not at all, until it is faster than the signal.
at_all_times() {
    local file=$1 seconds moments=0
    shift
    answers 0 "$@"
    mv "$file" right
    for seconds in $(seq 0.1 0.1 3); do
        rm -f "$file"
        ends_soon ${signals[n % 3]} "${codes[n % 3]} or 0" "$seconds" "$@"
        n=$((n + 1))
        [ ! -e "$file" ] || cmp -s "$file" right || wrong "$here: half of $file"
        if [ $code -eq 0 ]; then break; fi
        moments=$((moments + 1))
    done
    [ $moments -gt 1 ] || wrong "$1: over before the signal"
}
at_all_times many.ply convert many.splat many.ply -q
at_all_times small.png render many.splat --out small.png --size 64x64 --device cpu -q

# A terminal that closes ends the measuring and the checking; what there is by then is kept.
sent HUP 129 0.2 bench stages --device cpu --quick --out measured --threads 1
grep -q '"the rest: interrupted"' measured/bench.json || wrong "$here: it does not say so"
[ -s measured/bench.csv ] || wrong "$here: no table"
echo "bench: $took s after the signal"
sent HUP 129 0.2 verify --device cpu --quick --out verified --threads 1
[ -s verified/verify.csv ] && [ -s verified/report.md ] || wrong "$here: no results"
grep -q '"schema": "knead.verify/1"' verified/verify.json || wrong "$here: no verify.json"
echo "verify: $took s after the signal"
concluded
