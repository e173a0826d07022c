#!/usr/bin/env bash
# The program as its user meets it: a small scene from the command line to files, the same bits
# twice, and what it answers to bad input and wrong usage.
# usage: tests/cli/program_test.sh PROGRAM
set -u
. "$(dirname "$0")"/answers.sh

answers 0 --version
answers 0 --help
answers 0 run ball.json --device cpu --frames 3 --out one --json
holds said '"schema": "knead.report/1"'
holds one/report.json '"end": "complete"'
holds one/report.json '"exact": true'
for guard in clipped confined repaired; do holds one/report.json "\"$guard\": 0,?$"; done
[ "$(wc -l <one/frames.csv)" -eq 4 ] || wrong "frames.csv has not one line a frame and a heading"
[ "$(head -c 4 one/mesh.glb)" = glTF ] || wrong "mesh.glb is no GLB"

# The same bits, whatever the number of threads.
answers 0 run ball.json --device cpu --frames 3 --threads 1 --mesh obj --out two
state() { grep -o '"state_hash": "[0-9a-f]*"' "$1/report.json"; }
[ -n "$(state one)" ] || wrong "no state_hash"
[ "$(state one)" = "$(state two)" ] || wrong "another state with one thread"
[ -s two/mesh.obj ] || wrong "no mesh.obj"

# Nothing is replaced unasked.
answers 5 run ball.json --device cpu --frames 1 --out one
complains one
answers 0 run ball.json --device cpu --frames 1 --out one --overwrite

# The old set goes before the new one comes, its report first; what cannot be replaced is said
# before the work.
"$program" run ball.json --device cpu --threads 1 --out one --overwrite -q --frames 100000 \
    >said 2>complained </dev/null &
process=$!
until [ ! -e one/report.json ] || ! kill -0 $process; do sleep 0.01; done
sleep 0.5
kill -9 $process
wait $process 2>/dev/null
for file in report.json frames.csv mesh.glb; do
    [ ! -e one/$file ] || wrong "the old $file is there without the rest of its set"
done
answers 0 run ball.json --device cpu --frames 3 --out one
for file in report.json frames.csv mesh.glb; do
    mkdir -p folders/$file
    answers 5 run ball.json --device cpu --frames 1000000 --out folders --overwrite
    complains "folders/$file: is a folder"
    rmdir folders/$file
done

# A scene through the standard input; a coarser one; sequences of files.
answers_to() {
    "$program" "${@:2}" <"$1" >said 2>complained || wrong "exit $?: knead ${*:2}"
}
answers_to ball.json run - --device cpu --frames 3 --threads 1 --out piped
[ "$(state one)" = "$(state piped)" ] || wrong "another state of a scene without a file"
answers_to ball.json info - --cells 64
holds said 'nodes +\[64,64,64\]'
holds said 'frame_wall_s +([0-9.e-]+|null)$'
answers 0 run ball.json --device cpu --frames 1 --cells 16
complains 'a frame on this machine'
answers 3 run ball.json --cells 17
sequences=(run ball.json --device cpu --frames 5 --threads 1 --mesh stl --mesh-every 2
    --particles-every 2 --out moving)
answers 0 "${sequences[@]}"
[ "$(ls moving/meshes | tr '\n' ' ')" = "mesh_0001.stl mesh_0002.stl " ] || wrong "$(ls -R moving)"
[ "$(ls moving/particles | wc -l)" -eq 2 ] || wrong "$(ls -R moving)"
answers 0 run ball.json --device cpu --frames 4 --threads 1 --mesh stl --particles --out still
cmp -s moving/meshes/mesh_0002.stl still/mesh.stl || wrong "another mesh in a sequence"
cmp -s moving/particles/particles_0002.ply still/particles.ply || wrong "other particles in one"
touch moving/meshes/mesh_0007.stl moving/meshes/mine_0007.stl
answers 0 "${sequences[@]}" --overwrite
[ "$(ls moving/meshes | tr '\n' ' ')" = "mesh_0001.stl mesh_0002.stl mine_0007.stl " ] ||
    wrong "after --overwrite: $(ls -R moving)"
answers 2 run ball.json --mesh-every 2

# Wrong usage.
answers 2
answers 2 frobnicate
answers 2 run
answers 2 run ball.json --frames several
answers 2 run ball.json --mesh fbx --out three
answers 2 rn ball.json
complains 'rn: did you mean "run"?'
answers 2 run ball.json --devise cpu
complains '--devise: did you mean "--device"?'
answers 2 run ball.json --frmaes=3
complains 'did you mean "--frames"?'
for setting in gravity =1 objects..name=x .seed=1 seed.=1; do
    answers 2 run ball.json --set $setting
    complains 'path.key=value'
    answers 2 info ball.json --set $setting
