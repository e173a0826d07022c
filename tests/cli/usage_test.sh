#!/usr/bin/env bash
# What every verb answers to options that do not go together, and to files that are not what it
# wants: the exit code, and words that name the option or the file. Nothing is written by any.
# usage: tests/cli/usage_test.sh PROGRAM
set -u
tree=$(cd "$(dirname "$0")/../.." && pwd)
. "$(dirname "$0")"/answers.sh
refuses() {  # CODE WORDS ARGUMENT...
    local code=$1 words=$2
    shift 2
    answers "$code" "$@"
    complains "$words"
}

cp "$tree"/scenes/squeeze.hands hands.hands
sed '/"hands"/d' ball.json >still.json
echo 'no scene' >text.txt
echo '{"schema": "knead.other/1"}' >other.json
mkdir empty
printf 'x,y,z\n0.1,0.1,0.1\n' >three.csv
printf 'x,y,z\n0.1,b,0.1\n' >letter.csv
printf 'x,y,z,x\n1,2,3,4\n' >twice.csv
echo '{"schema": "knead.report/1"}' >bare.json
row='\0\0\200\77\0\0\0\100\0\0\100\100\0\0\200\77\0\0\200\77\0\0\200\77\377\0\200\377'
printf "$row\\377\\200\\200\\200" >one.splat
echo '1 press q' >keys
touch before && ls >before

refuses 2 "needs a SCENE, or --resume" run
refuses 2 "SCENE excludes --resume" run ball.json --resume empty
refuses 2 "--checkpoint needs --out DIR" run ball.json --checkpoint 2
refuses 2 "need --out DIR" run ball.json --video
refuses 2 "need --out DIR" run ball.json --particles
refuses 2 "need --out DIR" run ball.json --pictures 3
refuses 2 "need --out DIR" run ball.json --mesh-every 2
refuses 2 '--mesh: expected glb, ply, obj, stl or none, found "fbx"' run ball.json --mesh fbx
refuses 2 "--mesh-every needs another --mesh" run ball.json --out r --mesh none --mesh-every 2
refuses 2 '--splats: expected ply, compressed.ply, splat, spz, sog, glb or none' run ball.json \
    --splats png
refuses 2 'the scene has no "hands" to replace' run still.json --hands hands.hands
refuses 2 '--device: expected auto' run ball.json --device gpu
refuses 2 '--device: expected auto' run ball.json --device cuda:x
refuses 2 'expected path.key=value' run ball.json --device cpu --set nothing
refuses 2 'expected path.key=value' run ball.json --device cpu --set domain..cells=3
refuses 3 'expected an index below 1' run ball.json --device cpu --set objects.7.diameter=1
refuses 3 'ball.json: /objects: expected an array of 1 to 256 objects, found an array of 0' \
    run ball.json --device cpu --set 'objects=[]'
refuses 3 empty run --resume empty
for name in sqeeze sqeeze.json scenes/sqeeze.json; do
    for verb in run view vr info; do
        refuses 3 "$name: no such file, and no such scene; did you mean \"squeeze\"?" $verb $name
    done
done
refuses 3 'sqeeze.ply: no such file' info sqeeze.ply
grep -q 'did you mean' complained && wrong "a scene is suggested where a mesh was asked for"
refuses 3 'nothing like it: no such file' run 'nothing like it'
grep -q 'did you mean' complained && wrong "a scene of quite another name is suggested"
refuses 2 "not available with" run ball.json --device cpu:double --out r --checkpoint 2
rm -r r  # that is said when the folder is there

refuses 2 "OUT: expected a file ending in .hands or .jsonl" record press made.txt
refuses 2 "knead record needs a GESTURE and a file OUT" record
refuses 2 "SCENE: expected a file ending in .json" new scene.txt
refuses 2 "--set and --cells: only for scenes" info hands.hands --cells 32
refuses 2 "--set and --cells: only for scenes" info hands.hands --set seed=1
refuses 3 "text.txt" info text.txt
refuses 3 "expected two reports or two particle files" compare hands.hands hands.hands
refuses 3 "expected two reports or two particle files" compare three.csv hands.hands
refuses 3 "bare.json: /knead/simulated_s: expected a number as in every report" \
    compare bare.json bare.json
refuses 3 'letter.csv: line 2: expected 3 numbers, found "b" as number 2' convert letter.csv l.ply
refuses 3 'twice.csv: line 1: expected a name once, found "x" again' convert twice.csv t.ply
refuses 2 "give its format by --to" convert hands.hands -
refuses 2 "can be written as .hands, .jsonl" convert hands.hands hands.ply
refuses 2 "can be written as .ply, .csv" convert three.csv three.obj
refuses 3 "expected a mesh, a recording, particles, splats or a session" convert ball.json ball.ply
refuses 2 "no verb" help knit
refuses 2 "--completion: expected bash or zsh" help --completion fish

refuses 2 "needs --out PICTURE.png, --video FILE, or both" render any.ply
refuses 2 "--video: expected a file ending in" render any.ply --video film.gif
refuses 2 "cannot be combined with --orbit" render any.ply --out p.png --path way.json --orbit 3
refuses 2 "can only be encoded as a --video" render empty --out p.png
refuses 2 "can only be encoded as a --video" render empty --video f.mp4 --orbit 3
refuses 3 "expected the folder of a run with pictures" render empty --video f.mp4
refuses 2 "it needs --orbit FRAMES or --path FILE" render any.ply --video f.mp4

splat=(render one.splat --out p.png --device cpu)
refuses 2 '--at: expected three numbers with commas between them, found "1,2"' \
    "${splat[@]}" --at 1,2
refuses 2 '--eye: expected three numbers' "${splat[@]}" --eye 1,2,3,4
refuses 2 '--eye: expected another point than --at' "${splat[@]}" --eye 1,2,3 --at 1,2,3
refuses 2 '--up: expected x, y, z, -x, -y or -z, found "w"' "${splat[@]}" --up w
refuses 2 '--background: expected three numbers' "${splat[@]}" --background 0,grey,0
refuses 2 '--size: expected WIDTHxHEIGHT of at most 8192 pixels a side' "${splat[@]}" --size 8193x9
refuses 2 '--size: expected WIDTHxHEIGHT of at most 8192 pixels a side' "${splat[@]}" --size 64
refuses 3 'way.json' "${splat[@]}" --path way.json

refuses 2 "--hands-only needs --record FILE, or --out DIR" vr ball.json --hands-only
refuses 2 '--record: expected a file ending in .hands or .jsonl, found "mine.txt"' \
    vr ball.json --record mine.txt
refuses 2 "--place: expected x,y,z" vr ball.json --place 1,2
refuses 2 "--place: expected x,y,z" vr ball.json --place 1,2,30
refuses 2 "--binding: expected auto, egl, glx or wgl" vr ball.json --binding vulkan
refuses 2 "--size: expected WIDTHxHEIGHT of 64 to 16384 pixels" view ball.json --size 32x999
refuses 5 "text.txt: is there already; --overwrite replaces it" \
    view ball.json --frames 3 --screenshot text.txt
refuses 3 "keys" view ball.json --script keys
refuses 2 "no case of the stability suite" verify stability --device cpu --quick --case none
refuses 2 "no part of these suites" verify accuracy --device cpu --quick --only nothing
refuses 2 "cpu:double is not timed" bench --device cpu:double

rm -f said complained
new=$(ls | grep -vxFf before)
[ -z "$new" ] || wrong "files were made: $new"
concluded
