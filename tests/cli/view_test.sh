#!/usr/bin/env bash
# `knead view` on a screen that is memory alone (Xvfb): a scripted mouse presses a hand into a ball;
# the clay moves, pictures are made, OpenGL is content. Without a screen it says so.
# usage: tests/cli/view_test.sh PROGRAM
set -u
knead=$1
out=$(mktemp -d)
screen=
export XDG_STATE_HOME=$out/state
trap '[ -z "$screen" ] || kill "$screen" 2>/dev/null; rm -rf "$out"' EXIT
fail() { echo "FAILED: $*"; cat "$out"/*.txt 2>/dev/null; exit 1; }

env -u DISPLAY -u WAYLAND_DISPLAY "$knead" view scenes/squeeze.json >"$out/none.txt" 2>&1
[ $? -eq 4 ] && grep -q "no window" "$out/none.txt" || fail "no screen: exit code 4 and a reason"
"$knead" view scenes/squeeze.json --size 12 >"$out/size.txt" 2>&1
[ $? -eq 2 ] || fail "a size without sense is wrong usage"

command -v Xvfb >/dev/null || { echo "no Xvfb"; exit 77; }
if grep -q "configured without" "$out/none.txt"; then echo "no window in this build"; exit 77; fi
mkfifo "$out/number"
exec 3<>"$out/number"
Xvfb -displayfd 3 -screen 0 640x480x24 -nolisten tcp >"$out/xvfb.txt" 2>&1 &
screen=$!
read -t 30 -u 3 number || { echo "Xvfb does not start"; exit 77; }
export DISPLAY=:$number

cat >"$out/press" <<END
0 move 200 120
0.02 screenshot $out/begin.png
0.03 key h tap
0.04 key tab tap
0.3 button left down
0.85 lose
END
small=(--cells 16 --set surface.nodes=32 --size 320x240 --device cpu)
"$knead" view scenes/squeeze.json "${small[@]}" --script "$out/press" --frames 80 \
    --screenshot "$out/end.png" >"$out/said.txt" 2>"$out/errors.txt"
rc=$?
if grep -q "OpenGL 4.5" "$out/errors.txt"; then cat "$out/errors.txt"; exit 77; fi
[ $rc -eq 0 ] || fail "exit code $rc"
grep -q "^80 frames drawn by .* 80 simulated.* 0 cut short.* 0 OpenGL errors" "$out/said.txt" ||
    fail "what was said"
grep -q " 0 particle-substeps" "$out/said.txt" && fail "the hand touched nothing"
grep -q " a frame on this machine" "$out/errors.txt" || fail "no time of a frame is said"
[ -s "$out/begin.png" ] && [ -s "$out/end.png" ] || fail "no pictures"
cmp -s "$out/begin.png" "$out/end.png" && fail "the pictures are the same"

# The same script gives the same clay, and --cells what --set gives.
before=$(grep -o "[0-9]* particle-substeps" "$out/said.txt")
"$knead" view scenes/squeeze.json --set domain.cells=16 "${small[@]:2}" --script "$out/press" \
    --frames 80 --screenshot "$out/again.png" >"$out/said.txt" 2>"$out/errors.txt"
grep -q "begin.png" "$out/errors.txt" && fail "$(cat "$out/errors.txt")"
grep -q " $before" "$out/said.txt" || fail "another run of the script: not $before"
cmp -s "$out/end.png" "$out/again.png" || fail "another run of the script: another picture"

# By keys: a film by an ffmpeg that keeps its pictures as they are, a picture, a pause, a step, a
# turn; what is made without a name gets the first that is free.
mkdir "$out/bin" "$out/here"
printf '#!/bin/sh\nfor to; do :; done\nexec cat >"${to#file:}"\n' >"$out/bin/ffmpeg"
chmod +x "$out/bin/ffmpeg"
cat >"$out/keys" <<END
0.1 key v tap
0.15 key f12 tap
0.2 key e down
0.25 key t down
0.3 key e up
0.32 key t up
0.4 key v tap
0.45 key p tap
0.46 key home tap
0.5 key space tap
0.6 key n tap
0.7 key v tap
END
knead=$(realpath "$knead")
tree=$PWD
(cd "$out/here" && PATH=$out/bin:$PATH "$knead" view "$tree/scenes/squeeze.json" "${small[@]}" \
    --script "$out/keys" --frames 80) >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] || fail "view by keys"
simulated=$(sed -n 's/^80 frames drawn by .* \([0-9]*\) simulated.*/\1/p' "$out/said.txt")
[ "$simulated" -ge 40 ] && [ "$simulated" -le 50 ] || fail "$simulated simulated, paused at 0.5 s"
[ "$(cd "$out/here" && echo *)" = "knead_0001.mp4 knead_0001.png knead_0002.mp4" ] ||
    fail "made: $(ls "$out/here")"
# 30 a second, 0.3 s; the other one until the end, 0.19 s.
pictures=$(($(stat -c %s "$out/here/knead_0001.mp4") / (3 * 320 * 240)))
[ $pictures -ge 8 ] && [ $pictures -le 11 ] || fail "a film of $pictures pictures"
[ -s "$out/here/knead_0002.mp4" ] || fail "no film where it is not ended"

# --out and --record keep what a session made, as those of `knead vr` do: the same clay comes of the
# recorded hands, to the bit, and of a gravity that was changed on the way.
cat >"$out/led" <<END
0 move 200 120
0 key h tap
0 key tab tap
0.1 key control down
0.1 key h tap
0.1 key control up
0.3 key space tap
0.35 key n tap
0.4 key space tap
0.5 button left down
END
same=("${small[@]:0:4}" --device cpu)
"$knead" view scenes/squeeze.json "${small[@]}" --set deterministic=true --script "$out/led" \
    --frames 90 --out "$out/kept" --record "$out/mine.hands" >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] || fail "view --out"
