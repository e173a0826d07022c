#!/usr/bin/env bash
# knead run --commands: a scene built by a script is the scene of a file, to the bit; bad lines and
# refusals end with exit code 3 and say where; report.json lists the objects.
# usage: tests/cli/commands_test.sh PROGRAM
set -u
. "$(dirname "$0")"/answers.sh
export OMP_NUM_THREADS=2
command -v python3 >/dev/null || { echo "no python3"; exit 77; }

domain='"schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 90'
cat >nothing.json <<SCENE
{$domain, "objects": []}
SCENE
cat >written.json <<SCENE
{$domain, "gravity": [2, -3, 0], "objects": [
  {"name": "a", "shape": "sphere", "centre": [0.1, 0.15, 0.1], "diameter": 0.08,
   "material": "snow"},
  {"name": "b", "shape": "box", "centre": [0.2, 0.2, 0.2], "size": [0.08, 0.05, 0.06],
   "rotation": [0.9238795325112867, 0, 0, 0.3826834323650898], "category": 3,
   "material": {"preset": "clay", "young": 2e5}}]}
SCENE
ball='"name":"a","shape":"sphere","centre":[0.1,0.15,0.1],"diameter":0.08'
brick='"name":"b","shape":"box","centre":[0.1,0.1,0.2],"size":[0.08,0.05,0.06],"category":2'
turned='"rotation":[0.9238795325112867,0,0,0.3826834323650898]'
cat >script.jsonl <<LOG
{"frame":0,"add_object":{"object":{$ball}}}
{"frame":0,"add_object":{"object":{"name":"gone","centre":[0.1,0.24,0.1],"diameter":0.05}}}
{"frame":0,"add_object":{"object":{$brick,"material":{"preset":"clay","young":2e5}}}}
{"frame":0,"place_object":{"object":"b","centre":[0.2,0.2,0.2],$turned}}
{"frame":0,"set_material":{"object":"a","material":"snow"}}
{"frame":0,"set_category":{"object":3,"category":3}}
{"frame":0,"set_gravity":{"gravity":[2,-3,0]}}
{"frame":0,"remove_objects":{"objects":["gone"]}}
LOG
run=(run --device cpu --frames 6 -q --mesh none)
value() { python3 -c "import json,sys; print(json.load(open(sys.argv[1]))$2)" "$1"; }

answers 0 "${run[@]}" written.json --out written
answers 0 "${run[@]}" nothing.json --commands script.jsonl --out scripted
[ "$(value written/report.json "['knead']['state_hash']")" = \
    "$(value scripted/report.json "['knead']['state_hash']")" ] ||
    wrong "a script makes other clay than a file"
[ "$(value scripted/report.json "['knead']['document']['objects'][0]['id']")" = 1 ] &&
    [ "$(value scripted/report.json "['knead']['document']['objects'][1]['id']")" = 3 ] ||
    wrong "ids of the objects"
python3 - scripted/report.json written/report.json <<'PY' || wrong "objects of the report"
import json, math, sys
a, b = [json.load(open(f))['knead']['document']['objects'] for f in sys.argv[1:]]
for x, y in zip(a, b):
    for key in ('name', 'category', 'particles', 'mass_kg', 'volume_m3', 'box_m'):
        assert x[key] == y[key], (key, x, y)
ball = a[0]
assert abs(ball['volume_m3'] / (math.pi / 6 * 0.08**3) - 1) < 0.05, ball
assert abs(a[1]['volume_m3'] / (0.08 * 0.05 * 0.06) - 1) < 0.05, a[1]
low, high = ball['box_m']
assert all(0 < l < h < 0.32 for l, h in zip(low, high)), ball
PY

