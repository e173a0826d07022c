#!/usr/bin/env bash
# The program's other verbs on the files that it writes itself: record, info, convert, compare,
# verify, bench; and what they answer where a file is another, or is there already.
# usage: tests/cli/verbs_test.sh PROGRAM
set -u
scenes=$(realpath "$(dirname "$0")/../../scenes")
. "$(dirname "$0")"/answers.sh

# Hands by script, the same by the same seed, in both formats.
for gesture in squeeze imprint poke cut pinch roll flatten knead; do
    answers 0 record $gesture $gesture.hands --seconds 0.5
    holds said "$gesture"
done
answers 0 record squeeze noisy.hands --jitter 0.001 --dropouts 0.05 --seed 3 --rate 60 -q
answers 0 record squeeze again.hands --jitter 0.001 --dropouts 0.05 --seed 3 --rate 60 -q
cmp -s noisy.hands again.hands || wrong "another recording by the same seed"
cmp -s noisy.hands squeeze.hands && wrong "noise changes nothing"
answers 0 convert noisy.hands noisy.jsonl
answers 0 convert noisy.jsonl back.hands -q
cmp -s noisy.hands back.hands || wrong "a recording is another after .jsonl"
answers 2 record squeeze hands.txt
answers 3 record sqeeze typo.hands
complains 'the nearest is "squeeze"'
answers 2 record --live mine.hands
complains 'knead vr SCENE --record mine.hands'
answers 2 record squeeze
answers 5 record squeeze squeeze.hands
answers 0 record squeeze squeeze.hands --overwrite
answers 5 record squeeze absent/squeeze.hands
complains 'absent/squeeze.hands: cannot be written: No such file or directory'
# Half a recording never has a name that may be the user's; a link stays, and is written through.
printf mine >squeeze.hands.partial
ln -s aimed.hands link.hands
answers 5 record squeeze link.hands
[ ! -e aimed.hands ] || wrong "a link that is there was followed unasked"
answers 0 record squeeze link.hands --seconds 0.5 --overwrite
[ -L link.hands ] && [ -s aimed.hands ] || wrong "a link is no link after it was written through"
[ "$(cat squeeze.hands.partial)" = mine ] || wrong "a file of the user's was overwritten"
answers 5 record squeeze absent/squeeze.jsonl

# An object of splats, squeezed: described, drawn, and written as deformed.
pot="$scenes/pot.json --set domain.cells=16 --set objects.0.per_cell=2"
answers 0 info $pot
holds said 'splats_inside +[1-9]'
answers 0 run $pot --device cpu --frames 2 --pictures 2 --mesh none --splats spz --out pot
holds said 'splats +[0-9]+, [1-9][0-9]* of them interior'
[ -s pot/splats.spz ] || wrong "no splats were written"
answers 0 info pot/splats.spz
answers 0 convert pot/splats.spz pot/splats.glb
grep -aq KHR_gaussian_splatting pot/splats.glb || wrong "no splats in a GLB"
answers 2 run $pot --device cpu --splats obj
complains '--splats: expected ply, compressed.ply, splat, spz, sog, glb or none, found "obj"'

# A scene of splats that stands still.
ground="$scenes/ground.json --set domain.cells=16"
answers 0 run $ground --device cpu --frames 3 --pictures 3 --mesh none --splats spz --out ground
complains 'what a frame takes depends on the hands'
answers 0 info $ground
holds said 'frame_wall_s +null$'
holds said 'frame_wall_s_per_1000_local +([0-9.e-]+|null)$'
answers 0 info ground/splats.spz
holds said 'splats +20000'
answers 2 run $ground --device cpu:double --frames 1
complains 'local clay is not available'

# Runs to look at: with all that can be written, and one that differs.
answers 0 run ball.json --device cpu --frames 3 --out one --particles --pictures 1 -v
holds complained 'frame 2: [0-9]+ substeps'
answers 0 run ball.json --device cpu:double --frames 3 --out two --particles --mesh ply -q
[ -s said ] && wrong "says something with --quiet"
answers 0 run ball.json --device cpu --frames 3 --out three --particles --mesh obj --seed 5 \
    --set gravity=[0,-3,0] --audit 2 --hands poke
