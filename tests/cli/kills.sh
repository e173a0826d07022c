#!/usr/bin/env bash
# A run that is killed at random moments, again and again, and goes on from its checkpoints, ends in
# the bits of one that nothing disturbed, and leaves nothing lying about. A run with commands that
# is killed leaves valid logs, and the file that it saves is whole, old or new.
# usage: tests/cli/kills.sh PROGRAM [KILLS]
set -u
kills=${2:-30}
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=1 XDG_STATE_HOME=$folder/state
RANDOM=1
run=(run ball.json --device cpu --frames 12 --particles --threads 1 --set rest.mode=sleep
    --mesh-every 3 --particles-every 3)
answers 0 "${run[@]}" --out whole -q

# What does not depend on how long it took.
physics() {
    cut -d, -f1-4,7-100 "$1/frames.csv"
    grep -vE '"(bytes|cpu_time|real_time|p95|wall_s|[a-z0-9]*_ms|items_per_second|date)"' \
        "$1/report.json" | grep -A200 '"knead": {' | grep -vF "$1/"
}
same_as_whole() {
    local file
    for file in mesh.glb particles.ply; do
        cmp -s "whole/$file" "$1/$file" || wrong "another $file after $2 kills"
    done
    [ "$(physics whole)" = "$(physics "$1")" ] || wrong "another report after $2 kills"
    [ "$(cd "$1" && find . -type f | sort)" = "$(cd whole && find . -type f | sort)" ] ||
        wrong "left lying about: $(cd "$1" && find . -type f)"
}

done_kills=0 killed=0 runs=0 resumed=0
command=("${run[@]}" --out torn)
while [ $done_kills -lt "$kills" ]; do
    "$program" "${command[@]}" -q --checkpoint 1e-9 >said 2>complained </dev/null &
    process=$!
    sleep "0.$(printf %03d $((RANDOM % 400)))"
    if kill -9 $process 2>/dev/null; then done_kills=$((done_kills + 1)) killed=$((killed + 1)); fi
    wait $process 2>/dev/null
    code=$?
    if [ $code -eq 0 ]; then
        same_as_whole torn $killed
        runs=$((runs + 1)) killed=0
        command=("${run[@]}" --out torn --overwrite)
    elif [ $code -ne 137 ]; then
        wrong "exit $code after $killed kills: knead ${command[*]}"
        break
    elif [ -e torn/checkpoint.knead ]; then
        command=(run --resume torn --threads 1)
        resumed=$((resumed + 1))
    else
        command=("${run[@]}" --out torn --overwrite)
    fi
done
if [ -e torn/checkpoint.knead ]; then
    answers 0 run --resume torn --threads 1 -q
else
    answers 0 "${run[@]}" --out torn --overwrite -q
fi
same_as_whole torn $killed
[ $resumed -gt 0 ] || wrong "no kill found a checkpoint"
echo "$done_kills kills, $resumed runs that went on, $runs that ended among them"

cat >steps.jsonl <<'LOG'
{"frame":1,"set_gravity":{"gravity":[0,-5,0]}}
{"frame":2,"save":{"file":"steps.knead"}}
{"frame":4,"set_material":{"object":"object 0","material":"snow"}}
{"frame":5,"save":{"file":"steps.knead"}}
{"frame":7,"undo":{}}
{"frame":8,"save":{"file":"steps.knead"}}
{"frame":11,"save":{"file":"steps.knead"}}
LOG
steps=(run ball.json --device cpu --frames 12 --threads 1 --set rest.mode=sleep --mesh none -q
    --commands steps.jsonl --particles)
answers 0 "${steps[@]}" --out steps
answers 0 convert steps/steps.knead steps.ply -q
rm -rf state

# A session that was read from its file before the last kill, and its log, if there is one.
valid() {
    answers 0 session verify "$1"
    answers 0 convert "$1" clay.ply -q --overwrite
}
done_kills=0 logs=0 saved=0 runs=0
while [ $done_kills -lt "$kills" ]; do
    "$program" "${steps[@]}" --out broken --overwrite >said 2>complained </dev/null &
    process=$!
    sleep "0.$(printf %03d $((RANDOM % 500)))"
    kill -9 $process 2>/dev/null && done_kills=$((done_kills + 1))
    wait $process 2>/dev/null
    code=$?
    if [ $code -eq 0 ]; then
        runs=$((runs + 1))
        answers 0 convert broken/steps.knead clay.ply -q --overwrite
        answers 0 compare steps.ply clay.ply --tolerance 0
        cmp -s steps/particles.ply broken/particles.ply || wrong "other particles after kills"
    elif [ $code -ne 137 ]; then
        wrong "exit $code: knead ${steps[*]}"
        break
    fi
    for file in state/knead/*.log; do
        [ -e "$file" ] || continue
        # Of the first moments there is the head of a file, or less than the scene.
        if "$program" info "$file" >said 2>complained; then
            logs=$((logs + 1))
            answers 0 session verify "$file"
            grep -q 'step *1' said && valid "$file"
        else
            complains "expected a session, found none"
        fi
        rm "$file"
    done
    if [ -e broken/steps.knead ]; then
        saved=$((saved + 1))
        valid broken/steps.knead
    fi
done
[ "$logs" -gt 0 ] || wrong "no kill left a log"
[ "$saved" -gt 0 ] || wrong "no kill found a saved session"
answers 0 "${steps[@]}" --out broken --overwrite
answers 0 convert broken/steps.knead clay.ply -q --overwrite
answers 0 compare steps.ply clay.ply --tolerance 0
[ -z "$(ls state/knead)" ] || wrong "a log was left: $(ls state/knead)"
[ "$(cd broken && find . | sort)" = "$(cd steps && find . | sort)" ] ||
    wrong "left lying about: $(cd broken && find .)"
echo "$done_kills kills, $logs logs, $saved saved files, $runs runs that ended among them"
concluded