# Between frames, an object that was added late, moved, and removed.
cat >later.jsonl <<'LOG'
{"frame":0,"mark":{"text":"begins"}}
{"frame":1,"add_object":{"object":{"name":"late","centre":[0.1,0.24,0.1],"diameter":0.05}}}
{"frame":2,"place_object":{"object":"late","centre":[0.12,0.24,0.1]}}
{"frame":2,"rename":{"object":"late","name":"later"}}
{"frame":3,"set_gravity":{"gravity":[0,0,0]}}
{"frame":4,"remove_objects":{"objects":["a"]}}
{"frame":4,"set_walls":{"max":[0.29,0.29,0.29],"contact_mode":"slip"}}
LOG
answers 0 "${run[@]}" written.json --commands later.jsonl --out later
python3 - later/report.json <<'PY' || wrong "objects that came and went"
import json, sys
objects = json.load(open(sys.argv[1]))['knead']['document']['objects']
assert [(o['id'], o['name']) for o in objects] == [(2, 'b'), (3, 'later')], objects
assert all(o['particles'] > 0 and o['mass_kg'] > 0 for o in objects), objects
PY
answers 0 "${run[@]}" written.json --commands later.jsonl --out again
[ "$(value later/report.json "['knead']['state_hash']")" = \
    "$(value again/report.json "['knead']['state_hash']")" ] || wrong "not reproducible"

# refused TEXT LINE: the line ends a run of written.json with exit code 3 and that text.
refused() {
    printf '{"frame":0,"mark":{"text":"first"}}\n%s\n' "$2" >bad.jsonl
    answers 3 "${run[@]}" written.json --commands bad.jsonl
    complains 'bad.jsonl:2'
    complains "$1"
}
refused '/set_gravity/gravity/1' '{"frame":0,"set_gravity":{"gravity":[0,-1e9,0]}}'
refused '/set_gravity/gravity' '{"frame":0,"set_gravity":{}}'
refused 'the nearest is "set_gravity"' '{"frame":0,"set_gravty":{"gravity":[0,0,0]}}'
refused 'weight' '{"frame":0,"set_gravity":{"gravity":[0,0,0],"weight":1}}'
refused 'no object "c"' '{"frame":0,"rename":{"object":"c","name":"d"}}'
refused 'no object 7' '{"frame":2,"rename":{"object":7,"name":"d"}}'
refused 'between the walls' '{"frame":0,"place_object":{"object":"a","centre":[0.3,0.1,0.1]}}'
refused 'between the walls' '{"frame":2,"place_object":{"object":"a","centre":[0.3,0.1,0.1]}}'
refused 'JSON' '{"frame":0,"set_gravity":'
refused '/frame' '{"frame":-1,"mark":{"text":""}}'
refused 'one command' '{"frame":0,"mark":{"text":""},"reset":{}}'
refused 'one scene' '{"frame":0,"reset":{}}'
refused 'before it begins' '{"frame":0,"set_lattice":{"cells":24}}'
refused 'in the way' '{"frame":0,"copy_objects":{"objects":["a"],"by":[0.01,0,0]}}'
refused '/scale_objects/factor' '{"frame":0,"scale_objects":{"objects":["a"],"factor":1000}}'
refused 'largest factor that fits' '{"frame":1,"scale_objects":{"objects":["a"],"factor":9}}'
refused 'between the walls' '{"frame":1,"move_objects":{"objects":["a"],"by":[5,0,0]}}'
refused '/move_objects/turn' '{"frame":1,"move_objects":{"objects":["a"],"turn":[2,0,0,0]}}'
refused '/reset_objects/objects' '{"frame":1,"reset_objects":{"objects":[]}}'
refused '/set_colour/colour' '{"frame":0,"set_colour":{"objects":["a"],"colour":[0,2,0]}}'
refused '/merge_objects/objects' '{"frame":0,"merge_objects":{"objects":["a"]}}'
refused '/split_object/pieces' '{"frame":0,"split_object":{"object":"a","pieces":true}}'
refused '/set_material/material' '{"frame":1,"set_material":{"object":"a","material":"stone"}}'
cat >ambiguous.jsonl <<'LOG'
{"frame":0,"rename":{"object":1,"name":"same"}}
{"frame":0,"rename":{"object":2,"name":"same"}}
{"frame":0,"set_category":{"object":"same","category":1}}
LOG
answers 3 "${run[@]}" written.json --commands ambiguous.jsonl
complains 'ambiguous.jsonl:3'
complains '2 objects have the name "same"'
cat >locked.jsonl <<'LOG'
{"frame":0,"set_flags":{"object":"a","locked":true}}
{"frame":1,"set_material":{"object":"a","material":"clay"}}
{"frame":2,"set_gravity":{"gravity":[0,0,0]}}
LOG
answers 3 "${run[@]}" written.json --commands locked.jsonl --out stopped
complains 'locked.jsonl:2'
complains '"a" is locked'
[ "$(value stopped/report.json "['knead']['end']")" = "command refused" ] ||
    wrong "how a refused run ends"
