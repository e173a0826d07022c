#!/usr/bin/env bash
# Where results go: one process at a time writes into a folder, whatever ends it; what cannot be
# written is said and ends with exit code 5, the standard output included; every name that the file
# system takes can be written.
# usage: tests/cli/outputs_test.sh PROGRAM LIBRARY
set -u
library=$(realpath "${2:?usage: $0 PROGRAM LIBRARY}")
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=1

cat >small.json <<'SCENE'
{"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90,
 "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
              "material": {"preset": "clay", "young": 1e5}}]}
SCENE
run=(run small.json --device cpu --threads 1)
answers 0 "${run[@]}" --frames 1 --particles --out one -q
row='\0\0\200\77\0\0\0\100\0\0\100\100\0\0\200\77\0\0\200\77\0\0\200\77\377\0\200\377'
printf "$row\\377\\200\\200\\200" >one.splat

# A full standard output. Every verb has a line here, or a reason why not.
rows=(
    "run small.json --device cpu --frames 1 --json"
    "run small.json --device cpu --frames 1"
    "record squeeze a.hands --seconds 0.1 --overwrite"
    "info small.json" "info small.json --json" "info one/report.json" "info one/report.json --json"
    "info one/mesh.glb" "info one.splat"
    "compare one/report.json one/report.json" "compare one/report.json one/report.json --json"
    "convert one/mesh.glb a.obj --overwrite" "convert one/mesh.glb - --to obj"
    "render one.splat --out a.png --size 16x16 --device cpu --overwrite"
    "replay two-lumps.knead --to 1" "replay two-lumps.knead --to 1 --json"
    "session verify two-lumps.knead" "session verify two-lumps.knead --json" "session list"
    "doctor" "doctor --json"
    "bench stages --device cpu --quick --out measured --overwrite"
    "verify convergence --only patch --device cpu"
    "verify convergence --only patch --device cpu --json"
    "list presets" "list materials" "list gestures" "list scenes"
    "new a.json --overwrite" "new -"
    "help" "help run" "help --man" "help run --man" "help --completion bash"
    "help --completion zsh"
    "--help" "-h" "--version" "-V" "run --help" "list --help"
)
elsewhere=" vr view "  # they need a headset, a window
verbs=$("$program" help --completion bash | sed -n "s/.*compgen -W '\([^']*\) --help.*/\1/p")
[ "$(wc -w <<<"$verbs")" -gt 10 ] || wrong "only these verbs: $verbs"
for verb in $verbs; do
    [[ $elsewhere = *" $verb "* ]] || printf '%s\n' "${rows[@]}" | grep -q "^$verb\b" ||
        wrong "no line for knead $verb"
done
for line in "${rows[@]}"; do
    read -ra words <<<"$line"
    timeout 100 "$program" "${words[@]}" >/dev/full 2>complained </dev/null
    code=$?
    [ $code -eq 5 ] || wrong "exit $code instead of 5 with a full output: knead $line"
    complains 'No space left on device'
done
for line in "info small.json" "list presets" "help" "--version"; do
    read -ra words <<<"$line"
    "$program" "${words[@]}" >&- 2>complained </dev/null
    code=$?
    [ $code -eq 5 ] || wrong "exit $code instead of 5 with a closed output: knead $line"
done
# What has another end keeps its code.
"$program" info absent.json >/dev/full 2>complained
[ $? -eq 3 ] || wrong "another exit than 3 for a file that is not there"
"$program" list nothing >/dev/full 2>complained
[ $? -eq 2 ] || wrong "another exit than 2 for a wrong word"
# Files are written all the same.
"$program" "${run[@]}" --frames 1 --out full >/dev/full 2>complained
[ $? -eq 5 ] || wrong "a run with a full output"
[ -s full/report.json ] && [ -s full/mesh.glb ] && [ ! -e full/checkpoint.knead ] ||
    wrong "a full output cost results: $(ls -A full)"
# A closed one is no place for files.
"$program" "${run[@]}" --frames 1 --out closed -q >&- 2>complained
"$program" info closed/report.json >said 2>complained || wrong "a closed output is in a file"

# Two processes, one folder.
"$program" "${run[@]}" --frames 10000000 --out live -q >/dev/null 2>&1 &
process=$!
for _ in $(seq 600); do [ -s live/.knead-lock ] && break || sleep 0.1; done
[ "$(cut -d' ' -f1 live/.knead-lock)" = $process ] || wrong "no lock with the number $process"
for words in "${run[*]} --frames 1 --out live" "${run[*]} --frames 1 --out live --overwrite" \
    "${run[*]} --frames 1 --out ./live/../live --overwrite" "run --resume live" \
    "verify convergence --only patch --device cpu --out live --overwrite" \
    "bench targets --device cpu --quick --max-memory 1 --out live --overwrite" \
    "help --pages live"; do
    read -ra words <<<"$words"
    answers 5 "${words[@]}"
    complains "process $process is writing there"
done
[ "$(ls -A live | grep -v checkpoint)" = .knead-lock ] || wrong "a refused one left: $(ls -A live)"
answers 0 doctor live
grep -q '^left' said && wrong "doctor takes the lock of a live run for a leftover"
kill -9 $process
wait $process 2>/dev/null
answers 0 doctor live
holds said '^left .*\.knead-lock: a lock, by a program that was killed'
answers 0 "${run[@]}" --frames 1 --out live --overwrite -q
[ ! -e live/.knead-lock ] || wrong "a lock stays behind"
# Both began at the same moment: one of them has it.
for n in 1 2 3 4 5; do
    "$program" "${run[@]}" --frames 30 --out both$n -q >/dev/null 2>first &
    a=$!
    "$program" "${run[@]}" --frames 30 --out both$n -q >/dev/null 2>second &
    wait $a
    codes=$?
    wait $!
    codes="$codes $?"
    [ "$codes" = "0 5" ] || [ "$codes" = "5 0" ] || wrong "two at the same moment: exit $codes"
done
# Where there are no locks it is said, and goes on.
FAIL_LOCKS=1 LD_PRELOAD=$library "$program" "${run[@]}" --frames 1 --out unlocked -q 2>complained ||
    wrong "no run where there are no locks"
complains 'this file system has no locks (No locks available)'
[ -s unlocked/report.json ] && [ ! -e unlocked/.knead-lock ] || wrong "there is $(ls -A unlocked)"

# A limit of a file's size is an error, no death.
(ulimit -f 4; "$program" "${run[@]}" --frames 1 --out limited -q >/dev/null 2>complained)
code=$?
[ $code -eq 5 ] || wrong "exit $code instead of 5 at the limit of a file's size"
complains 'File too large'
[ -z "$(find limited -type f -size +4k)" ] || wrong "half a file: $(ls -l limited)"

# Long names.
long=$(printf 'n%.0s' $(seq 250))
answers 0 new "$long.json"
answers 0 record squeeze "${long%n}.hands" --seconds 0.1
answers 0 convert "${long%n}.hands" "${long%n}.jsonl"
answers 0 convert one/mesh.glb "${long}n.obj"
answers 0 render one.splat --out "${long}n.png" --size 16x16 --device cpu
answers 5 new "${long}n.json"
complains 'File name too long'
concluded
