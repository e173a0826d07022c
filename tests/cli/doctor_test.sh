#!/usr/bin/env bash
# knead doctor: what it says of the machine; which half-written files it names, wherever a run has
# its files, and that it lets them be; what it cannot read.
# usage: tests/cli/doctor_test.sh PROGRAM
set -u
. "$(dirname "$0")"/answers.sh

answers 0 doctor
holds said '^ok +CPU'
answers 0 doctor --json
holds said '"what": "memory"'
# OpenXR is named, and a runtime that is not there is no failure, but a hint.
XR_RUNTIME_JSON=/nowhere.json answers 0 doctor
holds said '^missing +OpenXR .*no knead vr'

# What a killed program left is named, and stays. No process has that number.
mkdir -p one/meshes one/particles one/pictures one/other two
dead=partial-999999999-0
left=(one/mesh.$dead.glb:mesh.glb one/meshes/mesh_0003.$dead.stl:mesh_0003.stl
    one/particles/particles_0002.$dead.ply:particles_0002.ply
    one/pictures/frame_00007.$dead.png:frame_00007.png)
for pair in "${left[@]}"; do printf half >"${pair%:*}"; done
printf half >$'one/\377.'$dead.hands
# These are nobody's leftovers: of a process that lives, without a number, where no run writes.
printf half >one/mesh.partial-$$-0.obj
printf whole >one/meshes/mesh.partial-x.glb
printf half >one/other/mesh.$dead.glb
mkdir one/pictures/frame_00008.$dead.png
for folder_asked in . one; do
    answers 0 doctor $folder_asked
    for pair in "${left[@]}"; do
        grep -qE "^left .*${pair%:*}: of ${pair#*:}, " said || wrong "${pair%:*} is not named"
    done
    expected=5
    [ $folder_asked = . ] || expected=6  # what lies directly in the folder's own folders is named
    [ "$(grep -c '^left' said)" -eq $expected ] || wrong "not $expected leftovers in $folder_asked"
done
answers 0 doctor two one
[ "$(grep -c '^left' said)" -eq 6 ] || wrong "not the leftovers of two folders"
answers 0 doctor two
grep -q '^left' said && wrong "something left in a folder without"
answers 0 doctor one --json
[ "$(grep -c '"what": "leftover"' said)" -eq 6 ] || wrong "other leftovers as JSON"
for pair in "${left[@]}"; do [ -e "${pair%:*}" ] || wrong "doctor removed ${pair%:*}"; done
answers 3 doctor absent
answers 3 doctor ball.json
complains "no such folder"

# What cannot be read is said: by somebody for whom that is so.
mkdir -p locked/inside shut
chmod 700 "$folder/shut" "$folder/locked/inside"
as=()
if [ "$(id -u)" -eq 0 ]; then
    command -v setpriv >/dev/null || { echo "without setpriv root reads all"; concluded; }
    as=(setpriv --reuid=65534 --regid=65534 --clear-groups)
    cp "$program" knead && chmod 755 . knead
    program=$folder/knead
else
    chmod 000 "$folder/shut" "$folder/locked/inside"
fi
"${as[@]}" "$program" doctor locked >said 2>complained || wrong "exit $? of a folder in a folder"
holds said '^unread +unread +locked/inside: cannot be read: Permission denied'
"${as[@]}" "$program" doctor shut >said 2>complained
[ $? -eq 3 ] || wrong "not exit code 3 for a folder that cannot be read"
complains 'shut: cannot be read: Permission denied'
chmod 700 shut locked/inside
concluded
