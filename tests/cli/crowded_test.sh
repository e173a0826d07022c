#!/usr/bin/env bash
# Runs that share processors take no more processor time than one alone: threads that wait do not
# spin. Times are those of the process, so that other programs matter little: with threads that
# spin a frame took up to 9 times as much.
# usage: tests/cli/crowded_test.sh PROGRAM
set -u
. "$(dirname "$0")"/answers.sh
unset OMP_NUM_THREADS OMP_WAIT_POLICY GOMP_SPINCOUNT
run=(run ball.json --device cpu --frames 8 --set surface.nodes=16 -q)

# Processor time of a frame of a run that has ended [ms].
cpu_time() {
    sed -nE 's/^ *"cpu_time": ([0-9.e+-]+),?$/\1/p' "$1/report.json" | head -n 1
}
OMP_NUM_THREADS=1 answers 0 "${run[@]}" --threads 1 --out alone
alone=$(cpu_time alone)
[ -n "$alone" ] || wrong "no cpu_time in alone/report.json"
processes=()
for n in 1 2 3 4; do
    "$program" "${run[@]}" --threads 4 --out crowd$n >/dev/null 2>&1 &
    processes+=($!)
done
for process in "${processes[@]}"; do
    wait "$process" || wrong "a run among others ended with $?"
done
sum=0
for n in 1 2 3 4; do
    took=$(cpu_time crowd$n)
    echo "a frame of one thread alone: $alone ms of processor time; of run $n of four: $took ms"
    sum="$sum + ${took:-1e9}"
    cmp -s alone/mesh.glb crowd$n/mesh.glb || wrong "another mesh among other runs"
done
awk -v a="$alone" "BEGIN { exit !(($sum) / 4 < 2.2 * a) }" ||
    wrong "frames of four runs took more than 2.2 times the processor time of one thread alone"
concluded