[ "$(ls -m "$out/kept")" = "hands.hands, hands.hands.commands, mesh.glb, view.json" ] ||
    fail "kept: $(ls -m "$out/kept")"
cmp -s "$out/kept/hands.hands" "$out/mine.hands" || fail "--record is not hands.hands"
# Control with R is not R: nothing began anew. Paused for 9 frames but one.
number() { sed -n "s/.*\"$2\": \([0-9.]*\),*/\1/p" "$1" | tail -n 1; }
hash_of() { sed -n 's/.*"state_hash": "\([0-9a-f]*\)".*/\1/p' "$1" | tail -n 1; }
frames=$(sed -n 's/^90 frames drawn by .* \([0-9]*\) simulated.*/\1/p' "$out/said.txt")
[ "$frames" = 82 ] || fail "$frames frames, paused for 8"
grep -q " 0 particle-substeps" "$out/said.txt" && fail "the hand that is recorded touched nothing"
"$knead" run scenes/squeeze.json "${same[@]}" --set deterministic=true --frames "$frames" -q \
    --hands "$out/mine.hands" --out "$out/played" >/dev/null 2>"$out/errors.txt" ||
    fail "run of what view recorded"
[ -n "$(hash_of "$out/kept/view.json")" ] &&
    [ "$(hash_of "$out/kept/view.json")" = "$(hash_of "$out/played/report.json")" ] ||
    fail "run of what view recorded: another state"
"$knead" view scenes/squeeze.json "${small[@]}" --frames 1 --out "$out/kept" >"$out/said.txt" \
    2>"$out/errors.txt"
[ $? -eq 5 ] && grep -q -- "--overwrite" "$out/errors.txt" || fail "results that are there"
"$knead" view scenes/squeeze.json "${small[@]}" --frames 1 --record "$out/mine.txt" \
    >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 2 ] || fail "--record with another ending is wrong usage"

# Ctrl+R begins the scene anew at once: undo takes it back. The mouse still leads: its hand, which
# had touched nothing, now does, and the recorded ones do not come back.
cat >"$out/anew" <<END
0 move 200 120
0 key h tap
0 key tab tap
0.12 key control down
0.12 key r tap
0.12 key control up
0.4 button left down
END
"$knead" view scenes/squeeze.json "${small[@]}" --script "$out/anew" --frames 90 --overwrite \
    --out "$out/kept" >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] || fail "view with a reset"