answers 0 "${run[@]}" written.json --commands locked.jsonl --keep-going --out kept
complains '"a" is locked'
[ "$(value kept/report.json "['knead']['frames']")" = 6 ] || wrong "frames after a refusal"

# Exports: of frame 0 and of the last, by object, in millimetres; they change nothing.
cat >export.jsonl <<'LOG'
{"frame":0,"export":{"file":"all.obj"}}
{"frame":3,"export":{"file":"a.stl","objects":["a"]}}
{"frame":6,"export":{"file":"all.glb"}}
LOG
answers 0 "${run[@]}" written.json --commands export.jsonl --out exported
[ "$(value written/report.json "['knead']['state_hash']")" = \
    "$(value exported/report.json "['knead']['state_hash']")" ] || wrong "an export changes the run"
[ "$(grep '^o ' exported/all.obj | tr '\n' ';')" = 'o a;o b;' ] || wrong "names in an OBJ"
python3 - exported/a.stl exported/all.glb <<'PY' || wrong "what was exported"
import json, struct, sys
stl, glb = [open(f, 'rb').read() for f in sys.argv[1:]]
assert stl.startswith(b'knead; millimetres '), stl[:20]
count, = struct.unpack_from('<I', stl, 80)
assert count > 100 and len(stl) == 84 + 50 * count, count
x = [struct.unpack_from('<12f', stl, 84 + 50 * k)[3::3] for k in range(count)]
across = max(map(max, x)) - min(map(min, x))
assert abs(across - 80) < 20, across
document = json.loads(glb[20:20 + struct.unpack_from('<I', glb, 12)[0]])
assert [n['name'] for n in document['nodes']] == ['a', 'b'], document['nodes']
assert [m['name'] for m in document['meshes']] == ['a', 'b'], document['meshes']
PY
refused 'expected a name that ends in .3mf, .glb' '{"frame":1,"export":{"file":"a.step"}}'
refused '/export/objects: refused: there is no object "c"' \
    '{"frame":1,"export":{"file":"a.glb","objects":["c"]}}'
refused 'no splats' '{"frame":1,"export":{"file":"a.spz"}}'
refused '/export/unit' '{"frame":1,"export":{"file":"a.glb","unit":"foot"}}'
refused 'at least one object' '{"frame":1,"export":{"file":"a.glb","objects":[]}}'
echo '{"frame":1,"export":{"file":"none/a.glb"}}' >nowhere.jsonl
answers 5 "${run[@]}" written.json --commands nowhere.jsonl --out unwritten
complains 'none/a.glb: '
echo '{"frame":1,"export":{"file":"a.glb"}}' >bare.jsonl
answers 3 "${run[@]}" nothing.json --commands bare.jsonl
complains 'there is nothing to export'

answers 3 "${run[@]}" nothing.json
complains 'expected an array of 1 to 256 objects'
answers 3 "${run[@]}" written.json --commands missing.jsonl
answers 2 "${run[@]}" written.json --keep-going
: >empty.jsonl
answers 0 "${run[@]}" written.json --commands empty.jsonl --out same
[ "$(value written/report.json "['knead']['state_hash']")" = \
    "$(value same/report.json "['knead']['state_hash']")" ] || wrong "an empty log changes the run"

concluded
