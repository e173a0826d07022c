#!/usr/bin/env bash
# The other lane: `knead vr` by GLX under X11, watched by the distribution's validation layer, which
# must have nothing to say. Skipped where Xvfb or the layer is missing.
# usage: tests/xr/validation.sh KNEAD RUNTIME.json
set -u
program=$1 runtime=$2
layers=/usr/share/openxr/1/api_layers/explicit.d
skip() { echo "$1: left out"; exit 77; }
command -v Xvfb >/dev/null || skip "Xvfb is not here"
grep -qs core_validation "$layers"/*.json || skip "the core_validation layer is not here"

folder=$(mktemp -d)
# Xvfb finds a free display by itself, and tells which.
Xvfb -displayfd 3 -screen 0 640x480x24 -noreset 3>"$folder/display" 2>"$folder/xvfb" &
server=$!
trap 'kill $server 2>/dev/null; wait $server 2>/dev/null; rm -rf "$folder"' EXIT
for _ in $(seq 100); do
    [ -s "$folder/display" ] && break
    sleep 0.1
done
[ -s "$folder/display" ] || skip "Xvfb does not start"

# The layer is older than two of the extensions, and takes their structs for faults.
cat >"$folder/script.json" <<END
{"hands": "scenes/squeeze.hands", "width": 64, "height": 64, "render_every": 15,
 "without": ["XR_EXT_hand_tracking_data_source", "XR_EXT_user_presence"],
 "controllers": [{"side": "right", "from": 0.2, "to": 0.5, "at": [0.2, 0, 0.1]}],
 "faults": [{"kind": "lose_session", "frame": 20}],
 "log": "$folder/log"}
END
DISPLAY=:$(cat "$folder/display") XR_RUNTIME_JSON=$runtime \
    KNEAD_REPLAY_SCRIPT=$folder/script.json \
    XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation \
    XR_CORE_VALIDATION_EXPORT_TYPE=text XR_CORE_VALIDATION_FILE_NAME=$folder/said \
    "$program" vr scenes/squeeze.json --set domain.cells=16 --set surface.nodes=16 --device cpu \
    --binding glx --deterministic --place 0,0,0 --frames 40 --json --quiet \
    >"$folder/report" 2>"$folder/messages"
code=$?

failed=0
expect() { [ "$2" = "$3" ] || { echo "$1: expected $2, found $3"; failed=1; }; }
expect "exit code" 0 $code
expect "what the layer said" "" "$(cat "$folder/said" 2>/dev/null)"
expect "the layer was there" 1 "$(grep -c 'Core Validation output' "$folder/report" \
    "$folder/messages" | awk -F: '$2 > 0 { n = 1 } END { print n + 0 }')"
expect "wrong calls" 0 "$(sed -n '$s/.*"wrong":\([0-9]*\).*/\1/p' "$folder/log")"
expect "binding" 1 "$(grep -c '"binding": "GLX"' "$folder/report")"
expect "GL errors" 1 "$(grep -c '"gl_errors": 0' "$folder/report")"
expect "sessions begun anew" 1 "$(sed -n 's/.*"renewals": \([0-9]*\).*/\1/p' "$folder/report")"
[ $failed -eq 0 ] || cat "$folder/messages"
exit $failed
