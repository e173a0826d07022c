#!/usr/bin/env bash
# Which lines of cuda/*/*.h and host/ the tests run on the CPU: a table by room, the files that are
# worst, and the total, which must be 90 % or more. What only a CUDA compiler sees (.cu, .cuh and
# the headers that only they include) cannot be counted this way and is left out; it is named.
# usage: tests/coverage.sh              (builds build/coverage; gcovr is needed)
#        KNEAD_COVERAGE_TESTS='-Cut*:*Rests*:*RecordedRun*' tests/coverage.sh
# The second leaves out the slowest tests: a lower bound. Cut alone runs host/solver/pieces.cpp.
set -eu
cd "$(dirname "$0")/.."
bound=90
build=build/coverage
if ! command -v gcovr >/dev/null; then
    echo "gcovr is not here (Debian: apt-get install gcovr)"
    exit 77
fi

cmake --preset coverage >/dev/null
targets=(knead knead_tests knead_fuzz knead_failing_calls)
cmake --build $build --target help | grep -q '^openxr_replay:' && targets+=(openxr_replay)
cmake --build $build --target "${targets[@]}"
find $build -name '*.gcda' -delete

# One thread each: threads that count the same line at a time would lose counts. In many parts, as
# many at a time as there are cores: what a part has counted is written when it ends.
cores=$(nproc)
export OMP_NUM_THREADS=1 GTEST_TOTAL_SHARDS=$((8 * cores))
failed=0
seq 0 $((GTEST_TOTAL_SHARDS - 1)) | xargs -P "$cores" -I '{}' sh -c '
    GTEST_SHARD_INDEX={} "$0"/knead_tests --gtest_brief=1 --gtest_filter="$1" \
        >"$0/tests_{}.log" 2>&1 || { tail -n 30 "$0/tests_{}.log"; exit 1; }' \
    $build "${KNEAD_COVERAGE_TESTS:-*}" || failed=1
tests/verify/quick.sh $build/knead || failed=1
# All that CTest runs of the program; 77: this machine lacks what the test needs.
also() { "$@" || [ $? -eq 77 ] || failed=1; }
for test in program verbs completion doctor usage view; do
    also tests/cli/${test}_test.sh $build/knead
done
for test in failures signals; do
    also tests/cli/$test.sh $build/knead $build/libknead_failing_calls.so
done
also tests/cli/kills.sh $build/knead
[ ! -e $build/libopenxr_replay.so ] ||
    also tests/xr/validation.sh $build/knead $PWD/$build/openxr_replay.json
also tests/fuzz/some.sh $build/knead_fuzz 400
[ $failed -eq 0 ] || echo "tests failed: what follows says only what they reached"

gcovr --root . --filter 'cuda/.*/.*\.h$' --filter 'host/' --csv --output $build/lines.csv $build
unseen=$(for header in cuda/*/*.h host/*/*.h host/*/*/*.h; do
    grep -q "^$header," $build/lines.csv || echo "$header"
done)
echo "No line to count on the CPU (declarations only, or of the GPU alone):" $unseen
awk -F, -v bound=$bound '
    BEGIN { rooms = "%-16s %6d lines %6.1f %%\n" }
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
            printf rooms, room, lines[room], 100 * run[room] / lines[room] | "sort"
        close("sort")
        printf "%-16s %6d lines %6.1f %%   (at least %d %%)\n", "total", all, 100 * ran / all, bound
        exit (100 * ran < bound * all)
    }' $build/lines.csv || failed=1
exit $failed