frames=$(sed -n 's/^90 frames drawn by .* \([0-9]*\) simulated.*/\1/p' "$out/said.txt")
[ "$frames" -ge 75 ] && [ "$frames" -le 80 ] || fail "$frames frames after a reset at the 12th"
grep -q " 0 particle-substeps" "$out/said.txt" && fail "after a reset the hand touches nothing"
grep -q '"mark":{"text":"reset"}' "$out/kept/hands.hands.commands" ||
    fail "a reset that is not recorded"

# Escape takes back the press under way, and the button has no effect until it is up.
cat >"$out/cancel" <<END
0 move 200 120
0 key h tap
0 key tab tap
0.5 button left down
1.1 key escape tap
END
"$knead" view scenes/squeeze.json "${small[@]}" --script "$out/cancel" --frames 130 --overwrite \
    --out "$out/kept" >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] || fail "view with a press that is cancelled"
grep -q " 0 particle-substeps" "$out/said.txt" && fail "the press touched nothing"
grep -q '"undo":{}' "$out/kept/hands.hands.commands" || fail "escape did not undo the press"

# A signal writes them, too. Paused and untouched the window costs next to nothing: of some two
# seconds, soon, no more than 3 % of a core.
ticks() { awk '{ print $14 + $15 }' "/proc/$1/stat"; }
for signal in TERM:143 HUP:129 INT:130; do
    "$knead" view scenes/squeeze.json "${small[@]}" --paused --out "$out/${signal%:*}" \
        >"$out/said.txt" 2>"$out/errors.txt" &
    window=$!
    calm=
    for _ in $(seq 30); do
        before=$(ticks $window)
        sleep 2
        spent=$(($(ticks $window) - before))
        if [ -s "$out/errors.txt" ] && [ "$spent" -le 6 ]; then calm=yes && break; fi
    done
    kill "-${signal%:*}" $window
    wait $window
    [ $? -eq "${signal#*:}" ] || fail "$signal: another exit code"
    [ -n "$calm" ] || fail "a window that is paused: $spent ticks of the last 200"
    [ -s "$out/${signal%:*}/mesh.glb" ] && [ -s "$out/${signal%:*}/view.json" ] ||
        fail "$signal: $(ls -m "$out/${signal%:*}")"
done

