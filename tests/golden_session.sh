#!/usr/bin/env bash
# Makes the session that later builds must read, tests/golden/session_v1.knead. It is made anew for
# a new version of the format only, under another name; the older ones stay.
# usage: tests/golden_session.sh PROGRAM OUT
set -eu
program=$(realpath "${1:?usage: $0 PROGRAM OUT}")
out=$(realpath "${2:?usage: $0 PROGRAM OUT}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_STATE_HOME=$folder/state
cd "$folder"
"$program" record squeeze hands.hands --seconds 0.1 -q
cat >golden.json <<'SCENE'
{"schema": "knead.scene/1", "name": "golden", "domain": {"edge": 0.32, "cells": 16},
 "frame_rate": 90, "gravity": [0, -9.81, 0], "surface": {"nodes": 16},
 "hands": {"recording": "hands.hands", "at": [0.16, 0.08, 0.16], "zoom": 0.5},
 "objects": [{"name": "ball", "shape": "sphere", "centre": [0.16, 0.08, 0.16], "diameter": 0.06,
              "material": "clay", "velocity": [0.1, 0, 0]}]}
SCENE
brick='"name":"brick","shape":"box","centre":[0.1,0.2,0.1],"size":[0.03,0.02,0.03],"category":2'
cat >script.jsonl <<LOG
{"frame":1,"add_object":{"object":{$brick,"material":"snow"}}}
{"frame":3,"rename":{"object":"ball","name":"renamed"}}
{"frame":4,"set_gravity":{"gravity":[0,5,0]}}
{"frame":6,"undo":{}}
{"frame":7,"set_material":{"object":"brick","material":"clay"}}
{"frame":9,"remove_objects":{"objects":["brick"]}}
{"frame":11,"undo":{}}
{"frame":11,"save":{"file":"golden.knead"}}
LOG
"$program" run --device cpu --threads 1 --frames 12 -q --mesh none golden.json \
    --commands script.jsonl --out made
cp made/golden.knead "$out"