answers 0 run ball.json --device cpu --frames 500 --time-limit 0.5 --json
holds said '"end": "time limit"'
if [ -d one/pictures ] && ls one/pictures/*.png >/dev/null 2>&1; then
    [ "$(ls one/pictures | wc -l)" -eq 3 ] || wrong "not a picture a frame"
    answers 0 run ball.json --device cpu --frames 2 --out one --overwrite --particles --video \
        --set pictures.width=128 --set pictures.height=96
fi
answers 2 run ball.json --video
answers 2 run ball.json --pictures 1
answers 2 run ball.json --device gpu:x
answers 3 run ball.json --hands absent.hands
grep -v '"hands"' ball.json | sed 's/"category": 1}],/"category": 1}],/' >no_hands.json
answers 2 run no_hands.json --hands poke

# What a file is, said by its contents.
for file in ball.json noisy.hands noisy.jsonl one/mesh.glb two/mesh.ply three/mesh.obj \
    one/particles.ply one/report.json; do
    answers 0 info "$file"
    [ -s said ] || wrong "nothing to say of $file"
    answers 0 info "$file" --json
    holds said '^\{'
done
answers 0 info ball.json --set domain.cells=16
answers 2 info one/mesh.glb --set domain.cells=16
for scene in "$scenes"/*.json; do answers 0 info "$scene"; done
for hands in "$scenes"/*.hands; do answers 0 info "$hands" --json; done
: >empty.ply
printf 'solid of nothing' >what.stl
answers 3 info what.stl
answers 3 info empty.ply
answers 3 info absent.glb

# The scenes that come with the program, from any folder.
for name in squeeze squeeze.json scenes/squeeze.json; do
    answers 0 info $name
    holds said 'kind +scene'
done
answers 0 info imprint.hands --json  # that of this folder
holds said '"frames": 31'

# From format to format.
for ending in obj ply glb; do
    answers 0 convert one/mesh.glb first.$ending
    answers 0 convert first.$ending second_$ending.glb
    answers 0 info second_$ending.glb
    holds said 'pieces +1'
done
answers 0 convert one/particles.ply particles.csv
answers 0 convert one/particles.ply particles.ply
cmp -s one/particles.ply particles.ply || wrong "particles are others after being converted"
answers 2 convert one/mesh.glb mesh.fbx
# STL, binary and text; particles as a table and back; pipes.
answers 0 convert one/mesh.glb first.stl
answers 0 convert first.stl second_stl.glb
answers 0 info second_stl.glb
holds said 'pieces +1'
printf 'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n%s' \
    $'endloop\nendfacet\nendsolid a\n' >text.stl
answers 0 info text.stl
holds said 'triangles +1$'
answers 0 convert particles.csv table.ply
answers 0 compare one/particles.ply table.ply --tolerance 0
"$program" convert - - --to stl <one/mesh.glb 2>complained >piped.stl || wrong "no pipe"
cmp -s first.stl piped.stl || wrong "another STL through a pipe"
"$program" convert - - --from stl --to obj <piped.stl 2>complained | "$program" convert - \
    piped.glb --from obj >said 2>complained || wrong "no pipe of two"
answers 0 info piped.glb
"$program" compare - one/report.json <one/report.json >said 2>complained ||
    wrong "no report by a pipe"
answers 2 convert one/mesh.glb -
answers 3 convert - empty.ply

# What it says of itself.
answers 0 -V
for verb in run info convert list new help; do
    answers 0 help $verb
    holds said "Usage: knead $verb"
    answers 0 help $verb --man
    holds said '^\.SH OPTIONS'
done
answers 2 help rnu
complains 'did you mean "run"?'
answers 0 help
holds said '^Usage: knead '
holds said '^  verify '
holds said '143 terminated'
answers 0 help --man
holds said '^\.B knead run'
if command -v man >/dev/null; then
    for verb in '' run convert; do
        "$program" help $verb --man >page.1
        [ -z "$(man --warnings=w -l page.1 2>&1 >/dev/null)" ] || wrong "roff of $verb: $(man \
            --warnings=w -l page.1 2>&1 >/dev/null | head -n 3)"
    done
fi
answers 2 help --completion fish
for kind in presets materials gestures scenes; do
    answers 0 list $kind
    [ "$(wc -l <said)" -ge 8 ] || wrong "few $kind"
done
holds said '^squeeze +Two hands'
answers 2 list tools
answers 0 new first.json
answers 0 info first.json
answers 0 run first.json --device cpu --frames 1 --cells 16 --pictures 0 -q
answers 5 new first.json
answers 2 new first.txt
"$program" new - 2>complained | cmp -s - first.json || wrong "another scene through a pipe"
answers 2 convert noisy.hands noisy.glb
answers 2 convert one/particles.ply particles.glb
answers 3 convert ball.json ball.glb
answers 5 convert one/mesh.glb first.glb
answers 0 convert one/mesh.glb first.glb --overwrite
answers 5 convert one/mesh.glb absent/first.glb
answers 5 convert one/particles.ply absent/particles.csv
for file in one/mesh.glb two/mesh.ply one/particles.ply noisy.hands; do
    head -c 300 "$file" >"half.${file##*.}"
    answers 3 info "half.${file##*.}"
done

# Splats: two rows of 32 bytes, the second without a rotation; then a PLY with harmonics.
row='\0\0\200\77\0\0\0\100\0\0\100\100\0\0\200\77\0\0\200\77\0\0\200\77\377\0\200\377'
printf "$row\\377\\200\\200\\200$row\\200\\200\\200\\200" >two.splat
answers 0 info two.splat
holds said 'splats +1$'
holds said 'no_rotation +1$'
for ending in ply spz splat; do
    answers 0 convert two.splat converted.$ending
    complains '1 splats left out'
    answers 0 info converted.$ending --json
    holds said '"splats": 1'
done
answers 0 convert converted.ply back.splat -q
cmp -s converted.splat back.splat || wrong "a splat is another after being converted"
{
    printf 'ply\nformat ascii 1.0\nelement vertex 1\n'
    for name in x y z opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 f_rest_{0..8}; do
        printf 'property float %s\n' $name
    done
    printf 'end_header\n1 2 3 0 -3 -3 -3 1 0 0 0 1 2 3 4 5 6 7 8 9\n'
} >one.ply
answers 0 convert one.ply one.splat
complains 'harmonics above degree 0'
answers 2 convert one.ply one.csv
answers 2 convert two.splat two.obj
answers 3 info /dev/null
head -c 33 two.splat >half.splat
answers 3 info half.splat
complains 'rows of 32 bytes'
head -c 40 converted.spz >half.spz
answers 3 convert half.spz whole.ply
[ ! -e whole.ply ] || wrong "a broken file was converted"

# Pictures of them: what is missing, wrong or there already is said.
head -c 32 two.splat >first.splat
answers 0 render first.splat --out drawn.png --size 64x48 --device cpu
holds said 'drawn.png'
[ "$(head -c 4 drawn.png | tail -c 3)" = PNG ] || wrong "a picture that is no PNG"
answers 5 render first.splat --out drawn.png --size 64x48 --device cpu
answers 0 render first.splat converted.ply one.ply --out many.png --size 64x48 --device cpu -q \
    --eye 1,2,-5 --at 1,2,3 --up y --fov 30 --background 0.1,0.2,0.3
[ ! -s said ] || wrong "says something with --quiet"
cmp -s drawn.png many.png && wrong "a picture of other splats is the same"
answers 0 render first.splat --out both.png --size 64x48 --device cpu:double --stereo
answers 0 render first.splat --out turn.png --size 32x32 --device cpu --orbit 3 --eye 1,2,-9 \
    --at 1,2,2
[ -s turn_0000.png ] && [ -s turn_0002.png ] || wrong "not a picture for each step of an orbit"
cmp -s turn_0000.png turn_0001.png && wrong "an orbit stands still"
answers 0 render first.splat --out coarse.png --size 512x384 --device cpu --foveate 1 \
    --eye 1,2,-2 --at 1,2,3
answers 0 render first.splat --out fine.png --size 512x384 --device cpu --eye 1,2,-2 --at 1,2,3
cmp -s coarse.png fine.png && wrong "a picture that is coarse beside its middle is the same"
answers 2 render first.splat --out other.png --device cpu:double --foveate 20
answers 2 render first.splat --out other.png --foveate 90
answers 2 render first.splat --out drawn.jpg
answers 2 render first.splat --out other.png --size 64
answers 2 render first.splat --out other.png --size 0x64
answers 2 render first.splat --out other.png --size 99999x64
answers 2 render first.splat --out other.png --eye 1,2
answers 2 render first.splat --out other.png --eye 1,2,nan
answers 2 render first.splat --out other.png --eye 1,2,3 --at 1,2,3 --device cpu
complains 'expected another point than --at'
answers 2 render first.splat --out other.png --up w
answers 2 render first.splat --out other.png --fov 200
answers 2 render first.splat --out other.png --device abacus
answers 2 render first.splat
answers 3 render absent.splat --out other.png --device cpu
answers 3 render half.splat --out other.png --device cpu
answers 5 render first.splat --out absent/other.png --device cpu
[ ! -e other.png ] || wrong "a picture of nothing was written"

# Videos of them: an orbit, a path, the pictures of a run; and what is no video is said.
cat >way.json <<'WAY'
{"schema": "knead.path/1", "keys": [{"time": 0, "eye": [1, 2, -5], "at": [1, 2, 3]},
                                    {"time": 0.2, "eye": [2, 2, -4], "at": [1, 2, 3]}]}
WAY
answers 0 render first.splat --path way.json --rate 10 --out way.png --size 32x32 --device cpu
[ -s way_0002.png ] && [ ! -e way_0003.png ] || wrong "0.2 s at 10 frames a second are 3 pictures"
cmp -s way_0000.png way_0002.png && wrong "the camera stands still"
mkdir -p a_run/pictures
cp way_0000.png a_run/pictures/frame_00002.png
cp way_0001.png a_run/pictures/frame_00010.png
# Where there is no ffmpeg, one that keeps the pictures as they are.
if ! command -v ffmpeg >/dev/null; then
    mkdir fake
    printf '#!/bin/sh\nfor to; do :; done\nexec cat >"${to#file:}"\n' >fake/ffmpeg
    chmod +x fake/ffmpeg
    PATH=$PWD/fake:$PATH
fi
answers 0 render first.splat --orbit 3 --video turn.mp4 --size 33x32 --device cpu
answers 0 render first.splat --path way.json --video way.mkv --size 32x32 --stereo --device cpu
answers 0 render a_run --video run.mp4 --rate 5
for video in turn.mp4 way.mkv run.mp4; do [ -s $video ] || wrong "no $video"; done
answers 5 render a_run --video run.mp4
answers 5 render first.splat --orbit 3 --video no/turn.mp4 --size 32x32 --device cpu
cp drawn.png a_run/pictures/frame_00011.png
answers 3 render a_run --video sizes.mp4
complains 'frame_00011.png: 64 x 48 pixels'
echo broken >a_run/pictures/frame_00011.png
answers 3 render a_run --video broken.mp4
complains 'frame_00011.png'
mkdir bare && ln -s "$(command -v timeout)" bare/
PATH=$PWD/bare answers 5 render a_run --video none.mp4
complains 'ffmpeg is not on the PATH'
[ ! -e none.mp4 ] || wrong "a video without ffmpeg"
answers 2 render first.splat --video one.mp4 --device cpu
complains '--orbit'
answers 2 render first.splat --orbit 3 --video turn.gif --device cpu
answers 2 render first.splat --orbit 3 --path way.json --out other.png --device cpu
answers 2 render a_run --out other.png --video other.mp4
answers 3 render a_run/pictures --video other.mp4
complains 'expected the folder of a run'
answers 3 render first.splat --path absent.json --out other.png --device cpu

# Two of a kind.
answers 0 compare one/report.json one/report.json
holds said 'the same'
answers 1 compare one/report.json three/report.json
holds said 'DIFFER'
answers 0 compare one/report.json three/report.json --tolerance 1e9 --json
answers 1 compare one/report.json two/report.json --slower 1e-9
holds said 'slower than allowed'
# Reports that somebody has cut about.
spoil() { python3 -c "
import json, sys
report = json.load(open('one/report.json'))
exec(sys.argv[1])
json.dump(report, open('spoiled.json', 'w'))" "$1" 2>/dev/null; }
if spoil ''; then
    answers 0 info spoiled.json
    answers 0 compare one/report.json spoiled.json
    spoil "report['knead'] = {}"
    answers 3 info spoiled.json
    complains /knead/end
    answers 3 compare spoiled.json spoiled.json
    complains /knead/simulated_s
    spoil "del report['context']"
    answers 3 info spoiled.json
    spoil "report['runs'] = [1]"
    answers 3 info spoiled.json
    complains /runs/0/name
    spoil "report['knead']['mass']['exact'] = 'yes'"
    answers 3 info spoiled.json
    complains /knead/mass/exact
    spoil "report['knead']['guards'] = [[]]"
    answers 3 info spoiled.json
    spoil "report['knead']['frames'] = 1e300; report['knead']['guards']['clipped'] = 'many'"
    answers 0 info spoiled.json
    spoil "report['knead']['mass']['last_kg'] = None"
    answers 3 compare one/report.json spoiled.json
    complains /knead/mass/last_kg
fi
answers 0 compare one/particles.ply one/particles.ply
answers 1 compare one/particles.ply three/particles.ply --json
answers 0 compare one/particles.ply two/particles.ply --tolerance 0.01
answers 3 compare one/particles.ply one/report.json
answers 3 compare one/mesh.glb one/mesh.glb

# Names that are no UTF-8.
cp ball.json $'b\377ll.json'
answers 0 info $'b\377ll.json' --json
answers 0 info $'b\377ll.json'
answers 0 run $'b\377ll.json' --device cpu --frames 1 --out $'o\377t' --json
answers 0 info $'o\377t/report.json'

answers 2 verify acuracy
complains accuracy
answers 2 verify --only nothing
answers 2 verify --device abacus
answers 0 verify convergence --only patch --device cpu --json --out verified
holds said '"schema": "knead.verify/1"'
holds verified/report.md 'patch test'
answers 5 verify convergence --only patch --device cpu --out verified
answers 0 verify convergence --only patch --device reference -q --out verified --overwrite
[ "$(wc -l <said)" -eq 1 ] || wrong "more than one line with --quiet"
answers 0 verify --case 'a single particle falls' --quick --device cpu --threads 1
holds said '"ending":"stable"'
answers 2 verify --case 'a case that is not there' --device cpu
complains 'stability suite'
answers 2 bench frobnicate
answers 2 bench --device abacus
answers 2 bench --device gpu
complains 'a GPU is called cuda'
answers 3 bench stages --device cpu --scene absent.json --out bench --quick
[ ! -e bench ] || wrong "a folder for results of nothing"
# Its scene is found from anywhere; where nothing could be measured, nothing is said to be written.
answers 4 bench stages --device cpu --quick --max-memory 1 --out bench
complains 'MiB are free'
grep -q wrote complained && wrong "says that it wrote what it could not measure"

concluded
