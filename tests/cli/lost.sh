#!/usr/bin/env bash
# How much a kill loses: a run with `--checkpoint SECONDS` is killed at random moments, again and
# again, and goes on each time. Of the frames that a kill loses, all but the last must have ended
# within SECONDS after the one that the checkpoint holds, and the checkpoint may be no older than
# that and the longest frame. Frames and their moments are those that the run says (-v), stamped as
# they are read; a run that goes on begins with the frame after the one that it found.
# usage: tests/cli/lost.sh PROGRAM [KILLS] [SECONDS] [SECONDS that may be lost]
set -u
export LC_ALL=C OMP_NUM_THREADS=1
kills=${2:-16} every=${3:-0.3}
allowed=${4:-$every}
. "$(dirname "$0")"/answers.sh
RANDOM=1
noise=0.1  # by which a stamp may be late where others want the processor [s]
run=(run ball.json --device cpu --frames 1000000 --set surface.nodes=16 --out torn)

stamped() { while IFS= read -r line; do printf '%s %s\n' "$EPOCHREALTIME" "$line"; done; }
frames_of() { sed -nE 's/^([0-9.]+) knead: frame ([0-9]+):.*/\1 \2/p' "$1" 2>/dev/null; }

# Begins the run, or goes on with it, and waits for its first frame.
begin() {
    local command=("${run[@]}")
    [ ! -e torn/checkpoint.knead ] || command=(run --resume torn)
    rm -f log
    "$program" "${command[@]}" --threads 1 -v --checkpoint "$every" 2> >(stamped >log) \
        >said </dev/null &
    process=$!
    for _ in $(seq 200); do
        read -r _ began < <(frames_of log) && return
        sleep 0.05
    done
    wrong "no frame in 10 s: $(cat log)"
    kill -9 $process
    concluded
}

# What the kill lost whose frames are in `torn_frames`: the next run began with frame $1.
judge() {
    awk -v found=$(($1 - 1)) -v at="$killed_at" -v written="$written" -v allowed="$allowed" \
        -v noise=$noise '
        NR == 1 { since = $1; before = $1; first = $2 }
        $2 <= found { since = $1 }
        { if ($1 - before > longest) longest = $1 - before
          last_but_one = before; before = $1; last = $2 }
        END {
            lost = last - found
            wall = lost > 1 && last_but_one > since ? last_but_one - since : 0
            age = written == "" || found < first ? 0 : at - written
            printf "%d %.3f %.3f %.3f %d\n", lost, wall, age, longest, (found >= first)
            exit !(lost >= 0 && wall <= allowed + noise && age <= allowed + longest + noise)
        }' torn_frames
}

worst=0 most=0 fresh=0 killed_at='' written=''
for ((n = 0; n <= kills; ++n)); do
    begin
    if [ $n -gt 0 ]; then
        if ! told=$(judge "$began"); then
            wrong "kill $n lost too much: frames, their seconds, the checkpoint's age, the" \
                "longest frame, and whether a checkpoint was of this run: $told"
        fi
        read -r lost wall _ _ held <<<"$told"
        worst=$(printf '%s\n' "$worst" "$wall" | sort -g | tail -n 1)
        [ "$lost" -le $most ] || most=$lost
        fresh=$((fresh + held))
    fi
    # From its first frame on: up to four times as long as checkpoints are apart.
    sleep "$(awk -v r=$RANDOM -v e="$every" 'BEGIN { print 4 * e * r / 32767 }')"
    killed_at=$EPOCHREALTIME
    kill -9 $process 2>/dev/null || wrong "the run ended by itself"
    wait $process 2>/dev/null
    sleep 0.1  # all that it said is stamped
    frames_of log >torn_frames
    written=$(stat -c %.Y torn/checkpoint.knead 2>/dev/null)
done
[ $fresh -ge $((kills / 2)) ] || wrong "only $fresh of $kills killed runs had kept a checkpoint"
[ $most -gt 1 ] || wrong "no kill lost a frame that had ended: nothing was measured"
echo "$kills kills lost $most frames and $worst s at most, with checkpoints $every s apart"
concluded
