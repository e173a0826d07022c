#!/usr/bin/env bash
# INT, TERM and HUP at every stage of a run: in the n-th round the signal comes with the n-th call
# that opens, writes, flushes, closes, renames or makes a file of the run's folder, from before the
# first frame until after the last file. Nothing is left half written; a run that had begun keeps
# its results and goes on to the end that it would have had; one that was over is whole.
# usage: tests/cli/signals.sh PROGRAM LIBRARY
set -u
library=$(realpath "${2:?usage: $0 PROGRAM LIBRARY}")
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=1 OMP_WAIT_POLICY=passive
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
concluded