# A session goes on: its log begins with the session, undo and save act by keys, and settings and
# damaged files are refused. A scripted window without a session keeps no log.
[ -z "$(find "$out/state" -name '*.log' -size +0 -newer "$out/led" 2>/dev/null | head -n 1)" ] ||
    rm -f "$out"/state/knead/*.log # of the windows that got signals
echo '{"frame":5,"set_gravity":{"gravity":[0,-3,0]}}
{"frame":8,"save":{"file":"clay.knead"}}' >"$out/script.jsonl"
"$knead" run scenes/squeeze.json "${same[@]}" --frames 8 -q --commands "$out/script.jsonl" \
    --out "$out/session" >"$out/said.txt" 2>"$out/errors.txt" || fail "no session"
clay=$out/session/clay.knead
cat >"$out/go_on" <<END
0.05 key control down
0.05 key z tap
0.05 key s tap
0.05 key control up
END
"$knead" view "$clay" --device cpu --size 320x240 --script "$out/go_on" --frames 20 \
    --out "$out/gone_on" >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] || fail "view of a session"
"$knead" session verify "$clay" >"$out/said.txt" 2>"$out/errors.txt" ||
    fail "a session that the window saved"
"$knead" replay "$clay" --check -q >"$out/said.txt" 2>"$out/errors.txt" ||
    fail "another replay than what the window saved"
grep -q '"undo":{}' "$out/gone_on"/*.commands 2>/dev/null || fail "Ctrl+Z is no undo"
[ -z "$(find "$out/state/knead" -name '*.log')" ] ||
    fail "a log that is saved was left: $(ls "$out/state/knead")"
grep -q '"[^"]*clay.knead"' "$out/state/knead/recent.json" || fail "the session is no recent file"
# What is not saved is asked about: escape keeps the window; so does a question without an answer.
cat >"$out/ask" <<END
0.05 key control down
0.05 key r tap
0.05 key control up
0.1 close
0.15 key escape tap
0.2 close
END
"$knead" view "$clay" --device cpu --size 320x240 --script "$out/ask" --frames 30 \
    >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] && grep -q "^30 frames drawn" "$out/said.txt" || fail "closed without a question"
echo "0.1 close" >"$out/close"
"$knead" view "$clay" --device cpu --size 320x240 --script "$out/close" --frames 30 \
    >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] && grep -q "^[0-9] frames drawn" "$out/said.txt" || fail "a question about nothing"
"$knead" view "$clay" --set surface.nodes=24 >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 2 ] && grep -q -- "--set: a session" "$out/errors.txt" || fail "settings of a session"
head -c 100 "$clay" >"$out/cut.knead"
"$knead" view "$out/cut.knead" >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 3 ] || fail "a session that is cut: $(cat "$out/errors.txt")"

: >"$out/still"
# Splats: a floor that stands still becomes clay at the recorded rod, a pot is squeezed and split.
for scene in "ground --set domain.cells=32" "pot --set domain.cells=24 --set splats.split.limit=1.2"
do
    # shellcheck disable=SC2086
    "$knead" view scenes/${scene%% *}.json ${scene#* } --set surface.nodes=24 --size 160x120 \
        --device cpu --script "$out/still" --frames 40 --bare --screenshot "$out/${scene%% *}.png" \
        >"$out/said.txt" 2>"$out/errors.txt"
    [ $? -eq 0 ] || fail "view of ${scene%% *}"
    grep -q "^40 frames drawn by .* 40 simulated.* 0 OpenGL errors" "$out/said.txt" ||
        fail "what was said of ${scene%% *}"
    [ -s "$out/${scene%% *}.png" ] || fail "no picture of ${scene%% *}"
    grep -q "; [1-9][0-9]* splats" "$out/said.txt" || fail "no splats of ${scene%% *}"
done
# An empty table, with a scene's name or without; splats on it; asking to close ends it.
echo "0.2 close" >"$out/close"
for scene in "" new scenes/pot.spz; do
    # shellcheck disable=SC2086
    "$knead" view $scene --cells 16 --size 160x120 --device cpu --script "$out/close" \
        --out "$out/table" --overwrite >"$out/said.txt" 2>"$out/errors.txt"
    [ $? -eq 0 ] || fail "view of a table: $scene"
    grep -q "^1[0-9] frames drawn by .* 0 OpenGL errors" "$out/said.txt" || fail "no close: $scene"
    [ "$(number "$out/table/view.json" particles)" -gt 0 ] && has=clay || has=nothing
    case $scene in
        *.spz) [ $has = clay ] && grep -q "; [1-9][0-9]* splats" "$out/said.txt" ;;
        *) [ $has = nothing ] ;;
    esac || fail "the table of \"$scene\" has $has"
done
# G, R and S: one command at the end of a move; none of those that are cancelled or cannot be.
cat >"$out/lift" <<END
0 move 200 120
0 key tab tap
0.05 key g tap
0.06 key y tap
0.07 text 5
0.1 key enter tap
0.15 key s tap
0.16 text 3
0.18 key escape tap
0.2 key r tap
0.21 key x tap
0.22 text 90
0.24 button right tap
0.25 key s tap
0.26 text 1000
0.28 key enter tap
END
"$knead" view scenes/squeeze.json "${small[@]}" --script "$out/lift" --frames 40 --overwrite \
    --out "$out/lifted" >"$out/said.txt" 2>"$out/errors.txt"
[ $? -eq 0 ] || fail "moving an object"
[ "$(grep -c '"frame"' "$out/lifted"/*.commands)" -eq 1 ] &&
    grep -q '"move_objects":{"by":\[0.0,0.05,0.0\],"objects":\[1\]}' "$out/lifted"/*.commands ||
    fail "the commands of a move: $(cat "$out/lifted"/*.commands)"
cat "$out/said.txt"
