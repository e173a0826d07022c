#!/usr/bin/env bash
# Undo, redo and sessions of a run with commands: a saved session opens, replays to the bit, is
# described, converted, verified and compacted; damaged files are refused.
# usage: tests/cli/session_test.sh PROGRAM
set -u
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=2 XDG_STATE_HOME=$folder/state
command -v python3 >/dev/null || { echo "no python3"; exit 77; }

cat >nothing.json <<SCENE
{"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90,
 "gravity": [0, 0, 0], "hands": {"recording": "squeeze", "at": [0.16, 0.16, 0.16]}, "objects": []}
SCENE
ball='"name":"a","shape":"sphere","centre":[0.16,0.16,0.16],"diameter":0.1'
brick='"name":"b","shape":"box","centre":[0.1,0.26,0.1],"size":[0.06,0.04,0.06],"category":2'
cat >script.jsonl <<LOG
{"frame":0,"add_object":{"object":{$ball,"material":"clay"}}}
{"frame":0,"add_object":{"object":{$brick}}}
{"frame":120,"undo":{}}
{"frame":125,"redo":{}}
{"frame":130,"set_material":{"object":"a","material":"snow"}}
{"frame":140,"save":{"file":"made.knead"}}
LOG
value() { python3 -c "import json,sys; print(json.load(open(sys.argv[1]))$2)" "$1"; }
run=(run --device cpu --frames 140 -q --mesh none --audit 140)

answers 0 "${run[@]}" nothing.json --commands script.jsonl --out made
python3 - made/report.json <<'PY' || wrong "the history of the report"
import json, sys
history = json.load(open(sys.argv[1]))['knead']['history']
assert history['steps'] >= 5, history
assert history['current'] == history['steps'] - 1, history
assert 0 < history['bytes'] < 1 << 28, history
PY
[ -e state/knead ] && [ -z "$(ls state/knead)" ] || wrong "a log was left: $(ls state/knead)"

answers 0 replay made/made.knead --check --json
[ "$(cat said)" = '{"frames":140,"equal":true}' ] || wrong "the answer of a check: $(cat said)"
answers 0 replay made/made.knead --check -q
holds said '140 frames, equal; compared: 141'
answers 0 info made/made.knead --json
python3 - said <<'PY' || wrong "what info says"
import json, sys
facts = json.load(open(sys.argv[1]))
assert facts['kind'] == 'session' and facts['frames'] == 140, facts
labels = [s['label'] for s in facts['steps']]
assert labels[:3] == ['', 'Add object', 'Add object'] and 'Press' in labels, labels
assert labels[-1] == 'Material', labels
assert [o['name'] for o in facts['objects']] == ['a', 'b'], facts
assert facts['hand_frames'] > 60, facts
PY

# Commands that read the clay, before the first frame as between frames: the saved session replays.
cat >parts.json <<SCENE
{"schema": "knead.scene/1", "domain": {"edge": 0.64, "cells": 32}, "frame_rate": 90,
 "objects": []}
SCENE
cut='"point":[0.16,0.17,0.16],"normal":[0,1,0]'
cat >parts.jsonl <<LOG
{"frame":0,"add_object":{"object":{$ball,"material":"clay"}}}
{"frame":0,"scale_objects":{"objects":["a"],"factor":2}}
{"frame":0,"copy_objects":{"objects":["a"],"by":[0.26,0.02,0],"names":["b"]}}
{"frame":0,"set_gravity":{"gravity":[0,-1,0]}}
{"frame":10,"split_object":{"object":"a","plane":{$cut},"names":["l","r"]}}
{"frame":12,"merge_objects":{"objects":["b","l"],"name":"c"}}
{"frame":14,"undo":{}}
{"frame":15,"redo":{}}
{"frame":16,"split_object":{"object":"c","pieces":true}}
{"frame":18,"scale_objects":{"objects":["c","r"],"factor":0.6}}
{"frame":18,"set_colour":{"objects":["c"],"colour":[0.2,0.4,0.8]}}
{"frame":19,"move_objects":{"objects":["c","r"],"by":[0,0.01,0],"turn":[0.96,0,0.28,0]}}
{"frame":20,"save":{"file":"parts.knead"}}
LOG
answers 0 run --device cpu --frames 20 -q --mesh none parts.json --commands parts.jsonl --out parts
python3 - parts/report.json <<'PY' || wrong "objects of the parts"
import json, math, sys
objects = json.load(open(sys.argv[1]))['knead']['document']['objects']
assert [o['name'] for o in objects] == ['r', 'c', 'c 2'], objects
assert [o['id'] for o in objects] == [1, 2, 4], objects
ball = math.pi / 6 * 0.2**3
for o, share in zip(objects, (0.63 * 0.6**3, 0.6**3, 0.37)):
    assert abs(o['volume_m3'] / (share * ball) - 1) < 0.05, o
PY
answers 0 replay parts/parts.knead --check --json
[ "$(cat said)" = '{"frames":20,"equal":true}' ] || wrong "the check of parts: $(cat said)"

# The session that comes with the program: on another kind of CPU its bits are others.
answers 0 replay two-lumps.knead --check --json
python3 - said <<'PY' || wrong "the replay of scenes/two-lumps.knead: $(cat said)"
import json, sys
said = json.load(open(sys.argv[1]))
assert said['frames'] == 200, said
assert said['equal'] or all(d['rms_m'] < 0.01 for d in said['distances']), said
PY

