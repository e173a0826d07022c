#!/usr/bin/env bash
# `knead view` on a screen that is memory alone (Xvfb): a scripted mouse presses a hand into a ball;
# the clay moves, pictures are made, OpenGL is content. Without a screen it says so.
# usage: tests/cli/view_test.sh PROGRAM
set -u
knead=$1
out=$(mktemp -d)
screen=
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
0.6 button left down
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
grep -q "about .* s a frame on this machine" "$out/errors.txt" || fail "no time of a frame is said"
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
cat "$out/said.txt"