done
for number in nan inf -1 1e300 much; do
    answers 2 run ball.json --device cpu --frames 1 --max-memory $number
    answers 2 bench stages --device cpu --quick --max-memory $number
done
answers 2 run ball.json --device cpu --frames 1 --time-limit nan
answers 2 run ball.json --device cpu --frames 1 --out three --checkpoint nan
answers 2 compare one/report.json one/report.json --tolerance nan

# Bad input: the place, what was expected, what was found.
answers 3 run ball.json --set objects.0.diametre=1
complains diameter
answers 3 run ball.json --set objects.0.diameter=-1
complains /objects/0/diameter
answers 3 run ball.json --set objects.0.material=marble
answers 3 run ball.json --set hands.recording=../../secret.hands
head -c 200 ball.json >half.json
answers 3 run half.json
complains half.json
head -c 4096 "$program" >noise.json
answers 3 run noise.json
: >empty.json
answers 3 run empty.json
answers 3 run absent.json
complains absent.json
answers 3 run ball.json --hands sqeeze
complains 'the nearest is "squeeze"'
sed 's/0.32/1e999/' ball.json >huge.json
answers 3 run huge.json
complains 'huge.json: line 3, column 24'
complains 'found 1e999'
answers 4 run ball.json --set objects.0.per_cell=64 --set domain.cells=256 --max-memory 50

# Files that cannot be written.
: >file
answers 5 run ball.json --device cpu --frames 1 --out file/below
answers 4 run ball.json --device cuda:99

# An interrupt keeps what there is.
timeout --preserve-status --kill-after=30 --signal=INT 5 \
    "$program" run ball.json --device cpu --frames 100000 --out stopped \
    >said 2>complained </dev/null
code=$?
[ $code -eq 130 ] || wrong "exit $code instead of 130 after an interrupt"
holds stopped/report.json '"end": "interrupted"'

# Every signal, and the time limit, act within a frame that would not end.
endless=(run ball.json --device cpu --threads 1 --frames 3 --particles
    --set step.fixed=1e-11 --set step.most_substeps=2000000000)
for signal in INT:130 TERM:143 HUP:129; do
    : >complained  # what the last one said is not waited for
    # Job control: what a script starts in the background would ignore INT.
    set -m
    "$program" "${endless[@]}" --out "cut-${signal%:*}" >said 2>complained </dev/null &
    process=$!
    set +m
    until grep -q 'on this machine' complained || ! kill -0 $process; do sleep 0.1; done
    sleep 1
    begin=$(date +%s%N)
    kill "-${signal%:*}" $process
    wait $process 2>/dev/null
    code=$?
    took=$((($(date +%s%N) - begin) / 1000000))
    echo "$signal: the end after $took ms, results written"
    [ $code -eq ${signal#*:} ] || wrong "exit $code instead of ${signal#*:} after $signal"
    [ $took -lt 2000 ] || wrong "took $took ms to end after $signal"
    for file in report.json frames.csv mesh.glb particles.ply; do
        [ -s "cut-${signal%:*}/$file" ] || wrong "no $file after $signal"
    done
    holds "cut-${signal%:*}/report.json" '"reached_s"'
done
answers 0 "${endless[@]}" --out cut-limit --time-limit 0.5
holds cut-limit/report.json '"end": "time limit"'
holds cut-limit/report.json '"reached_s"'
answers 3 run ball.json --device cpu --set step.fixed=1e-30
complains /step/fixed
answers 0 run ball.json --device cpu --frames 1
complains 'substeps of'
complains 'objects.0.material.young'
answers 0 info ball.json --json
holds said '"asked_by": "objects.0.material.young"'
# The ball's volume is 0.1^3 pi / 6 m^3, a cell's 0.01^3 m^3; eight particles a cell.
holds said '"particles": 4189,?$'
holds said '"substeps": [0-9]+,?$'
answers 0 info ball.json
holds said '^particles +4189$'
holds said '^substeps +[0-9]+$'

# Options of a run that goes on.
answers 2 run --resume one ball.json
answers 2 run --resume one --frames 3
answers 2 run ball.json --checkpoint 5
answers 3 run --resume absent
answers 3 run --resume one

if nvidia-smi -L >/dev/null 2>&1; then
    answers 0 run ball.json --device cuda --frames 3 --deterministic --out gpu-one
    answers 0 run ball.json --device cuda --frames 3 --deterministic --out gpu-two
    [ "$(state gpu-one)" = "$(state gpu-two)" ] || wrong "another state in a second run on the GPU"
fi

concluded