# Export: hands, and the clay of a step and of the end.
answers 0 replay made/made.knead --to 2 --particles two.ply --record hands.jsonl -q
answers 0 info two.ply
answers 0 info hands.jsonl
answers 0 convert made/made.knead hands.hands -q
answers 0 convert made/made.knead end.ply -q
answers 0 replay made/made.knead --particles replayed.ply --mesh end.obj -q
answers 0 compare end.ply replayed.ply --tolerance 0
answers 3 replay made/made.knead --to 99 -q
complains 'no step 99'
answers 2 replay made/made.knead --to nine -q

# Undo restores what was there: the state of a step is the same on both ways to it.
cat >still.json <<SCENE
{"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90,
 "objects": []}
SCENE
undone() { # NAME FRAMES COMMANDS...: particles at the end
    local name=$1 frames=$2
    shift 2
    printf '%s\n' "$@" >$name.jsonl
    answers 0 run --device cpu -q --mesh none still.json --commands $name.jsonl --out $name \
        --frames $frames --particles --audit $frames
}
adds="{\"frame\":0,\"add_object\":{\"object\":{$ball}}}"
undone once 21 "$adds" '{"frame":10,"set_gravity":{"gravity":[0,5,0]}}' '{"frame":20,"undo":{}}'
undone twice 43 "$adds" '{"frame":10,"set_gravity":{"gravity":[0,5,0]}}' '{"frame":20,"undo":{}}' \
    '{"frame":30,"redo":{}}' '{"frame":40,"undo":{}}' '{"frame":41,"redo":{}}' \
    '{"frame":42,"undo":{}}'
answers 0 compare once/particles.ply twice/particles.ply --tolerance 0
undone gone 12 "$adds" "{\"frame\":0,\"add_object\":{\"object\":{$brick}}}" '{"frame":11,"undo":{}}'
[ "$(value gone/report.json "['knead']['document']['objects'][-1]['name']")" = a ] ||
    wrong "an object stays that was undone"
undone first 12 "$adds" '{"frame":11,"go_to":{"step":0}}'
[ "$(value first/report.json "['knead']['document']['objects']")" = '[]' ] ||
    wrong "the beginning has objects"
refused() {
    printf '%s\n' "$2" >bad.jsonl
    answers 3 run --device cpu --frames 6 -q --mesh none ball.json --commands bad.jsonl
    complains "$1"
}
refused 'nothing to undo' '{"frame":2,"undo":{}}'
refused 'nothing to redo' '{"frame":2,"redo":{}}'
refused 'no step 7' '{"frame":2,"go_to":{"step":7}}'
refused '.knead' '{"frame":2,"save":{"file":"made.json"}}'

# Files.
answers 0 session verify made/made.knead
holds said 'valid; 140 frames'
answers 0 session compact made/made.knead --out small.knead
answers 0 session verify small.knead
[ "$(stat -c %s small.knead)" -lt "$(stat -c %s made/made.knead)" ] || wrong "compact is no smaller"
answers 0 convert small.knead small.ply -q
answers 0 compare end.ply small.ply --tolerance 0
answers 0 session list
holds said 'nothing to recover'
head -c 150 made/made.knead >cut.knead
answers 3 session verify cut.knead
head -c 20 made/made.knead >short.knead
answers 3 info short.knead
python3 - made/made.knead flipped.knead <<'PY'
import sys
data = bytearray(open(sys.argv[1], 'rb').read())
data[len(data) // 2] ^= 8
open(sys.argv[2], 'wb').write(data)
PY
answers 3 session verify flipped.knead
answers 3 session verify ball.json

# The checkpoint of a run that was stopped is a session, too.
for limit in 0.004 0.008 0.016 0.03 0.06 0.12 0.25 0.5 1; do
    answers 0 run ball.json --device cpu --frames 60 -q --mesh none --out stopped --overwrite \
        --time-limit $limit
    [ ! -e stopped/checkpoint.knead ] || break
done
cp stopped/checkpoint.knead stopped.knead
answers 0 info stopped.knead --json
python3 - said "$folder/ball.json" <<'PY' || wrong "what info says of a checkpoint"
import json, sys
facts = json.load(open(sys.argv[1]))
assert facts['kind'] == 'checkpoint' and facts['scene'] == sys.argv[2], facts
assert 0 < facts['frames'] < facts['frames_wanted'] == 60, facts
PY
answers 0 session verify stopped.knead
holds said 'valid; 0 frames'
answers 0 convert stopped.knead stopped.ply -q
answers 3 replay stopped.knead -q
complains 'no events to compute again'
cp made/made.knead stopped/checkpoint.knead
answers 3 run --resume stopped -q
complains 'expected a checkpoint of a run, found another session'
answers 0 session compact stopped.knead --out stopped/checkpoint.knead --overwrite
answers 0 run --resume stopped -q
[ ! -e stopped/checkpoint.knead ] || wrong "the run ended, but not its checkpoint"
printf 'knead.checkpoint and more than that' >older.knead
answers 3 session verify older.knead
complains 'is a checkpoint of an older knead, and no session'
answers 3 view older.knead
complains 'is a checkpoint of an older knead, and no session'
printf '{"frame":2,"save":{"file":"x.knead"}}\n' >save.jsonl
mkdir -p full && chmod 500 full
if [ "$(id -u)" != 0 ]; then
    printf '{"frame":2,"save":{"file":"%s/full/x.knead"}}\n' "$folder" >save.jsonl
    answers 5 run --device cpu --frames 3 -q --mesh none ball.json --commands save.jsonl
fi
concluded
