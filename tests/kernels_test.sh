#!/usr/bin/env bash
# What ptxas said of every kernel in a build folder, as a table. Fails where a kernel of ours keeps
# anything in local memory: a stack frame means an array indexed at run time, a spill means too many
# registers, and either costs more than any tuning wins. CUB's and Thrust's are only counted.
# usage: tests/kernels_test.sh BUILD_FOLDER
set -u
shopt -s globstar nullglob
records=("${1:?usage: tests/kernels_test.sh BUILD_FOLDER}"/**/*.ptxas)
if [ ${#records[@]} -eq 0 ]; then
    echo "no record of any kernel under $1: was it built with CUDA?" >&2
    exit 1
fi

awk '
    /Compiling entry function/ { split($0, part, "\047"); kernel = part[2]; card = part[4]; next }
    /Function properties for/ { of = $NF; next }
    /bytes stack frame/ { stack[of] = $1; spill[of] = $5 + $9; next }
    /Used [0-9]+ registers/ {
        match($0, /Used [0-9]+/)
        registers = substr($0, RSTART + 5, RLENGTH - 5)
        shared = 0
        if (match($0, /[0-9]+ bytes smem/)) shared = substr($0, RSTART, RLENGTH) + 0
        print kernel, card, registers, shared, stack[kernel] + 0, spill[kernel] + 0
    }' "${records[@]}" | sort -u | c++filt | awk '
    {
        # The name may hold blanks, so the figures are counted from the end.
        spill = $NF; stack = $(NF - 1); shared = $(NF - 2); registers = $(NF - 3); card = $(NF - 4)
        name = $1
        for (i = 2; i <= NF - 5; ++i) name = name " " $i
        sub(/^void /, "", name)
        if (name ~ /^(cub|thrust|cuda)::/) { ++others; next }
        gsub(/\(anonymous namespace\)::/, "", name)
        if (!sub(/>\(.*/, ">", name)) sub(/\(.*/, "", name)
        bad = stack + spill > 0
        failed += bad
        if (!total++)
            printf "%9s %7s %6s %6s  %-7s %s\n", "registers", "shared", "stack", "spills", "card",
                   "kernel"
        printf "%9d %7d %6d %6d  %-7s %s%s\n", registers, shared, stack, spill, card, name,
               bad ? "   <-- local memory" : ""
    }
    END {
        printf "%d kernels, %d with local memory; %d more of CUB and Thrust\n",
               total, failed, others
        exit failed > 0 || total == 0
    }'
