#!/usr/bin/env bash
# Profiles every stage with Nsight Compute: the ball of 137 k and 1.1 M particles between two tools,
# a frame of recorded hands, and the surface of both balls. Then summary.py makes the table of
# docs/engineering/kernels.md of it:
#
#     profiling/nsight/collect.sh out/nsight build
#     profiling/nsight/summary.py out/nsight --into docs/engineering/kernels.md
#
# For a timeline with the range of every stage (domain "knead"; graphs show none), where nsys is
# installed:
#
#     profiling/nsight/collect.sh --timeline out/nsight build
#
# Clocks and caches are left as they are in a run. Reports stay in the folder for ncu-ui.
# usage: collect.sh [--timeline] FOLDER [FOLDER_OF_PROGRAMS=build] [CASES="ball squeeze surface"]
set -u
cd "$(dirname "$0")/../.."
timeline=
[ "${1:-}" = --timeline ] && timeline=yes && shift
out=${1:?usage: collect.sh [--timeline] FOLDER [FOLDER_OF_PROGRAMS=build] [CASES]}
programs=${2:-build}
cases=${3:-ball squeeze surface}
mkdir -p "$out" || exit 5
for program in bench_substep bench_surface knead; do
    [ -x "$programs/$program" ] || { echo "no $programs/$program: build it first" >&2; exit 2; }
done

if [ -n "$timeline" ]; then
    command -v nsys >/dev/null || { echo "nsys is not installed" >&2; exit 4; }
    export KNEAD_GRAPH=0
    exec nsys profile --trace=cuda,nvtx --cuda-graph-trace=node --force-overwrite=true \
        --output="$out/timeline" "$programs/bench_substep" 64 10 gpu 1 1
fi
command -v ncu >/dev/null || { echo "ncu is not installed" >&2; exit 4; }

metrics=gpu__time_duration.sum,sm__cycles_elapsed.avg,sm__cycles_elapsed.avg.per_second
metrics+=,sm__cycles_active.avg,smsp__inst_executed.sum,sm__inst_executed.avg.per_cycle_active
metrics+=,smsp__issue_active.avg.pct_of_peak_sustained_active
metrics+=,smsp__thread_inst_executed_per_inst_executed.ratio
metrics+=,dram__bytes_read.sum,dram__bytes_write.sum,lts__t_sectors.sum
metrics+=,lts__t_requests_srcunit_tex_op_red.sum
metrics+=,dram__throughput.avg.pct_of_peak_sustained_elapsed
metrics+=,lts__throughput.avg.pct_of_peak_sustained_elapsed
metrics+=,l1tex__throughput.avg.pct_of_peak_sustained_elapsed
metrics+=,l1tex__data_pipe_lsu_wavefronts_mem_shared.sum
metrics+=,l1tex__data_bank_conflicts_pipe_lsu_mem_shared.sum
metrics+=,sm__warps_active.avg.pct_of_peak_sustained_active,sm__maximum_warps_per_active_cycle_pct
metrics+=,launch__registers_per_thread,launch__shared_mem_per_block_static
metrics+=,launch__shared_mem_per_block_dynamic,launch__grid_size,launch__block_size
metrics+=,launch__waves_per_multiprocessor
metrics+=,device__attribute_multiprocessor_count
for reason in barrier branch_resolving dispatch_stall drain imc_miss lg_throttle long_scoreboard \
    math_pipe_throttle membar mio_throttle misc no_instruction not_selected selected \
    short_scoreboard sleeping tex_throttle wait; do
    metrics+=,smsp__average_warps_issue_stalled_${reason}_per_issue_active.ratio
done

# Two launches a substep; five a frame with tools; those of a sort, which many frames do without.
substep='regex:(g2p|grid)_kernel'
frame='regex:(begin|p2g|sweep|mask|pose)_kernel'
sort='regex:(key|place|settled|move)_kernel|Scan'
surface='regex:(renew|clear|deposit|list|soften|count|march|relax|shade)_kernel|Scan'

failed=0
# profile NAME KERNELS SKIP COUNT COMMAND...: of those kernels, COUNT launches after SKIP.
profile() {
    local name=$1 kernels=$2 skip=$3 count=$4 report
    shift 4
    report=$out/$name
    echo "== $name: $*"
    rm -f "$report.ncu-rep" "$report.csv" "$report.txt"
    if KNEAD_GRAPH=0 ncu --clock-control none --cache-control none --metrics "$metrics" \
        -k "$kernels" --launch-skip "$skip" --launch-count "$count" -f -o "$report" \
        "$@" >"$report.txt" 2>&1 &&
        ncu --import "$report.ncu-rep" --page raw --csv --print-units base >"$report.csv"; then
        return 0
    fi
    tail -n 5 "$report.txt" >&2
    echo "$name: not profiled" >&2
    failed=$((failed + 1))
}

for case in $cases; do
    case $case in
        ball) # deep in the clay at the sixth of its frames
            for nodes in 64 128; do
                profile "ball-$nodes-substep" "$substep" $((nodes * 12)) 8 \
                    "$programs/bench_substep" "$nodes" 8 gpu 1 1
                profile "ball-$nodes-frame" "$frame" 25 10 \
                    "$programs/bench_substep" "$nodes" 8 gpu 1 1
                profile "ball-$nodes-sort" "$sort" 0 24 \
                    "$programs/bench_substep" "$nodes" 8 gpu 1 1
            done
            ;;
        squeeze) # both hands have the clay between them at the 120th
            profile squeeze-substep "$substep" 16000 8 \
                "$programs/knead" run scenes/squeeze.json --frames 125 --mesh none \
                --out "$out/run" --overwrite --device cuda
            profile squeeze-frame "$frame" 590 10 \
                "$programs/knead" run scenes/squeeze.json --frames 125 --mesh none \
                --out "$out/run" --overwrite --device cuda
            profile squeeze-sort "$sort" 24 24 \
                "$programs/knead" run scenes/squeeze.json --frames 60 --mesh none \
                --out "$out/run" --overwrite --device cuda
            ;;
        surface)
            for nodes in 128 256; do
                profile "surface-$nodes" "$surface" 60 60 "$programs/bench_surface" "$nodes" 5
            done
            ;;
        *)
            echo "no case $case" >&2
            exit 2
            ;;
    esac
done
[ $failed -eq 0 ]
