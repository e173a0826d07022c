#!/usr/bin/env bash
# Which lines of cuda/*/*.h and host/ the tests run on the CPU: a table by room, the files that are
# worst, and the total, which must be 90 % or more. What only a CUDA compiler sees (.cu, .cuh and
# the headers that only they include) cannot be counted this way and is left out; it is named.
# usage: tests/coverage.sh              (builds build/coverage; gcovr is needed)
set -eu
cd "$(dirname "$0")/.."
bound=90
build=build/coverage
if ! command -v gcovr >/dev/null; then
    echo "gcovr is not here (Debian: apt-get install gcovr)"
    exit 77
fi

cmake --preset coverage >/dev/null
cmake --build $build --target knead knead_tests
find $build -name '*.gcda' -delete

# One thread each: threads that count the same line at a time would lose counts.
export OMP_NUM_THREADS=1 GTEST_TOTAL_SHARDS=2
for shard in 0 1; do
    GTEST_SHARD_INDEX=$shard $build/knead_tests --gtest_brief=1 >$build/tests_$shard.log 2>&1 &
    shards[shard]=$!
done
failed=0
for shard in 0 1; do
    wait "${shards[shard]}" || { tail -n 30 $build/tests_$shard.log; failed=1; }
done
for test in program verbs; do tests/cli/${test}_test.sh $build/knead || failed=1; done
[ $failed -eq 0 ] || echo "tests failed: what follows says only what they reached"

gcovr --root . --filter 'cuda/.*/.*\.h$' --filter 'host/' --csv --output $build/lines.csv $build
unseen=$(for header in cuda/*/*.h host/*/*.h host/*/*/*.h; do
    grep -q "^$header," $build/lines.csv || echo "$header"
done)
echo "No line to count on the CPU (declarations only, or of the GPU alone):" $unseen
awk -F, -v bound=$bound '
    NR == 1 { next }
    {
        split($1, part, "/")
        room = part[1] "/" part[2]
        lines[room] += $2; run[room] += $3
        all += $2; ran += $3
        if ($2 - $3 >= 10) printf "%6d of %5d lines never run  %s\n", $2 - $3, $2, $1 | "sort -rn"
    }
    END {
        close("sort -rn")
        for (room in lines)
            printf "%-16s %6d lines %6.1f %%\n", room, lines[room], 100 * run[room] / lines[room] |
                "sort"
        close("sort")
        printf "%-16s %6d lines %6.1f %%   (at least %d %%)\n", "total", all, 100 * ran / all, bound
        exit 100 * ran / all < bound
    }' $build/lines.csv || failed=1
exit $failed
